//! Rings and fuzzy rules of one's own: what a mission file says is what the robot has.
#![expect(clippy::unwrap_used, reason = "a failing helper fails its test")]

use missions::{Mission, Run, sense};
use recordings::Rig;
use run_context::RunSeed;

/// A room whose walls are 2 m ahead, 1 m to the left, 3 m behind and far to the right, exact sonars, and a robot
/// that stands in it.
fn room(link: &str, ring: &str) -> String {
    format!(
        "[mission]\nname = \"room\"\nduration_max_s = 6.0\n\
         [world]\nbounds_m = [-4.0, -9.0, 3.0, 2.0]\n\
         [[world.walls]]\nline_m = [[2.0, -9.0], [2.0, 1.0], [-3.0, 1.0], [-3.0, -9.0]]\n\
         [[robots]]\nline.kind = \"{link}\"\nmind.how.method = \"straight\"\n\
         [robots.sonar]\nrange_std_m = 0.0\nrange_std_ratio = 0.0\ndropout_prob = 0.0\n\
         crosstalk_prob = 0.0\n{ring}\n"
    )
}

fn said(text: &str) -> String {
    match Mission::parse("room.toml", text, &[]) {
        Ok(mission) => format!("accepted: {}", mission.name()),
        Err(error) => error.to_string(),
    }
}

/// Mounts and the first whole row of the only robot, metres.
fn rows(text: &str) -> (Vec<geometry::Se2>, Vec<f64>, f64) {
    let mission = Mission::parse("room.toml", text, &[]).unwrap();
    let (_, recording) = sense(mission, RunSeed(1)).unwrap().recordings.remove(0);
    let Rig::Ring(ring) = &recording.rig else { panic!("no ring") };
    let rounds = &recording.scans;
    let last = rounds.len() - 1;
    // Over the wire ages come with the report: a mean over many rounds.
    let all = rounds[last].stamps[0].since(rounds[2].stamps[0]).as_secs_f64();
    let apart = all / (last - 2) as f64;
    (ring.base_from_sensors.clone(), rounds[2].ranges_m.clone(), apart)
}

/// Over the wire and without it: each sensor measures from its own place along its own axis, in its own time.
#[test]
fn a_ring_of_ones_own_measures_from_where_it_is() {
    let ring = "ring = \"own\"\nring_at = [[0.2, 0.0, 0.0], [0.0, 0.15, 90.0], [-0.25, 0.05, 180.0]]\n\
                ring_period_ms = 60";
    for link in ["memory", "direct"] {
        let (mounts, row, round_s) = rows(&room(link, ring));
        let places: Vec<[f64; 3]> =
            mounts.iter().map(|m| [m.x_m, m.y_m, m.yaw_rad.to_degrees().abs()]).collect();
        assert_eq!(places.len(), 3, "{link}");
        for (place, expected) in
            places.iter().zip([[0.2, 0.0, 0.0], [0.0, 0.15, 90.0], [-0.25, 0.05, 180.0]])
        {
            assert!(place.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9), "{places:?}");
        }
        // 2 − 0.2, 1 − 0.15 and 3 − 0.25 m; the wire carries millimetres.
        for (range_m, expected_m) in row.iter().zip([1.8, 0.85, 2.75]) {
            assert!((range_m - expected_m).abs() < 6e-4, "{link}: {row:?}");
        }
        // A row waits for the report that brings its last reading; reports come every 100 ms.
        assert!((0.175..0.205).contains(&round_s), "{link}: a round takes {round_s} s");
    }
}

/// Sixteen sensors in two chains, one sensor, and both presets on a robot that has another ring.
#[test]
fn rings_have_one_to_sixteen_sensors_and_presets() {
    let all: Vec<String> =
        (0..16).map(|i| format!("[0.1, 0.0, {}]", 22.5 * f64::from(i) - 168.75)).collect();
    let sixteen = format!("ring = \"own\"\nring_at = [{}]", all.join(", "));
    let count = |ring: &str| rows(&room("memory", ring)).1.len();
    assert_eq!(count(&sixteen), 16);
    assert_eq!(count("ring = \"own\"\nring_at = [[0.2, 0.0, 0.0]]"), 1);
    assert_eq!(count("ring = \"five\""), 5);
    assert_eq!(count("ring = \"eight\""), 8);
    assert_eq!(count("ring = \"eight\"\nring_chain = 4"), 8);
}

#[test]
fn rings_that_cannot_be_are_refused_with_what_can() {
    let refused = |ring: &str| said(&room("direct", ring));
    let of = |n: usize| vec!["[0.1, 0.0, 0.0]"; n].join(", ");
    for (ring, expected) in [
        (
            "ring = \"own\"".to_owned(),
            "robots[0].sonar.ring_at = 0 sonars: must be from 1 to 16 sonars, each [x (m), y (m), bearing \
             (degrees)]",
        ),
        (
            format!("ring = \"own\"\nring_at = [{}]", of(17)),
            "robots[0].sonar.ring_at = 17 sonars: must be from 1 to 16 sonars, each [x (m), y (m), bearing \
             (degrees)]",
        ),
        (
            "ring = \"own\"\nring_at = [[2.0, 0.0, 0.0]]".to_owned(),
            "robots[0].sonar.ring_at[0] = (2, 0) m: must be a place on the robot, at most 0.1 m outside its outline",
        ),
        (
            "ring = \"own\"\nring_at = [[0.1, 0.0, 270.0]]".to_owned(),
            "robots[0].sonar.ring_at[0] = 270.0: must be a bearing from -180 to 180 degrees",
        ),
        (
            "ring_at = [[0.1, 0.0, 0.0]]".to_owned(),
            "robots[0].sonar.ring = \"model\": must be \"own\", because ring_at lists a ring of one's own",
        ),
        (
            "ring = \"five\"\nring_period_ms = 5".to_owned(),
            "robots[0].sonar.ring_period_ms = 5: must be from 10 to 1000 ms, or 0 for the ring's own",
        ),
        (
            "ring = \"own\"\nring_at = [[-0.2, 0.0, 180.0]]".to_owned(),
            "robots[0].mind.guard.method = \"checked\" with 1 sonars, none within 60° of straight ahead: must be \
             \"off\", \"contact\", a ring with a sonar that looks ahead, or for a robot without sonars a laser",
        ),
    ] {
        let said = refused(&ring);
        assert!(said.ends_with(expected), "{ring}:\n{said}\n{expected}");
    }
}

/// The drive of `trail-45deg` with these settings: its state, and its greatest distance from the trail, mm.
fn driven(controller: &str, overrides: &[&str]) -> (String, f64) {
    let mut all = vec![format!("robots.mind.follow.trail_law={controller}")];
    all.extend(overrides.iter().map(|&o| format!("robots.mind.follow.fuzzy.{o}")));
    let mut run = Run::new(Mission::load("trail-45deg", &all).unwrap(), RunSeed(1)).unwrap();
    let mut greatest_m: f64 = 0.0;
    for _ in 0..2000 {
        run.step();
        greatest_m = greatest_m.max(run.view().robots[0].truth.y_m.abs());
    }
    (run.state_hash().to_string(), 1e3 * greatest_m)
}

#[test]
fn a_changed_table_or_set_changes_the_drive_and_the_default_spelt_out_does_not() {
    let own = ["table=own", "left_rules=HHM HML MLL", "right_rules=LLM LMH MHH"];
    for controller in ["fuzzy", "listing"] {
        let usual = driven(controller, &[]);
        assert_eq!(driven(controller, &own), usual, "{controller}");
        for changed in [
            &["table=literal_mirror"][..],
            &["table=own", "left_rules=HHM MMM MLL", "right_rules=LLM MMM MHH"],
            &["error_full=20"],
            &["change_full=60"],
            &["slow_ratio=0.8"],
            &["fast_ratio=1.2"],
        ] {
            assert_ne!(driven(controller, changed).0, usual.0, "{controller} {changed:?}");
        }
    }
    // Wheels that may differ less turn it back later.
    let gentle = driven("fuzzy", &["slow_ratio=0.8", "fast_ratio=1.2"]).1;
    let usual = driven("fuzzy", &[]).1;
    assert!(gentle > 1.2 * usual, "{gentle} mm against {usual} mm");
}

#[test]
fn rules_that_cannot_be_are_refused_with_what_can() {
    let refused = |lines: &str| {
        let fuzzy = format!("[robots.mind.follow.fuzzy]\n{lines}");
        said(&room("direct", &fuzzy))
    };
    for (lines, expected) in [
        (
            "table = \"own\"\nleft_rules = \"HHM\"\nright_rules = \"LLM LMH MHH\"",
            "fuzzy.left_rules = \"HHM\": must be nine letters L, M or H: for e = N, Z, P each e' = N, Z, P, such as \
             \"HHM HML MLL\"",
        ),
        (
            "left_rules = \"HHM HML MLL\"",
            "fuzzy.table = \"antisymmetric\": must be \"own\", because left_rules or right_rules are given",
        ),
        ("error_full = 0", "fuzzy.error_full = 0: must be from 1 to 100000"),
        ("fast_ratio = 0.5", "fuzzy.fast_ratio = 0.5: must be from 1 to 3"),
    ] {
        let said = refused(lines);
        assert!(said.ends_with(expected), "{lines}:\n{said}\n{expected}");
    }
}
