//! `cairn plan` as people use it.

mod support;

use support::Place;

const HALL: &str = "type octile\nheight 6\nwidth 9\nmap\n@@@@@@@@@\n@.......@\n@.@@@@@.@\n@.@...@.@\n@.@...@.@\n@@@@@@@@@\n";

#[test]
fn a_way_is_told_drawn_and_refused_to_overwrite() {
    let place = Place::new();
    let plan =
        |rest: &str| place.cairn(&format!("plan doorbell --from -4.3,-3.9 --to study {rest}"));
    let told = plan("--robot pioneer3dx --format json --svg way.svg").json();
    assert_eq!(told["outcome"], "found");
    let length_m = told["length_m"].as_f64().unwrap();
    let straight_m = (6.25_f64).hypot(7.8);
    assert!((straight_m..1.5 * straight_m).contains(&length_m), "{told}");
    assert!(told["clearance_min_m"].as_f64().unwrap() >= 0.32, "{told}");
    let points = told["points"].as_array().unwrap();
    assert_eq!(points[0], serde_json::json!([-4.3, -3.9]));
    // No piece of it crosses a wall of the world itself.
    let mission = missions::Mission::load("doorbell", &[]).unwrap();
    let (world, _) = missions::world_of(&mission, mission.seed()).unwrap();
    let place_of = |point: &serde_json::Value| {
        geometry::Vec2::new(point[0].as_f64().unwrap(), point[1].as_f64().unwrap())
    };
    for pair in points.windows(2) {
        assert!(!world.static_map().is_blocked(place_of(&pair[0]), place_of(&pair[1])), "{pair:?}");
    }
    let summed: f64 = points
        .windows(2)
        .map(|pair| {
            let d = |k: usize| pair[1][k].as_f64().unwrap() - pair[0][k].as_f64().unwrap();
            d(0).hypot(d(1))
        })
        .sum();
    // The ends are moved from the middles of their cells to where they were asked for.
    assert!((summed - length_m).abs() < 0.1, "{summed} {length_m}");
    let svg = std::fs::read_to_string(place.path("way.svg")).unwrap();
    assert!(svg.starts_with("<svg") && svg.contains("<polyline") && svg.contains("data:image/png"));
    plan("--svg way.svg").refused(2, &["way.svg", "--force"]);
    assert!(plan("--svg way.svg --force").out.contains("m in"), "a table");
    // Straight lines are shorter.
    let any = plan("--robot pioneer3dx --method any-angle --format json").json();
    assert!(any["length_m"].as_f64().unwrap() < length_m, "{any}");
    assert!(any["length_m"].as_f64().unwrap() >= straight_m - 0.1, "{any}");
}

#[test]
fn why_there_is_no_way_is_said() {
    let place = Place::new();
    std::fs::write(place.path("hall.map"), HALL).unwrap();
    let plan = |rest: &str| place.cairn(&format!("plan hall.map {rest}"));
    plan("--from 1.5,1.5 --to 4.5,2.5")
        .refused(1, &["no way leads to (4.50, 2.50)", "(4.50, 4.50)"]);
    plan("--from 1.5,1.5 --to 0.5,0.5")
        .refused(1, &["the goal (0.50, 0.50) is solid", "(1.50, 1.50)"]);
    plan("--from 1.5,1.5 --to 99,0").refused(1, &["is outside of the map"]);
    plan("--from 0.5,0.5 --to 1.5,1.5").refused(1, &["the start (0.50, 0.50) is solid"]);
    plan("--from 1.5,1.5 --to 7.5,1.5 --radius 0.6")
        .refused(1, &["no room for a radius of 0.60 m"]);
    let told = plan("--from 1.5,1.5 --to 4.5,2.5 --format json").json();
    assert_eq!(
        (told["outcome"].as_str(), &told["nearest"]),
        (Some("unreachable"), &serde_json::json!([4.5, 4.5]))
    );
    let found = plan("--from 1.5,1.5 --to 7.5,1.5 --format json").json();
    // Up, across, down: 3 + 6 + 3 cells of 1 m.
    assert!((found["length_m"].as_f64().unwrap() - 12.0).abs() < 1e-9, "{found}");
    plan("--from 1.5 --to 7.5,1.5").refused(2, &["--from 1.5", "names no rooms"]);
    place.cairn("plan doorbell --from 0,0 --to nowhere").refused(2, &["Living room", "Study"]);
    place.cairn("plan nosuch.map --from 0,0 --to 1,1").refused(2, &["nosuch.map"]);
}

#[test]
fn a_scenario_is_run_and_wrong_lengths_are_named() {
    let place = Place::new();
    std::fs::write(place.path("hall.map"), HALL).unwrap();
    let scenario = |length: &str, size: &str| {
        let text = format!("version 1\n0\thall.map\t{size}\t1\t4\t7\t4\t{length}\n");
        std::fs::write(place.path("hall.map.scen"), text).unwrap();
    };
    for method in ["astar", "jps", "any-angle"] {
        scenario("12.00000000", "9\t6");
        let told = place
            .cairn(&format!("plan --scenario hall.map.scen --method {method} --format json"))
            .json();
        assert_eq!((&told["instances"], &told["wrong"]), (&1.into(), &0.into()), "{told}");
        assert!(told["p99_us"].as_f64().unwrap() >= told["p50_us"].as_f64().unwrap(), "{told}");
    }
    scenario("11.5", "9\t6");
    let wrong = place.cairn("plan --scenario hall.map.scen");
    assert!(wrong.err.contains("line 2: found 12.00000, expected 11.5"), "{}", wrong.err);
    assert_eq!(wrong.code, 1);
    scenario("12.0", "8\t6");
    place.cairn("plan --scenario hall.map.scen").refused(2, &["line 2", "8 × 6", "9 × 6"]);
    std::fs::remove_file(place.path("hall.map")).unwrap();
    place.cairn("plan --scenario hall.map.scen").refused(2, &["hall.map", "beside"]);
}
