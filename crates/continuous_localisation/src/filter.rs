//! What is believed: the robot's pose, odometry's systematic error, and where the walls are, with all
//! that these have to do with each other.
//!
//! An extended Kalman filter over the pose (x, y, yaw), the yaw that odometry misses per metre, and
//! direction and offset of each wall about a point near it. The joint covariance is what makes a
//! straight wall useful: that all its echoes touch one line says how the robot turned on the way,
//! before the wall was ever seen twice; and coming back to a wall corrects what was learnt of the
//! walls since.
//!
//! Cost: O(n) for a step of odometry and O(n²) for an echo, with n = 4 + 2 walls.
//!
//! Source: Smith, Self, Cheeseman (1990), "Estimating uncertain spatial relationships in robotics",
//! for the joint filter; Leonard, Durrant-Whyte (1992), "Directed sonar sensing for mobile robot
//! navigation", for predicting a sonar's range from a wall as its perpendicular distance.

use geometry::{Se2, Twist, Vec2, wrap_to_pi};
use nalgebra::{DMatrix, DVector, Matrix3, Vector3, Vector4};

use crate::{
    config::{OdometryTrust, Squareness, WallTrust},
    walls::{Piece, Wall, tangent_of},
};

/// Unknowns before the walls: x, y, yaw, missed yaw per metre, direction of the building.
const N_ROBOT: usize = 5;
/// Index of the building's direction.
const BUILDING: usize = 4;
/// Standard deviation of the building's direction before any wall is known: anything, radians.
const BUILDING_STD_RAD: f64 = 3.0;
/// Deviations of a new wall before its first echo: direction (rad) and offset (m). Large against
/// everything that an echo says.
const NEW_DIRECTION_STD_RAD: f64 = 0.3;
const NEW_OFFSET_STD_M: f64 = 0.3;
/// An echo farther than so many deviations from what is predicted is of something else.
const GATE_SIGMAS: f64 = 3.0;
/// Chi-square of two degrees of freedom for a piece to be one of a known wall, 99.7 %.
const PIECE_CHI2_MAX: f64 = 11.8;
/// Chi-square of three degrees of freedom for a pose from the grids, 99.9 %.
const POSE_CHI2_MAX: f64 = 16.3;

/// Pose, missed yaw and walls with their joint covariance.
#[derive(Clone, Debug)]
pub(crate) struct Filter {
    pub map_from_base: Se2,
    pub missed_yaw_radpm: f64,
    /// Direction to which most walls are parallel or square, radians.
    building_rad: f64,
    pub walls: Vec<Wall>,
    covariance: DMatrix<f64>,
    /// Scratch: covariance times the row of an observation.
    gain: DVector<f64>,
}

/// What an echo had to do with a wall.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sighting {
    pub wall: usize,
    pub residual_m: f64,
}

impl Filter {
    pub(crate) fn new(map_from_base: Se2, variances: Vector4<f64>) -> Self {
        let building_var = BUILDING_STD_RAD * BUILDING_STD_RAD;
        let variances =
            DVector::from_iterator(N_ROBOT, variances.iter().copied().chain([building_var]));
        Self {
            map_from_base,
            missed_yaw_radpm: 0.0,
            building_rad: 0.0,
            walls: Vec::new(),
            covariance: DMatrix::from_diagonal(&variances),
            gain: DVector::zeros(N_ROBOT),
        }
    }

    pub(crate) fn pose_covariance(&self) -> Matrix3<f64> {
        self.covariance.fixed_view::<3, 3>(0, 0).into_owned()
    }

    pub(crate) fn set_robot_variances(&mut self, map_from_base: Se2, variances: Vector4<f64>) {
        self.map_from_base = map_from_base;
        for i in 0..variances.len() {
            self.covariance.row_mut(i).fill(0.0);
            self.covariance.column_mut(i).fill(0.0);
            self.covariance[(i, i)] = variances[i];
        }
    }

    /// What odometry is believed to miss per metre, and to which standard deviation; radians.
    pub(crate) fn missed_yaw(&self) -> (f64, f64) {
        (self.missed_yaw_radpm, self.covariance[(3, 3)].max(0.0).sqrt())
    }

    pub(crate) fn set_missed_yaw(&mut self, missed_yaw_radpm: f64, std_radpm: f64) {
        self.missed_yaw_radpm = missed_yaw_radpm;
        self.covariance[(3, 3)] = std_radpm * std_radpm;
    }

    /// Takes over walls that are known to these standard deviations.
    pub(crate) fn add_known_wall(&mut self, wall: Wall, direction_std_rad: f64, offset_std_m: f64) {
        let n = self.covariance.nrows();
        self.covariance.resize_mut(n + 2, n + 2, 0.0);
        self.covariance[(n, n)] = direction_std_rad.powi(2);
        self.covariance[(n + 1, n + 1)] = offset_std_m.powi(2);
        self.gain.resize_vertically_mut(n + 2, 0.0);
        self.walls.push(wall);
    }

    /// Follows `ratio` of a step of odometry.
    pub(crate) fn predict(&mut self, twist: Twist, ratio: f64, trust: &OdometryTrust) {
        let way_m = twist.dx_m * ratio;
        let dyaw_rad = twist.dyaw_rad * ratio + self.missed_yaw_radpm * way_m;
        let motion = Se2::exp(Twist { dx_m: way_m, dy_m: twist.dy_m * ratio, dyaw_rad });
        let from = self.map_from_base;
        self.map_from_base = from.compose(motion);
        let arm = self.map_from_base.position() - from.position();
        // Yaw turns the whole step; missed yaw turns half of it.
        let bent = arm * (0.5 * way_m);
        let n = self.covariance.nrows();
        let p = &mut self.covariance;
        for k in 0..n {
            let (yaw, missed) = (p[(2, k)], p[(3, k)]);
            p[(0, k)] += -arm.y * yaw - bent.y * missed;
            p[(1, k)] += arm.x * yaw + bent.x * missed;
            p[(2, k)] += way_m * missed;
        }
        for k in 0..n {
            let (yaw, missed) = (p[(k, 2)], p[(k, 3)]);
            p[(k, 0)] += -arm.y * yaw - bent.y * missed;
            p[(k, 1)] += arm.x * yaw + bent.x * missed;
            p[(k, 2)] += way_m * missed;
        }
        let way_m = arm.norm();
        p[(2, 2)] += trust.heading_std_rad.powi(2) * way_m
            + trust.turn_std_rad.powi(2) * (twist.dyaw_rad * ratio).abs();
        p[(3, 3)] += trust.drift_walk_std_radpm.powi(2) * way_m;
        let along = from.heading();
        let var = trust.position_std_m.powi(2) * way_m;
        p[(0, 0)] += var * along.x * along.x;
        p[(0, 1)] += var * along.x * along.y;
        p[(1, 0)] += var * along.x * along.y;
        p[(1, 1)] += var * along.y * along.y;
    }

    /// The known wall that a piece continues, if any: near and parallel to it within what is
    /// uncertain, and not too far along it.
    pub(crate) fn wall_of(&self, piece: &Piece, trust: &WallTrust) -> Option<usize> {
        let middle = (piece.ends[0] + piece.ends[1]) * 0.5;
        let length_m = (piece.ends[1] - piece.ends[0]).norm().max(0.1);
        let n_arcs = piece.arcs.len() as f64;
        // Of a line through n feet within a length: offset at its middle, and direction.
        let piece_offset_var = trust.range_std_m.powi(2) / n_arcs;
        let piece_direction_var = 12.0 * piece_offset_var / length_m.powi(2);
        let fits = (0..).zip(&self.walls).filter_map(|(i, wall)| {
            let turned = wrap_to_pi(piece.normal.y.atan2(piece.normal.x) - wall.normal_rad);
            let apart_m = wall.distance_m(middle);
            if turned.abs() > trust.direction_gate_rad
                || apart_m.abs() > trust.gate_m
                || wall.gap_m(piece) > trust.goes_on_m
            {
                return None;
            }
            // The piece hangs on the robot: both residuals depend on pose and wall.
            let lever = wall.along_m(middle);
            let arm = middle - self.map_from_base.position();
            let normal = wall.normal();
            let n = self.covariance.nrows();
            let mut offset_row = DVector::zeros(n);
            let mut direction_row = DVector::zeros(n);
            offset_row[0] = -normal.x;
            offset_row[1] = -normal.y;
            offset_row[2] = -normal.dot(&tangent_of(arm));
            let w = N_ROBOT + 2 * i;
            offset_row[w] = -lever;
            offset_row[w + 1] = 1.0;
            direction_row[2] = 1.0;
            direction_row[w] = -1.0;
            let p = &self.covariance;
            let oo = offset_row.dot(&(p * &offset_row)) + piece_offset_var;
            let dd = direction_row.dot(&(p * &direction_row)) + piece_direction_var;
            let od = offset_row.dot(&(p * &direction_row));
            let determinant = oo * dd - od * od;
            let chi2 = (dd * apart_m * apart_m - 2.0 * od * apart_m * turned
                + oo * turned * turned)
                / determinant.max(1e-18);
            (chi2 <= PIECE_CHI2_MAX).then_some((i, chi2))
        });
        fits.min_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0))).map(|(i, _)| i)
    }

    /// A wall of which only the arcs of a piece are known so far. Returns its index; `None` when
    /// there are so many walls already.
    pub(crate) fn add_wall(&mut self, piece: &Piece, n_walls_max: usize) -> Option<usize> {
        if self.walls.len() >= n_walls_max {
            return None;
        }
        self.add_known_wall(Wall::of(piece), NEW_DIRECTION_STD_RAD, NEW_OFFSET_STD_M);
        Some(self.walls.len() - 1)
    }

    /// The wall that an echo outside all pieces most likely is of, if any: the best fit among those
    /// seen there, and only a close one.
    pub(crate) fn sighted(
        &self,
        sensor: Se2,
        range_m: f64,
        trust: &WallTrust,
        half_angle_rad: f64,
    ) -> Option<usize> {
        if range_m > trust.range_max_m {
            return None;
        }
        let cos_half = half_angle_rad.cos();
        let found = (0..).zip(&self.walls).filter_map(|(i, wall)| {
            let point = sensor.position();
            let predicted_m = wall.distance_m(point);
            let off_m = (range_m - predicted_m).abs();
            let is_in_cone = wall.normal().dot(&sensor.heading()) >= cos_half;
            let is_close = predicted_m > 0.0 && off_m <= trust.lone_gate_m;
            let fits = is_close && is_in_cone && wall.is_seen_at(point);
            fits.then_some((i, off_m))
        });
        found.min_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0))).map(|(i, _)| i)
    }

    /// Learns from an echo of a wall: its range is the perpendicular distance. `None` when the echo
    /// lies too far from what is predicted; then nothing changes.
    pub(crate) fn observe_wall(
        &mut self,
        wall: usize,
        base_from_sensor: Se2,
        range_m: f64,
        trust: &WallTrust,
    ) -> Option<Sighting> {
        let pose = self.map_from_base;
        let sensor = pose.compose(base_from_sensor).position();
        let seen = &self.walls[wall];
        let (normal, along_m) = (seen.normal(), seen.along_m(sensor));
        let residual_m = range_m - seen.distance_m(sensor);
        let arm = sensor - pose.position();
        let robot = [-normal.x, -normal.y, -normal.dot(&tangent_of(arm))];
        let var = trust.range_std_m.powi(2) + (trust.range_std_ratio * range_m).powi(2);

        let w = N_ROBOT + 2 * wall;
        let n = self.covariance.nrows();
        let p = &self.covariance;
        for k in 0..n {
            self.gain[k] = robot[0] * p[(k, 0)]
                + robot[1] * p[(k, 1)]
                + robot[2] * p[(k, 2)]
                + -along_m * p[(k, w)]
                + p[(k, w + 1)];
        }
        let g = &self.gain;
        let s =
            robot[0] * g[0] + robot[1] * g[1] + robot[2] * g[2] - along_m * g[w] + g[w + 1] + var;
        if residual_m * residual_m > GATE_SIGMAS.powi(2) * s {
            return None;
        }
        self.apply_scalar(residual_m, s);
        self.walls[wall].take(sensor);
        Some(Sighting { wall, residual_m })
    }

    /// Learns that walls of a building are parallel or square, from every wall that is long enough
    /// and was not asked before. A wall that is neither within what is uncertain is left alone.
    pub(crate) fn square_up(&mut self, squareness: &Squareness) {
        for i in 0..self.walls.len() {
            let wall = &self.walls[i];
            let is_long = wall.to_m - wall.from_m >= squareness.length_min_m;
            if wall.is_squared || !is_long {
                continue;
            }
            self.walls[i].is_squared = true;
            let w = N_ROBOT + 2 * i;
            let off_rad = self.walls[i].normal_rad - self.building_rad;
            let quarter = std::f64::consts::FRAC_PI_2;
            let off_rad = off_rad - (off_rad / quarter).round() * quarter;
            for k in 0..self.covariance.nrows() {
                self.gain[k] = self.covariance[(k, w)] - self.covariance[(k, BUILDING)];
            }
            let s = self.gain[w] - self.gain[BUILDING] + squareness.std_rad.powi(2);
            // The first wall gives the building its direction.
            let is_first = s > 1.0;
            let fits = off_rad.abs() <= squareness.gate_rad
                && off_rad * off_rad <= GATE_SIGMAS.powi(2) * s;
            if is_first || fits {
                self.apply_scalar(-off_rad, s);
            }
        }
    }

    /// Adds gain · residual / s to everything and takes gain · gainᵀ / s from the covariance.
    fn apply_scalar(&mut self, residual: f64, s: f64) {
        let n = self.covariance.nrows();
        for column in 0..n {
            let factor = self.gain[column] / s;
            for row in 0..n {
                self.covariance[(row, column)] -= self.gain[row] * factor;
            }
        }
        let correction = &self.gain * (residual / s);
        self.shift(&correction);
    }

    /// Learns a pose that the grids measured, with its covariance. False when it lies too far from
    /// what is believed; then nothing changes.
    pub(crate) fn observe_pose(&mut self, measured: Se2, covariance: &Matrix3<f64>) -> bool {
        let pose = self.map_from_base;
        let residual = Vector3::new(
            measured.x_m - pose.x_m,
            measured.y_m - pose.y_m,
            wrap_to_pi(measured.yaw_rad - pose.yaw_rad),
        );
        let s = self.pose_covariance() + covariance;
        let Some(inverse) = s.try_inverse() else { return false };
        if residual.dot(&(inverse * residual)) > POSE_CHI2_MAX {
            return false;
        }
        let columns = self.covariance.columns(0, 3).into_owned();
        let gain = &columns * inverse;
        self.covariance -= &gain * columns.transpose();
        let correction = gain * residual;
        self.shift(&correction);
        true
    }

    fn shift(&mut self, by: &DVector<f64>) {
        let pose = self.map_from_base;
        self.map_from_base = Se2::new(pose.x_m + by[0], pose.y_m + by[1], pose.yaw_rad + by[2]);
        self.missed_yaw_radpm += by[3];
        self.building_rad += by[BUILDING];
        for (i, wall) in self.walls.iter_mut().enumerate() {
            wall.normal_rad = wrap_to_pi(wall.normal_rad + by[N_ROBOT + 2 * i]);
            wall.offset_m += by[N_ROBOT + 2 * i + 1];
        }
    }
}

/// Direction of `normal` from the axis of `sensor`, radians.
pub(crate) fn bearing_rad(sensor: Se2, normal: Vec2) -> f64 {
    wrap_to_pi(normal.y.atan2(normal.x) - sensor.yaw_rad)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TINY: f64 = 1e-8;

    fn filter(yaw_var: f64, missed_var: f64) -> Filter {
        Filter::new(Se2::IDENTITY, Vector4::new(TINY, TINY, yaw_var, missed_var))
    }

    fn still() -> OdometryTrust {
        OdometryTrust {
            heading_std_rad: 0.0,
            position_std_m: 0.0,
            turn_std_rad: 0.0,
            drift_std_radpm: 0.0,
            drift_walk_std_radpm: 0.0,
        }
    }

    fn piece(normal: Vec2, ends: [Vec2; 2]) -> Piece {
        Piece { normal, arcs: 0..10, ends }
    }

    /// Oracle: differences of two ways with slightly other yaw and missed yaw.
    #[test]
    fn uncertainty_spreads_as_small_errors_do() {
        let twist = Twist { dx_m: 0.05, dy_m: 0.0, dyaw_rad: 0.02 };
        let drive = |yaw_rad: f64, missed: f64| {
            let mut f = filter(TINY, TINY);
            f.map_from_base.yaw_rad = yaw_rad;
            f.missed_yaw_radpm = missed;
            (0..40).for_each(|_| f.predict(twist, 1.0, &still()));
            f.map_from_base
        };
        let here = drive(0.0, 0.0);
        for (yaw_var, missed_var, there) in
            [(1e-4, 0.0, drive(1e-5, 0.0)), (0.0, 1e-4, drive(0.0, 1e-5))]
        {
            let mut f = Filter::new(Se2::IDENTITY, Vector4::new(0.0, 0.0, yaw_var, missed_var));
            (0..40).for_each(|_| f.predict(twist, 1.0, &still()));
            let d = [there.x_m - here.x_m, there.y_m - here.y_m, there.yaw_rad - here.yaw_rad];
            let found = f.pose_covariance();
            for i in 0..3 {
                for k in 0..3 {
                    // 1e-5 of error for 1e-4 of variance: times (1e-2 / 1e-5)².
                    let expected = d[i] * d[k] * 1e6;
                    let slack = 2e-2 * expected.abs() + 1e-8;
                    assert!((found[(i, k)] - expected).abs() < slack, "{found} {d:?}");
                }
            }
        }
    }

    /// A robot drives 6 m along a wall while odometry misses a degree per metre. That one straight wall
    /// answers all the way is enough to learn it.
    #[test]
    fn one_long_wall_tells_what_odometry_misses() {
        for missed_deg in [1.0_f64, -1.0] {
            let mut f = filter(TINY, 1.5_f64.to_radians().powi(2));
            let left = Se2::new(0.07, 0.13, std::f64::consts::FRAC_PI_2);
            let start = piece(Vec2::y(), [Vec2::new(0.07, 1.0), Vec2::new(0.4, 1.0)]);
            let trust = WallTrust { range_std_m: 0.01, ..WallTrust::default() };
            let wall = f.add_wall(&start, 10).unwrap();
            let odometry =
                Twist { dx_m: 0.05, dy_m: 0.0, dyaw_rad: -missed_deg.to_radians() * 0.05 };
            for i in 0..120 {
                f.predict(odometry, 1.0, &still());
                let wiggle = 0.005 * (f64::from(i) * 2.1).sin();
                assert!(f.observe_wall(wall, left, 0.87 + wiggle, &trust).is_some(), "{i}");
            }
            let found_deg = f.missed_yaw_radpm.to_degrees();
            assert!((found_deg - missed_deg).abs() < 0.1, "{found_deg}");
            assert!(f.map_from_base.y_m.abs() < 0.03 && f.map_from_base.yaw_rad.abs() < 0.01);
            // Along the wall nothing was learnt, and that is known.
            assert!((f.map_from_base.x_m - 6.0).abs() < 0.05);
        }
    }

    #[test]
    fn an_echo_of_something_else_changes_nothing() {
        let mut f = filter(1e-4, TINY);
        let start = piece(Vec2::y(), [Vec2::new(0.0, 1.0), Vec2::new(0.4, 1.0)]);
        let wall = f.add_wall(&start, 10).unwrap();
        let left = Se2::new(0.0, 0.0, std::f64::consts::FRAC_PI_2);
        let trust = WallTrust::default();
        for _ in 0..5 {
            assert!(f.observe_wall(wall, left, 1.0, &trust).is_some());
        }
        let (pose, walls) = (f.map_from_base, f.walls.clone());
        assert!(f.observe_wall(wall, left, 1.3, &trust).is_none());
        assert_eq!((f.map_from_base, &f.walls), (pose, &walls));
        // Nor is it attributed to the wall in the first place: not in the cone, or not as far.
        assert_eq!(f.sighted(left, 1.0, &trust, 0.26), Some(wall));
        assert_eq!(f.sighted(left, 1.4, &trust, 0.26), None);
        // A door is deeper than its wall by more than the gate, an edge beside it nearer by more.
        for (range_m, found) in [(1.03, Some(wall)), (0.97, Some(wall)), (1.12, None), (0.9, None)]
        {
            assert_eq!(f.sighted(left, range_m, &trust, 0.26), found, "{range_m}");
        }
        let ahead = Se2::new(0.0, 0.0, 1.0);
        assert_eq!(f.sighted(ahead, 1.0, &trust, 0.26), None);
        assert_eq!(f.sighted(Se2::new(0.5, 0.0, left.yaw_rad), 1.0, &trust, 0.26), None, "beyond");
    }

    #[test]
    fn a_piece_continues_a_wall_near_and_parallel_to_it() {
        let mut f = filter(1e-6, TINY);
        let mut known = Wall::of(&piece(Vec2::y(), [Vec2::new(0.0, 1.0), Vec2::new(1.0, 1.0)]));
        known.take(Vec2::new(0.0, 0.0));
        known.take(Vec2::new(1.0, 0.0));
        f.add_known_wall(known, 0.01, 0.01);
        let trust = WallTrust::default();
        let at = |x: f64, y: f64, turn: f64| {
            let ends = [Vec2::new(x, y), Vec2::new(x + 0.5, y)];
            f.wall_of(&piece(Se2::new(0.0, 0.0, turn).rotate(Vec2::y()), ends), &trust)
        };
        assert_eq!(at(1.2, 1.01, 0.0), Some(0));
        assert_eq!(at(0.3, 0.99, 0.02), Some(0));
        assert_eq!(at(1.2, 1.25, 0.0), None, "beside it");
        assert_eq!(at(0.3, 1.0, 0.24), None, "another direction");
        assert_eq!(at(1.0 + trust.goes_on_m + 0.1, 1.0, 0.0), None, "too far on");
        assert_eq!(at(0.3, 1.0, std::f64::consts::PI), None, "the other side");
    }

    /// Two walls of a room; the second was measured with a heading that is 3° wrong.
    #[test]
    fn a_square_wall_corrects_the_heading_and_one_at_sixty_degrees_does_not() {
        let squareness = Squareness { std_rad: 0.005, ..Squareness::default() };
        let second = |normal_deg: f64| {
            let mut f = filter(TINY, TINY);
            let trust = WallTrust { range_std_m: 0.003, ..WallTrust::default() };
            let see = |f: &mut Filter, normal: Vec2, yaw_rad: f64| {
                let ends = [Vec2::zeros(), Vec2::zeros()].map(|_| normal);
                let wall = f.add_wall(&piece(normal, ends), 10).unwrap();
                for i in 0..30 {
                    // Sensors spread along the wall, looking at it squarely.
                    let along = tangent_of(Se2::new(0.0, 0.0, yaw_rad).heading());
                    let p = along * (0.03 * f64::from(i));
                    let sensor = Se2::new(p.x, p.y, yaw_rad);
                    f.observe_wall(wall, sensor, 1.0, &trust);
                }
            };
            see(&mut f, Vec2::x(), 0.0);
            f.square_up(&squareness);
            // The heading becomes uncertain, and is 3° off.
            f.covariance[(2, 2)] += 0.05_f64.powi(2);
            let wrong = normal_deg.to_radians() + 0.05;
            see(&mut f, Vec2::new(wrong.cos(), wrong.sin()), wrong);
            f.square_up(&squareness);
            f.map_from_base.yaw_rad
        };
        let corrected = second(90.0);
        assert!((corrected + 0.05).abs() < 0.015, "{corrected}");
        assert!(second(60.0).abs() < 1e-3, "walls at other angles say nothing");
    }

    #[test]
    fn a_pose_is_weighed_by_what_is_known_and_refused_when_it_is_absurd() {
        let mut f = Filter::new(Se2::IDENTITY, Vector4::new(0.01, 0.01, 0.01, TINY));
        let covariance = Matrix3::identity() * 0.01;
        assert!(f.observe_pose(Se2::new(0.1, -0.1, 0.04), &covariance));
        let p = f.map_from_base;
        assert!((p.x_m - 0.05).abs() < 1e-12 && (p.y_m + 0.05).abs() < 1e-12);
        assert!((p.yaw_rad - 0.02).abs() < 1e-12);
        assert!(!f.observe_pose(Se2::new(9.0, 0.0, 0.0), &covariance));
        assert_eq!(f.map_from_base, p);
    }
}
