//! Where clients come from, and one of them over TCP.

use std::{
    io::{ErrorKind, Read, Write},
    net::{Shutdown, SocketAddr, TcpListener, TcpStream},
    time::Duration,
};

use anyhow::Context;
use serialport::SerialPort;

/// Bytes taken per read.
const READ_SIZE: usize = 4096;
/// Bytes that may wait for a client that does not read; it is dropped beyond that. Five minutes of
/// a robot's usual packets.
const WAITING_BYTES_MAX: usize = 256 * 1024;

/// Bytes of a client that has to go that are still read.
const UNREAD_BYTES_MAX: usize = 64 * 1024;

/// Where clients come from.
pub(crate) enum Door {
    /// A TCP port.
    Tcp(TcpListener),
    /// A serial line, on which somebody is always taken to be listening.
    Serial(SerialDoor),
}

/// A serial line.
pub(crate) struct SerialDoor {
    port: Box<dyn SerialPort>,
    name: String,
    baud: Option<u32>,
    /// The clients' end of a pseudo-terminal: it stays open so that they may come and go.
    _other_end: Option<Box<dyn SerialPort>>,
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
        let port = port.with_context(|| format!("cannot open the serial line {device}"))?;
        let name = port.name().unwrap_or_else(|| device.to_owned());
        Ok(Self::Serial(SerialDoor { port, name, baud: Some(baud), _other_end: None }))
    }

    /// Opens a pseudo-terminal, which is a serial line within this computer; its name is the clients' end.
    #[cfg(unix)]
    pub(crate) fn pty() -> anyhow::Result<Self> {
        let (mut port, mut other) =
            serialport::TTYPort::pair().context("cannot open a pseudo-terminal")?;
        // Clients open it beside us.
        other.set_exclusive(false).context("cannot share a pseudo-terminal")?;
        port.set_timeout(Duration::from_millis(1)).context("cannot set up a pseudo-terminal")?;
        let name = other.name().context("a pseudo-terminal without a name")?;
        let (port, other): (Box<dyn SerialPort>, Box<dyn SerialPort>) =
            (Box::new(port), Box::new(other));
        Ok(Self::Serial(SerialDoor { port, name, baud: None, _other_end: Some(other) }))
    }

    /// Pseudo-terminals are not of this system.
    #[cfg(not(unix))]
    pub(crate) fn pty() -> anyhow::Result<Self> {
        anyhow::bail!("this system has no pseudo-terminals; give a device with --serial")
    }

    /// The address that clients connect to, or the device.
    pub(crate) fn name(&self) -> String {
        match self {
            Self::Tcp(listener) => {
                listener.local_addr().map_or_else(|_| "?".to_owned(), |address| address.to_string())
            }
            Self::Serial(line) => line.name.clone(),
        }
    }

    /// Somebody who has come, if anybody has.
    pub(super) fn accept(&self) -> Option<Client> {
        let Self::Tcp(listener) = self else {
            return None;
        };
        let (stream, address) = listener.accept().ok()?;
        stream.set_nonblocking(true).ok()?;
        // Packets are small and late ones are worthless.
        stream.set_nodelay(true).ok()?;
        Some(Client { stream, waiting: Vec::new(), address: address.to_string() })
    }
}

/// A client over TCP.
pub(super) struct Client {
    stream: TcpStream,
    waiting: Vec<u8>,
    pub(super) address: String,
}

/// Why a client is gone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Gone {
    /// It closed its end, or the connection broke.
    Left,
    /// It did not read what was sent.
    TooSlow,
}

impl Client {
    /// Appends what has arrived, at most `n_bytes_max`: what a flooding client sends beyond waits
    /// at its own end.
    pub(super) fn receive(&mut self, n_bytes_max: usize, into: &mut Vec<u8>) -> Result<(), Gone> {
        let mut buffer = [0; READ_SIZE];
        let mut n_left = n_bytes_max;
        while n_left > 0 {
            let room = &mut buffer[..READ_SIZE.min(n_left)];
            match self.stream.read(room) {
                Ok(0) => return Err(Gone::Left),
                Ok(n) => {
                    into.extend_from_slice(&buffer[..n]);
                    n_left -= n;
                }
                Err(error) if error.kind() == ErrorKind::WouldBlock => return Ok(()),
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(_broken) => return Err(Gone::Left),
            }
        }
        Ok(())
    }

    /// Whether it is still there, as far as can be told without reading.
    pub(super) fn is_there(&self) -> bool {
        let mut byte = [0];
        match self.stream.peek(&mut byte) {
            Ok(n) => n > 0,
            Err(error) => matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted),
        }
    }

    /// Sends what it can without waiting.
    pub(super) fn send(&mut self, bytes: &[u8]) -> Result<(), Gone> {
        self.waiting.extend_from_slice(bytes);
        while !self.waiting.is_empty() {
            match self.stream.write(&self.waiting) {
                Ok(n) => drop(self.waiting.drain(..n)),
                Err(error) if error.kind() == ErrorKind::WouldBlock => break,
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(_broken) => return Err(Gone::Left),
            }
        }
        if self.waiting.len() > WAITING_BYTES_MAX { Err(Gone::TooSlow) } else { Ok(()) }
    }

    /// Says why it has to go; a person with a terminal reads it, a robot's client skips it.
    pub(super) fn dismiss(mut self, reason: &str) {
        // What is left unread would end the connection before the reason arrives.
        let mut unread = Vec::new();
        let _it_may_be_gone = self.receive(UNREAD_BYTES_MAX, &mut unread);
        let _it_may_be_gone = self.send(format!("cairn: {reason}\r\n").as_bytes());
        let _it_may_be_gone = self.stream.shutdown(Shutdown::Both);
    }
}

impl SerialDoor {
    /// Appends what has arrived.
    pub(super) fn receive(&mut self, n_bytes_max: usize, into: &mut Vec<u8>) -> anyhow::Result<()> {
        let n_waiting = self.port.bytes_to_read().context("the serial line broke")? as usize;
        let mut buffer = [0; READ_SIZE];
        let n_wanted = n_waiting.min(READ_SIZE).min(n_bytes_max);
        if n_wanted > 0 {
            let n = self.port.read(&mut buffer[..n_wanted]).context("the serial line broke")?;
            into.extend_from_slice(&buffer[..n]);
        }
        Ok(())
    }

    /// Sends.
    pub(super) fn send(&mut self, bytes: &[u8]) -> anyhow::Result<()> {
        match self.port.write_all(bytes) {
            // Nobody reads at the other end: the bytes are lost, as on a real line.
            Err(e) if matches!(e.kind(), ErrorKind::TimedOut | ErrorKind::WouldBlock) => Ok(()),
            written => written.context("the serial line broke"),
        }
    }

    /// The robot speaks at another speed from now on; a line within this computer has none.
    pub(super) fn set_baud(&mut self, baud: u32) -> anyhow::Result<()> {
        if self.baud.is_some_and(|now| now != baud) {
            self.port.set_baud_rate(baud).context("the serial line refuses that speed")?;
            self.baud = Some(baud);
        }
        Ok(())
    }
}
