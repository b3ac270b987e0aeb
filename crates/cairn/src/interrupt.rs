//! Ctrl-C, a polite kill and a closed terminal: the robots are told to stand before the program ends.

use std::{
    io::Write as _,
    process,
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
    thread,
    time::Duration,
};

use anyhow::Context;
use tokio::runtime::Runtime;

/// Exit code of a program that was interrupted, as shells have it: 128 and the signal's number.
pub(crate) const EXIT_CODE: u8 = 130;
/// How often somebody who waits for it looks.
const LOOK_PERIOD: Duration = Duration::from_millis(20);

/// Whether somebody wants the program to end.
#[derive(Clone, Debug, Default)]
pub(crate) struct Interrupt(Arc<AtomicBool>);

impl Interrupt {
    /// Listens from now on; who interrupts a second time does not wait for anything any more.
    pub(crate) fn listen() -> anyhow::Result<Self> {
        let interrupt = Self::default();
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
        let runtime = runtime.context("cannot listen for Ctrl-C")?;
        interrupt.hear_signals(&runtime)?;
        thread::spawn(move || runtime.block_on(std::future::pending::<()>()));
        Ok(interrupt)
    }

    #[cfg(unix)]
    fn hear_signals(&self, runtime: &Runtime) -> anyhow::Result<()> {
        use tokio::signal::unix::{SignalKind, signal};
        let _inside = runtime.enter();
        let hangup = (!ignores_hangups()).then(SignalKind::hangup);
        let kinds = [SignalKind::interrupt(), SignalKind::terminate()];
        for kind in kinds.into_iter().chain(hangup) {
            let mut signals = signal(kind).context("cannot listen for Ctrl-C")?;
            let interrupt = self.clone();
            runtime.spawn(async move {
                while signals.recv().await.is_some() {
                    interrupt.note();
                }
            });
        }
        Ok(())
    }

    #[cfg(not(unix))]
    #[expect(clippy::unnecessary_wraps, reason = "it can fail elsewhere")]
    fn hear_signals(&self, runtime: &Runtime) -> anyhow::Result<()> {
        let interrupt = self.clone();
        runtime.spawn(async move {
            while tokio::signal::ctrl_c().await.is_ok() {
                interrupt.note();
            }
        });
        Ok(())
    }

    fn note(&self) {
        if self.0.swap(true, Ordering::Relaxed) {
            process::exit(EXIT_CODE.into());
        }
    }

    /// Whether it happened.
    pub(crate) fn happened(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }

    /// Until it happens.
    pub(crate) async fn wait(self) {
        while !self.happened() {
            tokio::time::sleep(LOOK_PERIOD).await;
        }
    }
}

/// Says why the program ends, where there is still somebody to read it: the terminal may be closed.
pub(crate) fn tell(why: &str) {
    let _unread = writeln!(std::io::stderr(), "cairn: {why}");
}

/// Whether the program was started to outlive its terminal, as `nohup` does.
#[cfg(unix)]
fn ignores_hangups() -> bool {
    // Where the system does not tell, it was not.
    let about = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = about.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let ignored = ignored.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    // SIGHUP is signal 1, and the lowest bit.
    ignored.is_some_and(|mask| mask & 1 == 1)
}
