//! The studio's door: takes connections, as many as it can keep, and shows out who is slow.
//!
//! Every bound of the server stands here or at the route that it is about. A connection costs a few kilobytes
//! while it is silent, and no more than one message or one upload while it is not.

use std::{
    io,
    net::{Ipv4Addr, SocketAddr},
    pin::Pin,
    sync::Arc,
    task::{Context, Poll},
    time::Duration,
};

use axum::{Router, extract::WebSocketUpgrade};
use hyper::server::conn::http1;
use hyper_util::{
    rt::{TokioIo, TokioTimer},
    service::TowerToHyperService,
};
use tokio::{
    io::{AsyncRead, AsyncWrite, ReadBuf},
    net::{TcpListener, TcpSocket, TcpStream},
    sync::{OwnedSemaphorePermit, Semaphore},
    time::{Instant, Sleep},
};

/// Connections at a time; one more is hung up on.
const N_CONNECTIONS_MAX: usize = 256;
/// Pages with a socket at a time, of both kinds together; one more is told so.
const N_PAGES_MAX: usize = 32;
/// Connections that wait to be taken.
const N_WAITING: u32 = 64;
/// Time in which the head of a request must be there; also how long an idle connection is kept.
const HEAD_PATIENCE: Duration = Duration::from_secs(10);
/// Longest head of a request, bytes.
const HEAD_BYTES_MAX: usize = 16 * 1024;
/// Most lines in it.
const N_HEADERS_MAX: usize = 64;
/// A client that takes nothing for this long, while there is something to take, is gone.
const WRITE_PATIENCE: Duration = Duration::from_secs(20);
/// Bytes that the system keeps for a client that does not read. More would be a queue of old frames.
const SEND_BUFFER_BYTES: u32 = 64 * 1024;
/// Bytes read from a page's socket at a time.
const READ_BUFFER_BYTES: usize = 4096;
/// Pause after a connection that could not be taken: there are no file handles left.
const ACCEPT_PAUSE: Duration = Duration::from_millis(100);
/// Messages a second that a page may send, and how many of them at once.
const MESSAGES_PER_S: f64 = 100.0;
/// See [`MESSAGES_PER_S`].
const MESSAGES_AT_ONCE: f64 = 100.0;

/// Listens on a port of this computer and of no other network, with a short queue towards each client.
///
/// # Errors
///
/// When the port is taken or not allowed.
pub(crate) fn listen(port: u16) -> io::Result<TcpListener> {
    let socket = TcpSocket::new_v4()?;
    // As the library's own listener does: a port is free again as soon as the program has ended.
    #[cfg(unix)]
    socket.set_reuseaddr(true)?;
    socket.set_send_buffer_size(SEND_BUFFER_BYTES)?;
    socket.bind(SocketAddr::from((Ipv4Addr::LOCALHOST, port)))?;
    socket.listen(N_WAITING)
}

/// Answers whoever comes, for ever.
pub(crate) async fn serve(listener: TcpListener, router: Router) {
    let places = Arc::new(Semaphore::new(N_CONNECTIONS_MAX));
    loop {
        let Ok((stream, _)) = listener.accept().await else {
            tokio::time::sleep(ACCEPT_PAUSE).await;
            continue;
        };
        let Ok(place) = places.clone().try_acquire_owned() else { continue };
        // Frames are small, and late ones are worthless; without it they only come later.
        drop(stream.set_nodelay(true));
        let service = TowerToHyperService::new(router.clone());
        let stream = TokioIo::new(Impatient { stream, stuck: None, _place: place });
        tokio::spawn(async move {
            let connection = http1::Builder::new()
                .timer(TokioTimer::new())
                .header_read_timeout(HEAD_PATIENCE)
                .max_buf_size(HEAD_BYTES_MAX)
                .max_headers(N_HEADERS_MAX)
                .serve_connection(stream, service)
                .with_upgrades();
            // A client that broke off is nobody's error.
            drop(connection.await);
        });
    }
}

/// A connection that gives up when its client takes nothing, and keeps its place until it ends.
struct Impatient {
    stream: TcpStream,
    /// Runs while the client takes nothing.
    stuck: Option<Pin<Box<Sleep>>>,
    _place: OwnedSemaphorePermit,
}

impl Impatient {
    fn judge<T>(
        &mut self,
        context: &mut Context<'_>,
        polled: Poll<io::Result<T>>,
    ) -> Poll<io::Result<T>> {
        if polled.is_ready() {
            self.stuck = None;
            return polled;
        }
        let begin = || Box::pin(tokio::time::sleep(WRITE_PATIENCE));
        match self.stuck.get_or_insert_with(begin).as_mut().poll(context) {
            Poll::Ready(()) => Poll::Ready(Err(io::ErrorKind::TimedOut.into())),
            Poll::Pending => Poll::Pending,
        }
    }
}

impl AsyncRead for Impatient {
    fn poll_read(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_read(context, buffer)
    }
}

impl AsyncWrite for Impatient {
    fn poll_write(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<io::Result<usize>> {
        let polled = Pin::new(&mut self.stream).poll_write(context, bytes);
        self.judge(context, polled)
    }

    fn poll_write_vectored(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        slices: &[io::IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        let polled = Pin::new(&mut self.stream).poll_write_vectored(context, slices);
        self.judge(context, polled)
    }

    fn is_write_vectored(&self) -> bool {
        self.stream.is_write_vectored()
    }

    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_flush(context)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_shutdown(context)
    }
}

/// The places for pages. Cloning gives another handle to them.
#[derive(Clone, Debug)]
pub(crate) struct Pages(Arc<Semaphore>);

impl Pages {
    /// All places free.
    pub(crate) fn new() -> Self {
        Self(Arc::new(Semaphore::new(N_PAGES_MAX)))
    }

    /// A place, kept until it is dropped.
    ///
    /// # Errors
    ///
    /// A sentence for the person at the page when all are taken.
    pub(crate) fn enter(&self) -> Result<OwnedSemaphorePermit, String> {
        self.0.clone().try_acquire_owned().map_err(|_full| {
            format!("{N_PAGES_MAX} pages of the studio are open already; close one of them")
        })
    }
}

/// A page's socket with its bounds: nothing longer than `bytes_max` is even taken in.
pub(crate) fn bounded(upgrade: WebSocketUpgrade, bytes_max: usize) -> WebSocketUpgrade {
    upgrade
        .read_buffer_size(READ_BUFFER_BYTES)
        .write_buffer_size(READ_BUFFER_BYTES)
        .max_frame_size(bytes_max)
        .max_message_size(bytes_max)
}

/// How much a page may still ask for: what it sends beyond that waits in its own socket.
#[derive(Debug)]
pub(crate) struct Allowance {
    left: f64,
    at: Instant,
}

impl Allowance {
    /// A full one.
    pub(crate) fn new() -> Self {
        Self { left: MESSAGES_AT_ONCE, at: Instant::now() }
    }

    /// Takes one message, and waits first where too many came.
    pub(crate) async fn take(&mut self) {
        let wait_s = self.charge(Instant::now());
        if wait_s > 0.0 {
            tokio::time::sleep(Duration::from_secs_f64(wait_s)).await;
        }
    }

    /// Takes one message at `now`; how long it has to wait, s.
    fn charge(&mut self, now: Instant) -> f64 {
        let passed_s = now.saturating_duration_since(self.at).as_secs_f64();
        self.left = (self.left + passed_s * MESSAGES_PER_S).min(MESSAGES_AT_ONCE) - 1.0;
        self.at = now;
        (-self.left / MESSAGES_PER_S).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Twice as many as at once: the second half comes at its rate, and a pause refills it.
    #[test]
    fn a_flood_is_taken_at_its_rate() {
        let mut allowance = Allowance::new();
        let begin = allowance.at;
        let waits: Vec<f64> = (0..200).map(|_| allowance.charge(begin)).collect();
        assert!(waits[..100].iter().all(|&wait_s| wait_s <= 0.0), "{waits:?}");
        assert!(
            (waits[199] - 1.0).abs() < 1e-9,
            "a hundred more take a second, not {}",
            waits[199]
        );
        let later = begin + Duration::from_secs(2);
        assert!(allowance.charge(later) <= 0.0);
        assert!(allowance.left < MESSAGES_AT_ONCE, "and never more than at once");
    }

    #[test]
    fn the_last_place_is_given_once_and_again_when_it_is_free() {
        let pages = Pages::new();
        let mut places: Vec<_> = (0..N_PAGES_MAX).map(|_| pages.enter().unwrap()).collect();
        assert!(pages.enter().unwrap_err().contains("32 pages"));
        places.pop();
        assert!(pages.enter().is_ok());
    }
}
