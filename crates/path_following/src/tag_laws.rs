//! Following a trail that is stored in tags on the floor: from what two readers read to wheel speeds.
//!
//! Reads come when a tag passes under a reader, tag by tag, with gaps; each holds the intensity at the tag, not at
//! the reader. Two [antennas](TagFollower::read) smooth them over the way driven, and the fuzzy controller works on
//! their difference e = `P_L − P_R`, as on a trail of the pheromone server.
//!
//! Source: the thesis, 5.3.2, variant A (two readers, gradient, fuzzy) and B (a look-ahead point in each tag,
//! pure pursuit). Differences: it gives no law for gaps between tags and none for the loss of the trail; the change
//! of the error is counted over the way driven and not over time, since tags pass in the measure of the way.

use geometry::Vec2;

use crate::{
    SettingError, Side, WheelReference,
    fuzzy::{FuzzyConfig, FuzzyController},
    wheels::check_range,
};

/// The way over which the error's change is counted, metres: 200 ms at 0.3 m/s, as on other trails.
const CHANGE_WAY_M: f64 = 0.06;

/// Less way than this since the last step says nothing about the change, metres.
const STANDING_M: f64 = 0.005;

/// A difference of so much of the error's full width tells on which side the trail lies.
const SIDE_RATIO: f64 = 0.3;

/// For so long the side is remembered that the trail was on last, metres.
const SIDE_WAY_M: f64 = 0.4;

/// How much slower the robot is where it turns hardest.
const TURNING_RATIO: f64 = 0.5;

/// How a trail in tags is followed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TagFollowerConfig {
    /// Sets and rules; errors in the units that tags store, 0 to 255.
    pub fuzzy: FuzzyConfig,
    /// Way over which an antenna smooths what it reads, metres, 0.001 to 1.
    pub smooth_m: f64,
    /// Way without a read after which an antenna smells nothing any more, metres, 0.05 to 2.
    pub hold_m: f64,
    /// No wheel is asked for more, metres per second, 0.01 to 10.
    pub wheel_speed_max_mps: f64,
}

impl Default for TagFollowerConfig {
    /// For tags every 0.1 m on a trail three or four of them wide, with 200 in the middle.
    fn default() -> Self {
        Self {
            fuzzy: FuzzyConfig {
                error_full: 150.0,
                change_full: 60.0,
                slow_ratio: 0.0,
                fast_ratio: 2.0,
                ..FuzzyConfig::default()
            },
            smooth_m: 0.05,
            hold_m: 0.3,
            wheel_speed_max_mps: 0.75,
        }
    }
}

/// What one reader knows of the trail.
#[derive(Clone, Copy, Debug, Default)]
struct Antenna {
    /// The intensity in the last tag, until the way since then is too long.
    latest: f64,
    since_read_m: f64,
    level: f64,
}

/// What the trail asks for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TagStep {
    /// The trail is there.
    Drive(WheelReference),
    /// Both antennas smell nothing; the side on which the trail was last, if it was on one.
    Lost(Option<Side>),
}

/// Two antennas and a fuzzy controller.
///
/// ```
/// use path_following::{Side, TagFollower, TagFollowerConfig, TagStep};
///
/// let mut follower = TagFollower::new(TagFollowerConfig::default()).unwrap();
/// follower.read(Side::Left, 200);
/// follower.read(Side::Right, 100);
/// follower.roll(0.05);
/// let TagStep::Drive(wheels) = follower.step(0.3) else { panic!("the trail is there") };
/// assert!(wheels.right_mps > wheels.left_mps, "there is more on the left");
/// ```
#[derive(Clone, Debug)]
pub struct TagFollower {
    config: TagFollowerConfig,
    controller: FuzzyController,
    /// Left, right.
    antennas: [Antenna; 2],
    previous: Option<f64>,
    /// Way since the last step.
    rolled_m: f64,
    side: Option<Side>,
    since_side_m: f64,
}

impl TagFollower {
    /// Checks the settings.
    ///
    /// # Errors
    ///
    /// [`SettingError`] for a value outside its range.
    pub fn new(config: TagFollowerConfig) -> Result<Self, SettingError> {
        check_range("smooth_m", config.smooth_m, 0.001..=1.0, "from 0.001 to 1 m")?;
        check_range("hold_m", config.hold_m, 0.05..=2.0, "from 0.05 to 2 m")?;
        let speed_max = config.wheel_speed_max_mps;
        check_range("wheel_speed_max_mps", speed_max, 0.01..=10.0, "from 0.01 to 10 m/s")?;
        let controller = FuzzyController::new(config.fuzzy)?;
        let antennas = [Antenna::default(); 2];
        let (previous, side) = (None, None);
        Ok(Self { config, controller, antennas, previous, rolled_m: 0.0, side, since_side_m: 0.0 })
    }

    /// The reader on that side has read a tag with this intensity.
    pub fn read(&mut self, side: Side, strength: u8) {
        let antenna = &mut self.antennas[usize::from(side == Side::Right)];
        antenna.latest = f64::from(strength);
        antenna.since_read_m = 0.0;
    }

    /// The robot has driven so far, metres, since the last call; backwards counts as much.
    pub fn roll(&mut self, way_m: f64) {
        let way_m = if way_m.is_finite() { way_m.abs() } else { 0.0 };
        self.rolled_m += way_m;
        self.since_side_m += way_m;
        // A first-order low pass over the way: what is left of a step after w is e^(−w / smooth).
        let share = 1.0 - (-way_m / self.config.smooth_m).exp();
        for antenna in &mut self.antennas {
            antenna.since_read_m += way_m;
            if antenna.since_read_m > self.config.hold_m {
                antenna.latest = 0.0;
            }
            antenna.level += share * (antenna.latest - antenna.level);
        }
    }

    /// Wheel speeds around the speed asked for (m/s, ≥ 0), less where the trail bends. O(1), allocates nothing.
    pub fn step(&mut self, speed_mps: f64) -> TagStep {
        let error = self.error();
        if !self.smells() {
            self.previous = None;
            let is_fresh = self.since_side_m <= SIDE_WAY_M;
            return TagStep::Lost(self.side.filter(|_| is_fresh));
        }
        if error.abs() > SIDE_RATIO * self.config.fuzzy.error_full {
            self.side = Some(if error > 0.0 { Side::Left } else { Side::Right });
            self.since_side_m = 0.0;
        } else if self.since_side_m > SIDE_WAY_M {
            self.side = None;
        }
        let before = self.previous.filter(|_| self.rolled_m > STANDING_M);
        let change = before.map_or(0.0, |before| CHANGE_WAY_M * (error - before) / self.rolled_m);
        self.previous = Some(error);
        self.rolled_m = 0.0;
        let turning = self.controller.step(error, change, speed_mps);
        let fuzzy = &self.config.fuzzy;
        let most_mps = (fuzzy.fast_ratio - fuzzy.slow_ratio) * speed_mps;
        let hard = ((turning.right_mps - turning.left_mps).abs() / most_mps.max(1e-9)).min(1.0);
        let slower = 1.0 - TURNING_RATIO * hard;
        let wheels = WheelReference {
            left_mps: slower * turning.left_mps,
            right_mps: slower * turning.right_mps,
        };
        TagStep::Drive(wheels.limited(self.config.wheel_speed_max_mps))
    }

    /// Whether the last tag that either reader has read lately is one of a trail.
    pub fn smells(&self) -> bool {
        self.antennas.iter().any(|antenna| antenna.latest > 0.0)
    }

    /// Whether that is so of both.
    pub fn smells_on_both_sides(&self) -> bool {
        self.antennas.iter().all(|antenna| antenna.latest > 0.0)
    }

    /// `P_L − P_R`, positive where the trail is on the left; −255 to 255.
    pub fn error(&self) -> f64 {
        let [left, right] = self.levels();
        left - right
    }

    /// What the antennas smell, left and right, 0 to 255.
    pub fn levels(&self) -> [f64; 2] {
        self.antennas.map(|antenna| antenna.level)
    }

    /// Forgets how the error changed and where the trail was: for a robot that has turned on the spot. What its
    /// antennas smell it still does.
    pub fn restart(&mut self) {
        self.previous = None;
        self.rolled_m = 0.0;
        self.side = None;
        for antenna in &mut self.antennas {
            antenna.level = antenna.latest;
        }
    }
}

/// Pure pursuit of a point (m, base frame): an arc through it; one behind is turned to on the tightest arc, a
/// radius of `radius_min_m`.
///
/// Source: the thesis, (5.12), γ = 2 y / L² with y to the left.
pub fn pursue(
    target_in_base: Vec2,
    speed_mps: f64,
    radius_min_m: f64,
    wheelbase_m: f64,
) -> WheelReference {
    let tightest_per_m = 1.0 / radius_min_m.max(1e-3);
    let square_m2 = target_in_base.norm_squared().max(1e-6);
    let curvature_per_m = if target_in_base.x > 0.0 {
        2.0 * target_in_base.y / square_m2
    } else {
        tightest_per_m.copysign(target_in_base.y)
    };
    let curvature_per_m = curvature_per_m.clamp(-tightest_per_m, tightest_per_m);
    WheelReference::along_arc(speed_mps, curvature_per_m, wheelbase_m)
}

#[cfg(test)]
#[path = "tag_laws_tests.rs"]
mod tests;
