//! The built-in robots against their published figures, and what a wrong file is answered with.

use super::*;
use expect_test::{Expect, expect};

fn pioneer() -> RobotModel {
    RobotModel::by_name("pioneer3dx").unwrap()
}

#[test]
fn every_built_in_file_is_read() {
    for text in FILES {
        RobotModel::from_toml(text).unwrap();
    }
    let names: Vec<String> = RobotModel::catalogue().into_iter().map(|m| m.name).collect();
    assert_eq!(names, ["pioneer3dx", "peoplebot", "artemic5", "artemic8", "create2"]);
}

/// Figures of the robots' public parameter files.
#[test]
fn the_pioneer_is_the_pioneer() {
    let model = pioneer();
    let bounds = model.footprint.bounds();
    let line = model.line.unwrap();
    assert_eq!((&*line.protocol, &*line.class, &*line.subclass), ("arcos", "Pioneer", "p3dx-sh"));
    assert_eq!((line.baud, line.watchdog), (9600, Some(Duration::from_secs(2))));
    assert_eq!((bounds.max.x, bounds.min.x), (0.210, -0.301));
    assert_eq!((bounds.max.y, bounds.min.y), (0.2125, -0.2125));
    assert!((model.radius_m - 0.25).abs() < 1e-12);
    assert!((model.drive.wheelbase_m - 0.38).abs() < 1e-12);
    assert!((model.limits.speed_max_mps - 2.2).abs() < 1e-12);
    assert!((model.limits.turn_rate_max_radps - 8.7266).abs() < 1e-4);
    let third = model.sonars[3].base_from_sensor.se2();
    assert_eq!((third.x_m, third.y_m), (0.166, 0.027));
    assert!((third.yaw_rad - 10.0_f64.to_radians()).abs() < 1e-12);
}

#[test]
fn the_peoplebot_has_the_same_wheels_and_a_second_pair_of_rings() {
    let model = RobotModel::by_name("peoplebot").unwrap();
    assert_eq!(model.drive, pioneer().drive);
    assert_eq!(model.sonars[..16], pioneer().sonars[..]);
    assert_eq!(model.sonars.len(), 32);
    let place = |i: usize| model.sonars[i].base_from_sensor.se2();
    assert_eq!((place(16).x_m, place(28).x_m), (-0.020, -0.290));
    assert!((model.footprint.bounds().size().x - 0.513).abs() < 1e-9);
}

/// Measures of the thesis on ARTEMIC and of its program.
#[test]
fn artemic_is_artemic() {
    let five = RobotModel::by_name("artemic5").unwrap();
    let eight = RobotModel::by_name("artemic8").unwrap();
    for model in [&five, &eight] {
        // One pulse is 1.00531 mm; wheels of 160 mm, 370 mm apart.
        assert!((model.drive.metres_per_tick() - 1.005_310e-3).abs() < 1e-9);
        assert!((model.drive.wheelbase_m - 0.37).abs() < 1e-12);
        assert_eq!(model.status_period, Duration::from_millis(50));
        assert_eq!((model.protocol(), pioneer().protocol()), (None, Some("arcos")));
    }
    assert_eq!(five.drive, eight.drive);
    assert_eq!(five.footprint, eight.footprint);
    let azimuths = |model: &RobotModel| -> Vec<i32> {
        let degrees = |m: &SonarMount| m.base_from_sensor.se2().yaw_rad.to_degrees();
        model.sonars.iter().map(|m| degrees(m).round() as i32).collect()
    };
    assert_eq!(azimuths(&five), [90, 45, 0, -45, -90]);
    // The program's ring is the front ring of a Pioneer.
    assert_eq!(eight.sonars, pioneer().sonars[..8]);
    // A chain of 49 ms a module.
    assert_eq!(five.ring.round(5), Duration::from_millis(245));
    assert_eq!(eight.ring.round(8), Duration::from_millis(392));
    assert_eq!(pioneer().ring.round(16), Duration::from_millis(320));
}

#[test]
fn rings_are_mirror_images_and_lie_inside_the_footprint() {
    for model in RobotModel::catalogue() {
        for (n_ring, ring) in model.sonars.chunks(8).enumerate() {
            for (i, (one, other)) in ring.iter().zip(ring.iter().rev()).enumerate() {
                let one = one.base_from_sensor.se2();
                let other = other.base_from_sensor.se2();
                assert_eq!((one.x_m, one.y_m), (other.x_m, -other.y_m), "{n_ring} {i}");
                let sum = geometry::wrap_to_pi(one.yaw_rad + other.yaw_rad);
                assert!(sum.abs() < 1e-9, "{n_ring} {i}");
            }
        }
        for mount in &model.sonars {
            let place = mount.base_from_sensor.se2().position();
            assert!(model.footprint.contains(place), "{} {place}", model.name);
        }
        assert!(model.bounding_radius_m() < 0.36);
    }
}

fn check(text: &str, expected: &Expect) {
    let outcome = RobotModel::from_toml(text).map_or_else(|e| e.to_string(), |m| m.title);
    expected.assert_eq(&outcome);
}

#[test]
fn wrong_files_are_refused_with_the_key_and_what_it_must_be() {
    let good = FILES[0];
    check(good, &expect!["Pioneer 3-DX"]);
    check(
        &good.replace("wheelbase_m = 0.380", "wheelbase_m = -1.0"),
        &expect!["drive.wheelbase_m = -1: must be from 0.01 to 5 m"],
    );
    check(
        &good.replace("gear_ratio = 38.3", "gear_ratio = nan"),
        &expect!["drive.gear_ratio = NaN: must be from 0.01 to 10000"],
    );
    check(
        &good.replace("number = 5\n", "number = 6\n"),
        &expect!["sonars: entry 5 has number 6: numbers must run from 0 without gaps"],
    );
    check(
        &good.replace("azimuth_deg = 50", "azimuth_deg = 500"),
        &expect!["sonars[1].azimuth_deg = 500: must be from -360 to 360 deg"],
    );
    check(
        &good.replace("[0.210, 0.120]", "[0.0, 0.0]"),
        &expect!["footprint_m: must be convex, but turns inwards at corner 1 (0, 0) m"],
    );
    check(
        &good.replace("title", "titel"),
        &expect![[r#"
            TOML parse error at line 6, column 1
              |
            6 | titel = "Pioneer 3-DX"
              | ^^^^^
            unknown field `titel`, expected one of `name`, `title`, `line`, `radius_m`, `status_period_ms`, `footprint_m`, `drive`, `limits`, `ring`, `sonars`, `mass_kg`, `bumpers`, `cliffs`, `infrareds`, `battery`
        "#]],
    );
}

#[test]
fn an_unknown_name_is_answered_with_the_known_ones() {
    assert_eq!(
        RobotModel::by_name("khepera").unwrap_err().to_string(),
        "unknown robot model `khepera`: the catalogue has `pioneer3dx`, `peoplebot`, `artemic5`, `artemic8`, `create2`"
    );
}

/// Figures of the Open Interface specification: 508.8 counts a turn, wheels of 72 mm, 235 mm apart.
#[test]
fn the_create_is_the_create() {
    let model = RobotModel::by_name("create2").unwrap();
    assert!((model.drive.metres_per_tick() - 0.444_56e-3).abs() < 1e-8);
    assert!((model.drive.wheelbase_m - 0.235).abs() < 1e-12);
    assert!((model.limits.speed_max_mps - 0.5).abs() < 1e-12);
    // Both wheels against each other at 500 mm/s.
    assert!((model.limits.turn_rate_max_radps - 1.0 / 0.235).abs() < 1e-3);
    let line = model.line.as_ref().unwrap();
    assert_eq!((&*line.protocol, line.baud, line.watchdog), ("create_oi", 115_200, None));
    let Devices { bumpers, cliffs, infrareds, battery } = &model.devices;
    assert_eq!((bumpers.len(), cliffs.len(), infrareds.len()), (2, 4, 7));
    assert!(battery.is_some() && model.sonars.is_empty());
    for pair in [(0, 3), (1, 2)] {
        let (one, other) = (cliffs[pair.0].place, cliffs[pair.1].place);
        assert_eq!((one.x, one.y), (other.x, -other.y));
        assert!(model.footprint.contains(one));
    }
    let ([right, left], [other_right, other_left]) =
        (bumpers[1].between_deg, bumpers[0].between_deg);
    assert_eq!((right, left), (-other_left, -other_right));
}

#[test]
fn wrong_lines_and_devices_are_refused_with_the_key() {
    let good = FILES[4];
    check(good, &expect!["iRobot Create 2"]);
    let wrong = |from: &str, to: &str, expected: &Expect| {
        assert!(good.contains(from), "{from}");
        check(&good.replacen(from, to, 1), expected);
    };
    wrong(
        "\"create_oi\"",
        "\"Create OI\"",
        &expect![
            "line.protocol = `Create OI`: must be a name of small letters, digits and `_`, such as `arcos`"
        ],
    );
    wrong(
        "baud = 115200",
        "baud = 10",
        &expect!["line.baud = 10: must be from 300 to 4000000 baud"],
    );
    wrong(
        "baud_min = 38400",
        "baud_min = 230400",
        &expect!["line.baud_min = 230400: must be from 300 baud to line.baud"],
    );
    wrong(
        "watchdog_ms = 0",
        "watchdog_ms = -1",
        &expect!["line.watchdog_ms = -1: must be from 0 (none) to 60000 ms"],
    );
    wrong(
        "left_deg = 15",
        "left_deg = -91",
        &expect!["bumpers[0].left_deg = -91: must be above right_deg by 1 to 179 deg"],
    );
    wrong("x_m = 0.070", "x_m = 7", &expect!["cliffs[0].x_m = 7: must be from -5 to 5 m"]);
    wrong(
        "empty_v = 12.0",
        "empty_v = 99",
        &expect!["battery.empty_v = 99: must be from 0.1 V to full_v"],
    );
    wrong("mass_kg = 3.58", "mass_kg = 0", &expect!["mass_kg = 0: must be from 0.01 to 10000 kg"]);
}
