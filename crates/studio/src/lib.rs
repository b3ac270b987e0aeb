//! The studio: a run in the browser, and the browser's hand on the run.
//!
//! [`serve`] steps a mission on a thread of its own and shows it on this computer only. What the page
//! asks for becomes an [`missions::Intervention`], which is recorded; the studio writes nothing else
//! into a run. `web/` holds the page; its built bundle is embedded.
#![expect(
    clippy::disallowed_methods,
    reason = "the studio decides how fast a run is stepped, so it looks at the clock and waits"
)]

mod convert;
mod edges;
mod protocol;
mod runner;
mod server;
mod session;

use std::{
    net::{Ipv4Addr, SocketAddr},
    path::PathBuf,
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
};

use anyhow::Context;
use missions::Mission;
use tokio::net::TcpListener;

pub use protocol::MissionName;
pub use session::Show;

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

/// Serves `show` until the program is interrupted (Ctrl-C, or a request to terminate); calls `on_ready`
/// with the address once the page can be opened. Gives back the path of the recording, if one was completed.
///
/// # Errors
///
/// When no port is free, the show cannot be started or recorded, or the runtime cannot be made.
pub fn serve(
    show: Show,
    options: Options,
    on_ready: impl FnOnce(SocketAddr),
) -> anyhow::Result<Option<PathBuf>> {
    serve_until(show, options, on_ready, interrupted())
}

/// As [`serve`], until `stop` is ready.
///
/// # Errors
///
/// As [`serve`].
pub fn serve_until(
    show: Show,
    options: Options,
    on_ready: impl FnOnce(SocketAddr),
    stop: impl Future<Output = ()>,
) -> anyhow::Result<Option<PathBuf>> {
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .worker_threads(1)
        .enable_all()
        .build()
        .context("cannot start the web server's runtime")?;
    let listener = runtime.block_on(listen(options.port))?;
    let address = listener.local_addr().context("cannot tell the server's own address")?;
    let missions = Arc::new(shipped_missions());
    let (runner, remote) = runner::Runner::new(show, missions.clone(), options.speed_ratio)
        .map_err(anyhow::Error::msg)?;
    let stopping = Arc::new(AtomicBool::new(false));
    let stop_stepping = stopping.clone();
    let stepping = std::thread::Builder::new()
        .name("run".to_owned())
        .spawn(move || runner.drive(|| stop_stepping.load(Ordering::Relaxed)))
        .context("cannot start the thread that steps the run")?;
    on_ready(address);
    let router = server::router(server::App { remote, missions, address });
    let served = runtime.block_on(async {
        tokio::select! {
            served = async { axum::serve(listener, router).await } => served.context("the web server ended"),
            () = stop => Ok(()),
        }
    });
    stopping.store(true, Ordering::Relaxed);
    let recorded =
        stepping.join().map_err(|_panic| anyhow::anyhow!("the run ended by a fault of its own"))?;
    served?;
    recorded.map_err(anyhow::Error::msg)
}

/// Ready when the program is asked to end. Where that cannot be known, the system ends it.
async fn interrupted() {
    let ctrl_c = async {
        if tokio::signal::ctrl_c().await.is_err() {
            std::future::pending::<()>().await;
        }
    };
    #[cfg(unix)]
    let terminated = async {
        use tokio::signal::unix::{SignalKind, signal};
        match signal(SignalKind::terminate()) {
            Ok(mut signal) => drop(signal.recv().await),
            Err(_) => std::future::pending::<()>().await,
        }
    };
    #[cfg(not(unix))]
    let terminated = std::future::pending::<()>();
    tokio::select! {
        () = ctrl_c => {}
        () = terminated => {}
    }
}

fn shipped_missions() -> Vec<MissionName> {
    Mission::shipped_infos()
        .into_iter()
        .map(|info| MissionName { name: info.name, title: info.title, about: info.about })
        .collect()
}

/// Binds this computer's own address.
async fn listen(port: Option<u16>) -> anyhow::Result<TcpListener> {
    let bind = |port| TcpListener::bind(SocketAddr::from((Ipv4Addr::LOCALHOST, port)));
    if let Some(port) = port {
        return bind(port).await.with_context(|| {
            format!("port {port} on 127.0.0.1 cannot be used; leave --port out to take a free one")
        });
    }
    let last = PORT_FIRST + N_PORTS_TRIED - 1;
    for port in PORT_FIRST..=last {
        if let Ok(listener) = bind(port).await {
            return Ok(listener);
        }
    }
    anyhow::bail!(
        "no port from {PORT_FIRST} to {last} on 127.0.0.1 is free; choose one with --port"
    )
}
