//! The studio among clients that mean no good: what they cost in memory, and whether honest pages notice.
//!
//! Small numbers unless `CAIRN_HOSTILE=full` asks for twenty sockets, uploads of 250 MB and half a minute:
//! `CAIRN_HOSTILE=full cargo test --release -p cairn --test hostile -- --nocapture`. Memory is bounded in both; how
//! long a frame may come late depends on the machine and is held to in the full form only.

#![expect(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot go on fails")]
#![expect(
    clippy::disallowed_methods,
    reason = "what honest pages notice is measured by the clock, and printed"
)]

mod support;

use std::{
    io::{BufRead as _, BufReader, Read as _, Write as _},
    net::TcpStream,
    process::{Child, Stdio},
    sync::atomic::{AtomicBool, AtomicUsize, Ordering},
    thread,
    time::{Duration, Instant},
};

use support::Place;
use tungstenite::{Message, WebSocket, client::IntoClientRequest as _};

/// What the hostile clients may add to the program's memory, bytes.
const ADDED_BYTES_MAX: u64 = 50 * 1024 * 1024;
/// How much later than in quiet a frame may come, in the full form.
const LATER_MAX: Duration = Duration::from_millis(100);

/// How hard it is tried.
struct Trial {
    is_full: bool,
    lasts: Duration,
    n_of_each: usize,
    upload_bytes: usize,
    /// Logs that were read, that met another one being read, and that were refused for another reason.
    n_read: AtomicUsize,
    n_busy: AtomicUsize,
    n_refused: AtomicUsize,
}

impl Trial {
    fn wanted() -> Self {
        let is_full = std::env::var("CAIRN_HOSTILE").is_ok_and(|value| value == "full");
        let (secs, n_of_each, upload_bytes) =
            if is_full { (30, 5, 250_000_000) } else { (4, 2, 20_000_000) };
        let none = || AtomicUsize::new(0);
        let (n_read, n_busy, n_refused) = (none(), none(), none());
        let lasts = Duration::from_secs(secs);
        Self { is_full, lasts, n_of_each, upload_bytes, n_read, n_busy, n_refused }
    }
}

struct Studio {
    process: Child,
    address: String,
}

impl Studio {
    fn start(place: &Place) -> Self {
        let mut command = place.command();
        command.args(["run", "doorbell", "--port", "0"]).stdout(Stdio::piped());
        let mut process = command.stderr(Stdio::null()).spawn().unwrap();
        let lines = BufReader::new(process.stdout.take().unwrap()).lines();
        let address = lines
            .map_while(Result::ok)
            .find_map(|line| Some(line.split_once("http://")?.1.split(' ').next()?.to_owned()));
        Self { process, address: address.expect("an address") }
    }

    fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(&self.address).unwrap();
        stream.set_read_timeout(Some(Duration::from_mins(1))).unwrap();
        stream.set_write_timeout(Some(Duration::from_mins(1))).unwrap();
        stream
    }

    fn page(&self, path: &str) -> WebSocket<TcpStream> {
        let request = format!("ws://{}{path}", self.address).into_client_request().unwrap();
        tungstenite::client(request, self.connect()).expect("a socket").0
    }

    /// Resident now and at its peak, bytes; `None` where the system does not tell.
    fn memory(&self) -> Option<[u64; 2]> {
        let status = format!("/proc/{}/status", self.process.id());
        let status = std::fs::read_to_string(status).ok()?;
        let of = |name: &str| {
            let line = status.lines().find(|line| line.starts_with(name))?;
            Some(line.split_whitespace().nth(1)?.parse::<u64>().ok()? * 1024)
        };
        Some([of("VmRSS:")?, of("VmHWM:")?])
    }

    fn forget_peak(&self) {
        // Where it cannot be reset, the peak so far counts as well.
        drop(std::fs::write(format!("/proc/{}/clear_refs", self.process.id()), "5"));
    }
}

impl Drop for Studio {
    fn drop(&mut self) {
        self.process.kill().unwrap();
        self.process.wait().unwrap();
    }
}

/// Reads a page's frames until told otherwise; their number and the longest wait for one.
fn watch(
    mut page: WebSocket<TcpStream>,
    kind: &'static str,
    stop: &AtomicBool,
) -> (usize, Duration) {
    let (mut n, mut longest, mut last) = (0, Duration::ZERO, Instant::now());
    while !stop.load(Ordering::Relaxed) {
        let message = page.read().expect("an honest page is served to the end");
        let Message::Text(text) = message else { continue };
        if text.starts_with(&format!("{{\"type\":\"{kind}\"")) {
            longest = longest.max(last.elapsed());
            (n, last) = (n + 1, Instant::now());
        }
    }
    (n, longest)
}

/// The frames that two honest pages see while `meanwhile` happens: number and longest wait of each.
fn watched(studio: &Studio, meanwhile: impl FnOnce()) -> [(usize, Duration); 2] {
    let stop = AtomicBool::new(false);
    let (mission, mut mapping) = (studio.page("/ws"), studio.page("/map/ws"));
    for request in [r#"{"type":"rewind"}"#, r#"{"type":"speed","ratio":0.5}"#] {
        mapping.send(Message::text(request)).unwrap();
    }
    thread::scope(|scope| {
        let one = scope.spawn(|| watch(mission, "state", &stop));
        let other = scope.spawn(|| watch(mapping, "state", &stop));
        meanwhile();
        stop.store(true, Ordering::Relaxed);
        [one.join().unwrap(), other.join().unwrap()]
    })
}

/// What a hostile client does until `stop`; it may be thrown out at any time.
type Attack = fn(&Studio, &Trial, &AtomicBool);

/// A frame that claims ten megabytes, and sends them.
fn huge_frame(studio: &Studio, _: &Trial, stop: &AtomicBool) {
    while !stop.load(Ordering::Relaxed) {
        let mut socket = studio.page("/ws");
        let stream = socket.get_mut();
        let mut head = vec![0x81, 0xff];
        head.extend(10_000_000_u64.to_be_bytes());
        head.extend([1, 2, 3, 4]);
        let mut is_taken = stream.write_all(&head).is_ok();
        let piece = vec![b'x'; 64 * 1024];
        for _ in 0..160 {
            is_taken &= stream.write_all(&piece).is_ok();
        }
        if is_taken {
            drop(stream.read(&mut [0; 1024]));
        }
        thread::sleep(Duration::from_millis(100));
    }
}

/// Opens both kinds of pages and reads nothing.
fn never_reads(studio: &Studio, _: &Trial, stop: &AtomicBool) {
    let sockets = [studio.page("/ws"), studio.page("/map/ws")];
    while !stop.load(Ordering::Relaxed) {
        thread::sleep(Duration::from_millis(100));
    }
    drop(sockets);
}

/// A request that comes byte by byte.
fn slow_loris(studio: &Studio, _: &Trial, stop: &AtomicBool) {
    let mut stream = studio.connect();
    for byte in format!("GET / HTTP/1.1\r\nHost: {}\r\nX: ", studio.address).bytes().cycle() {
        if stop.load(Ordering::Relaxed) || stream.write_all(&[byte]).is_err() {
            return;
        }
        thread::sleep(Duration::from_millis(200));
    }
}

/// Half a request, half a body, half a handshake; and nothing more.
fn half_requests(studio: &Studio, _: &Trial, stop: &AtomicBool) {
    let host = &studio.address;
    let halves = [
        "GET / HT".to_owned(),
        format!("GET /ws HTTP/1.1\r\nHost: {host}\r\nUpgrade: websocket\r\n"),
        format!(
            "POST /map/recording?name=x HTTP/1.1\r\nHost: {host}\r\nContent-Length: 9000000\r\n\r\nhalf"
        ),
    ];
    let mut streams: Vec<TcpStream> = halves.iter().map(|_| studio.connect()).collect();
    for (stream, half) in streams.iter_mut().zip(&halves) {
        drop(stream.write_all(half.as_bytes()));
    }
    while !stop.load(Ordering::Relaxed) {
        thread::sleep(Duration::from_millis(100));
    }
}

/// Messages without a pause, sense and nonsense, of which no answer is read.
fn flood(studio: &Studio, _: &Trial, stop: &AtomicBool) {
    let mut socket = studio.page("/map/ws");
    socket.get_ref().set_write_timeout(Some(Duration::from_millis(200))).unwrap();
    let texts = [
        r#"{"type":"fly"}"#,
        r#"{"type":"sample","name":"laser-room"}"#,
        r#"{"type":"speed","ratio":0.5}"#,
    ];
    for text in texts.into_iter().cycle() {
        if stop.load(Ordering::Relaxed) {
            return;
        }
        drop(socket.send(Message::text(text)));
    }
}

/// A log of scans with `n_readings` each, from which pieces are sent over and over.
fn log_of(n_readings: usize) -> String {
    let readings = " 12.34".repeat(n_readings);
    let line = |i| format!("FLASER {n_readings}{readings} 2.0 0 0 2.0 0 0 {i}.25 host {i}.25\n");
    (0..100).map(line).collect()
}

/// Logs, one after the other, whatever is answered: with their length and without, short scans and long ones, as
/// much as may be brought and more.
fn upload(studio: &Studio, trial: &Trial, stop: &AtomicBool) {
    let largest = 10 * 1024 * 1024;
    let trials = [
        (log_of(5), trial.upload_bytes, true),
        (log_of(5), trial.upload_bytes, false),
        (log_of(180), largest, true),
        (log_of(180), largest, false),
        (log_of(361), largest - 1000, true),
        (log_of(5), largest / 5, false),
    ];
    for (piece, n_bytes, is_told) in trials.iter().cycle() {
        if stop.load(Ordering::Relaxed) {
            return;
        }
        send_log(studio, trial, (piece, *n_bytes, *is_told), stop);
        thread::sleep(Duration::from_millis(50));
    }
}

fn send_log(
    studio: &Studio,
    trial: &Trial,
    (piece, n_bytes, is_told): (&str, usize, bool),
    stop: &AtomicBool,
) {
    let mut stream = studio.connect();
    let length = if is_told {
        format!("Content-Length: {n_bytes}")
    } else {
        "Transfer-Encoding: chunked".to_owned()
    };
    let head = format!(
        "POST /map/recording?name=x.log HTTP/1.1\r\nHost: {}\r\n{length}\r\n\r\n",
        studio.address
    );
    drop(stream.write_all(head.as_bytes()));
    let mut left = n_bytes;
    while left > 0 && !stop.load(Ordering::Relaxed) {
        let n = left.min(piece.len());
        let mut part = piece.as_bytes()[..n].to_vec();
        if !is_told {
            part = [format!("{n:x}\r\n").as_bytes(), &part, b"\r\n"].concat();
        }
        if stream.write_all(&part).is_err() {
            break;
        }
        left -= n;
    }
    if !is_told {
        drop(stream.write_all(b"0\r\n\r\n"));
    }
    let mut answer = [0; 12];
    let status = stream.read_exact(&mut answer).is_ok().then(|| answer[9..].to_vec());
    let counted = match status.as_deref() {
        Some(b"204") => &trial.n_read,
        Some(b"409") => &trial.n_busy,
        _ => &trial.n_refused,
    };
    counted.fetch_add(1, Ordering::Relaxed);
}

/// Every attack several times at once, and eight who bring logs, for as long as the trial lasts.
fn attack_with(attacks: &[Attack], studio: &Studio, trial: &Trial) {
    let stop = &AtomicBool::new(false);
    thread::scope(|scope| {
        for _ in 0..trial.n_of_each {
            for attack in attacks {
                scope.spawn(move || attack(studio, trial, stop));
            }
        }
        for _ in 0..8 {
            scope.spawn(move || upload(studio, trial, stop));
        }
        thread::sleep(trial.lasts);
        stop.store(true, Ordering::Relaxed);
    });
}

#[test]
fn hostile_clients_cost_little_memory_and_honest_pages_go_on() {
    let place = Place::new();
    let (studio, trial) = (Studio::start(&place), Trial::wanted());
    let mut mapping = studio.page("/map/ws");
    mapping.send(Message::text(r#"{"type":"sample","name":"laser-room"}"#)).unwrap();
    while !mapping.read().unwrap().to_string().contains(r#""phase":"under way""#) {}
    drop(mapping);
    let quiet = watched(&studio, || thread::sleep(trial.lasts / 4));
    let before = studio.memory();
    studio.forget_peak();
    let attacks: [Attack; 5] = [huge_frame, never_reads, slow_loris, half_requests, flood];
    // Samples that a flood asks for, and halves of logs, keep other logs out; so once more without them.
    for attacks in [&attacks[..], &attacks[..3]] {
        let disturbed = watched(&studio, || attack_with(attacks, &studio, &trial));
        for (page, (quiet, disturbed)) in
            ["mission", "mapping"].iter().zip(quiet.iter().zip(&disturbed))
        {
            eprintln!(
                "{page} page: longest wait for a frame {:?} in quiet, {:?} under {} attacks ({} frames)",
                quiet.1,
                disturbed.1,
                attacks.len(),
                disturbed.0
            );
            assert!(disturbed.0 > 10, "the {page} page is served");
            assert!(!trial.is_full || disturbed.1 <= quiet.1 + LATER_MAX, "a frame came late");
        }
    }
    let n = [&trial.n_read, &trial.n_busy, &trial.n_refused].map(|n| n.load(Ordering::Relaxed));
    eprintln!("logs: {} read, {} met another being read, {} refused", n[0], n[1], n[2]);
    assert!(n[0] > 0 && n[2] > 0, "logs are read and refused");
    match (before, studio.memory()) {
        (Some([before, _]), Some([after, peak])) => {
            let [added, kept] = [peak, after].map(|bytes| bytes.saturating_sub(before));
            eprintln!(
                "memory: {} kB, at most {} kB more, {} kB kept",
                before / 1024,
                added / 1024,
                kept / 1024
            );
            assert!(added <= ADDED_BYTES_MAX, "{added} bytes more");
        }
        _ => eprintln!("skipped: this system does not tell how much memory a program has"),
    }
}
