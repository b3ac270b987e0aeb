//! One line: who is connected, who waits, who has to go.

use std::time::{Duration, Instant};

use serde_json::json;

use super::{
    door::{Client, Door, Gone},
    log::Log,
    peer::Peer,
};

/// Bytes taken per tick: as much as a line of 3.3 Mbit/s carries.
const BYTES_PER_TICK_MAX: usize = 4096;
/// Clients looked at per turn, so that a flood of them does not hold up the robots.
const N_NEWCOMERS_MAX: usize = 4;

/// One line.
pub(super) struct Line {
    door: Door,
    client: Option<Connected>,
    waiting: Option<Waiting>,
    gone: Option<Gone>,
}

/// The client that is served.
struct Connected {
    client: Client,
    since: Instant,
    n_heard: u64,
    last_heard: Instant,
}

/// A client that waits for the other to leave or to fall silent.
struct Waiting {
    client: Client,
    since: Instant,
}

impl Line {
    pub(super) fn new(door: Door) -> Self {
        Self { door, client: None, waiting: None, gone: None }
    }

    /// Looks who has come, and who has been silent for too long.
    pub(super) fn attend(&mut self, line: usize, peer: &mut dyn Peer, now: Instant, log: &mut Log) {
        let n_heard = peer.n_heard(line);
        if let Some(client) = &mut self.client
            && client.n_heard != n_heard
        {
            client.n_heard = n_heard;
            client.last_heard = now;
        }
        let patience = peer.patience(line);
        if let Some(patience) = patience {
            self.settle(line, peer, patience, now, log);
        }
        for _ in 0..N_NEWCOMERS_MAX {
            if self.client.is_some() && patience.is_none() {
                break;
            }
            let Some(newcomer) = self.door.accept() else { break };
            self.greet(line, newcomer, peer, now, log);
        }
    }

    /// Somebody new: served, asked to wait, or sent away.
    fn greet(
        &mut self,
        line: usize,
        newcomer: Client,
        peer: &dyn Peer,
        now: Instant,
        log: &mut Log,
    ) {
        match (&self.client, &self.waiting) {
            (None, _) => self.welcome(line, newcomer, peer, now, log),
            (Some(_), None) => self.waiting = Some(Waiting { client: newcomer, since: now }),
            (Some(_), Some(other)) if !other.client.is_there() => {
                self.waiting = Some(Waiting { client: newcomer, since: now });
            }
            (Some(first), Some(_)) => {
                let address = &newcomer.address;
                let text = format!(
                    "{address} refused: {} is connected, another waits",
                    first.client.address
                );
                log.event(
                    peer.name(line).unwrap_or_default(),
                    "refused",
                    &text,
                    json!({"client": address}),
                );
                newcomer.dismiss("another client is connected and one more waits; try again later");
            }
        }
    }

    /// Whether the one who waits may take over, or waits in vain.
    fn settle(
        &mut self,
        line: usize,
        peer: &mut dyn Peer,
        patience: Duration,
        now: Instant,
        log: &mut Log,
    ) {
        let Some(waiting) = &self.waiting else { return };
        let Some(first) = &self.client else {
            if let Some(waiting) = self.waiting.take() {
                self.welcome(line, waiting.client, peer, now, log);
            }
            return;
        };
        let silence = now.saturating_duration_since(first.last_heard);
        if !waiting.client.is_there() {
            self.waiting = None;
        } else if silence >= patience {
            let seconds = silence.as_secs_f64();
            let (old, new) = (first.client.address.clone(), waiting.client.address.clone());
            let text = format!("{old} was silent for {seconds:.1} s: displaced by {new}");
            let facts = json!({"client": old, "by": new, "silent_s": seconds});
            log.event(peer.name(line).unwrap_or_default(), "displaced", &text, facts);
            if let Some(first) = self.client.take() {
                let text = format!("you were silent for {seconds:.1} s: {new} has taken over");
                first.client.dismiss(&text);
            }
            peer.hang_up(line);
            if let Some(waiting) = self.waiting.take() {
                self.welcome(line, waiting.client, peer, now, log);
            }
        } else if now.saturating_duration_since(waiting.since) >= patience
            // Somebody who was heard not long ago is active; others may fall silent yet.
            && silence < patience / 2
        {
            let (old, new) = (&first.client.address, &waiting.client.address);
            let text = format!("{new} refused: {old} is connected and active");
            let facts = json!({"client": new, "connected": old});
            log.event(peer.name(line).unwrap_or_default(), "refused", &text, facts);
            if let Some(waiting) = self.waiting.take() {
                waiting.client.dismiss("another client is connected and active; one at a time");
            }
        }
    }

    fn welcome(
        &mut self,
        line: usize,
        client: Client,
        peer: &dyn Peer,
        now: Instant,
        log: &mut Log,
    ) {
        let address = &client.address;
        log.event(
            peer.name(line).unwrap_or_default(),
            "connected",
            &format!("{address} connected"),
            json!({"client": address}),
        );
        let n_heard = peer.n_heard(line);
        self.client = Some(Connected { client, since: now, n_heard, last_heard: now });
        self.gone = None;
    }

    /// Appends what has arrived; `n_ticks` are about to be made.
    pub(super) fn receive(&mut self, n_ticks: u32, into: &mut Vec<u8>) -> anyhow::Result<()> {
        let n_bytes_max = BYTES_PER_TICK_MAX * n_ticks as usize;
        match (&mut self.door, &mut self.client) {
            (Door::Serial(line), _) => line.receive(n_bytes_max, into)?,
            (Door::Tcp(_), Some(connected)) => {
                self.gone = connected.client.receive(n_bytes_max, into).err();
            }
            (Door::Tcp(_), None) => {}
        }
        Ok(())
    }

    /// Sends what the robot says, at the speed at which it speaks.
    pub(super) fn send(&mut self, bytes: &[u8], baud: Option<u32>) -> anyhow::Result<()> {
        match (&mut self.door, &mut self.client) {
            (Door::Serial(line), _) => {
                line.send(bytes)?;
                if let Some(baud) = baud {
                    line.set_baud(baud)?;
                }
            }
            (Door::Tcp(_), Some(connected)) if self.gone.is_none() => {
                self.gone = connected.client.send(bytes).err();
            }
            (Door::Tcp(_), _) => {}
        }
        Ok(())
    }

    /// Takes leave of a client that is gone.
    pub(super) fn part(&mut self, line: usize, peer: &mut dyn Peer, log: &mut Log) {
        let Some(gone) = self.gone.take() else { return };
        let Some(connected) = self.client.take() else { return };
        let address = &connected.client.address;
        let seconds = connected.since.elapsed().as_secs_f64();
        let (told, facts) = peer.farewell(line);
        let how = match gone {
            Gone::Left => "left",
            Gone::TooSlow => "was dropped, because it did not read what the robot sent,",
        };
        let text = format!("{address} {how} after {seconds:.1} s{told}");
        let mut object = json!({"client": address, "after_s": seconds});
        if let (Some(object), serde_json::Value::Object(more)) = (object.as_object_mut(), facts) {
            object.extend(more);
        }
        let kind = if gone == Gone::Left { "left" } else { "dropped" };
        log.event(peer.name(line).unwrap_or_default(), kind, &text, object);
        peer.hang_up(line);
    }
}
