//! Dead reckoning as recorded against the wheels' counters, worked out another way.

use geometry::wrap_to_pi;
use run_context::RunSeed;

use crate::{Mission, Run};

/// Follows the counters of one robot: straight chords of the arcs, with plain trigonometry.
struct ByHand {
    metres_per_tick: f64,
    wheelbase_m: f64,
    ticks: [i64; 2],
    pose: [f64; 3],
}

impl ByHand {
    fn count(&mut self, ticks: [i64; 2]) {
        let way = |i: usize| self.metres_per_tick * (ticks[i] - self.ticks[i]) as f64;
        let (left, right) = (way(0), way(1));
        self.ticks = ticks;
        let (ds, turn) = (0.5 * (left + right), (right - left) / self.wheelbase_m);
        let half = 0.5 * turn;
        let chord = if half == 0.0 { ds } else { ds * half.sin() / half };
        let [x, y, yaw] = self.pose;
        self.pose = [x + chord * (yaw + half).cos(), y + chord * (yaw + half).sin(), yaw + turn];
    }
}

/// Greatest gap of any report of a run from the counters, m and rad; and how many reports there were.
fn gaps(name: &str, overrides: &[&str], steps: u64, mut hand: ByHand) -> (f64, f64, usize) {
    let overrides: Vec<String> = overrides.iter().map(|&o| o.to_owned()).collect();
    let mission = Mission::load(name, &overrides).unwrap();
    let mut run = Run::new(mission, RunSeed(4)).unwrap();
    let mut poses = Vec::new();
    let (mut gap_m, mut gap_rad, mut n) = (0.0_f64, 0.0_f64, 0);
    for _ in 0..steps {
        hand.count(run.world.bodies()[0].encoder_ticks);
        poses.push(hand.pose);
        run.step();
        for report in run.sensed().next().unwrap().reports {
            let step = report.stamp.as_nanos() / 10_000_000;
            let [x, y, yaw] = poses[usize::try_from(step).unwrap()];
            let found = report.odom_from_base;
            gap_m = gap_m.max((found.x_m - x).hypot(found.y_m - y));
            gap_rad = gap_rad.max(wrap_to_pi(found.yaw_rad - yaw).abs());
            n += 1;
        }
    }
    let [x, y, _] = hand.pose;
    assert!(x.hypot(y) > 1.5, "it hardly moved");
    (gap_m, gap_rad, n)
}

#[test]
fn recorded_dead_reckoning_is_the_integral_of_the_counters() {
    let artemic = ByHand {
        metres_per_tick: std::f64::consts::PI * 0.16 / 500.0,
        wheelbase_m: 0.37,
        ticks: [0; 2],
        pose: [0.0; 3],
    };
    let (gap_m, gap_rad, n) = gaps("artemic-e3", &[], 9000, artemic);
    assert!(gap_m < 1e-9 && gap_rad < 1e-9, "{gap_m} m, {gap_rad} rad");
    assert_eq!(n, 9000 / 5);
}

#[test]
fn over_the_wire_it_is_so_in_whole_millimetres() {
    let pioneer = ByHand {
        metres_per_tick: std::f64::consts::PI * 0.1953 / (38.3 * 500.0),
        wheelbase_m: 0.38,
        ticks: [0; 2],
        pose: [0.0; 3],
    };
    // The time of a report is known to a step, in which the robot moves by 3 mm.
    let errors = "robots.odometry={drift_degpm=1.0, slip_std_ratio=0.002}";
    let (gap_m, gap_rad, n) = gaps("one-obstacle", &[errors], 1500, pioneer);
    assert!(gap_m < 0.005 && gap_rad < 0.012, "{gap_m} m, {gap_rad} rad");
    assert!(n > 120, "{n} reports");
}
