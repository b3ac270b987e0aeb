//! The shape of a recording: one sensor rig, its scans in order of time, and the robot's odometry.

use geometry::{Se2, Twist};
use run_context::Stamp;

/// Everything that one robot sensed.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    /// What the ranges mean.
    pub rig: Rig,
    /// In order of time; equal stamps keep the order of the file.
    pub scans: Vec<Scan>,
    /// Dead reckoning at its full rate, in order of time, if the file has more of it than the scans do.
    pub odometry: Vec<StampedPose>,
    /// Poses that somebody else computed and that came with the file, one for each scan, or empty; in a map
    /// frame of their own. For comparison only.
    pub reference: Vec<StampedPose>,
    /// True poses (simulated recordings, one for each scan), or empty. For judging only.
    pub truth: Vec<StampedPose>,
    /// Readings of sonars whose place is not known (columns beyond the ring), metres: one row for each scan,
    /// or empty. Good for counting readings as the thesis' listing does, and for writing them back.
    pub extra_columns_m: Vec<Vec<f64>>,
    /// The file's own time at [`Stamp::ZERO`], nanoseconds; add it to a stamp to get the file's.
    pub epoch_ns: i64,
}

/// What took the readings.
#[derive(Clone, Debug, PartialEq)]
pub enum Rig {
    /// A scanning laser.
    Laser(LaserRig),
    /// Sonars around the robot, each with its own place.
    Ring(RingRig),
}

/// A scanning laser: equally spaced beams.
#[derive(Clone, Debug, PartialEq)]
pub struct LaserRig {
    /// Where the laser sits on the robot.
    pub base_from_sensor: Se2,
    /// Bearing of the first beam from the sensor's x axis, radians.
    pub first_beam_rad: f64,
    /// From one beam to the next, counter-clockwise positive, radians.
    pub beam_spacing_rad: f64,
    /// Beams in a scan.
    pub n_beams: usize,
    /// Readings from here on mean that nothing came back, metres.
    pub range_max_m: f64,
}

/// Sonars around the robot.
#[derive(Clone, Debug, PartialEq)]
pub struct RingRig {
    /// Each sonar's face, x along its axis; the order is that of the readings.
    pub base_from_sensors: Vec<Se2>,
    /// Half of the cone's opening, radians.
    pub half_angle_rad: f64,
    /// Nearer echoes cannot be measured, metres.
    pub range_min_m: f64,
    /// Readings from here on mean that nothing came back, metres.
    pub range_max_m: f64,
}

/// One sweep of the laser, or one row of readings of the ring.
#[derive(Clone, Debug, PartialEq)]
pub struct Scan {
    /// When it was taken.
    pub stamp: Stamp,
    /// Dead reckoning at that moment; `None` where the file has none (then a laser must do without).
    pub odom_from_base: Option<Se2>,
    /// One range for each beam or sonar, metres; finite and not negative, or infinite for "nothing came back".
    /// A laser's readings from `range_max_m` on are infinite here. A ring's keep their number, so that a row
    /// can be counted and written back as it was: ask [`Rig::is_echo`].
    pub ranges_m: Vec<f64>,
    /// When each reading was taken, if that is not `stamp` for all; same length as `ranges_m`, or empty.
    pub stamps: Vec<Stamp>,
}

/// A pose at a moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StampedPose {
    /// When.
    pub stamp: Stamp,
    /// Where, in the frame that the owner says.
    pub pose: Se2,
}

impl Recording {
    /// Metres that the robot drove by the odometry of its scans; zero without odometry.
    pub fn path_length_m(&self) -> f64 {
        let poses: Vec<Se2> = self.scans.iter().filter_map(|s| s.odom_from_base).collect();
        poses.windows(2).map(|p| (p[1].position() - p[0].position()).norm()).sum()
    }

    /// Time from the first scan to the last.
    pub fn duration(&self) -> std::time::Duration {
        match (self.scans.first(), self.scans.last()) {
            (Some(first), Some(last)) => last.stamp.since(first.stamp),
            _ => std::time::Duration::ZERO,
        }
    }
}

impl Rig {
    /// Readings in a scan.
    pub fn n_readings(&self) -> usize {
        match self {
            Self::Laser(laser) => laser.n_beams,
            Self::Ring(ring) => ring.base_from_sensors.len(),
        }
    }

    /// Readings from here on mean that nothing came back, metres.
    pub fn range_max_m(&self) -> f64 {
        match self {
            Self::Laser(laser) => laser.range_max_m,
            Self::Ring(ring) => ring.range_max_m,
        }
    }

    /// Whether a reading (metres) is of something, not of nothing: shorter than `range_max_m`.
    pub fn is_echo(&self, range_m: f64) -> bool {
        range_m < self.range_max_m()
    }
}

impl LaserRig {
    /// Bearing of a beam from the sensor's x axis, radians; not wrapped.
    pub fn bearing_rad(&self, beam: usize) -> f64 {
        self.first_beam_rad + beam as f64 * self.beam_spacing_rad
    }
}

/// Where something was at a moment between the poses of a track; `None` outside of it. `track` is in order of
/// time; between two poses the motion is an arc of constant velocity, and among poses of one moment the
/// last one counts. O(log n).
pub fn interpolate_pose(track: &[StampedPose], stamp: Stamp) -> Option<Se2> {
    let after = track.partition_point(|p| p.stamp <= stamp);
    let before = track.get(after.checked_sub(1)?)?;
    let Some(next) = track.get(after) else {
        return (before.stamp == stamp).then_some(before.pose);
    };
    let whole = next.stamp.since(before.stamp).as_secs_f64();
    let share = stamp.since(before.stamp).as_secs_f64() / whole;
    if share == 0.0 {
        return Some(before.pose);
    }
    let twist = before.pose.inverse().compose(next.pose).log();
    let part = Twist {
        dx_m: share * twist.dx_m,
        dy_m: share * twist.dy_m,
        dyaw_rad: share * twist.dyaw_rad,
    };
    Some(before.pose.compose(Se2::exp(part)))
}

/// A pose of these numbers; an angle that is wrapped keeps every bit, which wrapping it again would not grant.
pub(crate) fn exact_pose(x_m: f64, y_m: f64, yaw_rad: f64) -> Se2 {
    if is_wrapped(yaw_rad) { Se2 { x_m, y_m, yaw_rad } } else { Se2::new(x_m, y_m, yaw_rad) }
}

/// Whether an angle (rad) is in [-π, π).
pub(crate) fn is_wrapped(yaw_rad: f64) -> bool {
    (-std::f64::consts::PI..std::f64::consts::PI).contains(&yaw_rad)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    fn at(ms: u64, x_m: f64, y_m: f64, yaw_rad: f64) -> StampedPose {
        StampedPose { stamp: Stamp::from_millis(ms), pose: Se2::new(x_m, y_m, yaw_rad) }
    }

    #[test]
    fn between_two_poses_the_robot_is_on_an_arc() {
        // A quarter circle of radius 1 around (0, 1).
        let track = [at(1000, 0.0, 0.0, 0.0), at(3000, 1.0, 1.0, FRAC_PI_2)];
        let half = interpolate_pose(&track, Stamp::from_millis(2000)).unwrap();
        let c = std::f64::consts::FRAC_1_SQRT_2;
        assert!((half.x_m - c).abs() < 1e-12 && (half.y_m - (1.0 - c)).abs() < 1e-12, "{half:?}");
        assert!((half.yaw_rad - FRAC_PI_2 / 2.0).abs() < 1e-12);
        assert_eq!(interpolate_pose(&track, Stamp::from_millis(999)), None);
        assert_eq!(interpolate_pose(&track, Stamp::from_millis(3001)), None);
        assert_eq!(interpolate_pose(&track, Stamp::from_millis(1000)), Some(track[0].pose));
        assert_eq!(interpolate_pose(&track, Stamp::from_millis(3000)), Some(track[1].pose));
        assert_eq!(interpolate_pose(&[], Stamp::ZERO), None);
    }

    #[test]
    fn of_poses_of_one_moment_the_last_counts() {
        let track = [at(1, 0.0, 0.0, 0.0), at(1, 5.0, 0.0, 0.0), at(2, 6.0, 0.0, 0.0)];
        assert_eq!(interpolate_pose(&track, Stamp::from_millis(1)), Some(track[1].pose));
    }
}
