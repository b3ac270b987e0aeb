//! Ports on this computer with one client each, in ticks of real time: what serves robots and
//! servers.

mod door;
mod line;
mod log;
mod pace;

use std::time::{Duration, Instant};

use virtual_robots::Exchange;

pub(crate) use self::{door::Door, log::Log};
use self::{line::Line, pace::Pace};

/// Something that answers bytes, tick by tick, on one line or several.
pub(crate) trait Peer {
    /// Takes what has arrived on each line and appends the answers.
    fn tick(&mut self, exchanges: &mut [Exchange], log: &mut Log);

    /// The client of a line is gone.
    fn hang_up(&mut self, line: usize);

    /// What a line is called in the log; nothing when there is only one.
    fn name(&self, line: usize) -> Option<&str>;

    /// How many packets were understood on that line so far: a client for which this stands still
    /// is silent.
    fn n_heard(&self, line: usize) -> u64;

    /// How long a client may be silent before another may take its place; without it clients are
    /// never displaced, and others wait until the first has left.
    fn patience(&self, line: usize) -> Option<Duration>;

    /// The speed at which it speaks on that line now, bits per second; `None` where clients cannot change it.
    fn baud(&self, _line: usize) -> Option<u32> {
        None
    }

    /// What there is to tell of a client that leaves: text for people, the same for machines.
    fn farewell(&self, line: usize) -> (String, serde_json::Value);

    /// The real time that the last turn of the loop took.
    fn note_interval(&mut self, interval: Duration);
}

/// Ticks `peer` every `period` of real time until the process is interrupted; door i is line i.
///
/// Time that the computer had no time for is made up, up to [`pace::MADE_UP_MAX`] at once; what is
/// lost beyond is told.
pub(crate) fn forever(
    doors: Vec<Door>,
    peer: &mut dyn Peer,
    period: Duration,
    mut log: Log,
) -> anyhow::Result<()> {
    let mut lines: Vec<Line> = doors.into_iter().map(Line::new).collect();
    let mut exchanges = vec![Exchange::default(); lines.len()];
    let mut pace = Pace::new(period, now());
    loop {
        let turn = pace.turn(now());
        log.lost(turn.lost);
        peer.note_interval(turn.since_last);
        for (index, (line, exchange)) in lines.iter_mut().zip(&mut exchanges).enumerate() {
            line.attend(index, peer, now(), &mut log);
            line.receive(turn.n_ticks, &mut exchange.received)?;
        }
        for _tick in 0..turn.n_ticks {
            peer.tick(&mut exchanges, &mut log);
            for exchange in &mut exchanges {
                exchange.received.clear();
            }
        }
        for (index, (line, exchange)) in lines.iter_mut().zip(&mut exchanges).enumerate() {
            line.send(&exchange.out, peer.baud(index))?;
            exchange.out.clear();
            line.part(index, peer, &mut log);
        }
        if let Some(rest) = pace.rest(now()) {
            std::thread::sleep(rest);
        }
    }
}

fn now() -> Instant {
    Instant::now()
}
