//! The golden run and the published counts need the measured data; the rest does not.

use recordings::mat::MatFile;

use super::*;

/// A file of the measured data.
fn mat_file(name: &str) -> Option<MatFile> {
    let path = testkit::data_folder("artemic")?.join(name);
    let bytes = std::fs::read(path).unwrap();
    Some(MatFile::parse(&bytes, 1 << 26).unwrap())
}

/// A log of the measured data, 16 readings in a row, as the file has it.
fn measured(name: &str) -> Option<ClassicLog> {
    let file = mat_file(&format!("{name}.mat"))?;
    let pose = file.matrix("saved_pose").unwrap();
    let poses = (0..pose.n_rows()).map(|r| [0, 1, 2].map(|c| pose.at(r, c))).collect();
    let readings = file.matrix("saved_readings").unwrap();
    let readings_mm = (0..readings.n_rows()).flat_map(|row| readings.row(row)).collect();
    Some(ClassicLog::new(poses, readings_mm, readings.n_columns(), 0.25).unwrap())
}

#[test]
fn the_golden_run_comes_out_to_the_last_cell() {
    let Some(log) = measured("robot_state_U") else { return };
    let run = run(&log, &ClassicConfig::listing(50.0, 800)).unwrap();
    assert_eq!(run.steps.len(), 240);
    let last = run.steps.last().unwrap();
    assert_eq!((last.first_row, last.n_rows, last.n_readings), (718, 2, 32));
    assert_eq!(last.position, [443, 118]);
    let score = last.scores[last.chosen.unwrap()].unwrap();
    assert!((score - 3_044.851_138_553_776).abs() < 1e-9, "{score}");
    assert_eq!(last.scores.len(), 63);
    // The author's saved map, cell by cell.
    let workspace = mat_file("matlab.mat").unwrap();
    let world = workspace.matrix("world").unwrap();
    let cells = (1..=800).flat_map(|row| (1..=800).map(move |column| (row, column)));
    let mut n_occupied = 0;
    for (row, column) in cells {
        let ours = run.world.prob(row as i64, column as i64) >= 0.7;
        n_occupied += usize::from(ours);
        assert_eq!(ours, world.at(row - 1, column - 1) > 0.5, "cell ({row}, {column})");
    }
    assert_eq!(n_occupied, 3124);
    assert_eq!(run.world.extent(), (1, 1, 800, 800), "nothing lies beyond the author's map");
}

#[test]
fn every_log_and_scale_has_its_published_counts() {
    for (name, scale_mm, n_world, expected) in [
        ("robot_state_camera", 20.0, 600, (36_716, 1742, 26_945)),
        ("robot_state", 20.0, 600, (30_793, 1525, 23_136)),
        ("robot_state_camera", 35.0, 600, (17_018, 1455, 13_590)),
        ("robot_state_U", 35.0, 1000, (30_200, 2822, 25_155)),
        ("robot_state_U", 50.0, 800, (23_460, 3124, 18_006)),
    ] {
        let Some(log) = measured(name) else { return };
        let run = run(&log, &ClassicConfig::listing(scale_mm, n_world)).unwrap();
        let counts = run.world.counts(0.7);
        let found = (counts.n_known, counts.n_occupied, counts.n_free);
        assert_eq!((run.steps.len(), found), (240, expected), "{name} {scale_mm}");
    }
}

/// The pose generator and the geometry of the world, as published.
#[test]
fn nine_shifts_and_a_window_in_the_right_place() {
    assert_eq!(NINE_SHIFTS[0], [0, 0]);
    let mut all = NINE_SHIFTS.to_vec();
    all.sort_unstable();
    all.dedup();
    assert_eq!(all.len(), 9);
    assert!(all.iter().flatten().all(|step| (-1..=1).contains(step)));
    let n = |degrees| {
        let headings_deg = headings_deg(degrees);
        ClassicConfig { headings_deg, ..ClassicConfig::thesis() }.n_candidates()
    };
    assert_eq!([n(3), n(1), n(6)], [63, 27, 117]);
    let config = ClassicConfig::listing(50.0, 800);
    assert_eq!(config.position(2.91, 0.0, 0), [361, 360]);
    assert_eq!(config.cell_of_robot(2.91, 0.0), [436, 435]);
}

/// A robot that drives past a row of pillars, once by true odometry and once with every later row
/// shifted by a cell and turned by a degree.
fn simulated(shift_mm: f64, turn_deg: f64) -> ClassicLog {
    let pillars = [(700.0, 500.0), (1100.0, -450.0), (1500.0, 520.0), (900.0, 900.0)];
    let (mut poses, mut readings) = (Vec::new(), Vec::new());
    for row in 0..90 {
        let x = 12.0 * f64::from(row % 45);
        for sonar in LISTING_RING {
            let (sx, sy) = (x + sonar.x_mm, sonar.y_mm);
            let seen = pillars.iter().filter_map(|&(px, py)| {
                let (dx, dy): (f64, f64) = (px - sx, py - sy);
                let off_deg = dy.atan2(dx).to_degrees() - sonar.azimuth_deg;
                (off_deg.abs() < 7.0).then(|| dx.hypot(dy))
            });
            readings.push(seen.fold(5000.0, f64::min));
        }
        let is_late = row >= 45;
        let (s, t) = if is_late { (shift_mm, turn_deg) } else { (0.0, 0.0) };
        let (sin, cos) = t.to_radians().sin_cos();
        poses.push([x * cos + s, x * sin, t]);
    }
    ClassicLog::new(poses, readings, 8, 0.05).unwrap()
}

fn searching(score: Score) -> ClassicConfig {
    ClassicConfig { maturity: Maturity::Scans(44), score, ..ClassicConfig::thesis() }
}

#[test]
fn a_short_term_map_that_lies_a_cell_off_is_moved_back() {
    for score in [Score::CommonCells { n_cells_min: 50 }, Score::Evidence { n_cells_min: 50 }] {
        let run = run(&simulated(35.0, 0.0), &searching(score)).unwrap();
        let second = &run.steps[1];
        assert_eq!((second.shift, second.heading_deg), ([-1, 0], 0.0), "{score:?}");
        let corrected = run.poses[88];
        assert!((corrected[0] - 12.0 * 43.0).abs() < 1e-9, "{corrected:?}");
    }
}

#[test]
fn a_short_term_map_that_is_turned_is_turned_back() {
    let config = searching(Score::Evidence { n_cells_min: 50 });
    let run = run(&simulated(0.0, 2.0), &config).unwrap();
    let turned = run.steps[1].heading_deg;
    assert!((-3.0..=-1.0).contains(&turned), "{turned}");
}

#[test]
fn nothing_is_corrected_without_overlap_or_with_the_digit_one() {
    let config = searching(Score::CommonCells { n_cells_min: 100_000 });
    let log = simulated(35.0, 1.0);
    let alone = run(&log, &config).unwrap();
    assert!(alone.steps.iter().all(|step| step.chosen.is_none() && step.shift == [0, 0]));
    assert_eq!(alone.poses, log.poses());
    let listing =
        ClassicConfig { maturity: Maturity::Scans(44), ..ClassicConfig::listing(35.0, 800) };
    let listing = run(&log, &listing).unwrap();
    assert!(listing.steps.iter().all(|step| step.chosen == Some(0) && step.shift == [0, 0]));
    assert_eq!(listing.poses, log.poses());
}

#[test]
fn logs_that_cannot_be_used_are_refused_with_the_row() {
    let config = ClassicConfig::listing(35.0, 600);
    let log = |poses: Vec<[f64; 3]>, n_columns: usize| {
        let readings = vec![5000.0; poses.len() * n_columns];
        ClassicLog::new(poses, readings, n_columns, 0.05).unwrap()
    };
    assert!(run(&log(Vec::new(), 8), &config).unwrap().steps.is_empty());
    assert!(run(&log(vec![[0.0; 3]], 8), &config).unwrap().steps.is_empty());
    let message = |log: &ClassicLog| run(log, &config).unwrap_err().to_string();
    assert!(message(&log(vec![[0.0; 3]; 2], 5)).contains("8 sonars"));
    let not_finite = message(&log(vec![[0.0; 3], [0.0, f64::NAN, 0.0]], 8));
    assert!(not_finite.starts_with("row 2:"), "{not_finite}");
    let far = message(&log(vec![[0.0; 3], [1e9, 0.0, 0.0], [1e9, 0.0, 0.0]], 8));
    assert!(far.starts_with("row 2:") && far.contains("units"), "{far}");
    let shape = ClassicLog::new(vec![[0.0; 3]], vec![1.0; 7], 8, 0.05).unwrap_err();
    assert!(shape.to_string().contains("1 poses of 8"), "{shape}");
}
