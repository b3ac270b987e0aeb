//! A studio in this process and pages that talk to it, for the tests.

#![expect(dead_code, reason = "each test file uses a part of it")]

pub(crate) mod mapping;

use std::{
    io::{ErrorKind, Read, Write},
    net::{SocketAddr, TcpStream},
    path::{Path, PathBuf},
    sync::mpsc,
    thread::JoinHandle,
    time::Duration,
};

use missions::{Mission, Recorder, Run};
use serde_json::{Value, json};
use studio::{Options, Show};
use tokio::sync::oneshot;
use tungstenite::{Message, WebSocket, client::IntoClientRequest, http::HeaderValue};

/// Nothing that is awaited here takes this long; it turns a hang into a failure.
const PATIENCE: Duration = Duration::from_mins(1);
/// Messages read in search of one.
const N_MESSAGES_MAX: usize = 50_000;

/// A studio on a free port.
#[derive(Debug)]
pub(crate) struct Studio {
    pub(crate) address: SocketAddr,
    stop: Option<oneshot::Sender<()>>,
    thread: Option<JoinHandle<anyhow::Result<Vec<PathBuf>>>>,
}

impl Studio {
    pub(crate) fn start(show: Show, speed_ratio: f64) -> Self {
        let (tell_address, address) = mpsc::channel();
        let (stop, stopped) = oneshot::channel();
        let thread = std::thread::spawn(move || {
            let options = Options { port: Some(0), speed_ratio };
            let stopped = async { drop(stopped.await) };
            studio::serve_until(
                show,
                options,
                |address| tell_address.send(address).unwrap(),
                stopped,
            )
        });
        let address = address.recv_timeout(PATIENCE).unwrap();
        Self { address, stop: Some(stop), thread: Some(thread) }
    }

    pub(crate) fn of(mission: &str, speed_ratio: f64) -> Self {
        Self::start(live(mission, None), speed_ratio)
    }

    pub(crate) fn page(&self) -> Page {
        self.page_as(&format!("http://{}", self.address), &self.address.to_string()).unwrap()
    }

    /// Connects with an origin and a host of one's choice; the status of a refusal.
    pub(crate) fn page_as(&self, origin: &str, host: &str) -> Result<Page, u16> {
        connect(self.address, "/ws", origin, host)
    }

    /// Status line, headers and body of a plain request.
    pub(crate) fn get(&self, path: &str, host: &str) -> (String, String, Vec<u8>) {
        let head = format!("GET {path} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n");
        exchange(self.address, &head, &[])
    }

    /// Brings a body; status line and text of the answer.
    pub(crate) fn post(&self, path: &str, body: &[u8]) -> (String, String) {
        let (host, length) = (self.address, body.len());
        let head = format!(
            "POST {path} HTTP/1.1\r\nHost: {host}\r\nContent-Length: {length}\r\nConnection: close\r\n\r\n"
        );
        let (status, _, text) = exchange(self.address, &head, body);
        (status, String::from_utf8(text).unwrap())
    }

    /// Ends it as Ctrl-C would; the recordings' paths.
    pub(crate) fn stop(mut self) -> Vec<PathBuf> {
        self.stop.take().unwrap().send(()).unwrap();
        self.thread.take().unwrap().join().unwrap().unwrap()
    }
}

impl Drop for Studio {
    fn drop(&mut self) {
        if let Some(stop) = self.stop.take() {
            // It may have ended by itself.
            let (Ok(()) | Err(())) = stop.send(());
        }
    }
}

/// Opens a socket with an origin and a host of one's choice; the status of a refusal.
fn connect(address: SocketAddr, path: &str, origin: &str, host: &str) -> Result<Page, u16> {
    let stream = TcpStream::connect(address).unwrap();
    stream.set_read_timeout(Some(PATIENCE)).unwrap();
    stream.set_write_timeout(Some(PATIENCE)).unwrap();
    let mut request = format!("ws://{address}{path}").into_client_request().unwrap();
    let headers = request.headers_mut();
    headers.insert("Origin", HeaderValue::from_str(origin).unwrap());
    headers.insert("Host", HeaderValue::from_str(host).unwrap());
    match tungstenite::client(request, stream) {
        Ok((socket, _)) => Ok(Page { socket }),
        Err(tungstenite::HandshakeError::Failure(tungstenite::Error::Http(response))) => {
            Err(response.status().as_u16())
        }
        Err(other) => panic!("{other}"),
    }
}

/// Sends a plain request; status line, headers and body of the answer.
fn exchange(address: SocketAddr, head: &str, body: &[u8]) -> (String, String, Vec<u8>) {
    let mut stream = TcpStream::connect(address).unwrap();
    stream.set_read_timeout(Some(PATIENCE)).unwrap();
    stream.write_all(head.as_bytes()).unwrap();
    stream.write_all(body).unwrap();
    let mut answer = Vec::new();
    // A server that refuses a body may close the line before all of it came.
    let (Ok(_) | Err(_)) = stream.read_to_end(&mut answer);
    let end = answer.windows(4).position(|w| w == b"\r\n\r\n").unwrap();
    let head = String::from_utf8(answer[..end].to_vec()).unwrap();
    let (status, headers) = head.split_once("\r\n").unwrap();
    (status.to_owned(), headers.to_lowercase(), answer[end + 4..].to_vec())
}

/// What a browser's page would be.
#[derive(Debug)]
pub(crate) struct Page {
    socket: WebSocket<TcpStream>,
}

impl Page {
    pub(crate) fn send(&mut self, request: &Value) {
        self.send_text(&request.to_string());
    }

    pub(crate) fn send_text(&mut self, text: &str) {
        self.socket.send(Message::text(text)).unwrap();
    }

    /// Sends what the studio may refuse before all of it came.
    pub(crate) fn send_too_much(&mut self, text: &str) {
        let (Ok(()) | Err(_)) = self.socket.send(Message::text(text));
    }

    /// The next message.
    pub(crate) fn next(&mut self) -> Value {
        loop {
            if let Message::Text(text) = self.socket.read().unwrap() {
                return serde_json::from_str(&text).unwrap();
            }
        }
    }

    /// Whether the studio ends the connection; silence and an answer do not count as that.
    pub(crate) fn is_shown_out(&mut self) -> bool {
        let ends = (0..N_MESSAGES_MAX).find_map(|_| match self.socket.read() {
            Ok(Message::Text(text)) if text.contains(r#""type":"error""#) => Some(false),
            Ok(_) => None,
            Err(tungstenite::Error::Io(error)) => {
                let is_silence =
                    matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut);
                Some(!is_silence)
            }
            Err(_) => Some(true),
        });
        ends.unwrap_or(false)
    }

    /// Reads on to a message of this type that `wanted` accepts.
    pub(crate) fn until(&mut self, kind: &str, wanted: impl Fn(&Value) -> bool) -> Value {
        let mut last = Value::Null;
        for _ in 0..N_MESSAGES_MAX {
            let message = self.next();
            if message["type"] != kind {
                continue;
            }
            if wanted(&message) {
                return message;
            }
            last = message;
        }
        panic!("no such {kind}; the last was {last}");
    }

    pub(crate) fn state(&mut self, wanted: impl Fn(&Value) -> bool) -> Value {
        self.until("state", wanted)
    }

    /// Holds the run; the state in which it holds.
    pub(crate) fn pause(&mut self) -> Value {
        self.send(&json!({"type": "pause"}));
        self.state(|s| s["playing"] == false)
    }

    /// One click on `step`; the state after it.
    pub(crate) fn step(&mut self, before: &Value) -> Value {
        let before = step_of(before);
        self.send(&json!({"type": "step"}));
        self.state(|s| step_of(s) > before)
    }

    /// The text of the next refusal.
    pub(crate) fn error(&mut self) -> String {
        self.until("error", |_| true)["text"].as_str().unwrap().to_owned()
    }
}

pub(crate) fn step_of(state: &Value) -> u64 {
    state["step"].as_u64().unwrap()
}

pub(crate) fn live(mission: &str, record: Option<PathBuf>) -> Show {
    let mission = Mission::load(mission, &[]).unwrap();
    let seed = mission.seed();
    let record = record.map(|path| studio::Recordings::new(path, files::Outputs::new(false)));
    Show::Mission { mission: Box::new(mission), seed, record }
}

/// Runs a mission to its end without a studio and records it.
pub(crate) fn record(mission: &str, path: &Path) {
    let mission = Mission::load(mission, &[]).unwrap();
    let seed = mission.seed();
    let mut run = Run::new(mission, seed).unwrap();
    let mut recorder = Recorder::create(path, &run, &files::Outputs::new(false)).unwrap();
    while run.finished().is_none() {
        run.step();
        let said = run.drain_log();
        recorder.record(&run, &said).unwrap();
    }
    recorder.finish(&run).unwrap();
}
