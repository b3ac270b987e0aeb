//! What is remembered of a robot's line from tick to tick.

/// What is remembered of one robot's line.
#[derive(Default)]
pub(super) struct RobotLine {
    pub(super) name: String,
    /// Whether it is of a laser, and not of what drives.
    pub(super) is_laser: bool,
    /// The robot's way and packets when its last client left.
    pub(super) travelled_m: f64,
    pub(super) n_packets: u64,
    pub(super) battery_was_low: bool,
    /// Messages told in the present second of virtual time, and not told at all.
    pub(super) second: u64,
    pub(super) n_told: u32,
    pub(super) n_untold: u64,
}
