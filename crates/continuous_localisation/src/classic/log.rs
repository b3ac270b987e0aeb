//! Rows of poses and readings in the source's units.

use recordings::{Recording, Rig};

use super::{ClassicConfig, ClassicSonar};

/// Poses (x mm, y mm, heading degrees) with one row of readings (mm) each.
#[derive(Clone, Debug, PartialEq)]
pub struct ClassicLog {
    pub(super) poses: Vec<[f64; 3]>,
    n_columns: usize,
    readings_mm: Vec<f64>,
    pub(super) period_s: f64,
}

/// Why a log cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ClassicError {
    /// Not every pose has a row of readings of the same length.
    #[error(
        "{n_poses} poses of {n_columns} readings need {} readings, but there are {n_readings}: \
         each pose has one row, and all rows are equally long",
        n_poses * n_columns
    )]
    Shape {
        /// Poses.
        n_poses: usize,
        /// Readings in a row.
        n_columns: usize,
        /// Readings altogether.
        n_readings: usize,
    },
    /// The ring has more sonars than a row has readings.
    #[error(
        "the ring has {n_sonars} sonars, but a row has {n_columns} readings: choose another ring"
    )]
    RingTooLarge {
        /// Sonars.
        n_sonars: usize,
        /// Readings in a row.
        n_columns: usize,
    },
    /// A pose that is not finite.
    #[error("row {row}: a coordinate of the pose is {value}; poses must be finite")]
    NotFinite {
        /// Counted from 1.
        row: usize,
        /// What was found.
        value: f64,
    },
    /// The map would become too large.
    #[error(
        "row {row}: the pose ({x_mm} mm, {y_mm} mm) lies so far from the others that the map would \
         have more than 16 million cells; check the units of the log (mm, degrees) or take a larger \
         scale"
    )]
    TooFar {
        /// Counted from 1.
        row: usize,
        /// Of the pose.
        x_mm: f64,
        /// Of the pose.
        y_mm: f64,
    },
    /// A recording without sonars or without odometry.
    #[error("{0}: the source's method needs a ring of sonars with odometry for every row")]
    Unsuitable(&'static str),
    /// A parameter that cannot be used.
    #[error("{key} = {value}: must be {requirement}")]
    Config {
        /// The parameter.
        key: &'static str,
        /// What it is.
        value: f64,
        /// What it must be.
        requirement: &'static str,
    },
}

impl ClassicLog {
    /// From poses and readings row by row, taken every `period_s` seconds.
    ///
    /// # Errors
    ///
    /// [`ClassicError::Shape`].
    pub fn new(
        poses: Vec<[f64; 3]>,
        readings_mm: Vec<f64>,
        n_columns: usize,
        period_s: f64,
    ) -> Result<Self, ClassicError> {
        let (n_poses, n_readings) = (poses.len(), readings_mm.len());
        if n_poses.checked_mul(n_columns) != Some(n_readings) {
            return Err(ClassicError::Shape { n_poses, n_columns, n_readings });
        }
        Ok(Self { poses, n_columns, readings_mm, period_s })
    }

    /// From a recording of a ring, and the ring in the source's units. Silence becomes the
    /// ring's greatest range, as the source's files have it. Columns beyond the ring follow its readings, because
    /// the program counts them.
    ///
    /// Metres and radians are converted and then rounded to 1e-7 mm and 1e-9 degrees, so that
    /// numbers that came from millimetres and degrees with fewer digits are what they were.
    ///
    /// # Errors
    ///
    /// [`ClassicError::Unsuitable`] for a laser's recording or a row without odometry,
    /// [`ClassicError::Shape`] for rows of different lengths.
    pub fn from_recording(
        recording: &Recording,
    ) -> Result<(Self, Vec<ClassicSonar>), ClassicError> {
        let Rig::Ring(rig) = &recording.rig else {
            return Err(ClassicError::Unsuitable("this is a laser's recording"));
        };
        let mm = |m: f64| (m * 1e10).round() / 1e7;
        let deg = |rad: f64| (rad.to_degrees() * 1e9).round() / 1e9;
        let ring = rig.base_from_sensors.iter().map(|sensor| ClassicSonar {
            x_mm: mm(sensor.x_m),
            y_mm: mm(sensor.y_m),
            azimuth_deg: deg(sensor.yaw_rad),
        });
        let reading_mm = |m: f64| mm(if m < rig.range_max_m { m } else { rig.range_max_m });
        let mut poses = Vec::with_capacity(recording.scans.len());
        let mut readings_mm = Vec::new();
        for (row, scan) in recording.scans.iter().enumerate() {
            let Some(pose) = scan.odom_from_base else {
                return Err(ClassicError::Unsuitable("a row has no odometry"));
            };
            poses.push([mm(pose.x_m), mm(pose.y_m), deg(pose.yaw_rad)]);
            let extra = recording.extra_columns_m.get(row).map_or(&[][..], Vec::as_slice);
            readings_mm.extend(scan.ranges_m.iter().chain(extra).map(|&m| reading_mm(m)));
        }
        let n_columns = recording.scans.first().map_or(0, |scan| {
            scan.ranges_m.len() + recording.extra_columns_m.first().map_or(0, Vec::len)
        });
        let period_s = match (recording.scans.first(), recording.scans.last()) {
            (Some(first), Some(last)) if recording.scans.len() > 1 => {
                last.stamp.since(first.stamp).as_secs_f64() / (recording.scans.len() - 1) as f64
            }
            _ => 0.0,
        };
        Ok((Self::new(poses, readings_mm, n_columns, period_s)?, ring.collect()))
    }

    /// Rows.
    pub fn n_rows(&self) -> usize {
        self.poses.len()
    }

    /// Poses as given: x mm, y mm, heading degrees.
    pub fn poses(&self) -> &[[f64; 3]] {
        &self.poses
    }

    /// The readings of a row, all columns.
    pub fn readings_mm(&self, row: usize) -> &[f64] {
        &self.readings_mm[row * self.n_columns..(row + 1) * self.n_columns]
    }

    /// Refuses what [`run`](super::run) could not go through with.
    pub(super) fn check(&self, config: &ClassicConfig) -> Result<(), ClassicError> {
        let n_sonars = config.ring.len();
        if self.n_rows() > 0 && n_sonars > self.n_columns {
            return Err(ClassicError::RingTooLarge { n_sonars, n_columns: self.n_columns });
        }
        for (row, pose) in (1..).zip(&self.poses) {
            if let Some(&value) = pose.iter().find(|value| !value.is_finite()) {
                return Err(ClassicError::NotFinite { row, value });
            }
        }
        let checks = [
            ("pose_scale_mm", config.pose_scale_mm, 1.0, 1000.0, "from 1 to 1000 mm"),
            ("shape.scale_mm", config.shape.scale_mm, 1.0, 1000.0, "from 1 to 1000 mm"),
            ("shape.n_cells", config.shape.n_cells as f64, 2.0, 1000.0, "from 2 to 1000"),
            ("n_world_cells", config.n_world_cells as f64, 0.0, 4000.0, "at most 4000"),
            ("n_margin_cells", config.n_margin_cells as f64, 0.0, 500.0, "at most 500"),
            ("half_angle_deg", config.shape.half_angle_deg, 0.1, 90.0, "from 0.1 to 90 degrees"),
        ];
        for (key, value, min, max, requirement) in checks {
            if !(min..=max).contains(&value) {
                return Err(ClassicError::Config { key, value, requirement });
            }
        }
        Ok(())
    }
}
