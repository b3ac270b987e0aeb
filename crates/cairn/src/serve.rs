//! Ports on this computer with one client each, in ticks of real time: what serves robots and
//! servers.

mod door;
mod line;
mod log;
mod pace;
mod peer;

use std::time::{Duration, Instant};

use virtual_robots::Exchange;

pub(crate) use self::{door::Door, log::Log, peer::Peer};
use self::{line::Line, pace::Pace};

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
