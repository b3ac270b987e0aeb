//! Who is behind the doors, as the loop that serves them sees it.

use std::time::Duration;

use virtual_robots::Exchange;

use super::log::Log;

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
