//! The measured recordings with injected drift: recorded odometry is taken as truth, as nothing better
//! is known, and a systematic error of heading is added to it.

use continuous_localisation::{
    LocaliserConfig, Maturity, Score,
    classic::{self, ClassicConfig, ClassicLog},
    run,
};
use geometry::{Se2, Twist, wrap_to_pi};
use recordings::{Loaded, ReadOptions, Recording, read};

/// Position error over the run and at its end, and error of heading at the end.
struct Errors {
    rms_m: f64,
    final_m: f64,
    final_deg: f64,
}

pub(crate) fn table() {
    let Some(folder) = testkit::data_folder("artemic") else { return };
    println!(
        "\nRecordings with injected drift; errors against recorded odometry: RMS mm / final mm / \
         final heading\nrecording        method                        none               0.3°/m  \
                      1°/m"
    );
    for name in ["robot_state", "robot_state_U", "robot_state_camera"] {
        let bytes = std::fs::read(folder.join(format!("{name}.mat"))).expect("it is readable");
        let Loaded { recording, .. } =
            read(&format!("{name}.mat"), &bytes, &ReadOptions::default())
                .expect("it is a recording");
        let drifted: Vec<Recording> =
            [0.0, 0.3, 1.0].iter().map(|&degpm| with_drift(&recording, degpm)).collect();
        line(name, "odometry", &recording, &drifted, odometry);
        for (method, score) in [
            ("source, programmed score", Score::WholeWindow),
            ("source, printed score", Score::CommonCells { n_cells_min: 100 }),
            ("source, evidence", Score::Evidence { n_cells_min: 100 }),
        ] {
            line(name, method, &recording, &drifted, |r| source(r, score));
        }
        for (method, score) in [
            ("grids only, programmed score", Score::WholeWindow),
            ("grids only, printed score", Score::CommonCells { n_cells_min: 150 }),
            ("grids only, evidence", Score::Evidence { n_cells_min: 150 }),
        ] {
            let config = grids_only(score);
            line(name, method, &recording, &drifted, |r| ours(r, config.clone()));
        }
        line(name, "default", &recording, &drifted, |r| ours(r, LocaliserConfig::default()));
    }
}

fn line(
    name: &str,
    method: &str,
    truth: &Recording,
    drifted: &[Recording],
    found: impl Fn(&Recording) -> Vec<Se2>,
) {
    print!("{name:18} {method:28}");
    for recording in drifted {
        let e = errors(&found(recording), truth);
        print!(" {:6.0}/{:6.0}/{:6.1}°", e.rms_m * 1e3, e.final_m * 1e3, e.final_deg);
    }
    println!();
}

fn errors(found: &[Se2], truth: &Recording) -> Errors {
    let truth: Vec<Se2> = truth.scans.iter().filter_map(|s| s.odom_from_base).collect();
    let off = |(a, b): (&Se2, &Se2)| (a.position() - b.position()).norm();
    let squares: Vec<f64> = found.iter().zip(&truth).map(|pair| off(pair).powi(2)).collect();
    let (a, b) = (found[found.len() - 1], truth[truth.len() - 1]);
    Errors {
        rms_m: (squares.iter().sum::<f64>() / squares.len() as f64).sqrt(),
        final_m: off((&a, &b)),
        final_deg: wrap_to_pi(a.yaw_rad - b.yaw_rad).to_degrees(),
    }
}

fn with_drift(recording: &Recording, degpm: f64) -> Recording {
    let mut drifted = recording.clone();
    let truth: Vec<Se2> = recording.scans.iter().filter_map(|s| s.odom_from_base).collect();
    let mut pose = truth[0];
    for (i, scan) in drifted.scans.iter_mut().enumerate() {
        if i > 0 {
            let step = truth[i - 1].inverse().compose(truth[i]).log();
            let yaw = degpm.to_radians() * step.dx_m.hypot(step.dy_m);
            pose = pose.compose(Se2::exp(Twist { dyaw_rad: step.dyaw_rad + yaw, ..step }));
        }
        scan.odom_from_base = Some(pose);
    }
    drifted
}

fn odometry(recording: &Recording) -> Vec<Se2> {
    recording.scans.iter().filter_map(|s| s.odom_from_base).collect()
}

/// The source's method with its search switched on: 63 candidates, 20 scans, a range that fits.
fn source(recording: &Recording, score: Score) -> Vec<Se2> {
    let (log, ring) = ClassicLog::from_recording(recording).expect("a ring with odometry");
    let config = ClassicConfig { ring, score, ..ClassicConfig::thesis() };
    let run = classic::run(&log, &config).expect("the map is small enough");
    let pose = |p: &[f64; 3]| Se2::new(p[0] * 1e-3, p[1] * 1e-3, p[2].to_radians());
    run.poses.iter().map(pose).collect()
}

fn grids_only(score: Score) -> LocaliserConfig {
    LocaliserConfig {
        score,
        maturity: Maturity::Scans(20),
        walls: None,
        squareness: None,
        ..LocaliserConfig::default()
    }
}

fn ours(recording: &Recording, config: LocaliserConfig) -> Vec<Se2> {
    let found = run(recording, config).expect("a ring");
    found.online.iter().map(|p| p.pose).collect()
}
