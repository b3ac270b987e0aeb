//! A path made ready for driving: its sharp corners, its curvature, and how fast each place may be passed.
//!
//! A law of following knows where the robot should be, not how fast it may come there. Three things
//! bound the speed at a place: what the wheels can do on a curve, how far the robot runs on before a
//! change of its turn rate shows, and whatever must be slower further on. A corner that no law turns
//! around within a few centimetres is turned on the spot: there the speed is zero, and the course
//! falls into *legs* between such corners.
//!
//! The bounds are carried along the way by one pass backwards, for braking, and one forwards, for
//! accelerating. Our own; the thesis drives at one speed. Tests compare with bounds written out anew.

use geometry::wrap_to_pi;

use crate::{Path, Piece};

/// Turning within [`CORNER_WAY_M`] from which a corner is turned on the spot, radians: from about here on
/// the fuzzy law, whose tightest circle is as wide as the robot, leaves the path by more than 10 cm.
const CORNER_TURN_RAD: f64 = 0.6;
/// Turning within so much way is one corner, metres.
const CORNER_WAY_M: f64 = 0.2;
/// Curvature is the mean over so much way, metres: a polyline that stands for an arc has it, too.
const CURVATURE_WAY_M: f64 = 0.3;
/// Distance between two samples of the course, metres.
const SAMPLE_M: f64 = 0.05;
/// Samples at most; very long paths are sampled more coarsely.
const N_SAMPLES_MAX: f64 = 20_000.0;
/// Arcs count as turns so far apart, metres.
const ARC_TURNS_EVERY_M: f64 = 0.05;
/// How far a robot may leave a curve because its turn comes late, metres.
const LATE_TURN_M: f64 = 0.05;
/// Way that a robot may drive before a decision shows, metres.
const LAG_WAY_M: f64 = 0.35;
/// Part of the wheels' acceleration that is for braking; the rest is for corrections.
const BRAKING_SHARE: f64 = 0.7;
/// Part of it that is for getting faster, which comes while the robot still turns out of a curve.
const SPEEDING_SHARE: f64 = 0.4;
/// Part of it that is for turning into a curve, which comes while the robot still brakes.
const TURNING_SHARE: f64 = 0.35;

/// What the robot on a course can do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CourseLimits {
    /// Speed on straight pieces, metres per second, > 0.
    pub cruise_mps: f64,
    /// No wheel turns faster, metres per second, > 0.
    pub wheel_speed_max_mps: f64,
    /// What the wheels can do, metres per second squared, > 0.
    pub acceleration_mps2: f64,
    /// Between the wheels (b), metres, > 0.
    pub wheelbase_m: f64,
    /// From what is sensed to what the wheels do about it, seconds, ≥ 0: control period, age of a report, way
    /// of a command.
    pub lag_s: f64,
}

/// A corner that is turned on the spot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Corner {
    /// Where, along the path, metres.
    pub along_m: f64,
    /// By how much the direction changes, radians, left positive, in [−π, π).
    pub turn_rad: f64,
}

/// A piece of a path without corners, driven in one go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leg {
    /// Where it begins, along the path, metres.
    pub from_m: f64,
    /// Where it ends, metres.
    pub to_m: f64,
}

/// A path with what its driver must know beforehand.
#[derive(Clone, Debug, PartialEq)]
pub struct Course {
    path: Path,
    corners: Vec<Corner>,
    sample_m: f64,
    /// Signed curvature at each sample, 1/m; without the corners.
    curvatures_per_m: Vec<f64>,
    speeds_mps: Vec<f64>,
}

impl Course {
    /// Looks the path over once: O(length), bounded by 20 000 samples. Later questions allocate nothing.
    pub fn new(path: Path, limits: &CourseLimits) -> Self {
        let turns = turns(&path);
        let (corners, gentle) = split(&turns);
        let length_m = path.length_m();
        let n_samples = (length_m / SAMPLE_M).ceil().clamp(1.0, N_SAMPLES_MAX);
        let sample_m = length_m / n_samples;
        let curvatures_per_m = curvatures(&gentle, sample_m, n_samples as usize);
        let mut speeds_mps: Vec<f64> =
            curvatures_per_m.iter().map(|k| limits.speed_on_curve_mps(k.abs())).collect();
        for corner in &corners {
            let at = (corner.along_m / sample_m).round() as usize;
            if let Some(speed) = speeds_mps.get_mut(at) {
                *speed = 0.0;
            }
        }
        // v² ≤ v′² + 2 a Δs: first backwards, so that it can brake in time, then forwards.
        let a_mps2 = limits.acceleration_mps2;
        let reach = |from_mps: f64, share: f64| {
            (from_mps * from_mps + 2.0 * share * a_mps2 * sample_m).sqrt()
        };
        for i in (1..speeds_mps.len()).rev() {
            speeds_mps[i - 1] = speeds_mps[i - 1].min(reach(speeds_mps[i], BRAKING_SHARE));
        }
        for i in 1..speeds_mps.len() {
            speeds_mps[i] = speeds_mps[i].min(reach(speeds_mps[i - 1], SPEEDING_SHARE));
        }
        Self { path, corners, sample_m, curvatures_per_m, speeds_mps }
    }

    /// The path.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The corners that are turned on the spot, in order.
    pub fn corners(&self) -> &[Corner] {
        &self.corners
    }

    /// How many legs it has: one more than corners.
    pub fn n_legs(&self) -> usize {
        self.corners.len() + 1
    }

    /// The leg of that index; the last one for greater indices.
    pub fn leg(&self, index: usize) -> Leg {
        let index = index.min(self.corners.len());
        let from_m = index.checked_sub(1).map_or(0.0, |before| self.corners[before].along_m);
        let to_m = self.corners.get(index).map_or(self.path.length_m(), |c| c.along_m);
        Leg { from_m, to_m }
    }

    /// The leg that a place belongs to; at a corner the later one. O(log corners).
    pub fn leg_at(&self, along_m: f64) -> usize {
        self.corners.partition_point(|corner| corner.along_m <= along_m)
    }

    /// The greatest speed at a place, metres per second; zero only beside a corner. O(1).
    pub fn speed_at_mps(&self, along_m: f64) -> f64 {
        let (below, above) = self.around(along_m);
        self.speeds_mps[below].min(self.speeds_mps[above])
    }

    /// The least of the greatest speeds from one place to another: what may be driven now if nothing can be
    /// changed before the second one. O(samples between).
    pub fn speed_until_mps(&self, from_m: f64, to_m: f64) -> f64 {
        let (first, last) = (self.around(from_m).0, self.around(to_m.max(from_m)).1);
        self.speeds_mps[first..=last].iter().copied().fold(f64::INFINITY, f64::min)
    }

    /// Mean curvature around a place, 1/m, left positive; without the corners. O(1).
    pub fn curvature_at_per_m(&self, along_m: f64) -> f64 {
        let (below, above) = self.around(along_m);
        0.5 * (self.curvatures_per_m[below] + self.curvatures_per_m[above])
    }

    /// The samples on both sides of a place.
    fn around(&self, along_m: f64) -> (usize, usize) {
        let last = self.speeds_mps.len() - 1;
        let position = (along_m / self.sample_m).clamp(0.0, last as f64);
        (position.floor() as usize, position.ceil() as usize)
    }
}

impl CourseLimits {
    /// The fastest on a curve of that curvature (≥ 0, 1/m), metres per second.
    fn speed_on_curve_mps(&self, curvature_per_m: f64) -> f64 {
        let cruise_mps = self.cruise_mps.min(self.wheel_speed_max_mps);
        let straight_mps =
            if self.lag_s > 0.0 { cruise_mps.min(LAG_WAY_M / self.lag_s) } else { cruise_mps };
        if curvature_per_m <= 1e-9 {
            return straight_mps;
        }
        // The outer wheel: v (1 + κ b / 2) ≤ v_max.
        let outer = 1.0 + 0.5 * curvature_per_m * self.wheelbase_m;
        let by_wheels_mps = self.wheel_speed_max_mps / outer;
        // The turn rate must grow by κ v within the curvature's way: v² κ / w ≤ α = 2 a / b.
        let alpha_radps2 = TURNING_SHARE * 2.0 * self.acceleration_mps2 / self.wheelbase_m;
        let by_acceleration_mps = (alpha_radps2 * CURVATURE_WAY_M / curvature_per_m).sqrt();
        // Straight on for the lag T it leaves the curve by κ (v T)² / 2.
        let by_lag_mps = if self.lag_s > 0.0 {
            (2.0 * LATE_TURN_M / curvature_per_m).sqrt() / self.lag_s
        } else {
            f64::INFINITY
        };
        straight_mps.min(by_wheels_mps).min(by_acceleration_mps).min(by_lag_mps)
    }
}

/// Where the direction changes, and by how much (rad): at joints, and along arcs in small parts.
fn turns(path: &Path) -> Vec<Corner> {
    let mut turns = Vec::new();
    let mut along_m = 0.0;
    let mut before: Option<f64> = None;
    for piece in path.pieces() {
        let begins_rad = piece.pose_at(0.0).yaw_rad;
        let turn_rad = before.map_or(0.0, |ended_rad| wrap_to_pi(begins_rad - ended_rad));
        if turn_rad.abs() > 1e-9 {
            turns.push(Corner { along_m, turn_rad });
        }
        let length_m = piece.length_m();
        if let Piece::Arc(arc) = piece {
            let n_parts = (length_m / ARC_TURNS_EVERY_M).ceil().clamp(1.0, 4000.0);
            let turn_rad = arc.sweep_rad / n_parts;
            let middle = |k: u32| along_m + length_m * (f64::from(k) + 0.5) / n_parts;
            turns.extend((0..n_parts as u32).map(|k| Corner { along_m: middle(k), turn_rad }));
        }
        before = Some(piece.pose_at(length_m).yaw_rad);
        along_m += length_m;
    }
    turns
}

/// Sharp corners and what is left of the turns.
fn split(turns: &[Corner]) -> (Vec<Corner>, Vec<Corner>) {
    let (mut sharp, mut gentle) = (Vec::new(), Vec::new());
    let mut i = 0;
    while i < turns.len() {
        // As many turns as make the corner sharper, within the way of one corner.
        let begins_m = turns[i].along_m;
        let (mut sum_rad, mut n_taken) = (turns[i].turn_rad, 1);
        for turn in turns[i + 1..].iter().take_while(|t| t.along_m - begins_m <= CORNER_WAY_M) {
            if (sum_rad + turn.turn_rad).abs() < sum_rad.abs() {
                break;
            }
            sum_rad += turn.turn_rad;
            n_taken += 1;
        }
        if sum_rad.abs() < CORNER_TURN_RAD {
            gentle.push(turns[i]);
            i += 1;
            continue;
        }
        let cluster = &turns[i..i + n_taken];
        let weight_rad: f64 = cluster.iter().map(|t| t.turn_rad.abs()).sum();
        let along_m =
            cluster.iter().map(|t| t.along_m * t.turn_rad.abs()).sum::<f64>() / weight_rad;
        sharp.push(Corner { along_m, turn_rad: wrap_to_pi(sum_rad) });
        i += n_taken;
    }
    (sharp, gentle)
}

/// Mean curvature around each of the samples 0..=n: the turning within the window over its length.
fn curvatures(turns: &[Corner], sample_m: f64, n_samples: usize) -> Vec<f64> {
    let (mut first, mut beyond, mut sum_rad) = (0, 0, 0.0);
    let half_m = 0.5 * CURVATURE_WAY_M;
    (0..=n_samples)
        .map(|k| {
            let at_m = sample_m * k as f64;
            while beyond < turns.len() && turns[beyond].along_m <= at_m + half_m {
                sum_rad += turns[beyond].turn_rad;
                beyond += 1;
            }
            while first < beyond && turns[first].along_m < at_m - half_m {
                sum_rad -= turns[first].turn_rad;
                first += 1;
            }
            if first == beyond {
                // No rounding is left over from what has gone.
                sum_rad = 0.0;
            }
            sum_rad / CURVATURE_WAY_M
        })
        .collect()
}

#[cfg(test)]
#[path = "course_tests.rs"]
mod tests;
