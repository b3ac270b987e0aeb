//! Lasers on robots of a mission: their verdicts, their lines, what is said of them, what they cost.
#![expect(clippy::unwrap_used, reason = "a failing helper fails its test")]

use expect_test::expect;
use missions::{Direction, Intervention, Line, LogLevel, Mission, Run, ViewScan, sense};
use run_context::RunSeed;

fn run(name: &str, overrides: &[&str], seed: u64) -> Run {
    let overrides: Vec<String> = overrides.iter().map(ToString::to_string).collect();
    Run::new(Mission::load(name, &overrides).unwrap(), RunSeed(seed)).unwrap()
}

fn steps(run: &mut Run, n: u64) {
    (0..n).for_each(|_| run.step());
}

/// What the log says that is not good news, of a laser.
fn said(run: &mut Run, name: &str) -> Vec<(LogLevel, String)> {
    let log = run.drain_log();
    log.into_iter().filter(|l| l.text.contains(name)).map(|l| (l.level, l.text)).collect()
}

fn refused(overrides: &[&str]) -> String {
    let overrides: Vec<String> = overrides.iter().map(ToString::to_string).collect();
    Mission::load("laser-ward", &overrides).unwrap_err().to_string()
}

#[test]
fn the_shipped_missions_with_lasers_pass() {
    for name in ["laser-ward", "create-errand", "create-scan"] {
        for seed in [1, 2] {
            let mut run = run(name, &[], seed);
            let verdict = run.run_to_end();
            assert!(verdict.passed, "{name} {seed}: {}", verdict.text);
        }
    }
    // Each laser on each of the robots, with bytes and without.
    for kind in ["sick", "rplidar", "ld06"] {
        let kind = format!("robots.lasers.kind={kind}");
        for line in ["memory", "direct"] {
            let line = format!("robots.lasers.line.kind={line}");
            let mut run = run("laser-ward", &[&kind, &line], 1);
            let verdict = run.run_to_end();
            assert!(verdict.passed, "{kind} {line}: {}", verdict.text);
        }
    }
}

/// A Create 2 hears and sees nothing by itself; with a laser it drives around a box that no map knows, and without one that
/// guard is refused.
#[test]
fn a_robot_that_only_has_a_laser_is_guarded_by_it() {
    let mission = |laser: &str| {
        format!(
            "[mission]\nname = \"way\"\nduration_max_s = 120.0\n[[world.walls]]\nline_m = [[-1.0, -2.0], [6.0, -2.0], \
             [6.0, 2.0], [-1.0, 2.0]]\nclosed = true\n[[robots]]\nname = \"c\"\nmodel = \"create2\"\n[robots.line]\n\
             baud = 115200\n{laser}[robots.mind]\nhow.method = \"straight\"\nfollow.speed_mps = 0.2\n[[events]]\n\
             at_s = 1.0\ndo = \"place_box\"\nat_m = [2.2, 0.05]\nsize_m = 0.4\n[[events]]\nat_s = 2.0\n\
             do = \"goal\"\nrobot = \"c\"\npose = [4.5, 0.0, 0.0]\n[success]\nno_contact = true\n\
             [[success.arrived]]\nrobot = \"c\"\npose = [4.5, 0.0, 0.0]\n"
        )
    };
    for kind in ["ld06", "rplidar"] {
        let laser = format!("[[robots.lasers]]\nname = \"head\"\nkind = \"{kind}\"\n");
        let mission = Mission::parse("way.toml", &mission(&laser), &[]).unwrap();
        let mut run = Run::new(mission, RunSeed(1)).unwrap();
        let verdict = run.run_to_end();
        assert!(verdict.passed, "{kind}: {}", verdict.text);
    }
    let error = Mission::parse("way.toml", &mission(""), &[]).unwrap_err().to_string();
    assert!(error.contains("guard.method") && error.contains("a laser"), "{error}");
}

/// Wheels that are not as the robot's file says lead it astray; particles on the map keep it where it is.
#[test]
fn particles_on_the_map_correct_what_the_wheels_get_wrong() {
    let errors = "robots.odometry={left_diameter_ratio=1.006, right_diameter_ratio=0.994, slip_std_ratio=0.01}";
    let off_m = |method: &str, seed: u64| {
        let method = format!("robots.mind.where_am_i.method={method}");
        let mut run = run("laser-ward", &[errors, &method], seed);
        let (mut sum, mut n, mut most) = (0.0, 0.0, 0.0_f64);
        while run.finished().is_none() {
            run.step();
            let robot = &run.view_of_first(1).robots[0];
            let off_m =
                (robot.truth.x_m - robot.estimate.x_m).hypot(robot.truth.y_m - robot.estimate.y_m);
            most = most.max(off_m);
            sum += off_m * off_m;
            n += 1.0;
        }
        let passed = run.finished().unwrap().passed;
        (passed, (sum / n).sqrt(), most)
    };
    for seed in 1..4 {
        let (_, wheels_m, _) = off_m("dead_reckoning", seed);
        let (passed, rms_m, most_m) = off_m("particles", seed);
        println!(
            "seed {seed}: by wheels {wheels_m:.3} m rms, with particles {rms_m:.3} m, at most {most_m:.3} m"
        );
        assert!(passed && rms_m < 0.08 && most_m < 0.25, "{seed}: {rms_m} {most_m}");
        assert!(wheels_m > 4.0 * rms_m, "{seed}: {wheels_m} {rms_m}");
    }
    let error =
        Mission::load("one-obstacle", &["robots.mind.where_am_i.method=particles".to_owned()]);
    assert!(error.unwrap_err().to_string().contains("[[robots.lasers]]"));
}

/// A robot whose wheels are so far off that particles cannot follow says that it does not know where it is.
#[test]
fn a_robot_that_does_not_know_where_it_is_says_so() {
    let told = |errors: &str| {
        let method = "robots.mind.where_am_i.method=particles";
        let mut run = run("laser-ward", &[errors, method, "mission.duration_max_s=90"], 1);
        run.run_to_end();
        said(&mut run, "where it is")
    };
    let doubts = told("robots.odometry={left_diameter_ratio=1.25, right_diameter_ratio=0.8}");
    assert!(doubts.iter().any(|(level, _)| *level != LogLevel::Info), "{doubts:?}");
    let doubts = told("robots.odometry={left_diameter_ratio=1.0}");
    assert!(doubts.iter().all(|(level, _)| *level != LogLevel::Bad), "{doubts:?}");
}

/// In closed rooms no way is free without end: a beam that got lost is shown as unseen.
#[test]
fn lost_beams_are_not_shown_as_free() {
    for kind in ["ld06", "rplidar"] {
        let mut run = run("create-scan", &[&format!("robots.lasers.kind={kind}")], 1);
        let (mut n_seen, mut n_unseen) = (0, 0);
        for _ in 0..300 {
            steps(&mut run, 10);
            for scan in &run.view().robots[0].scans {
                assert!(scan.ranges_m.iter().all(|range_m| *range_m != ViewScan::FREE), "{kind}");
                n_seen += scan.ranges_m.len();
                n_unseen += scan.ranges_m.iter().filter(|r| **r == ViewScan::UNSEEN).count();
            }
        }
        assert!(
            n_seen > 10_000 && n_unseen > 0 && n_unseen < n_seen / 5,
            "{kind} {n_unseen} of {n_seen}"
        );
    }
}

/// Each scan is the world as it was where and when its beams were fired: the true pose that stands beside it puts all
/// surfaces onto walls of the map and boxes, whatever the laser and its line.
#[test]
fn scans_lie_on_the_walls() {
    for (kind, least) in [("sick", 150), ("rplidar", 80), ("ld06", 200)] {
        for line in ["memory", "direct"] {
            let overrides = [
                format!("robots.lasers.kind={kind}"),
                format!("robots.lasers.line.kind={line}"),
                "mission.duration_max_s=25".to_owned(),
            ];
            let mission = Mission::load("laser-ward", &overrides).unwrap();
            let (world, _) = missions::world_of(&mission, RunSeed(3)).unwrap();
            let sensed = sense(mission, RunSeed(3)).unwrap();
            let (name, recording) = &sensed.recordings[1];
            assert_eq!(name, "carrier/front");
            let recordings::Rig::Laser(rig) = &recording.rig else { panic!("{:?}", recording.rig) };
            assert!(recording.scans.len() >= least, "{kind} {line}: {}", recording.scans.len());
            assert_eq!(recording.scans.len(), recording.truth.len());
            let (mut n, mut off) = (0_u32, 0_u32);
            for (scan, truth) in recording.scans.iter().zip(&recording.truth).step_by(7) {
                let sensor = truth.pose.compose(rig.base_from_sensor);
                let origin = sensor.position();
                for (beam, range_m) in scan.ranges_m.iter().enumerate().step_by(5) {
                    if !range_m.is_finite() {
                        continue;
                    }
                    let yaw = sensor.yaw_rad + rig.bearing_rad(beam);
                    let direction = geometry::Vec2::new(yaw.cos(), yaw.sin());
                    let ray = geometry::Ray { origin, direction };
                    let scene = world.scene(None);
                    let hit = geometry::RayCaster::cast(&scene, &ray, 90.0);
                    n += 1;
                    // Edges and slanting walls move while the robot turns during a sweep.
                    let near = hit.is_some_and(|hit| (hit.distance_m - range_m).abs() < 0.15);
                    off += u32::from(!near);
                }
            }
            assert!(n > 500 && f64::from(off) < 0.06 * f64::from(n), "{kind} {line}: {off} of {n}");
        }
    }
}

/// A laser whose line is cut sees nothing: no scan is shown, the log names it, and when the line is mended it is heard again.
#[test]
fn a_laser_that_is_cut_is_unseen_and_named() {
    for line in ["memory", "direct"] {
        let mut run = run("laser-ward", &[&format!("robots.lasers.line.kind={line}")], 1);
        steps(&mut run, 800);
        assert_eq!(run.view().robots[0].scans.len(), 1, "{line}");
        let (laser, direction) = (Line::Laser(0), Direction::Back);
        run.apply(Intervention::CutLink { robot: 0, line: laser, direction }).unwrap();
        let _before = run.drain_log();
        steps(&mut run, 250);
        assert!(run.view().robots[0].scans.is_empty(), "{line}: what is not seen is not shown");
        let troubles = said(&mut run, "`front`");
        if line == "memory" {
            let (level, text) = troubles.first().unwrap();
            assert_eq!(*level, LogLevel::Bad);
            assert!(text.starts_with("carrier: laser `front` (SICK LMS200) is silent"), "{text}");
        }
        run.apply(Intervention::RestoreLink { robot: 0, line: laser, direction }).unwrap();
        steps(&mut run, 900);
        assert_eq!(run.view().robots[0].scans.len(), 1, "{line}");
        if line == "memory" {
            let troubles = said(&mut run, "`front`");
            let (level, text) = troubles.last().unwrap();
            assert_eq!((*level, text.contains("again")), (LogLevel::Good, true), "{text}");
        }
    }
}

/// The words of a mission for it.
#[test]
fn a_mission_can_cut_a_laser_by_its_name() {
    let cut = |line: &str| {
        let text = include_str!("../../../missions/create-scan.toml");
        let event = format!(
            "[[events]]\nat_s = 5.0\ndo = \"cut_line\"\nrobot = \"create\"\nline = \"{line}\"\ndirection = \"from_laser\"\n[success]"
        );
        Mission::parse("mission", &text.replace("[success]", &event), &[])
    };
    let mut run = Run::new(cut("head").unwrap(), RunSeed(1)).unwrap();
    steps(&mut run, 900);
    assert!(run.view().robots[0].scans.is_empty());
    assert!(cut("tail").unwrap_err().to_string().contains("tail"));
}

/// At the wrong speed bytes come and mean nothing: the log says so, names the device and the speed, and no scan is made of it.
#[test]
fn a_cable_at_the_wrong_speed_gives_noise_and_no_scan() {
    for (kind, wrong) in [("ld06", 115_200), ("rplidar", 9600), ("rplidar", 256_000)] {
        let kind = format!("robots.lasers.kind={kind}");
        let mut run = run("create-scan", &[&kind, &format!("robots.lasers.line.baud={wrong}")], 1);
        steps(&mut run, 1500);
        assert!(run.view().robots[0].scans.is_empty(), "{kind}");
        let troubles = said(&mut run, "`head`");
        assert!(troubles.iter().any(|(level, _)| *level == LogLevel::Bad), "{kind}: {troubles:?}");
        if kind.ends_with("ld06") {
            let text = &troubles[0].1;
            assert!(text.contains("nothing can be read") && text.contains("230400"), "{text}");
        }
    }
}

/// Two lasers on one robot: each has its own line, its own scans and its own place in what is recorded and shown.
#[test]
fn two_lasers_on_one_robot_are_two() {
    let text = include_str!("../../../missions/laser-ward.toml");
    let second = "[[robots.lasers]]\nname = \"back\"\nkind = \"ld06\"\nat_m = [-0.2, 0.0]\nyaw_deg = 180.0\n[robots.mind]";
    let text = text.replace("[robots.mind]", second);
    let mut run = Run::new(Mission::parse("mission", &text, &[]).unwrap(), RunSeed(1)).unwrap();
    let links: Vec<(String, u32)> =
        run.scene().links.into_iter().map(|l| (l.name, l.baud)).collect();
    let wanted = [("robot", 9600), ("front", 38_400), ("back", 230_400), ("ground", 9600)];
    assert_eq!(links, wanted.map(|(name, baud)| (name.to_owned(), baud)));
    run.set_trace(true);
    steps(&mut run, 500);
    let told = run.drain_log().into_iter().filter(|l| l.text.contains("laser `"));
    assert_eq!(told.map(|l| l.text).collect::<Vec<_>>(), Vec::<String>::new(), "nothing is wrong");
    let trace = run.drain_trace();
    let told =
        |link: usize, words: &str| trace.iter().any(|t| t.link == link && t.text.contains(words));
    assert!(trace.iter().any(|t| t.link == 0), "the base");
    assert!(told(1, "SCAN of 181"), "the SICK's telegrams in words");
    assert!(told(2, "POINTS from"), "the LD06's packets in words");
    let view = run.view();
    let scans: Vec<(usize, usize)> =
        view.robots[0].scans.iter().map(|s| (s.scanner, s.ranges_m.len())).collect();
    assert_eq!(scans, [(0, 181), (1, 450)]);
    assert!(view.robots[0].scans.iter().all(|s: &ViewScan| s.ranges_m.iter().any(|&r| r > 0.0)));
}

#[test]
fn lasers_that_cannot_be_are_refused_with_words() {
    let twice = include_str!("../../../missions/create-scan.toml").replace(
        "[robots.mind]",
        "[[robots.lasers]]\nname = \"head\"\nkind = \"sick\"\n[robots.mind]",
    );
    let twice = Mission::parse("mission", &twice, &[]).unwrap_err().to_string();
    assert!(
        twice.contains("robots[0].lasers[1].name")
            && twice.contains("robots[0].lasers[0] has this one"),
        "{twice}"
    );
    let found = [
        refused(&["robots.lasers.kind=hokuyo"]),
        refused(&["robots.lasers.at_m=[0.9, 0.0]"]),
        refused(&["robots.lasers.name=ground"]),
        refused(&["robots.lasers.line.baud=57600"]),
        refused(&["robots.lasers.line.kind=tcp", "robots.lasers.line.address=1.2.3.4:5"]),
    ];
    expect![[r#"
        --set robots.lasers.kind=hokuyo: robots[0].lasers[0].kind = "hokuyo": must be one of `sick`, `rplidar`, `ld06`
        --set robots.lasers.at_m=[0.9, 0.0]: robots[0].lasers[0].at_m = [0.9, 0]: must be a place on the robot: the outline of Pioneer 3-DX reaches from -0.30 to 0.21 m along x, from -0.21 to 0.21 m along y
        --set robots.lasers.name=ground: robots[0].lasers[0].name = "ground": must be another name: this is the word for another line of the robot
        --set robots.lasers.line.baud=57600: robots[0].lasers[0].line.baud = 57600: must be 9600, 19200, 38400 or 500000, which a SICK can speak at
        --set robots.lasers.line.kind=tcp: robots[0].lasers[0].line.kind = "tcp": must be `memory` or `direct`, as the robot's own line: it is simulated here"#]].assert_eq(&found.join("\n"));
}

#[test]
fn with_lasers_a_run_allocates_nothing() {
    for overrides in [
        &["robots.lasers.kind=sick"][..],
        &["robots.lasers.kind=rplidar"],
        &["robots.lasers.kind=ld06"],
        &["robots.lasers.kind=ld06", "robots.lasers.line.kind=direct"],
    ] {
        let mut run = run("laser-ward", overrides, 1);
        steps(&mut run, 1200);
        let second = |run: &mut Run| allocation_counter::measure(|| steps(run, 100)).count_total;
        let quietest = (0..6).map(|_| second(&mut run)).min().unwrap();
        assert_eq!(quietest, 0, "{overrides:?}");
    }
}

/// A swarm with lasers, on one thread and on four: the same bits.
#[test]
fn threads_change_nothing_with_lasers() {
    let text = include_str!("../../../missions/swarm.toml");
    let laser = "[[robots.lasers]]\nname = \"head\"\nkind = \"ld06\"\n[robots.lasers.line]\nkind = \"direct\"\n[robots.mind]";
    let text = text.replacen("[robots.mind]", laser, 1);
    let few = ["robots.count=24".to_owned(), "robots.row_length=6".to_owned()];
    let mission = Mission::parse("mission", &text, &few).unwrap();
    let with_threads = |n: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
        pool.install(|| {
            let mut run = Run::new(mission.clone(), RunSeed(1)).unwrap();
            steps(&mut run, 300);
            assert!(run.view().robots.iter().all(|robot| robot.scans.len() == 1));
            run.state_hash()
        })
    };
    assert_eq!(with_threads(1), with_threads(4));
}
