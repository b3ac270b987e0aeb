//! Settings of a mind as written: plain data with working defaults.

use std::time::Duration;

use geometry::{Se2, Vec2};
use messages::{DeviceId, N_RING_MAX};
use obstacle_avoidance::{DetourConfig, EchoMemoryConfig, RangeSensor, Variant};
use path_following::{
    PathController, TagFollowerConfig, TrailController, fuzzy::FuzzyConfig,
    fuzzy_listing::ListingConfig,
};
use robot_models::{BumperMount, DriveGeometry, OdometryNoise, RobotModel};

use crate::values::Limits;

/// No wheel is asked for more than this times the cruising speed; H is 1.5 times it.
const WHEEL_SPEED_MAX_RATIO: f64 = 1.6;

/// Most readers on a robot.
pub const N_TAG_READERS_MAX: usize = 2;

/// Which of the thesis's variants.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TagController {
    /// A: two readers, fuzzy on the difference of the intensities.
    #[default]
    Gradient,
    /// B: one reader, pure pursuit of the look-ahead point that each tag stores.
    LookAhead,
}

settings::choices!(TagController {
    Gradient = "gradient": "two readers, a fuzzy controller on the difference of what they read",
    LookAhead = "look_ahead": "one reader, drives the arc through the point ahead that each tag stores",
});

/// How a trail of tags is followed.
#[derive(Clone, Debug, PartialEq)]
pub struct TagSettings {
    /// The law.
    pub controller: TagController,
    /// Where the readers are (m, base frame): left and right, or one for the look-ahead law.
    pub readers_in_base: Vec<Vec2>,
    /// The antennas and the fuzzy law; its greatest wheel speed is that of the navigator.
    pub follower: TagFollowerConfig,
}

impl Default for TagSettings {
    /// Two readers 0.25 m apart under the front of a Pioneer: two and a half tags, so that one of them
    /// passes over a row of tags where the other passes between two.
    fn default() -> Self {
        Self {
            controller: TagController::default(),
            readers_in_base: vec![Vec2::new(0.18, 0.125), Vec2::new(0.18, -0.125)],
            follower: TagFollowerConfig::default(),
        }
    }
}

/// How a goal is reached.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Method {
    /// Over the pheromone trail that leads to it (the thesis, 5.3 and 7.4).
    #[default]
    Trail,
    /// In a straight line, over intermediate goals if there are any (the thesis, 7.5).
    Direct,
    /// Along the path given by `Navigator::set_path`.
    Path,
    /// Over a trail of tags in the floor (the thesis, 5.3.2).
    Tags,
    /// Along a way that is planned on the map given by `Navigator::set_map` (extension).
    Map,
}

settings::choices!(Method {
    Trail = "trail": "over pheromones, which a server knows of",
    Direct = "straight": "in a straight line",
    Path = "path": "along the corners that are given",
    Tags = "tags": "over a trail of radio tags in the floor",
    Map = "map": "along a way that it plans on the map of its world",
});

/// What says where the robot is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PoseMethod {
    /// The wheels alone.
    DeadReckoning,
    /// The wheels, and the coordinates that tags in the floor store, where readers read any.
    #[default]
    TagFixes,
    /// The wheels, and where the beams of its lasers end on the map given by `Navigator::set_particles` (extension).
    Particles,
}

settings::choices!(PoseMethod {
    DeadReckoning = "dead_reckoning": "what its wheels roll, and nothing else",
    TagFixes = "tag_fixes": "the same, corrected by the coordinates that tags in the floor store, if it reads any",
    Particles = "particles": "particles on the map of its world, weighed by where the beams of its lasers end",
});

/// What is done about obstacles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Avoidance {
    /// Nothing; for experiments in empty worlds.
    Off,
    /// The thesis's bubble rebound: the bubble stops, the rebound heading leads away.
    Rebound,
    /// Nothing but what touches the robot, for those that hear and see nothing: it stops at once, backs off where it came,
    /// and rebounds from the side that was touched (extension).
    Contact,
    /// The same machine, but what blocks and where to go around is checked against remembered
    /// echoes and the path ahead (extension).
    #[default]
    Checked,
}

settings::choices!(Avoidance {
    Checked = "checked": "a way around is checked against what was heard before",
    Rebound = "rebound": "the bubble rebound as the thesis has it",
    Contact = "contact": "what touches: it backs off where it came and rebounds, for robots that hear nothing",
    Off = "off": "nothing; for experiments in empty worlds",
});

/// A planar laser on a robot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LaserMount {
    /// Whose scans are its.
    pub device: DeviceId,
    /// Where it sits and which way its x axis looks (m, rad).
    pub base_from_sensor: Se2,
}

/// Where a robot feels that it touches something, or that there is no floor.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ContactMounts {
    /// Of each bumper in the order of its bits: from where to where it is pressed, radians from straight ahead, the right
    /// end first.
    pub bumpers_rad: Vec<[f64; 2]>,
    /// Where each cliff sensor looks at the floor (m, base frame), in the order of its bits.
    pub cliffs_in_base: Vec<Vec2>,
}

impl ContactMounts {
    /// Those of a robot of the catalogue.
    fn of(model: &RobotModel) -> Self {
        let devices = &model.devices;
        let between = |mount: &BumperMount| mount.between_deg.map(f64::to_radians);
        Self {
            bumpers_rad: devices.bumpers.iter().map(between).collect(),
            cliffs_in_base: devices.cliffs.iter().map(|mount| mount.place).collect(),
        }
    }
}

/// Settings as written; every field has a working default. Checked by `NavigatorConfig::try_from`.
#[derive(Clone, Debug, PartialEq)]
pub struct NavigatorSettings {
    /// How a goal is reached.
    pub method: Method,
    /// Law on a trail.
    pub trail_controller: TrailController,
    /// Sets and rules of the fuzzy laws on a trail; the number of sets follows from the law.
    pub trail_fuzzy: FuzzyConfig,
    /// Constants and rules of the law in whole numbers.
    pub trail_listing: ListingConfig,
    /// What says where the robot is.
    pub pose_method: PoseMethod,
    /// How a trail of tags is followed.
    pub tags: TagSettings,
    /// Law on a given path.
    pub path_controller: PathController,
    /// What is done about obstacles.
    pub avoidance: Avoidance,
    /// When to aim at the target again after a rebound.
    pub variant: Variant,
    /// Cruising speed, metres per second: the middle singleton M. L and H are half and one and a
    /// half times it. From 0.05 to 1.
    pub speed_mps: f64,
    /// Time between control steps, seconds, from 0.05 to 2.
    pub control_period_s: f64,
    /// What the wheels can do, metres per second squared, from 0.05 to 5; for stopping distances.
    pub acceleration_mps2: f64,
    /// The fastest that a wheel of this robot can turn, metres per second, from 0.05 to 10.
    pub speed_max_mps: f64,
    /// How long a robot that hears nothing more goes on with its last command, until its watchdog stops it,
    /// seconds, up to 10; 0: it cannot go deaf. So far, and until it stands, it must touch nothing that was heard.
    pub watchdog_s: f64,
    /// Whether to turn in place towards the trail before driving off on it, and where it leads far
    /// to the side; otherwise the law of the trail does all turning, as in the thesis's experiment 7.4.
    pub turn_first: bool,
    /// Whether a trail is driven as fast as it allows: slower before bends and the goal, and with wider sets of
    /// laws `fuzzy` and `fuzzy_fine` above 0.3 m/s; the other laws have no sets to widen. Otherwise the law is as printed and the speed constant, as in the thesis's
    /// experiment 7.4; what avoidance allows still counts.
    pub fit_to_speed: bool,
    /// How long to wait before an obstacle for it to go away, seconds, from 0 to 60. The thesis
    /// does not wait: 0.
    pub wait_s: f64,
    /// Distance at which a target on the way counts as reached (NEAR), metres, from 0.05 to 2.
    pub near_m: f64,
    /// Length of the temporary target of the detour variant, metres, from 0.1 to 5.
    pub detour_m: f64,
    /// Within this distance of the goal the trail is left for a straight line, metres, 0.1 to 5.
    pub approach_m: f64,
    /// The same when the trail has ended, metres, 0.1 to 5.
    pub approach_from_trail_end_m: f64,
    /// How near to the goal the robot must stand, metres, from 0.01 to 1.
    pub goal_tolerance_m: f64,
    /// How well it must look the goal's way, radians, from 0.005 to 1.
    pub heading_tolerance_rad: f64,
    /// How much of the way that the scout found the robot shows ahead of it, metres, from 0 to 20; with
    /// 0 it forgets the way once it is under way and follows its antennas alone, also at junctions.
    pub preview_m: f64,
    /// How long a way to the goal the scout looks for, metres, from 1 to 60; a longer one is looked
    /// for and driven in legs.
    pub scout_max_m: f64,
    /// How far to drive on after the trail was lost, metres, from 0 to 5.
    pub lost_drive_m: f64,
    /// Attempts on one obstacle before the navigator gives up, from 1 to 100.
    pub attempts_max: u32,
    /// Time for a whole task, seconds, from 1 to 36 000.
    pub task_limit_s: f64,
    /// Time without coming nearer to the goal along the way, seconds, from 1 to 3 600.
    pub progress_limit_s: f64,
    /// Silence of the vehicle after which it counts as lost, seconds, from 0.2 to 60.
    pub link_limit_s: f64,
    /// Silence of the pheromone server after which a task fails, seconds, from 0.5 to 60.
    pub server_limit_s: f64,
    /// Gains K_i of the bubble (6.3.1), one per sensor.
    pub bubble_gains: Vec<f64>,
    /// Floors of the bubble, metres, one per sensor.
    pub bubble_floors_m: Vec<f64>,
    /// Greatest range of the sensors, metres.
    pub range_max_m: f64,
    /// Where the sensors are; at most 16.
    pub sensors: Vec<RangeSensor>,
    /// Time in which each of them fires once.
    pub sonar_round: Duration,
    /// Outline of the robot (m, base frame): convex, counter-clockwise, 3 to 12 corners.
    pub outline_m: Vec<Vec2>,
    /// Wheels and encoders.
    pub drive: DriveGeometry,
    /// Random errors of the wheels, for the uncertainty that is shown.
    pub odometry_noise: OdometryNoise,
    /// Where its planar lasers are. A robot with lasers and without a ring of sonars stops while one of them is silent.
    pub lasers: Vec<LaserMount>,
    /// Where its bumpers are pressed and its cliff sensors look, for [`Avoidance::Contact`].
    pub contacts: ContactMounts,
    /// A laser that has sent no scan for so long is silent, seconds, from 0.1 to 10: what it looked at is unseen, not free.
    pub laser_limit_s: f64,
    /// Settings of the echo memory.
    pub echoes: EchoMemoryConfig,
    /// Settings of the checked detour.
    pub detour: DetourConfig,
}

impl NavigatorSettings {
    /// The defaults for a robot of the catalogue: its outline, wheels and its first 16 sonars.
    pub fn for_robot(model: &RobotModel) -> Self {
        let place = |mount: &robot_models::SonarMount| {
            let base_from_sensor = mount.base_from_sensor.se2();
            RangeSensor {
                in_base: base_from_sensor.position(),
                bearing_rad: base_from_sensor.yaw_rad,
            }
        };
        let sensors: Vec<RangeSensor> = model.sonars.iter().take(N_RING_MAX).map(place).collect();
        Self {
            bubble_gains: sensors.iter().map(|s| default_bubble(s.bearing_rad).0).collect(),
            bubble_floors_m: sensors.iter().map(|s| default_bubble(s.bearing_rad).1).collect(),
            sonar_round: model.ring.round(sensors.len()),
            sensors,
            outline_m: model.footprint.corners().to_vec(),
            contacts: ContactMounts::of(model),
            drive: model.drive,
            speed_max_mps: model.limits.speed_max_mps,
            ..Self::default()
        }
    }
}

impl NavigatorSettings {
    pub(crate) fn limits(&self) -> Limits {
        Limits {
            speed_mps: self.speed_mps,
            acceleration_mps2: self.acceleration_mps2,
            period_s: self.control_period_s,
        }
    }

    /// No wheel is asked for more: H is 1.5 times the cruising speed, and the robot has its limit, m/s.
    pub(crate) fn wheel_speed_max_mps(&self) -> f64 {
        (WHEEL_SPEED_MAX_RATIO * self.speed_mps).min(self.speed_max_mps)
    }
}

impl Default for NavigatorSettings {
    /// The thesis's values (v 300 mm/s, Δt 200 ms) for a robot without range sensors and with the
    /// outline and wheels of a Pioneer 3-DX; use [`NavigatorSettings::for_robot`].
    fn default() -> Self {
        Self {
            method: Method::default(),
            trail_controller: TrailController::default(),
            trail_fuzzy: FuzzyConfig::default(),
            trail_listing: ListingConfig::default(),
            pose_method: PoseMethod::default(),
            tags: TagSettings::default(),
            path_controller: PathController::default(),
            avoidance: Avoidance::default(),
            variant: Variant::default(),
            speed_mps: 0.3,
            control_period_s: 0.2,
            acceleration_mps2: 0.3,
            speed_max_mps: 2.2,
            watchdog_s: 2.0,
            turn_first: true,
            fit_to_speed: true,
            wait_s: 2.5,
            near_m: 0.25,
            detour_m: 1.2,
            approach_m: 0.7,
            approach_from_trail_end_m: 1.6,
            goal_tolerance_m: 0.06,
            heading_tolerance_rad: 4.0_f64.to_radians(),
            preview_m: 4.0,
            scout_max_m: 60.0,
            lost_drive_m: 0.6,
            attempts_max: 10,
            task_limit_s: 900.0,
            progress_limit_s: 90.0,
            link_limit_s: 2.0,
            server_limit_s: 5.0,
            bubble_gains: Vec::new(),
            bubble_floors_m: Vec::new(),
            range_max_m: 5.0,
            sensors: Vec::new(),
            sonar_round: Duration::from_millis(320),
            outline_m: vec![
                Vec2::new(0.21, -0.2125),
                Vec2::new(0.21, 0.2125),
                Vec2::new(-0.301, 0.2125),
                Vec2::new(-0.301, -0.2125),
            ],
            drive: DriveGeometry {
                wheelbase_m: 0.38,
                wheel_diameter_m: 0.195,
                encoder_ticks_per_turn: 500.0,
                gear_ratio: 38.3,
            },
            odometry_noise: OdometryNoise::default(),
            lasers: Vec::new(),
            laser_limit_s: 0.5,
            contacts: ContactMounts::default(),
            echoes: EchoMemoryConfig::default(),
            detour: DetourConfig::default(),
        }
    }
}

/// Gain and floor (m) of a sensor by its bearing.
///
/// At 300 mm/s and 200 ms V·Δt is 60 mm, so ahead the boundary lies at 0.6 m: the robot needs
/// 0.15 m to stop, moves 0.1 m before a reading is acted upon, and stands with room to turn. To the
/// sides it shrinks, so that a robot in the middle of a 0.95 m door does not see the posts inside.
/// Sensors that look sideways or back take no part, as in Annex C.
pub(crate) fn default_bubble(bearing_rad: f64) -> (f64, f64) {
    match bearing_rad.abs().to_degrees() {
        b if b < 22.0 => (10.0, 0.25),
        b if b < 40.0 => (6.0, 0.32),
        b if b < 60.0 => (3.5, 0.20),
        _ => (0.0, 0.0),
    }
}
