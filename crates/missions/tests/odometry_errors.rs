//! Every error of dead reckoning that a mission can state does what it says, with its law.
#![expect(clippy::unwrap_used, reason = "a failing helper fails its test")]

use geometry::{Se2, wrap_to_pi};
use missions::{Mission, PoseReport, Run};
use run_context::RunSeed;

/// ARTEMIC's wheels stand 370 mm apart and count a pulse every 1.00531 mm.
const WHEELBASE_M: f64 = 0.37;
const PULSE_M: f64 = 1.005_31e-3;
const SPEED_MPS: f64 = 0.4;

/// Reports of a robot that a person, who sees the truth, drives straight for `way_m`.
fn driven(way_m: f64, errors: &str, seed: u64) -> Vec<PoseReport> {
    let text = format!(
        "[mission]\nname = \"floor\"\nduration_max_s = {}\n\
         [[robots]]\nmodel = \"artemic5\"\nline.kind = \"direct\"\nmind.how.method = \"straight\"\n\
         [robots.teleoperator]\npath_m = [[0.0, 0.0], [{way_m:?}, 0.0]]\nspeed_mps = {SPEED_MPS:?}\n\
         [robots.odometry]\n{errors}\n",
        way_m / SPEED_MPS + 6.0
    );
    let mission = Mission::parse("floor.toml", &text, &[]).unwrap();
    let mut run = Run::new(mission, RunSeed(seed)).unwrap();
    let mut reports = Vec::new();
    for _ in 0..(100.0 * (way_m / SPEED_MPS + 5.0)) as usize {
        run.step();
        for sensed in run.sensed() {
            reports.extend_from_slice(sensed.reports);
        }
    }
    reports
}

fn truth(report: &PoseReport) -> Se2 {
    report.world_from_base.unwrap()
}

/// How much farther it is than it believes, along the line, report by report, m.
fn lags(reports: &[PoseReport]) -> Vec<f64> {
    reports.iter().map(|r| truth(r).x_m - r.odom_from_base.x_m).collect()
}

fn turned_away(report: &PoseReport) -> f64 {
    wrap_to_pi(report.odom_from_base.yaw_rad - truth(report).yaw_rad)
}

fn std_of(values: &[f64]) -> f64 {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt()
}

#[test]
fn without_errors_it_knows_where_it_is_to_two_pulses() {
    for report in driven(4.0, "", 1) {
        let apart = truth(&report).inverse().compose(report.odom_from_base);
        assert!(apart.x_m.hypot(apart.y_m) < 2.0 * PULSE_M + 0.01, "{apart:?}");
    }
}

#[test]
fn larger_wheels_carry_it_farther_than_it_believes() {
    for ratio in [1.02, 0.97] {
        let errors = format!("left_diameter_ratio = {ratio}\nright_diameter_ratio = {ratio}");
        let last = *driven(4.0, &errors, 1).last().unwrap();
        let found = truth(&last).x_m / last.odom_from_base.x_m;
        assert!((found / ratio - 1.0).abs() < 1e-3, "{ratio}: {found}");
    }
}

/// It moves to the side of where it looks: driven along a line it looks aside, and believes to go
/// where it looks.
#[test]
fn a_misaligned_axle_leads_dead_reckoning_aside_by_its_sine() {
    for misalignment_deg in [2.0_f64, -2.0] {
        let errors = format!("misalignment_deg = {misalignment_deg:?}");
        let reports = driven(4.0, &errors, 1);
        let last = reports.last().unwrap();
        assert!(truth(last).y_m.abs() < 0.05, "{:?}", truth(last));
        let expected_m = -truth(last).x_m * misalignment_deg.to_radians().sin();
        let found_m = last.odom_from_base.y_m - truth(last).y_m;
        // 140 mm; the turn onto the line costs some of it.
        assert!((found_m / expected_m - 1.0).abs() < 0.1, "{found_m} instead of {expected_m}");
        assert!(turned_away(last).abs() < 2.0 * PULSE_M / WHEELBASE_M);
    }
}

/// Whole steps are counted, so it believes to be behind by up to one of them and never ahead.
#[test]
fn a_coarse_encoder_is_behind_by_up_to_a_step() {
    let step_m = 50.0 * PULSE_M;
    let lags = lags(&driven(4.0, "encoder_coarsening_ticks = 50", 1));
    let (least, most) = lags.iter().fold((f64::MAX, f64::MIN), |(a, b), &l| (a.min(l), b.max(l)));
    // Turns of half a step make it believe in a slight detour.
    assert!(least > -0.3 * step_m && most < 1.3 * step_m, "{least} to {most} m");
    assert!(most > 0.7 * step_m, "{most} m");
}

#[test]
fn slow_sampling_is_behind_by_up_to_the_way_of_a_period() {
    let lags = lags(&driven(4.0, "encoder_period_ms = 500.0", 1));
    let most = lags.iter().fold(f64::MIN, |most, &lag| most.max(lag));
    assert!((0.85..=1.05).contains(&(most / (SPEED_MPS * 0.5))), "{most} m");
    let last = *lags.last().unwrap();
    assert!(last.abs() < 0.01, "standing it knows: {last} m");
}

/// Each bump turns it by σ / b, n of them by √n as much. The deviation of 60 runs is known to
/// 9 %; four times that is allowed.
#[test]
fn bumps_turn_it_at_random_and_come_at_their_rate() {
    let (rate_hz, std_m, n) = (2.0, 0.005, 60);
    let errors = format!("bump_rate_hz = {rate_hz:?}\nbump_std_m = {std_m:?}");
    let ends: Vec<f64> =
        (1..=n).map(|seed| turned_away(driven(3.0, &errors, seed).last().unwrap())).collect();
    // It moves for the way at its speed, and a second of ramps.
    let expected = std_m * (rate_hz * (3.0 / SPEED_MPS + 1.0_f64)).sqrt() / WHEELBASE_M;
    let found = std_of(&ends);
    assert!((found / expected - 1.0).abs() < 0.36, "{found} instead of {expected}");
    let mean = ends.iter().sum::<f64>() / n as f64;
    assert!(mean.abs() < 4.0 * expected / (n as f64).sqrt(), "bumps have a direction: {mean}");
}

#[test]
fn keys_outside_their_ranges_are_refused_by_name() {
    for (key, value, allowed) in [
        ("misalignment_deg", "11", "from -10 to 10 degrees"),
        ("encoder_coarsening_ticks", "0", "from 1 to 100000 pulses"),
        ("encoder_period_ms", "-1", "from 0 to 1000 ms"),
        ("bump_rate_hz", "101", "from 0 to 100 per second"),
        ("bump_std_m", "0.2", "from 0 to 0.1 m"),
    ] {
        let set = vec![format!("robots.odometry.{key}={value}")];
        let error = Mission::load("one-obstacle", &set).unwrap_err().to_string();
        assert!(error.contains(key) && error.contains(allowed), "{error}");
    }
}
