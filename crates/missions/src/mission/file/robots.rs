//! `[[robots]]`: the body, its sensors, its line, and whoever drives it by hand.

use serde::{Deserialize, Serialize};

use super::{LaserFile, LineFile, MindFile, TagReadersFile};

/// `[[robots]]`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct RobotFile {
    /// Unique name.
    pub name: String,
    /// Model from the catalogue.
    pub model: String,
    /// Where it starts: x, y (m), yaw (degrees).
    pub start: [f64; 3],
    /// How many; more than one are laid out in rows from `start`.
    pub count: usize,
    /// Distance between neighbours when there are many: along x and y (m).
    pub spacing_m: [f64; 2],
    /// Robots in a row when there are many.
    pub row_length: usize,
    /// `[robots.odometry]`: how its dead reckoning errs.
    pub odometry: OdometryFile,
    /// `[robots.sonar]`: what its sonars return.
    pub sonar: SonarFile,
    /// `[robots.line]`: the line between the robot and its mind.
    pub line: LineFile,
    /// `[robots.mind]`: the methods by which it finds its way.
    pub mind: MindFile,
    /// `[robots.tag_readers]`: readers of tags in the floor; absent: none, unless it follows tags.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tag_readers: Option<TagReadersFile>,
    /// `[[robots.lasers]]`: scanning lasers on its body.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub lasers: Vec<LaserFile>,
    /// `[robots.teleoperator]`: a person who drives it by hand; absent: nobody does.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub teleoperator: Option<TeleoperatorFile>,
}

impl Default for RobotFile {
    fn default() -> Self {
        Self {
            name: "robot".into(),
            model: "pioneer3dx".into(),
            start: [0.0; 3],
            count: 1,
            spacing_m: [1.5, 1.5],
            row_length: 32,
            odometry: OdometryFile::default(),
            sonar: SonarFile::default(),
            line: LineFile::default(),
            mind: MindFile::default(),
            tag_readers: None,
            lasers: Vec::new(),
            teleoperator: None,
        }
    }
}

/// `[robots.teleoperator]`: a person who sees the robot and drives it along a path by hand.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct TeleoperatorFile {
    /// Corners of the path over the floor, x and y (m).
    pub path_m: Vec<[f64; 2]>,
    /// How often the path is driven; more than once only when it ends where it begins.
    pub laps: u32,
    /// Radius of the arcs around its corners (m).
    pub corner_radius_m: f64,
    /// Speed along it, m/s.
    pub speed_mps: f64,
    /// When the person takes the stick, seconds.
    pub starts_at_s: f64,
}

impl Default for TeleoperatorFile {
    fn default() -> Self {
        Self {
            path_m: Vec::new(),
            laps: 1,
            corner_radius_m: 0.4,
            speed_mps: 0.08,
            starts_at_s: 1.0,
        }
    }
}

/// `[robots.odometry]`: errors of dead reckoning; the defaults are perfect.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct OdometryFile {
    /// True left wheel diameter over the nominal one.
    pub left_diameter_ratio: f64,
    /// True right wheel diameter over the nominal one.
    pub right_diameter_ratio: f64,
    /// True wheelbase over the nominal one.
    pub wheelbase_ratio: f64,
    /// What the robot truly turns without noticing, counter-clockwise positive, degrees per metre of way; it
    /// widens the difference of the diameters.
    pub drift_degpm: f64,
    /// Direction in which the wheels roll, seen from the robot's front, counter-clockwise, degrees.
    pub misalignment_deg: f64,
    /// Encoder pulses that are counted as one step.
    pub encoder_coarsening_ticks: u32,
    /// Time between two readings of the encoders, ms; 0: every step.
    pub encoder_period_ms: f64,
    /// Standard deviation of wheel slip, as a ratio of the distance rolled.
    pub slip_std_ratio: f64,
    /// Bumps while it moves, per second.
    pub bump_rate_hz: f64,
    /// Standard deviation of the way that a bump adds to one wheel, m.
    pub bump_std_m: f64,
}

impl Default for OdometryFile {
    fn default() -> Self {
        Self {
            left_diameter_ratio: 1.0,
            right_diameter_ratio: 1.0,
            wheelbase_ratio: 1.0,
            drift_degpm: 0.0,
            misalignment_deg: 0.0,
            encoder_coarsening_ticks: 1,
            encoder_period_ms: 0.0,
            slip_std_ratio: 0.0,
            bump_rate_hz: 0.0,
            bump_std_m: 0.0,
        }
    }
}

/// `[robots.sonar]`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct SonarFile {
    /// Where the sonars are: `model` (as the robot has them), `five`, `eight` or `own`.
    pub ring: String,
    /// Place (x, y, m) and bearing (degrees) of each, for `ring = "own"`.
    pub ring_at: Vec<[f64; 3]>,
    /// Time between two pings of a chain, ms; 0: as the ring has it.
    pub ring_period_ms: u32,
    /// Sonars that fire one after another; 0: as the ring has it.
    pub ring_chain: usize,
    /// Nearer things read as this, m.
    pub range_min_m: f64,
    /// Greatest range, m.
    pub range_max_m: f64,
    /// Readings are whole numbers of these, m; 0: as fine as measured.
    pub range_step_m: f64,
    /// Half the opening of the cone, degrees.
    pub half_angle_deg: f64,
    /// Rays per cone.
    pub n_rays: usize,
    /// Standard deviation of a range that does not grow with it, m.
    pub range_std_m: f64,
    /// Standard deviation that grows with the range, as a ratio of it.
    pub range_std_ratio: f64,
    /// Probability that a mirrored ray is followed to a ghost.
    pub ghost_prob: f64,
    /// Probability that an echo is missed.
    pub dropout_prob: f64,
    /// Probability that another sensor is heard instead.
    pub crosstalk_prob: f64,
}

impl Default for SonarFile {
    fn default() -> Self {
        Self {
            ring: "model".into(),
            ring_at: Vec::new(),
            ring_period_ms: 0,
            ring_chain: 0,
            range_min_m: 0.15,
            range_max_m: 5.0,
            range_step_m: 0.0,
            half_angle_deg: 15.0,
            n_rays: 9,
            range_std_m: 0.005,
            range_std_ratio: 0.005,
            ghost_prob: 0.5,
            dropout_prob: 0.01,
            crosstalk_prob: 0.001,
        }
    }
}
