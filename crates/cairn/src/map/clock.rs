//! A clock for the libraries, which have none of their own.

use std::time::Instant;

use surveys::Clock;

/// Time since now.
pub(super) fn clock() -> Clock {
    let begun = Instant::now();
    Clock::new(move || begun.elapsed())
}
