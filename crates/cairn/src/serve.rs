//! A port on this computer with one client at a time, in ticks: what serves robots and servers.

use std::{
    io::{self, ErrorKind, Read, Write},
    net::{SocketAddr, TcpListener, TcpStream},
    time::{Duration, Instant},
};

use anyhow::Context;
use serialport::SerialPort;

use crate::output::note;

/// Bytes taken per read.
const READ_SIZE: usize = 4096;
/// Bytes taken per tick.
const RECEIVED_BYTES_MAX: usize = 64 * 1024;
/// Bytes that may wait for a client that does not read; it is dropped beyond that.
const WAITING_BYTES_MAX: usize = 1 << 20;

/// Something that answers bytes, tick by tick.
pub(crate) trait Peer {
    /// Takes what has arrived and appends the answer.
    fn tick(&mut self, received: &[u8], out: &mut Vec<u8>);
    /// The client is gone.
    fn hang_up(&mut self);
}

/// Where clients come from.
pub(crate) enum Door {
    /// A TCP port.
    Tcp(TcpListener),
    /// A serial line, on which somebody is always taken to be listening.
    Serial(Box<dyn SerialPort>),
}

impl Door {
    /// Opens a TCP port.
    pub(crate) fn tcp(address: SocketAddr) -> anyhow::Result<Self> {
        let listener = TcpListener::bind(address).with_context(|| {
            format!("cannot listen on {address}; choose another port with --listen")
        })?;
        listener.set_nonblocking(true).context("cannot listen without blocking")?;
        Ok(Self::Tcp(listener))
    }

    /// Opens a serial line, 8N1.
    pub(crate) fn serial(device: &str, baud: u32) -> anyhow::Result<Self> {
        let port = serialport::new(device, baud).timeout(Duration::from_millis(1)).open();
        Ok(Self::Serial(port.with_context(|| format!("cannot open the serial line {device}"))?))
    }

    /// The address that clients connect to, or the device.
    pub(crate) fn name(&self) -> String {
        match self {
            Self::Tcp(listener) => {
                listener.local_addr().map_or_else(|_| "?".to_owned(), |address| address.to_string())
            }
            Self::Serial(port) => port.name().unwrap_or_else(|| "the serial line".to_owned()),
        }
    }

    fn accept(&self) -> Option<(Client, String)> {
        let Self::Tcp(listener) = self else {
            return None;
        };
        let (stream, address) = listener.accept().ok()?;
        stream.set_nonblocking(true).ok()?;
        // Packets are small and late ones are worthless.
        stream.set_nodelay(true).ok()?;
        Some((Client { stream, waiting: Vec::new() }, address.to_string()))
    }
}

struct Client {
    stream: TcpStream,
    waiting: Vec<u8>,
}

impl Client {
    /// Appends what has arrived; an error means that the client is gone.
    fn receive(&mut self, into: &mut Vec<u8>) -> io::Result<()> {
        let mut buffer = [0; READ_SIZE];
        // What a flooding client sends beyond this waits in its socket.
        while into.len() < RECEIVED_BYTES_MAX {
            match self.stream.read(&mut buffer) {
                Ok(0) => return Err(ErrorKind::UnexpectedEof.into()),
                Ok(n) => into.extend_from_slice(&buffer[..n]),
                Err(error) if error.kind() == ErrorKind::WouldBlock => return Ok(()),
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }

    /// Sends what it can without waiting.
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.waiting.extend_from_slice(bytes);
        if self.waiting.len() > WAITING_BYTES_MAX {
            return Err(ErrorKind::TimedOut.into());
        }
        while !self.waiting.is_empty() {
            match self.stream.write(&self.waiting) {
                Ok(n) => drop(self.waiting.drain(..n)),
                Err(error) if error.kind() == ErrorKind::WouldBlock => break,
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }
}

/// Ticks `peer` every `period` of real time until the process is interrupted.
///
/// A second TCP client has to wait until the first has left, as with the real robot's one cable.
pub(crate) fn forever(mut door: Door, peer: &mut dyn Peer, period: Duration) -> anyhow::Result<()> {
    let mut client: Option<(Client, String)> = None;
    let (mut received, mut out) = (Vec::new(), Vec::new());
    let mut next_tick = Instant::now();
    loop {
        received.clear();
        out.clear();
        if client.is_none()
            && let Some(newcomer) = door.accept()
        {
            note(format_args!("{} connected", newcomer.1));
            client = Some(newcomer);
        }
        let mut alive = true;
        match (&mut door, &mut client) {
            (Door::Serial(port), _) => receive_serial(&mut **port, &mut received)?,
            (Door::Tcp(_), Some((client, _))) => alive = client.receive(&mut received).is_ok(),
            (Door::Tcp(_), None) => {}
        }
        peer.tick(&received, &mut out);
        match (&mut door, &mut client) {
            (Door::Serial(port), _) => {
                match port.write_all(&out) {
                    // Nobody reads at the other end: the bytes are lost, as on a real line.
                    Err(e) if matches!(e.kind(), ErrorKind::TimedOut | ErrorKind::WouldBlock) => {}
                    written => written.context("the serial line broke")?,
                }
            }
            (Door::Tcp(_), Some((client, _))) => alive = client.send(&out).is_ok() && alive,
            (Door::Tcp(_), None) => {}
        }
        if !alive && let Some((_, address)) = client.take() {
            note(format_args!("{address} left"));
            peer.hang_up();
        }
        next_tick += period;
        match next_tick.checked_duration_since(Instant::now()) {
            Some(rest) => std::thread::sleep(rest),
            // After a pause of the machine, go on from here instead of racing.
            None => next_tick = Instant::now(),
        }
    }
}

fn receive_serial(port: &mut dyn SerialPort, into: &mut Vec<u8>) -> anyhow::Result<()> {
    let n_waiting = port.bytes_to_read().context("the serial line broke")? as usize;
    let mut buffer = [0; READ_SIZE];
    let n_wanted = n_waiting.min(READ_SIZE);
    if n_wanted > 0 {
        let n = port.read(&mut buffer[..n_wanted]).context("the serial line broke")?;
        into.extend_from_slice(&buffer[..n]);
    }
    Ok(())
}
