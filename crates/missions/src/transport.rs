//! Byte pipes to a robot: in memory, over TCP, over a serial line. The driver above cannot tell.

use std::{
    io::{self, Read, Write},
    net::{TcpStream, ToSocketAddrs},
    time::Duration,
};

use run_context::Stamp;
use wire::link::{End, Link};

/// How long a connection may take to be accepted.
const CONNECT_TIMEOUT: Duration = Duration::from_secs(3);
/// Bytes taken per read.
const READ_SIZE: usize = 4096;

/// A byte pipe to a robot.
///
/// Implementations never block for longer than a read or write that the operating system has ready.
pub trait Transport: Send {
    /// Sends bytes; they may be on their way for a while.
    ///
    /// # Errors
    ///
    /// [`TransportError`] when the other side is gone.
    fn send(&mut self, now: Stamp, bytes: &[u8]) -> Result<(), TransportError>;

    /// Appends what has arrived to `into`.
    ///
    /// # Errors
    ///
    /// [`TransportError`] when the other side is gone.
    fn receive(&mut self, now: Stamp, into: &mut Vec<u8>) -> Result<(), TransportError>;
}

/// A pipe that cannot be opened or has broken.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TransportError {
    /// It could not be opened.
    #[error("cannot connect to {target}: {source}; is the robot (or its simulator) switched on?")]
    Open {
        /// Address or device.
        target: String,
        /// Why.
        source: io::Error,
    },
    /// It broke.
    #[error("the link to {target} broke: {source}")]
    Broken {
        /// Address or device.
        target: String,
        /// Why.
        source: io::Error,
    },
}

/// The client's end of a link in memory, in virtual time.
#[derive(Debug)]
pub struct MemoryTransport<'l> {
    link: &'l mut Link,
    end: End,
}

impl<'l> MemoryTransport<'l> {
    /// One end of `link`.
    pub fn new(link: &'l mut Link, end: End) -> Self {
        Self { link, end }
    }
}

impl Transport for MemoryTransport<'_> {
    fn send(&mut self, now: Stamp, bytes: &[u8]) -> Result<(), TransportError> {
        self.link.send(self.end, now, bytes);
        Ok(())
    }

    fn receive(&mut self, now: Stamp, into: &mut Vec<u8>) -> Result<(), TransportError> {
        self.link.receive(self.end, now, into);
        Ok(())
    }
}

/// A TCP connection, such as to a robot simulator on port 8101 or to a serial-to-Ethernet converter.
#[derive(Debug)]
pub struct TcpTransport {
    stream: TcpStream,
    target: String,
}

impl TcpTransport {
    /// Connects to `address` (`host:port`).
    ///
    /// # Errors
    ///
    /// [`TransportError::Open`] when nobody answers within 3 s.
    pub fn connect(address: &str) -> Result<Self, TransportError> {
        let open = |source| TransportError::Open { target: address.to_owned(), source };
        let mut last = io::Error::new(io::ErrorKind::NotFound, "the address resolves to nothing");
        for resolved in address.to_socket_addrs().map_err(open)? {
            match TcpStream::connect_timeout(&resolved, CONNECT_TIMEOUT) {
                Ok(stream) => {
                    stream.set_nonblocking(true).map_err(open)?;
                    stream.set_nodelay(true).map_err(open)?;
                    return Ok(Self { stream, target: address.to_owned() });
                }
                Err(error) => last = error,
            }
        }
        Err(open(last))
    }

    fn broken(&self, source: io::Error) -> TransportError {
        TransportError::Broken { target: self.target.clone(), source }
    }
}

impl Transport for TcpTransport {
    fn send(&mut self, _now: Stamp, bytes: &[u8]) -> Result<(), TransportError> {
        send_all(&mut self.stream, bytes).map_err(|e| self.broken(e))
    }

    fn receive(&mut self, _now: Stamp, into: &mut Vec<u8>) -> Result<(), TransportError> {
        receive_ready(&mut self.stream, into).map_err(|e| self.broken(e))
    }
}

/// A serial line.
pub struct SerialTransport {
    port: Box<dyn serialport::SerialPort>,
    target: String,
}

impl std::fmt::Debug for SerialTransport {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("SerialTransport").field("target", &self.target).finish_non_exhaustive()
    }
}

impl SerialTransport {
    /// Opens `device` at `baud` bits per second, 8 data bits, no parity, 1 stop bit.
    ///
    /// # Errors
    ///
    /// [`TransportError::Open`] when the device is absent, busy or not permitted.
    pub fn open(device: &str, baud: u32) -> Result<Self, TransportError> {
        let port = serialport::new(device, baud).timeout(Duration::from_millis(1)).open();
        let port = port.map_err(|e| TransportError::Open {
            target: device.to_owned(),
            source: io::Error::other(e),
        })?;
        Ok(Self { port, target: device.to_owned() })
    }
}

impl Transport for SerialTransport {
    fn send(&mut self, _now: Stamp, bytes: &[u8]) -> Result<(), TransportError> {
        send_all(&mut self.port, bytes)
            .map_err(|source| TransportError::Broken { target: self.target.clone(), source })
    }

    fn receive(&mut self, _now: Stamp, into: &mut Vec<u8>) -> Result<(), TransportError> {
        let waiting = self.port.bytes_to_read().unwrap_or(0);
        if waiting == 0 {
            return Ok(());
        }
        receive_ready(&mut self.port, into)
            .map_err(|source| TransportError::Broken { target: self.target.clone(), source })
    }
}

/// Writes everything; what a full buffer refuses is lost, as on a line without flow control.
fn send_all(to: &mut impl Write, bytes: &[u8]) -> io::Result<()> {
    let mut rest = bytes;
    while !rest.is_empty() {
        match to.write(rest) {
            Ok(0) => return Err(io::ErrorKind::WriteZero.into()),
            Ok(n) => rest = &rest[n..],
            Err(e) if e.kind() == io::ErrorKind::Interrupted => {}
            Err(e) if is_not_ready(&e) => return Ok(()),
            Err(e) => return Err(e),
        }
    }
    Ok(())
}

/// Reads what is there, at most one buffer.
fn receive_ready(from: &mut impl Read, into: &mut Vec<u8>) -> io::Result<()> {
    let mut buffer = [0; READ_SIZE];
    match from.read(&mut buffer) {
        Ok(0) => Err(io::ErrorKind::UnexpectedEof.into()),
        Ok(n) => {
            into.extend_from_slice(&buffer[..n]);
            Ok(())
        }
        Err(e) if is_not_ready(&e) || e.kind() == io::ErrorKind::Interrupted => Ok(()),
        Err(e) => Err(e),
    }
}

fn is_not_ready(error: &io::Error) -> bool {
    matches!(error.kind(), io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut)
}
