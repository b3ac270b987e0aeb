//! From counters that wrap to a pose and speeds.

use std::{collections::VecDeque, time::Duration};

use geometry::{Base, Odom, Transform2};
use robot_models::{DriveGeometry, Odometry, WheelSpeeds};
use run_context::Stamp;

/// Time over which speeds are measured: a count in this time is 4 mm/s.
const SPEED_WINDOW: Duration = Duration::from_millis(100);
/// Frames that are remembered for that.
const N_FRAMES_MAX: usize = 32;
/// Counts that wheels may turn beside what they can do, m.
const JUMP_MARGIN_M: f64 = 0.1;

/// The pose by the encoders.
#[derive(Clone, Debug)]
pub(super) struct Odometer {
    drive: DriveGeometry,
    odometry: Odometry,
    /// What the counters said last.
    last: Option<(Stamp, [u16; 2])>,
    /// Counts since the first frame.
    counts: [i64; 2],
    /// The newest frames, the oldest first: when, and the counts.
    window: VecDeque<(Stamp, [i64; 2])>,
}

impl Odometer {
    pub(super) fn new(drive: DriveGeometry) -> Self {
        Self {
            drive,
            odometry: Odometry::new(drive),
            last: None,
            counts: [0; 2],
            window: VecDeque::with_capacity(N_FRAMES_MAX),
        }
    }

    /// Takes the counters of the left and the right wheel; `false` when they show a way that wheels of `speed_max_mps`
    /// cannot have made: then it is passed over.
    pub(super) fn take(&mut self, about: Stamp, counters: [i32; 2], speed_max_mps: f64) -> bool {
        // Two's complement: the low 16 bits.
        let counters = counters.map(|counter| counter as u16);
        let Some((before, last)) = self.last.replace((about, counters)) else { return true };
        let steps: [i16; 2] =
            std::array::from_fn(|side| counters[side].wrapping_sub(last[side]).cast_signed());
        let possible_m = speed_max_mps * about.since(before).as_secs_f64() + JUMP_MARGIN_M;
        let farthest = steps.iter().map(|step| f64::from(step.unsigned_abs())).fold(0.0, f64::max);
        if self.drive.metres_per_tick() * farthest > possible_m {
            self.window.clear();
            return false;
        }
        for (count, step) in self.counts.iter_mut().zip(steps) {
            *count += i64::from(step);
        }
        let [left, right] = self.counts;
        self.odometry.update(left, right);
        if self.window.len() == N_FRAMES_MAX {
            self.window.pop_front();
        }
        self.window.push_back((about, self.counts));
        while self.window.get(1).is_some_and(|&(at, _)| about.since(at) >= SPEED_WINDOW) {
            self.window.pop_front();
        }
        true
    }

    pub(super) fn odom_from_base(&self) -> Transform2<Odom, Base> {
        self.odometry.odom_from_base()
    }

    /// Over the last tenth of a second.
    pub(super) fn wheel_speeds(&self) -> WheelSpeeds {
        let (Some(&(from, first)), Some(&(to, last))) = (self.window.front(), self.window.back())
        else {
            return WheelSpeeds::ZERO;
        };
        let seconds = to.since(from).as_secs_f64();
        if seconds <= 0.0 {
            return WheelSpeeds::ZERO;
        }
        let mps = |side: usize| {
            self.drive.metres_per_tick() * (last[side] - first[side]) as f64 / seconds
        };
        WheelSpeeds { left_mps: mps(0), right_mps: mps(1) }
    }
}

#[cfg(test)]
mod tests {
    use robot_models::RobotModel;

    use super::*;

    fn odometer() -> Odometer {
        Odometer::new(RobotModel::by_name("create2").unwrap().drive)
    }

    #[test]
    fn counters_wrap_both_ways() {
        for (from, to, steps) in [
            (65_530, 10, 16),
            (10, 65_530, -16),
            (0, 65_535, -1),
            (65_535, 0, 1),
            (40_000, 40_100, 100),
        ] {
            let mut odometer = odometer();
            assert!(odometer.take(Stamp::ZERO, [from, from], 0.5));
            assert!(odometer.take(Stamp::from_millis(15), [to, to], 0.5));
            // 0.44456 mm a count.
            let x_m = odometer.odom_from_base().se2().x_m;
            assert!((x_m - f64::from(steps) * 0.444_56e-3).abs() < 1e-6, "{from} {to} {x_m}");
        }
    }

    #[test]
    fn ways_beyond_a_wrap_are_counted_on() {
        let mut odometer = odometer();
        // 200 000 counts at 0.5 m/s are 89 m: three wraps.
        for k in 0..=12_500_i32 {
            odometer.take(
                Stamp::from_millis(u64::from(k.unsigned_abs()) * 15),
                [(16 * k) % 65_536, 0],
                0.5,
            );
        }
        assert!((odometer.odometry.travelled_m() - 0.5 * 88.91).abs() < 0.01);
        let speeds = odometer.wheel_speeds();
        assert!((speeds.left_mps - 0.474).abs() < 0.001 && speeds.right_mps == 0.0, "{speeds:?}");
    }

    #[test]
    fn a_jump_that_no_wheel_makes_is_passed_over() {
        let mut odometer = odometer();
        odometer.take(Stamp::ZERO, [20_000, 20_000], 0.5);
        assert!(!odometer.take(Stamp::from_millis(1000), [0, 0], 0.5));
        assert!(odometer.take(Stamp::from_millis(1015), [5, 5], 0.5));
        assert!((odometer.odom_from_base().se2().x_m - 5.0 * 0.444_56e-3).abs() < 1e-6);
        // The same way is possible in 20 s.
        assert!(odometer.take(Stamp::from_millis(21_000), [20_000, 20_000], 0.5));
    }
}
