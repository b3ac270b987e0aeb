//! What can be observed, sensor by sensor.

use geometry::{Base, Odom, Transform2};
use robot_models::WheelSpeeds;
use run_context::Stamp;
use sensor_models::TagMemory;

use crate::Order;

/// Greatest number of sensors in one [`Ring`].
pub const N_RING_MAX: usize = 16;

/// Everything that a node can be told.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sensed {
    /// Where the wheels say that the robot is, and how they turn.
    Odometry(OdometryReading),
    /// The latest ranges of a ring of sonars or infrared sensors.
    Ring(Ring),
    /// A scan of a planar laser; its beams are in the [`Observations`](crate::Observations) that hold it.
    Scan(Scan),
    /// What touches the robot, or makes its wheels stand.
    Contact(Contacts),
    /// Whether the motors follow what they are told.
    Motors(Motors),
    /// How the battery stands.
    Battery(Battery),
    /// A reader has read a tag in the floor.
    Tag(TagRead),
    /// The pheromone server's answer to a question.
    Smell(Smell),
    /// An order from the ground.
    Order(Order),
    /// Whether the robot answers.
    Link(LinkState),
}

/// What the wheels say.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OdometryReading {
    /// Dead-reckoned pose: (0, 0, 0) where the robot was switched on.
    pub odom_from_base: Transform2<Odom, Base>,
    /// Measured wheel speeds.
    pub wheel_speeds: WheelSpeeds,
    /// The robot itself says that it moves.
    pub moving: bool,
}

/// The latest ranges of a ring of sensors, each with its age.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ring {
    /// Latest range of each sensor, metres; the range limit where nothing was heard.
    pub ranges_m: [f64; N_RING_MAX],
    /// How old each of them was at the time that the observation is about, as well as the driver knows, milliseconds;
    /// what is older than 65 s is 65 535.
    pub ages_ms: [u16; N_RING_MAX],
    /// How many of `ranges_m` exist.
    pub n_sensors: usize,
    /// Bit i: sensor i was measured anew since the last observation of this ring.
    pub fresh: u16,
}

/// A scan of a planar laser, without its beams.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scan {
    /// Its number since its client was made, from 0.
    pub number: u64,
    /// Surfaces nearer than this are not measured, metres.
    pub range_min_m: f64,
    /// What a beam that went beyond the device's scale is free up to, metres.
    pub range_max_m: f64,
    /// Where its beams begin in the observations, and how many there are.
    pub(crate) first_beam: u32,
    pub(crate) n_beams: u32,
}

/// What touches a robot, or makes its wheels stand.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Contacts {
    /// The left and right wheel are driven but do not turn.
    pub stalled: [bool; 2],
    /// Bit i: bumper i of the robot is pressed.
    pub bumpers: u16,
    /// Bit i: cliff sensor i sees no floor.
    pub cliffs: u8,
    /// The left and right wheel hang in the air.
    pub dropped: [bool; 2],
}

/// Whether motors follow what they are told.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Motors {
    /// They do.
    pub enabled: bool,
}

/// How a battery stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Battery {
    /// Voltage, volts.
    pub voltage_v: f64,
}

/// A tag in the floor that a reader has read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TagRead {
    /// Which reader: its place among the robot's, the left one first.
    pub reader: u8,
    /// The tag's own number.
    pub tag: u32,
    /// What it stores.
    pub memory: TagMemory,
}

/// What a robot at the pose of a question would smell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Smell {
    /// The number of the question, echoed.
    pub query: u8,
    /// Intensity at the left antenna, 0–255 on the wire.
    pub left: f64,
    /// Intensity at the right antenna, 0–255 on the wire.
    pub right: f64,
}

/// Whether a robot answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LinkState {
    /// It answers (again).
    Up,
    /// It does not answer any more; what was known of it is old.
    Down,
}

impl Ring {
    /// The ranges that exist, metres.
    pub fn ranges_m(&self) -> &[f64] {
        &self.ranges_m[..self.n_sensors.min(N_RING_MAX)]
    }

    /// Whether sensor `index` was measured anew.
    pub fn is_fresh(&self, index: usize) -> bool {
        index < N_RING_MAX && self.fresh >> index & 1 != 0
    }
}

impl Contacts {
    /// Whether anything touches the robot, or holds or drops a wheel of it.
    pub fn any(&self) -> bool {
        *self != Self::default()
    }
}

/// Whole milliseconds from `measured` to `about`, as [`Ring::ages_ms`] holds them.
pub fn age_ms(measured: Stamp, about: Stamp) -> u16 {
    u16::try_from(about.since(measured).as_millis()).unwrap_or(u16::MAX)
}
