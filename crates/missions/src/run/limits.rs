//! How long a step is, and of how many things a run speaks.

use std::time::Duration;

/// One step of virtual time.
pub const STEP: Duration = Duration::from_millis(10);

/// The first so many robots are traced and written about in the log.
pub(super) const N_REPORTED_MAX: usize = 7;

/// Sonars that are shown: the front ring, as the thesis uses it.
pub(super) const N_SONARS_SHOWN: usize = 8;
