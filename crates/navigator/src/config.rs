//! Settings of a mind that hold together, and the parts that are made of them.

use std::time::Duration;

use messages::N_RING_MAX;
use obstacle_avoidance::{Bubble, BubbleError, Footprint, MachineConfigError, RangeSensor};
use path_following::SettingError;

use crate::{
    around::{Surroundings, sectors},
    follow::Follow,
    guard::Guard,
    health::Health,
    how::Route,
    settings::{Avoidance, NavigatorSettings, default_bubble},
    where_am_i::Locator,
    where_to::Task,
};

/// Settings that hold together; made only by `try_from`.
#[derive(Clone, Debug)]
pub struct NavigatorConfig {
    settings: NavigatorSettings,
    parts: Parts,
}

/// Most lasers of a robot.
const N_LASERS_MAX: usize = 4;

/// Echoes for which each of them needs room.
const N_ECHOES_OF_LASER: usize = 512;

/// The parts of a mind; made once, cloned by every mind.
#[derive(Clone, Debug)]
pub(crate) struct Parts {
    pub(crate) locator: Locator,
    pub(crate) around: Surroundings,
    pub(crate) task: Task,
    pub(crate) route: Route,
    pub(crate) follow: Follow,
    pub(crate) guard: Guard,
    pub(crate) health: Health,
}

/// A setting outside its range.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ConfigError {
    /// A single value.
    #[error("navigator.{key} = {value}: must be {requirement}")]
    Value {
        /// The key.
        key: &'static str,
        /// What was given.
        value: f64,
        /// What is allowed.
        requirement: &'static str,
    },
    /// The bubble.
    #[error("navigator: {0}")]
    Bubble(#[from] BubbleError),
    /// The avoider.
    #[error("navigator: {0}")]
    Avoider(#[from] MachineConfigError),
    /// A follower.
    #[error("navigator: {0}")]
    Follower(#[from] SettingError),
}

impl NavigatorConfig {
    /// The settings it was made from.
    pub fn settings(&self) -> &NavigatorSettings {
        &self.settings
    }

    /// Time between control steps.
    pub(crate) fn period(&self) -> Duration {
        Duration::from_secs_f64(self.settings.control_period_s)
    }

    /// Parts of a new mind, with all the room that they will ever need.
    pub(crate) fn parts(&self) -> Parts {
        let parts = self.parts.clone();
        Parts {
            around: parts.around.with_room(&self.settings),
            route: parts.route.with_room(),
            ..parts
        }
    }
}

impl TryFrom<NavigatorSettings> for NavigatorConfig {
    type Error = ConfigError;

    fn try_from(mut settings: NavigatorSettings) -> Result<Self, ConfigError> {
        check_ranges(&settings)?;
        // A silent sensor reads its greatest range, whatever that is; noise stays above this.
        settings.echoes.silence_m = settings.echoes.silence_m.min(0.98 * settings.range_max_m);
        let footprint = Footprint::new(&settings.outline_m).ok_or(ConfigError::Value {
            key: "outline_m",
            value: settings.outline_m.len() as f64,
            requirement: "3 to 12 corners of a convex outline around the axle, counter-clockwise",
        })?;
        let hears = !settings.sensors.is_empty();
        settings.echoes.capacity += N_ECHOES_OF_LASER * settings.lasers.len();
        let feels = settings.avoidance == Avoidance::Contact;
        if feels || !hears && !settings.lasers.is_empty() {
            // What is written for a ring of sonars holds for the sectors of a laser or of a skin, too.
            let bubble = |sensor: &RangeSensor| default_bubble(sensor.bearing_rad);
            settings.sensors = sectors(&footprint);
            settings.bubble_gains = settings.sensors.iter().map(|s| bubble(s).0).collect();
            settings.bubble_floors_m = settings.sensors.iter().map(|s| bubble(s).1).collect();
        }
        let s = &settings;
        let bubble = Bubble::new(&s.bubble_gains, &s.bubble_floors_m, s.range_max_m)?;
        let parts = Parts {
            locator: Locator::new(s),
            guard: Guard::new(s, bubble.clone(), &footprint)?,
            around: Surroundings::new(s, bubble, footprint, hears),
            task: Task::new(s),
            route: Route::new(s)?,
            follow: Follow::new(s)?,
            health: Health::new(s),
        };
        Ok(Self { settings, parts })
    }
}

fn check_ranges(s: &NavigatorSettings) -> Result<(), ConfigError> {
    let ranges = [
        ("speed_mps", s.speed_mps, 0.05, 1.0, "from 0.05 to 1 m/s"),
        ("control_period_s", s.control_period_s, 0.05, 2.0, "from 0.05 to 2 s"),
        ("acceleration_mps2", s.acceleration_mps2, 0.05, 5.0, "from 0.05 to 5 m/s²"),
        ("speed_max_mps", s.speed_max_mps, 0.05, 10.0, "from 0.05 to 10 m/s"),
        ("watchdog_s", s.watchdog_s, 0.0, 10.0, "from 0 to 10 s"),
        ("wait_s", s.wait_s, 0.0, 60.0, "from 0 to 60 s"),
        ("near_m", s.near_m, 0.05, 2.0, "from 0.05 to 2 m"),
        ("detour_m", s.detour_m, 0.1, 5.0, "from 0.1 to 5 m"),
        ("approach_m", s.approach_m, 0.1, 5.0, "from 0.1 to 5 m"),
        ("approach_from_trail_end_m", s.approach_from_trail_end_m, 0.1, 5.0, "from 0.1 to 5 m"),
        ("goal_tolerance_m", s.goal_tolerance_m, 0.01, 1.0, "from 0.01 to 1 m"),
        ("heading_tolerance_rad", s.heading_tolerance_rad, 0.005, 1.0, "from 0.005 to 1 rad"),
        ("preview_m", s.preview_m, 0.0, 20.0, "from 0 to 20 m"),
        ("scout_max_m", s.scout_max_m, 1.0, 60.0, "from 1 to 60 m"),
        ("lost_drive_m", s.lost_drive_m, 0.0, 5.0, "from 0 to 5 m"),
        ("attempts_max", f64::from(s.attempts_max), 1.0, 100.0, "from 1 to 100"),
        ("task_limit_s", s.task_limit_s, 1.0, 36_000.0, "from 1 to 36 000 s"),
        ("progress_limit_s", s.progress_limit_s, 1.0, 3_600.0, "from 1 to 3 600 s"),
        ("link_limit_s", s.link_limit_s, 0.2, 60.0, "from 0.2 to 60 s"),
        ("server_limit_s", s.server_limit_s, 0.5, 60.0, "from 0.5 to 60 s"),
        ("range_max_m", s.range_max_m, 0.1, 100.0, "from 0.1 to 100 m"),
        ("sensors", s.sensors.len() as f64, 0.0, N_RING_MAX as f64, "at most 16 sensors"),
        ("lasers", s.lasers.len() as f64, 0.0, N_LASERS_MAX as f64, "at most 4 lasers"),
        ("laser_limit_s", s.laser_limit_s, 0.1, 10.0, "from 0.1 to 10 s"),
        ("drive.wheelbase_m", s.drive.wheelbase_m, 0.01, 2.0, "from 0.01 to 2 m"),
    ];
    for (key, value, least, most, requirement) in ranges {
        if !(least..=most).contains(&value) {
            return Err(ConfigError::Value { key, value, requirement });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use robot_models::RobotModel;

    use super::*;

    #[test]
    fn the_defaults_hold_for_every_robot_of_the_catalogue() {
        for model in RobotModel::catalogue() {
            let config = NavigatorConfig::try_from(NavigatorSettings::for_robot(&model)).unwrap();
            let n_sensors = config.settings().sensors.len();
            assert_eq!(n_sensors, model.sonars.len().min(N_RING_MAX), "{}", model.name);
            let turning_radius_m = config.parts.around.footprint().turning_radius_m();
            assert!(turning_radius_m > model.bounding_radius_m() - 1e-9, "{}", model.name);
        }
    }

    #[test]
    fn a_setting_outside_its_range_is_named_with_its_value() {
        let settings = NavigatorSettings { speed_mps: f64::NAN, ..NavigatorSettings::default() };
        let error = NavigatorConfig::try_from(settings).unwrap_err();
        assert_eq!(error.to_string(), "navigator.speed_mps = NaN: must be from 0.05 to 1 m/s");
        let settings = NavigatorSettings { wait_s: -1.0, ..NavigatorSettings::default() };
        let error = NavigatorConfig::try_from(settings).unwrap_err();
        assert_eq!(error.to_string(), "navigator.wait_s = -1: must be from 0 to 60 s");
        let settings =
            NavigatorSettings { bubble_gains: vec![1.0], ..NavigatorSettings::default() };
        assert!(matches!(NavigatorConfig::try_from(settings), Err(ConfigError::Bubble(_))));
    }
}
