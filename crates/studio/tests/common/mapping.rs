//! A studio with the mapping page alone, and what a page puts together from its messages.

use std::{
    collections::BTreeMap,
    net::SocketAddr,
    sync::{Arc, mpsc},
};

use recordings::Recording;
use serde_json::Value;
use studio::Exhibit;
use surveys::{Known, SurveyConfig};
use tokio::sync::oneshot;
use tungstenite::Message;

use super::{N_MESSAGES_MAX, PATIENCE, Page, connect, exchange};

/// A studio without a mission, on a free port.
#[derive(Debug)]
pub(crate) struct MappingStudio {
    pub(crate) address: SocketAddr,
    stop: Option<oneshot::Sender<()>>,
}

impl MappingStudio {
    pub(crate) fn empty() -> Self {
        Self::start(None)
    }

    pub(crate) fn showing(recording: Recording) -> Self {
        Self::showing_with(recording, SurveyConfig::default())
    }

    pub(crate) fn showing_with(recording: Recording, config: SurveyConfig) -> Self {
        Self::start(Some(Exhibit {
            name: "made.log".to_owned(),
            format: "CARMEN log".to_owned(),
            recording: Arc::new(recording),
            known: Known::default(),
            prior: None,
            complaints: Vec::new(),
            config,
        }))
    }

    fn start(exhibit: Option<Exhibit>) -> Self {
        let (tell_address, address) = mpsc::channel();
        let (stop, stopped) = oneshot::channel();
        std::thread::spawn(move || {
            let stopped = async { drop(stopped.await) };
            let ready = |address| tell_address.send(address).unwrap();
            studio::serve_survey_until(exhibit, Some(0), ready, stopped).unwrap();
        });
        Self { address: address.recv_timeout(PATIENCE).unwrap(), stop: Some(stop) }
    }

    pub(crate) fn page(&self) -> Page {
        mapping_page(self.address)
    }

    pub(crate) fn page_as(&self, origin: &str, host: &str) -> Result<Page, u16> {
        connect(self.address, "/map/ws", origin, host)
    }

    pub(crate) fn get(&self, path: &str, host: &str) -> (String, String, Vec<u8>) {
        let head = format!("GET {path} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n");
        exchange(self.address, &head, &[])
    }

    /// Status line and text of the answer; `length` lies about the body's length.
    pub(crate) fn post(&self, path: &str, body: &[u8], length: Option<usize>) -> (String, String) {
        self.send(&format!("http://{}", self.address), path, body, length)
    }

    pub(crate) fn post_as(&self, origin: &str, path: &str, body: &[u8]) -> (String, String) {
        self.send(origin, path, body, None)
    }

    fn send(
        &self,
        origin: &str,
        path: &str,
        body: &[u8],
        length: Option<usize>,
    ) -> (String, String) {
        let (host, length) = (self.address, length.unwrap_or(body.len()));
        let head = format!(
            "POST {path} HTTP/1.1\r\nHost: {host}\r\nOrigin: {origin}\r\nContent-Length: {length}\r\n\
             Connection: close\r\n\r\n"
        );
        let (status, _, text) = exchange(self.address, &head, body);
        (status, String::from_utf8(text).unwrap())
    }
}

impl Drop for MappingStudio {
    fn drop(&mut self) {
        if let Some(stop) = self.stop.take() {
            // It may have ended by itself.
            let (Ok(()) | Err(())) = stop.send(());
        }
    }
}

/// The mapping page of a studio.
pub(crate) fn mapping_page(address: SocketAddr) -> Page {
    connect(address, "/map/ws", &format!("http://{address}"), &address.to_string()).unwrap()
}

/// What a page draws, read from the description of the messages alone.
#[derive(Clone, Debug, Default)]
pub(crate) struct Picture {
    slot: u8,
    run: Option<u32>,
    /// By column and row; without the unknown ones.
    cells: BTreeMap<(i32, i32), u8>,
    pub(crate) cell_m: f64,
    pub(crate) tracks: [Vec<[f32; 3]>; 3],
    pub(crate) n_vertices: usize,
    pub(crate) n_edges: usize,
    pub(crate) n_closures: usize,
    pub(crate) half_angle_rad: f32,
    pub(crate) n_cones: usize,
    pub(crate) n_patch_cells: usize,
    pub(crate) registration: Option<Arc<Value>>,
}

impl Picture {
    pub(crate) fn of_slot(slot: u8) -> Self {
        Self { slot, ..Self::default() }
    }

    pub(crate) fn cells(&self) -> &BTreeMap<(i32, i32), u8> {
        &self.cells
    }

    fn take(&mut self, bytes: &[u8]) {
        let mut reader = Reader(bytes);
        let [kind, slot, zero, other_zero] = reader.take();
        assert_eq!([zero, other_zero], [0, 0]);
        let run = reader.u32();
        if slot != self.slot {
            return;
        }
        if self.run != Some(run) {
            *self = Self { slot, run: Some(run), ..Self::default() };
        }
        match kind {
            1 => self.take_tiles(&mut reader),
            2 => {
                let (which, first, n) = (reader.u32(), reader.u32(), reader.u32());
                let track = &mut self.tracks[which as usize];
                assert!(first as usize <= track.len(), "poses are missing");
                track.truncate(first as usize);
                track.extend((0..n).map(|_| [reader.f32(), reader.f32(), reader.f32()]));
            }
            3 => {
                self.n_vertices = reader.u32() as usize;
                (0..2 * self.n_vertices).for_each(|_| assert!(reader.f32().is_finite()));
                self.n_edges = reader.u32() as usize;
                let edge = |_| [reader.u32(), reader.u32(), reader.u32()];
                let edges: Vec<[u32; 3]> = (0..self.n_edges).map(edge).collect();
                assert!(edges.iter().all(|e| e[0].max(e[1]) < self.n_vertices as u32 && e[2] < 2));
                self.n_closures = edges.iter().filter(|edge| edge[2] == 1).count();
            }
            4 => {
                self.half_angle_rad = reader.f32();
                let n = reader.u32() as usize;
                self.n_cones = if self.half_angle_rad > 0.0 { n } else { 0 };
                let n_values = if self.half_angle_rad > 0.0 { 5 } else { 2 };
                (0..n * n_values).for_each(|_| assert!(reader.f32().is_finite()));
            }
            5 => {
                (0..6).for_each(|_| assert!(reader.f64().is_finite()));
                let (columns, rows, length) = (reader.u32(), reader.u32(), reader.u32());
                let cells = unpack(reader.bytes(length as usize));
                assert_eq!(cells.len(), (columns * rows) as usize);
                self.n_patch_cells = cells.iter().filter(|cell| **cell != 0).count();
            }
            other => panic!("kind {other} is not described"),
        }
        assert!(reader.0.is_empty(), "{} bytes more than described", reader.0.len());
    }

    fn take_tiles(&mut self, reader: &mut Reader<'_>) {
        assert!(reader.f64().is_finite() && reader.f64().is_finite());
        self.cell_m = reader.f64();
        for _ in 0..reader.u32() {
            let (column, row) = (reader.i32(), reader.i32());
            let length = u16::from_le_bytes(reader.take());
            let cells = unpack(reader.bytes(usize::from(length)));
            assert_eq!(cells.len(), 64 * 64);
            for (i, cell) in cells.into_iter().enumerate() {
                let key = (column + (i % 64) as i32, row + (i / 64) as i32);
                if cell == 0 {
                    self.cells.remove(&key);
                } else {
                    self.cells.insert(key, cell);
                }
            }
        }
    }
}

impl Page {
    /// Draws until a state comes that is `wanted`, and whatever comes with it.
    pub(crate) fn watch(
        &mut self,
        picture: &mut Picture,
        wanted: impl Fn(&Value) -> bool,
    ) -> Value {
        let mut found: Option<Value> = None;
        for _ in 0..N_MESSAGES_MAX {
            match self.socket.read().unwrap() {
                Message::Binary(bytes) => picture.take(&bytes),
                Message::Text(text) => {
                    let message: Value = serde_json::from_str(&text).unwrap();
                    if message["type"] == "registration" && message["slot"] == picture.slot {
                        picture.registration = Some(Arc::new(message));
                    } else if message["type"] == "state" && found.is_none() && wanted(&message) {
                        // What the state came with follows it; a wish brings the next message.
                        found = Some(message);
                        self.send(&serde_json::json!({"type": "speed", "ratio": 3.25}));
                    } else if message["type"] == "state"
                        && message["speed_ratio"] == 3.25
                        && let Some(found) = found
                    {
                        return found;
                    }
                }
                _ => {}
            }
        }
        panic!("no such state");
    }

    /// Bytes of all messages until a state that is `wanted`.
    pub(crate) fn bytes_until(&mut self, wanted: impl Fn(&Value) -> bool) -> usize {
        let mut n_bytes = 0;
        loop {
            let message = self.socket.read().unwrap();
            n_bytes += message.len();
            if let Message::Text(text) = message {
                let message: Value = serde_json::from_str(&text).unwrap();
                if message["type"] == "state" && wanted(&message) {
                    return n_bytes;
                }
            }
        }
    }
}

fn unpack(mut packed: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    while let [n, rest @ ..] = packed {
        let n = usize::from(*n);
        if n < 128 {
            bytes.extend(&rest[..=n]);
            packed = &rest[n + 1..];
        } else {
            bytes.extend(std::iter::repeat_n(rest[0], 257 - n));
            packed = &rest[1..];
        }
    }
    bytes
}

struct Reader<'a>(&'a [u8]);

impl<'a> Reader<'a> {
    fn bytes(&mut self, n: usize) -> &'a [u8] {
        let (bytes, rest) = self.0.split_at(n);
        self.0 = rest;
        bytes
    }

    fn take<const N: usize>(&mut self) -> [u8; N] {
        self.bytes(N).try_into().unwrap()
    }

    fn u32(&mut self) -> u32 {
        u32::from_le_bytes(self.take())
    }

    fn i32(&mut self) -> i32 {
        i32::from_le_bytes(self.take())
    }

    fn f32(&mut self) -> f32 {
        f32::from_le_bytes(self.take())
    }

    fn f64(&mut self) -> f64 {
        f64::from_le_bytes(self.take())
    }
}
