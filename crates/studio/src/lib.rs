//! The studio: a run in the browser, and the browser's hand on the run; and maps as they grow from recordings.
//!
//! [`serve_until`] steps a mission on a thread of its own and shows it on this computer only. What the page
//! asks for becomes an [`missions::Intervention`], which is recorded; the studio writes nothing else
//! into a run. Beside it is the mapping page, which plays recordings into surveys; [`serve_survey_until`] shows it alone,
//! with a recording. `web/` holds the pages; their built bundles are embedded.
#![expect(
    clippy::disallowed_methods,
    reason = "the studio decides how fast a run is stepped, so it looks at the clock and waits"
)]

mod beams;
mod convert;
mod crowd;
mod description;
mod door;
mod edges;
mod history;
mod library;
mod mapping;
mod past;
mod places;
mod protocol;
mod runner;
mod server;
mod session;

use std::{
    net::SocketAddr,
    path::PathBuf,
    sync::{
        Arc, Mutex,
        atomic::{AtomicBool, Ordering},
    },
    thread::JoinHandle,
};

use anyhow::Context;
use door::Pages;
use library::Library;
use mapping::{Mapping, Player};
use runner::Runner;
use tokio::net::TcpListener;

pub use mapping::Exhibit;
pub use session::{Recordings, Show};

/// The first port tried when none is asked for.
pub const PORT_FIRST: u16 = 7878;
/// How many ports are tried from there on.
const N_PORTS_TRIED: u16 = 100;

/// How to show it.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// The port; `None` for the first free one from [`PORT_FIRST`], 0 for any free one.
    pub port: Option<u16>,
    /// Seconds simulated per second, clamped to 0.1 to 20.
    pub speed_ratio: f64,
}

/// Serves `show` until `stop` is ready; calls `on_ready` with the address once the page can be opened. Then every
/// robot is told to stand, and waited for. Gives back the paths of what was recorded, one for each restart.
///
/// # Errors
///
/// When no port is free, the show cannot be started, a recording could not be written to its end, or the runtime
/// cannot be made.
pub fn serve_until(
    show: Show,
    options: Options,
    on_ready: impl FnOnce(SocketAddr),
    stop: impl Future<Output = ()>,
) -> anyhow::Result<Vec<PathBuf>> {
    let house = House::open(options.port)?;
    let library = Arc::new(Mutex::new(Library::shipped()));
    let (runner, remote) =
        Runner::new(show, library.clone(), options.speed_ratio).map_err(anyhow::Error::msg)?;
    let pages = Pages::new();
    let (mapping, player) = Mapping::new(true, pages.clone());
    let mission = Some((runner, server::MissionPage { remote, library, pages }));
    house.serve(mission, (mapping, player), on_ready, stop)
}

/// Serves the mapping page until `stop` is ready, with a recording to begin with or without; calls `on_ready` with
/// the address once the page can be opened. The port is chosen as in [`Options`].
///
/// # Errors
///
/// When no port is free or the runtime cannot be made. A recording that cannot be mapped is told on the page.
pub fn serve_survey_until(
    exhibit: Option<Exhibit>,
    port: Option<u16>,
    on_ready: impl FnOnce(SocketAddr),
    stop: impl Future<Output = ()>,
) -> anyhow::Result<()> {
    let (mapping, player) = Mapping::new(false, Pages::new());
    if let Some(exhibit) = exhibit {
        mapping.show(exhibit);
    }
    House::open(port)?.serve(None, (mapping, player), on_ready, stop).map(drop)
}

/// A port of this computer and the runtime that answers on it.
struct House {
    runtime: tokio::runtime::Runtime,
    listener: TcpListener,
    address: SocketAddr,
}

impl House {
    fn open(port: Option<u16>) -> anyhow::Result<Self> {
        let runtime = tokio::runtime::Builder::new_multi_thread()
            .worker_threads(1)
            .enable_all()
            .build()
            .context("cannot start the web server's runtime")?;
        // Sockets belong to a runtime.
        let listener = runtime.block_on(async { listen(port) })?;
        let address = listener.local_addr().context("cannot tell the server's own address")?;
        Ok(Self { runtime, listener, address })
    }

    /// Serves the pages, with what they show stepped on threads of its own, until `stop` is ready. Gives back the
    /// paths of what was recorded.
    fn serve(
        self,
        mission: Option<(Runner, server::MissionPage)>,
        (mapping, player): (Mapping, Player),
        on_ready: impl FnOnce(SocketAddr),
        stop: impl Future<Output = ()>,
    ) -> anyhow::Result<Vec<PathBuf>> {
        let Self { runtime, listener, address } = self;
        let stopping = Arc::new(AtomicBool::new(false));
        let (runner, page) = mission.unzip();
        let stepping = match runner {
            Some(runner) => Some(spawn("run", &stopping, |stop| runner.drive(stop))?),
            None => None,
        };
        // The player is not waited for at the end: a step of its last optimisation may take long.
        spawn("player", &stopping, |stop| player.drive(stop))?;
        on_ready(address);
        let router = server::router(page, mapping, address);
        runtime.block_on(async {
            tokio::select! {
                () = door::serve(listener, router) => {}
                () = stop => {}
            }
        });
        stopping.store(true, Ordering::Relaxed);
        // Nor is a recording that is being read.
        runtime.shutdown_background();
        let recorded = stepping.map_or(Ok(Ok(Vec::new())), JoinHandle::join);
        let recorded =
            recorded.map_err(|_panic| anyhow::anyhow!("the run ended by a fault of its own"))?;
        recorded.map_err(anyhow::Error::msg)
    }
}

/// Starts a thread that is told when it should end.
fn spawn<T: Send + 'static>(
    name: &str,
    stopping: &Arc<AtomicBool>,
    work: impl FnOnce(&dyn Fn() -> bool) -> T + Send + 'static,
) -> anyhow::Result<JoinHandle<T>> {
    let stopping = stopping.clone();
    std::thread::Builder::new()
        .name(name.to_owned())
        .spawn(move || work(&|| stopping.load(Ordering::Relaxed)))
        .with_context(|| format!("cannot start the thread `{name}`"))
}

/// Takes a port of this computer.
fn listen(port: Option<u16>) -> anyhow::Result<TcpListener> {
    if let Some(port) = port {
        return door::listen(port).with_context(|| {
            format!("port {port} on 127.0.0.1 cannot be used; leave --port out to take a free one")
        });
    }
    let last = PORT_FIRST + N_PORTS_TRIED - 1;
    for port in PORT_FIRST..=last {
        if let Ok(listener) = door::listen(port) {
            return Ok(listener);
        }
    }
    anyhow::bail!(
        "no port from {PORT_FIRST} to {last} on 127.0.0.1 is free; choose one with --port"
    )
}
