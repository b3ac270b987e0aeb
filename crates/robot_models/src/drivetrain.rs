//! The drive as it is, not as it should be: true travel, encoder counts, injected errors.
//!
//! A motor controller holds the speed that its encoder counts, so a *wheel speed* here is what the
//! robot believes: rotation times nominal radius. What the body does with it follows from the
//! true diameters, the true wheelbase, a misaligned axle, slip and bumps. Dead reckoning that
//! counts the encoders therefore drifts from the truth, as a real one does.
//!
//! Source: the thesis, section 3.2, lists these errors; the models are ours, the simplest that
//! have each error's signature (which grows with the way, which with its root, which with turning).

use std::time::Duration;

use geometry::Twist;
use rand_core::Rng;
use rand_distr::{Distribution, StandardNormal};
use run_context::RandomStream;

use crate::drive::{DriveGeometry, WheelSpeeds, WheelTravel};

/// How one robot's drive differs from its data sheet. The default differs in nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OdometryErrors {
    /// True over nominal diameter of the left wheel, from 0.5 to 2.
    pub left_diameter_ratio: f64,
    /// True over nominal diameter of the right wheel, from 0.5 to 2.
    pub right_diameter_ratio: f64,
    /// True (effective) over nominal wheelbase, from 0.5 to 2.
    pub wheelbase_ratio: f64,
    /// Direction in which the wheels roll, seen from the body's x axis, counter-clockwise,
    /// radians, from −0.5 to 0.5.
    pub misalignment_rad: f64,
    /// Encoder pulses that the electronics count as one step, at least 1: a coarser encoder.
    pub encoder_coarsening_ticks: u32,
    /// Time between two readings of the encoders; zero for every step.
    pub encoder_period: Duration,
    /// Random slip: standard deviation of a wheel's way over the ground after rolling 1 m, as a
    /// ratio of that metre; grows with the root of the way. From 0 to 1.
    pub slip_std_ratio: f64,
    /// Bumps per second while the robot moves (Poisson), from 0 to 100 Hz.
    pub bump_rate_hz: f64,
    /// Standard deviation of the way that a bump adds to or takes from one of the wheels, chosen
    /// by chance, metres, from 0 to 0.1.
    pub bump_std_m: f64,
}

/// An error parameter outside its range.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{key} = {value}: must be from {min} to {max}")]
pub struct ErrorRange {
    /// The field of [`OdometryErrors`].
    pub key: &'static str,
    /// What it is.
    pub value: f64,
    /// Least allowed.
    pub min: f64,
    /// Greatest allowed.
    pub max: f64,
}

/// Counts the pulses of one wheel: rolling in, whole pulses out, fractions kept.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Encoder {
    metres_per_tick: f64,
    coarsening_ticks: u32,
    /// Way rolled since switching on; unwrapped, signed.
    rolled_m: f64,
}

/// One robot's drive with its errors, its encoders and the slip of the moment.
#[derive(Clone, Debug)]
pub struct Drivetrain {
    nominal: DriveGeometry,
    errors: OdometryErrors,
    encoders: [Encoder; 2],
    latched_ticks: [i64; 2],
    since_latch: Duration,
}

impl Default for OdometryErrors {
    fn default() -> Self {
        Self {
            left_diameter_ratio: 1.0,
            right_diameter_ratio: 1.0,
            wheelbase_ratio: 1.0,
            misalignment_rad: 0.0,
            encoder_coarsening_ticks: 1,
            encoder_period: Duration::ZERO,
            slip_std_ratio: 0.0,
            bump_rate_hz: 0.0,
            bump_std_m: 0.0,
        }
    }
}

impl OdometryErrors {
    /// Wheels whose diameters differ by `difference_ratio` (0.01 = 1 %), the right one larger
    /// when positive; their mean is nominal.
    pub fn unequal_diameters(difference_ratio: f64) -> Self {
        Self {
            left_diameter_ratio: 1.0 - 0.5 * difference_ratio,
            right_diameter_ratio: 1.0 + 0.5 * difference_ratio,
            ..Self::default()
        }
    }

    /// Refuses parameters outside the ranges that the fields state.
    ///
    /// # Errors
    ///
    /// [`ErrorRange`] for the first field outside its range; NaN is outside every range.
    pub fn checked(self) -> Result<Self, ErrorRange> {
        let ranges = [
            ("left_diameter_ratio", self.left_diameter_ratio, 0.5, 2.0),
            ("right_diameter_ratio", self.right_diameter_ratio, 0.5, 2.0),
            ("wheelbase_ratio", self.wheelbase_ratio, 0.5, 2.0),
            ("misalignment_rad", self.misalignment_rad, -0.5, 0.5),
            ("encoder_coarsening_ticks", f64::from(self.encoder_coarsening_ticks), 1.0, 1e6),
            ("slip_std_ratio", self.slip_std_ratio, 0.0, 1.0),
            ("bump_rate_hz", self.bump_rate_hz, 0.0, 100.0),
            ("bump_std_m", self.bump_std_m, 0.0, 0.1),
        ];
        for (key, value, min, max) in ranges {
            if !(min..=max).contains(&value) {
                return Err(ErrorRange { key, value, min, max });
            }
        }
        Ok(self)
    }

    /// Way of the two wheels over the ground when the encoders see them roll by `rolled` in `dt`.
    ///
    /// Draws from `rng` only what random errors need, so a drive without them draws nothing.
    fn true_travel(
        &self,
        rolled: WheelTravel,
        dt: Duration,
        rng: &mut RandomStream,
    ) -> WheelTravel {
        let mut travel = WheelTravel {
            left_m: rolled.left_m * self.left_diameter_ratio,
            right_m: rolled.right_m * self.right_diameter_ratio,
        };
        if self.slip_std_ratio > 0.0 {
            // A sum of independent parts: variance grows with the way, not with its square.
            let slip = |way_m: f64, rng: &mut RandomStream| {
                self.slip_std_ratio * way_m.abs().sqrt() * gauss(rng)
            };
            travel.left_m += slip(rolled.left_m, rng);
            travel.right_m += slip(rolled.right_m, rng);
        }
        let moves = rolled.left_m != 0.0 || rolled.right_m != 0.0;
        if moves && self.bump_rate_hz > 0.0 {
            let bump_prob = 1.0 - (-self.bump_rate_hz * dt.as_secs_f64()).exp();
            if uniform(rng) < bump_prob {
                let push_m = self.bump_std_m * gauss(rng);
                let wheel =
                    if uniform(rng) < 0.5 { &mut travel.left_m } else { &mut travel.right_m };
                *wheel += push_m;
            }
        }
        travel
    }

    /// The body's motion for wheel ways over the ground.
    fn body_twist(&self, nominal: &DriveGeometry, travel: WheelTravel) -> Twist {
        let truth =
            DriveGeometry { wheelbase_m: nominal.wheelbase_m * self.wheelbase_ratio, ..*nominal };
        let straight = truth.body_twist(travel);
        let (s, c) = self.misalignment_rad.sin_cos();
        Twist { dx_m: c * straight.dx_m, dy_m: s * straight.dx_m, dyaw_rad: straight.dyaw_rad }
    }
}

impl Encoder {
    /// An encoder at rest: `metres_per_tick` of (3.2), and pulses counted in steps of
    /// `coarsening_ticks` (0 counts as 1).
    pub fn new(metres_per_tick: f64, coarsening_ticks: u32) -> Self {
        Self { metres_per_tick, coarsening_ticks: coarsening_ticks.max(1), rolled_m: 0.0 }
    }

    /// Rolls the wheel on by `way_m` (metres, signed).
    pub fn roll(&mut self, way_m: f64) {
        self.rolled_m += way_m;
    }

    /// Whole pulses since switching on, negative backwards; rounds down, so no pulse is counted
    /// twice around zero.
    ///
    /// Source: the thesis, eq. (3.3), solved for the count: `N = ⌊S / c_m⌋`.
    pub fn ticks(&self) -> i64 {
        let step = f64::from(self.coarsening_ticks);
        // Exact below 2^53 pulses: over 280 000 km on a Pioneer.
        (self.rolled_m / (self.metres_per_tick * step)).floor() as i64
            * i64::from(self.coarsening_ticks)
    }
}

impl Drivetrain {
    /// A drive at rest with its counters at zero. `errors` outside their ranges are the caller's
    /// to refuse ([`OdometryErrors::checked`]).
    pub fn new(nominal: DriveGeometry, errors: OdometryErrors) -> Self {
        let encoder = Encoder::new(nominal.metres_per_tick(), errors.encoder_coarsening_ticks);
        Self {
            nominal,
            errors,
            encoders: [encoder; 2],
            latched_ticks: [0; 2],
            since_latch: Duration::ZERO,
        }
    }

    /// The errors it was made with.
    pub fn errors(&self) -> &OdometryErrors {
        &self.errors
    }

    /// How the body would move, in its own frame, if the wheels turned at `wheels` for `dt`.
    ///
    /// Nothing is counted yet: the world may refuse a part of the motion. Then
    /// [`commit`](Self::commit) what was granted.
    pub fn propose(&self, wheels: WheelSpeeds, dt: Duration, rng: &mut RandomStream) -> Twist {
        let rolled = rolled(wheels, dt);
        let travel = self.errors.true_travel(rolled, dt, rng);
        self.errors.body_twist(&self.nominal, travel)
    }

    /// Counts the wheels' rolling at `wheels` during `dt`, of which the world granted
    /// `granted_ratio` (0 to 1).
    pub fn commit(&mut self, wheels: WheelSpeeds, dt: Duration, granted_ratio: f64) {
        let rolled = rolled(wheels, dt);
        self.encoders[0].roll(granted_ratio * rolled.left_m);
        self.encoders[1].roll(granted_ratio * rolled.right_m);
        self.since_latch += dt;
        if self.since_latch >= self.errors.encoder_period {
            self.since_latch = Duration::ZERO;
            self.latched_ticks = [self.encoders[0].ticks(), self.encoders[1].ticks()];
        }
    }

    /// Left and right pulses since switching on, as last read.
    pub fn ticks(&self) -> [i64; 2] {
        self.latched_ticks
    }
}

fn rolled(wheels: WheelSpeeds, dt: Duration) -> WheelTravel {
    let dt_s = dt.as_secs_f64();
    WheelTravel { left_m: wheels.left_mps * dt_s, right_m: wheels.right_mps * dt_s }
}

fn gauss(rng: &mut RandomStream) -> f64 {
    StandardNormal.sample(rng)
}

/// Uniform in [0, 1), 53 bits.
fn uniform(rng: &mut RandomStream) -> f64 {
    (rng.next_u64() >> 11) as f64 * (1.0 / (1_u64 << 53) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Odometry;
    use geometry::Se2;
    use run_context::RunSeed;

    const STEP: Duration = Duration::from_millis(10);

    fn drive(wheelbase_m: f64) -> DriveGeometry {
        DriveGeometry {
            wheelbase_m,
            wheel_diameter_m: 0.1953,
            encoder_ticks_per_turn: 500.0,
            gear_ratio: 38.3,
        }
    }

    /// Drives `wheels` for `steps` steps; true pose, believed pose, pulses.
    fn run(
        wheelbase_m: f64,
        errors: OdometryErrors,
        wheels: WheelSpeeds,
        steps: u32,
    ) -> (Se2, Se2, [i64; 2]) {
        run_seeded(wheelbase_m, errors, wheels, steps, 1)
    }

    fn run_seeded(
        wheelbase_m: f64,
        errors: OdometryErrors,
        wheels: WheelSpeeds,
        steps: u32,
        seed: u64,
    ) -> (Se2, Se2, [i64; 2]) {
        let mut rng = RunSeed(seed).stream("body");
        let mut train = Drivetrain::new(drive(wheelbase_m), errors);
        let mut odometry = Odometry::new(drive(wheelbase_m));
        let mut truth = Se2::IDENTITY;
        for _ in 0..steps {
            truth = truth.compose(Se2::exp(train.propose(wheels, STEP, &mut rng)));
            train.commit(wheels, STEP, 1.0);
            let [left, right] = train.ticks();
            odometry.update(left, right);
        }
        (truth, odometry.odom_from_base().se2(), train.ticks())
    }

    fn both(speed_mps: f64) -> WheelSpeeds {
        WheelSpeeds { left_mps: speed_mps, right_mps: speed_mps }
    }

    /// The thesis, Fig. 3.2: one percent over ten metres, 1200 mm to the side. That holds for a
    /// wheelbase of 415 mm; for the 380 mm of its section 7.4 the arc ends at 1308 mm. Its other
    /// figure, 30 degrees, contradicts both.
    #[test]
    fn one_percent_of_diameter_costs_1200_mm_in_ten_metres() {
        for (wheelbase_m, lateral_m, turn_deg) in [(0.380, 1.308, 15.1), (0.415, 1.199, 13.8)] {
            let errors = OdometryErrors::unequal_diameters(0.01);
            let (truth, believed, _) = run(wheelbase_m, errors, both(0.5), 2000);
            assert!((truth.y_m - lateral_m).abs() < 0.001, "{truth:?}");
            assert!((truth.yaw_rad.to_degrees() - turn_deg).abs() < 0.05, "{truth:?}");
            // It notices nothing: the encoders counted ten straight metres.
            assert!((believed.x_m - 10.0).abs() < 1e-3 && believed.y_m.abs() < 1e-9);

            let (mirrored, ..) =
                run(wheelbase_m, OdometryErrors::unequal_diameters(-0.01), both(0.5), 2000);
            assert!((mirrored.y_m + truth.y_m).abs() < 1e-9, "{mirrored:?}");
        }
    }

    #[test]
    fn a_perfect_drive_is_believed_to_a_pulse() {
        let curve = WheelSpeeds { left_mps: 0.2, right_mps: -0.31 };
        let (truth, believed, _) = run(0.38, OdometryErrors::default(), curve, 3000);
        let gap = truth.inverse().compose(believed);
        // A pulse is 32 µm; over b that is 0.1 mrad.
        assert!(gap.x_m.hypot(gap.y_m) < 1e-4 && gap.yaw_rad.abs() < 2e-4, "{gap:?}");
    }

    #[test]
    fn a_wrong_wheelbase_shows_in_turns_only() {
        let wide = OdometryErrors { wheelbase_ratio: 1.05, ..OdometryErrors::default() };
        let (straight, ..) = run(0.38, wide, both(0.5), 1000);
        assert!((straight.x_m - 5.0).abs() < 1e-9 && straight.yaw_rad.abs() < 1e-12);

        let spin = WheelSpeeds { left_mps: -0.1, right_mps: 0.1 };
        let (truth, believed, _) = run(0.38, wide, spin, 500);
        assert!((believed.yaw_rad / truth.yaw_rad - 1.05).abs() < 1e-3);
    }

    #[test]
    fn a_misaligned_axle_drifts_sideways_without_turning() {
        for misalignment_rad in [0.02, -0.02] {
            let errors = OdometryErrors { misalignment_rad, ..OdometryErrors::default() };
            let (truth, ..) = run(0.38, errors, both(0.5), 1000);
            assert!((truth.y_m - 5.0 * misalignment_rad.sin()).abs() < 1e-9, "{truth:?}");
            assert!(truth.yaw_rad.abs() < 1e-12);
        }
    }

    #[test]
    fn a_coarse_encoder_counts_whole_steps() {
        let errors = OdometryErrors { encoder_coarsening_ticks: 1000, ..OdometryErrors::default() };
        let (.., [left, right]) = run(0.38, errors, both(0.5), 100);
        // 0.5 m is 15 605 pulses.
        assert_eq!([left, right], [15_000, 15_000]);
        let (.., back) = run(0.38, errors, both(-0.5), 100);
        assert_eq!(back, [-16_000, -16_000]);
    }

    #[test]
    fn slow_sampling_holds_the_count() {
        let errors = OdometryErrors {
            encoder_period: Duration::from_millis(100),
            ..OdometryErrors::default()
        };
        let (.., at_99) = run(0.38, errors, both(0.5), 99);
        let (.., at_100) = run(0.38, errors, both(0.5), 100);
        let (.., fresh) = run(0.38, OdometryErrors::default(), both(0.5), 90);
        assert_eq!(at_99, fresh);
        assert_eq!(at_100, [15_605, 15_605]);
    }

    #[test]
    fn what_the_world_refuses_is_not_counted() {
        let mut train = Drivetrain::new(drive(0.38), OdometryErrors::default());
        train.commit(both(0.5), Duration::from_secs(1), 0.25);
        assert_eq!(train.ticks(), [3901, 3901]);
        train.commit(both(0.5), Duration::from_secs(1), 0.0);
        assert_eq!(train.ticks(), [3901, 3901]);
    }

    /// 2000 seeded drives of 1 m in 100 steps: the sample standard deviation of the way is
    /// slip/√2 (two wheels averaged) within 5 σ of its own error, σ = 1/√(2·1999); a false alarm
    /// once in 1.7 million.
    #[test]
    fn slip_grows_with_the_root_of_the_way() {
        let errors = OdometryErrors { slip_std_ratio: 0.02, ..OdometryErrors::default() };
        for (steps, way_m) in [(100, 1.0_f64), (400, 4.0)] {
            let n = 2000_u32;
            let ways: Vec<f64> = (0..n)
                .map(|seed| {
                    // The mean of the wheels' ways, not the chord.
                    let mut rng = RunSeed(seed.into()).stream("body");
                    let train = Drivetrain::new(drive(0.38), errors);
                    (0..steps).map(|_| train.propose(both(1.0), STEP, &mut rng).dx_m).sum()
                })
                .collect();
            let mean = ways.iter().sum::<f64>() / f64::from(n);
            let var = ways.iter().map(|w| (w - mean).powi(2)).sum::<f64>() / f64::from(n - 1);
            let expected = 0.02 * way_m.sqrt() / 2.0_f64.sqrt();
            let bound = 5.0 / (2.0 * f64::from(n - 1)).sqrt();
            assert!((var.sqrt() / expected - 1.0).abs() < bound, "{} {expected}", var.sqrt());
            assert!((mean - way_m).abs() < 5.0 * expected / f64::from(n).sqrt());
        }
    }

    /// 10 000 s at 0.5 bumps per second: a Poisson count of 5000 ± 5·√5000.
    #[test]
    fn bumps_come_at_their_rate_and_only_when_moving() {
        let errors =
            OdometryErrors { bump_rate_hz: 0.5, bump_std_m: 0.01, ..OdometryErrors::default() };
        let count = |speed_mps| {
            let mut rng = RunSeed(3).stream("body");
            let train = Drivetrain::new(drive(0.38), errors);
            let quiet_m = speed_mps * 0.01;
            (0..1_000_000)
                .filter(|_| {
                    let twist = train.propose(both(speed_mps), STEP, &mut rng);
                    (twist.dx_m - quiet_m).abs() > 1e-12
                })
                .count()
        };
        assert!((4646..=5354).contains(&count(0.3)));
        assert_eq!(count(0.0), 0);
    }

    #[test]
    fn equal_seeds_slip_equally() {
        let errors = OdometryErrors { slip_std_ratio: 0.05, ..OdometryErrors::default() };
        let end = |seed| run_seeded(0.38, errors, both(0.3), 100, seed).0;
        assert_eq!(end(5), end(5));
        assert_ne!(end(5), end(6));
    }

    #[test]
    fn errors_outside_their_ranges_are_named() {
        let bad = OdometryErrors { wheelbase_ratio: f64::NAN, ..OdometryErrors::default() };
        let error = bad.checked().unwrap_err();
        assert_eq!(error.to_string(), "wheelbase_ratio = NaN: must be from 0.5 to 2");
        let none = OdometryErrors { encoder_coarsening_ticks: 0, ..OdometryErrors::default() };
        let error = none.checked().unwrap_err();
        assert_eq!(error.to_string(), "encoder_coarsening_ticks = 0: must be from 1 to 1000000");
        assert!(OdometryErrors::unequal_diameters(0.1).checked().is_ok());
        assert!(OdometryErrors::unequal_diameters(2.1).checked().is_err());
    }
}
