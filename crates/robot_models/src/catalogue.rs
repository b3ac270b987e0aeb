//! The catalogue of robots: data files, read and checked.
//!
//! A model is a TOML file under `data/`, built into the program; [`RobotModel::from_toml`] reads
//! one that a user wrote. Lengths are metres; degrees are allowed in the file only.

use std::time::Duration;

use geometry::{Base, Polygon, Se2, Sensor, Transform2, Vec2};
use serde::Deserialize;

use crate::{
    devices::{BatteryModel, BumperFile, CliffFile, Devices, InfraredFile},
    drive::{DriveGeometry, DriveLimits},
    model_error::{ModelError, check_range},
};

/// The files of the built-in models.
const FILES: [&str; 5] = [
    include_str!("../data/pioneer3dx.toml"),
    include_str!("../data/peoplebot.toml"),
    include_str!("../data/artemic5.toml"),
    include_str!("../data/artemic8.toml"),
    include_str!("../data/create2.toml"),
];

/// A kind of robot: what all robots of the kind share.
#[derive(Clone, Debug)]
pub struct RobotModel {
    /// The name in missions, such as `pioneer3dx`.
    pub name: String,
    /// The name for people, such as `Pioneer 3-DX`.
    pub title: String,
    /// Its line to its navigator; `None` when its bytes are not known here.
    pub line: Option<LineModel>,
    /// Time between two reports of pose and ranges to its navigator, over any line.
    pub status_period: Duration,
    /// Wheels and encoders.
    pub drive: DriveGeometry,
    /// Greatest speeds and starting accelerations.
    pub limits: DriveLimits,
    /// Outline in the base frame, convex, counter-clockwise, metres.
    pub footprint: Polygon,
    /// Radius that stands for the body where a circle is enough, metres.
    pub radius_m: f64,
    /// Its sonars, in the order of their numbers.
    pub sonars: Vec<SonarMount>,
    /// How they take turns.
    pub ring: RingTiming,
    /// Its mass, kg, if the catalogue knows it.
    pub mass_kg: Option<f64>,
    /// What it carries besides.
    pub devices: Devices,
}

/// The line between a robot and its navigator, as the robot's maker made it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LineModel {
    /// The protocol spoken on it, such as `arcos`; the registries of firmware, drivers and readers know it by this name.
    pub protocol: String,
    /// Speed of the line when the robot has been switched on, bits per second.
    pub baud: u32,
    /// The slowest line over which its reports fit, bits per second.
    pub baud_min: u32,
    /// Time without a word of the client after which the robot stops by itself; `None`: it never does.
    pub watchdog: Option<Duration>,
    /// What it says that it is, where the protocol has a word for that; client libraries go by it.
    pub class: String,
    /// What it says more precisely, from which client libraries take their parameters.
    pub subclass: String,
}

/// How the sonars of a robot take turns: in chains, one of each chain at a time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RingTiming {
    /// Sonars in a chain, at least 1: the first so many in the order of their numbers, then the next.
    pub chain_len: usize,
    /// Time between two pings of a chain.
    pub ping_period: Duration,
}

impl RingTiming {
    /// The Pioneer's: chains of eight, 40 ms apart.
    pub const PIONEER: Self = Self { chain_len: 8, ping_period: Duration::from_millis(40) };

    /// Time in which each of `n_sonars` has fired once.
    pub fn round(self, n_sonars: usize) -> Duration {
        let n_turns = u32::try_from(self.chain_len.min(n_sonars)).unwrap_or(u32::MAX);
        self.ping_period.saturating_mul(n_turns)
    }
}

/// Where one sonar sits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SonarMount {
    /// Pose of the sensor (x along its axis) in the base frame.
    pub base_from_sensor: Transform2<Base, Sensor>,
}

/// A name that is not in the catalogue.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("unknown robot model `{name}`: the catalogue has {known}")]
pub struct UnknownModel {
    /// What was asked for.
    pub name: String,
    /// The names there are, as prose.
    pub known: String,
}

impl RobotModel {
    /// The built-in model with that name.
    ///
    /// ```
    /// let model = robot_models::RobotModel::by_name("pioneer3dx")?;
    /// assert_eq!(model.sonars.len(), 16);
    /// # Ok::<(), robot_models::UnknownModel>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`UnknownModel`], which lists the names there are.
    pub fn by_name(name: &str) -> Result<Self, UnknownModel> {
        let catalogue = Self::catalogue();
        let known: Vec<String> = catalogue.iter().map(|m| format!("`{}`", m.name)).collect();
        catalogue
            .into_iter()
            .find(|model| model.name == name)
            .ok_or_else(|| UnknownModel { name: name.to_owned(), known: known.join(", ") })
    }

    /// All built-in models.
    pub fn catalogue() -> Vec<Self> {
        // A test reads every file, so none is dropped here.
        FILES.iter().filter_map(|text| Self::from_toml(text).ok()).collect()
    }

    /// Reads a model file.
    ///
    /// # Errors
    ///
    /// [`ModelError`], naming the key, the value and what it must be.
    pub fn from_toml(text: &str) -> Result<Self, ModelError> {
        let file: ModelFile = toml::from_str(text)?;
        file.check_ranges()?;
        let corners = file.footprint_m.iter().map(|&[x, y]| Vec2::new(x, y)).collect();
        let footprint = Polygon::new(corners)?;
        check_convex(&footprint)?;
        let sonars = file.sonars.iter().enumerate().map(|(index, sonar)| sonar.mount(index));
        let devices = Devices {
            bumpers: mounts(file.bumpers, BumperFile::mount)?,
            cliffs: mounts(file.cliffs, CliffFile::mount)?,
            infrareds: mounts(file.infrareds, InfraredFile::mount)?,
            battery: file.battery.map(BatteryModel::checked).transpose()?,
        };
        Ok(Self {
            devices,
            mass_kg: file.mass_kg,
            sonars: sonars.collect::<Result<_, _>>()?,
            footprint,
            name: file.name,
            title: file.title,
            status_period: milliseconds(file.status_period_ms),
            ring: RingTiming {
                chain_len: file.ring.chain_length,
                ping_period: milliseconds(file.ring.ping_period_ms),
            },
            line: file.line.map(LineFile::checked).transpose()?,
            drive: DriveGeometry {
                wheelbase_m: file.drive.wheelbase_m,
                wheel_diameter_m: file.drive.wheel_diameter_m,
                encoder_ticks_per_turn: file.drive.encoder_ticks_per_turn,
                gear_ratio: file.drive.gear_ratio,
            },
            limits: DriveLimits {
                speed_max_mps: file.limits.speed_max_mps,
                turn_rate_max_radps: file.limits.turn_rate_max_degps.to_radians(),
                acceleration_max_mps2: file.limits.acceleration_mps2,
                turn_acceleration_max_radps2: file.limits.turn_acceleration_degps2.to_radians(),
            },
            radius_m: file.radius_m,
        })
    }

    /// The protocol of its line, if it has one.
    pub fn protocol(&self) -> Option<&str> {
        self.line.as_ref().map(|line| line.protocol.as_str())
    }

    /// Distance from the base's origin to the farthest corner of the footprint, metres.
    pub fn bounding_radius_m(&self) -> f64 {
        self.footprint.corners().iter().map(Vec2::norm).fold(0.0, f64::max)
    }
}

/// A model file as written.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct ModelFile {
    name: String,
    title: String,
    line: Option<LineFile>,
    radius_m: f64,
    #[serde(default = "pioneer_status_period_ms")]
    status_period_ms: f64,
    footprint_m: Vec<[f64; 2]>,
    drive: DriveFile,
    limits: LimitsFile,
    #[serde(default)]
    ring: RingFile,
    #[serde(default)]
    sonars: Vec<SonarFile>,
    mass_kg: Option<f64>,
    #[serde(default)]
    bumpers: Vec<BumperFile>,
    #[serde(default)]
    cliffs: Vec<CliffFile>,
    #[serde(default)]
    infrareds: Vec<InfraredFile>,
    battery: Option<BatteryModel>,
}

fn slowest_baud() -> u32 {
    300
}

fn pioneer_status_period_ms() -> f64 {
    100.0
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct LineFile {
    protocol: String,
    baud: u32,
    #[serde(default = "slowest_baud")]
    baud_min: u32,
    /// 0: it has none.
    watchdog_ms: f64,
    #[serde(default)]
    class: String,
    #[serde(default)]
    subclass: String,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct DriveFile {
    wheelbase_m: f64,
    wheel_diameter_m: f64,
    encoder_ticks_per_turn: f64,
    gear_ratio: f64,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct LimitsFile {
    speed_max_mps: f64,
    turn_rate_max_degps: f64,
    acceleration_mps2: f64,
    turn_acceleration_degps2: f64,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct RingFile {
    chain_length: usize,
    ping_period_ms: f64,
}

impl Default for RingFile {
    fn default() -> Self {
        let RingTiming { chain_len, ping_period } = RingTiming::PIONEER;
        Self { chain_length: chain_len, ping_period_ms: 1e3 * ping_period.as_secs_f64() }
    }
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct SonarFile {
    number: usize,
    x_m: f64,
    y_m: f64,
    azimuth_deg: f64,
}

impl ModelFile {
    fn check_ranges(&self) -> Result<(), ModelError> {
        let (drive, limits) = (&self.drive, &self.limits);
        let checks = [
            ("radius_m", self.radius_m, 0.01, 5.0, "from 0.01 to 5 m"),
            ("mass_kg", self.mass_kg.unwrap_or(1.0), 0.01, 1e4, "from 0.01 to 10000 kg"),
            ("status_period_ms", self.status_period_ms, 10.0, 1000.0, "from 10 to 1000 ms"),
            ("ring.chain_length", self.ring.chain_length as f64, 1.0, 64.0, "from 1 to 64"),
            ("ring.ping_period_ms", self.ring.ping_period_ms, 1.0, 1000.0, "from 1 to 1000 ms"),
            ("drive.wheelbase_m", drive.wheelbase_m, 0.01, 5.0, "from 0.01 to 5 m"),
            ("drive.wheel_diameter_m", drive.wheel_diameter_m, 0.005, 2.0, "from 0.005 to 2 m"),
            (
                "drive.encoder_ticks_per_turn",
                drive.encoder_ticks_per_turn,
                1.0,
                1e6,
                "from 1 to 1000000",
            ),
            ("drive.gear_ratio", drive.gear_ratio, 0.01, 10_000.0, "from 0.01 to 10000"),
            ("limits.speed_max_mps", limits.speed_max_mps, 0.01, 20.0, "from 0.01 to 20 m/s"),
            (
                "limits.turn_rate_max_degps",
                limits.turn_rate_max_degps,
                1.0,
                3600.0,
                "from 1 to 3600 deg/s",
            ),
            (
                "limits.acceleration_mps2",
                limits.acceleration_mps2,
                0.001,
                100.0,
                "from 0.001 to 100 m/s²",
            ),
            (
                "limits.turn_acceleration_degps2",
                limits.turn_acceleration_degps2,
                0.1,
                36_000.0,
                "from 0.1 to 36000 deg/s²",
            ),
        ];
        for (key, value, min, max, requirement) in checks {
            check_range(key, value, min, max, requirement)?;
        }
        Ok(())
    }
}

impl LineFile {
    fn checked(self) -> Result<LineModel, ModelError> {
        let is_name = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_';
        if self.protocol.is_empty() || !self.protocol.chars().all(is_name) {
            return Err(ModelError::Protocol { protocol: self.protocol });
        }
        check_range("line.baud", self.baud.into(), 300.0, 4e6, "from 300 to 4000000 baud")?;
        let requirement = "from 300 baud to line.baud";
        check_range("line.baud_min", self.baud_min.into(), 300.0, self.baud.into(), requirement)?;
        let requirement = "from 0 (none) to 60000 ms";
        check_range("line.watchdog_ms", self.watchdog_ms, 0.0, 60_000.0, requirement)?;
        let watchdog = milliseconds(self.watchdog_ms);
        Ok(LineModel {
            protocol: self.protocol,
            baud: self.baud,
            baud_min: self.baud_min,
            watchdog: (!watchdog.is_zero()).then_some(watchdog),
            class: self.class,
            subclass: self.subclass,
        })
    }
}

impl SonarFile {
    fn mount(&self, index: usize) -> Result<SonarMount, ModelError> {
        if self.number != index {
            return Err(ModelError::SonarNumber { index, number: self.number });
        }
        let numbers = [
            ("x_m", self.x_m, 5.0, "from -5 to 5 m"),
            ("y_m", self.y_m, 5.0, "from -5 to 5 m"),
            ("azimuth_deg", self.azimuth_deg, 360.0, "from -360 to 360 deg"),
        ];
        for (key, value, limit, requirement) in numbers {
            if !(-limit..=limit).contains(&value) {
                let key = format!("sonars[{index}].{key}");
                return Err(ModelError::Range { key, value, requirement });
            }
        }
        let pose = Se2::new(self.x_m, self.y_m, self.azimuth_deg.to_radians());
        Ok(SonarMount { base_from_sensor: Transform2::new(pose) })
    }
}

/// Mounts in the order of the file.
fn mounts<F, M>(
    files: Vec<F>,
    mount: impl Fn(F, usize) -> Result<M, ModelError>,
) -> Result<Vec<M>, ModelError> {
    files.into_iter().enumerate().map(|(index, file)| mount(file, index)).collect()
}

/// A time that was checked to be positive and finite.
fn milliseconds(value_ms: f64) -> Duration {
    Duration::try_from_secs_f64(1e-3 * value_ms).unwrap_or_default()
}

fn check_convex(footprint: &Polygon) -> Result<(), ModelError> {
    let corners = footprint.corners();
    let n = corners.len();
    for i in 0..n {
        let (before, here, after) = (corners[(i + n - 1) % n], corners[i], corners[(i + 1) % n]);
        if (here - before).perp(&(after - here)) < 0.0 {
            return Err(ModelError::NotConvex { corner: i, x_m: here.x, y_m: here.y });
        }
    }
    Ok(())
}

#[cfg(test)]
#[path = "catalogue_tests.rs"]
mod tests;
