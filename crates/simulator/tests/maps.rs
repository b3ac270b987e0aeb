//! The map reader and writer, on real maps and on broken ones.

#![expect(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::{fmt::Write, fs, io::Read};

use expect_test::{Expect, expect};
use geometry::{RayCaster, Vec2};
use proptest::prelude::*;
use simulator::activmedia_map::{MapFile, MapWarning, parse};

/// A data file's text, or `None` with a line that says so.
fn data(name: &str) -> Option<String> {
    let path = testkit::data_folder(&format!("maps/{name}"))?;
    let bytes = fs::read(&path).unwrap();
    let mut text = String::new();
    if path.extension().is_some_and(|e| e == "gz") {
        flate2::read::GzDecoder::new(&bytes[..]).read_to_string(&mut text).unwrap();
    } else {
        text = String::from_utf8(bytes).unwrap();
    }
    Some(text)
}

fn check_summary(name: &str, expected: &Expect) {
    let Some(text) = data(name) else { return };
    let map = parse(&text).unwrap();
    let bounds = map.to_segment_world().bounds();
    let home = map.home.map(|h| (h.x_m, h.y_m, h.yaw_rad.to_degrees().round()));
    expected.assert_eq(&format!(
        "{} lines, {} points, {} things, home {home:?}, x {:.3} to {:.3}, y {:.3} to {:.3}, {:?}",
        map.lines.len(),
        map.points.len(),
        map.things.len(),
        bounds.min.x,
        bounds.max.x,
        bounds.min.y,
        bounds.max.y,
        map.warnings,
    ));
    // Written and read again, it is the same map.
    assert_eq!(parse(&map.to_string()).unwrap(), map);
}

#[test]
fn the_four_public_maps_are_read() {
    check_summary(
        "triangle.map",
        &expect![
            "9 lines, 0 points, 1 things, home Some((5.09, 3.58, 54.0)), x 0.000 to 10.260, y 0.000 to 10.080, []"
        ],
    );
    check_summary(
        "office.map",
        &expect![
            "101 lines, 0 points, 1 things, home Some((1.0, 1.498, 0.0)), x 0.000 to 18.760, y 0.000 to 14.000, []"
        ],
    );
    check_summary(
        "ActivMediaLab.map",
        &expect![
            "71 lines, 0 points, 1 things, home Some((7.76, 0.675, 0.0)), x 0.000 to 12.640, y 0.000 to 5.759, []"
        ],
    );
    check_summary(
        "columbia.map.gz",
        &expect![
            "470 lines, 63311 points, 25 things, home Some((-0.182, 0.176, 0.0)), x -4.790 to 19.570, y -27.010 to 24.690, []"
        ],
    );
}

#[test]
fn columbia_has_its_goals_and_areas() {
    let Some(text) = data("columbia.map.gz") else { return };
    let map = parse(&text).unwrap();
    assert_eq!(map.resolution_m, Some(0.02));
    let door = map.things_of("GoalWithHeading").next().unwrap();
    assert_eq!((door.name.as_str(), door.pose.x_m, door.pose.y_m), ("Lobby door", -1.86, -22.44));
    assert!((door.pose.yaw_rad.to_degrees() + 48.5763).abs() < 1e-9);
    let area = map.things_of("ForbiddenArea").next().unwrap();
    assert_eq!(area.outline()[0], Vec2::new(-4.54, -10.8));
    assert_eq!(area.outline()[2], Vec2::new(-3.08, -7.78));
    assert!(map.info.iter().any(|(key, text)| key == "MapInfo" && text.contains("BadGPS")));
}

const SMALL: &str = "2D-Map\nNumLines: 1\nCairn: RobotHome 100 -200 90 \"\" ICON \"Home base\"\n\
                     LINES\n0 0 2500 0\nDATA\n1000 500\n";

#[test]
fn a_small_map_is_what_it_says() {
    let map = parse(SMALL).unwrap();
    assert_eq!(map.lines[0].b, Vec2::new(2.5, 0.0));
    assert_eq!(map.points, [Vec2::new(1.0, 0.5)]);
    let home = map.home.unwrap();
    assert_eq!((home.x_m, home.y_m), (0.1, -0.2));
    assert!((home.yaw_rad - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
    assert_eq!(map.things[0].name, "Home base");
    // A point is a square of 20 mm unless the resolution says otherwise.
    let world = map.to_segment_world();
    let ray = geometry::Ray { origin: Vec2::new(0.0, 0.5), direction: Vec2::x() };
    assert!((world.cast(&ray, 5.0).unwrap().distance_m - 0.99).abs() < 1e-9);
    // Line ends, a byte order mark and blank lines do not matter.
    let windows = format!("\u{feff}{}", SMALL.replace('\n', "\r\n\r\n"));
    assert_eq!(parse(&windows).unwrap(), map);
}

#[test]
fn sections_may_be_missing_or_empty_or_in_the_other_order() {
    assert_eq!(parse("2D-Map").unwrap(), MapFile::default());
    assert_eq!(parse("2D-Map\nLINES\nDATA\n").unwrap(), MapFile::default());
    assert!(parse("2D-Map\n").unwrap().to_segment_world().is_empty());
    let turned = parse("2D-Map\nDATA\n1 2\nLINES\n0 0 1 1\n").unwrap();
    assert_eq!((turned.points.len(), turned.lines.len()), (1, 1));
}

#[test]
fn more_than_stated_is_a_warning_and_a_line_without_length_is_left_out() {
    let map = parse("2D-Map\nNumLines: 1\nLINES\n0 0 1 1\n5 5 5 5\n").unwrap();
    assert_eq!(
        map.warnings,
        [
            MapWarning::EmptyLine { line: 5 },
            MapWarning::MoreThanStated { key: "NumLines".to_owned(), stated: 1, found: 2 },
        ]
    );
    assert_eq!((map.lines.len(), map.to_segment_world().len()), (2, 1));
}

fn check(text: &str, expected: &Expect) {
    expected.assert_eq(&parse(text).unwrap_err().to_string());
}

#[test]
fn broken_maps_are_refused_with_the_line_and_what_is_allowed() {
    check(
        "",
        &expect![
            "line 1: found ``, expected `2D-Map` or one of `2D-Map-Ex` to `2D-Map-Ex4`: this is no ActivMedia 2-D map"
        ],
    );
    check(
        "Logfile v2\nLINES\n",
        &expect![
            "line 1: found `Logfile v2`, expected `2D-Map` or one of `2D-Map-Ex` to `2D-Map-Ex4`: this is no ActivMedia 2-D map"
        ],
    );
    check(
        "2D-Map\nLINES\n0 0 x 1\n",
        &expect!["line 3: x2 is `x`, expected a number from -1e9 to 1e9"],
    );
    check(
        "2D-Map\nLINES\n0 0 1\n",
        &expect!["line 3: y2 is missing: expected `x1 y1 x2 y2` in mm, `DATA` or the end"],
    );
    check(
        "2D-Map\nLINES\n0 0 1 1 1\n",
        &expect!["line 3: found `1`, expected `x1 y1 x2 y2` in mm, `DATA` or the end"],
    );
    check(
        "2D-Map\nLINES\n0 0 NaN 1\n",
        &expect!["line 3: x2 is `NaN`, expected a number from -1e9 to 1e9"],
    );
    check(
        "2D-Map\nLINES\n0 0 1e300 1\n",
        &expect!["line 3: x2 is `1e300`, expected a number from -1e9 to 1e9"],
    );
    check(
        "2D-Map\nDATA\n5 inf\n",
        &expect!["line 3: y is `inf`, expected a number from -1e9 to 1e9"],
    );
    check(
        "2D-Map\nNumLines: 2\nLINES\n0 0 1 1\n",
        &expect!["NumLines states 2, but the file has 1: it was probably cut short"],
    );
    check(
        "2D-Map\nNumPoints: -3\n",
        &expect!["line 2: NumPoints is `-3`, expected a whole number, 0 or more"],
    );
    check(
        "2D-Map\nNumPoints: 3\nNumPoints: 3\n",
        &expect!["line 3: `NumPoints` was already given: keep one"],
    );
    check("2D-Map\nLINES\nLINES\n", &expect!["line 3: `LINES` was already given: keep one"]);
    check(
        "2D-Map\nResolution: 0\n",
        &expect!["line 2: the resolution is `0`, expected a length above 0 mm"],
    );
}

#[test]
fn broken_headers_are_refused_likewise() {
    check(
        "2D-Map\nno colon here\n",
        &expect!["line 2: found `no colon here`, expected `Key: values`, `LINES` or `DATA`"],
    );
    check(
        "2D-Map\nCairn: Goal 1 2\n",
        &expect![[
            r#"line 2: th is missing: expected `TYPE x y th "description" ICON "name" [x1 y1 x2 y2]`"#
        ]],
    );
    check(
        "2D-Map\nCairn: Goal 1 2 0 desc ICON \"a\"\n",
        &expect![[
            r#"line 2: found `desc`, expected `TYPE x y th "description" ICON "name" [x1 y1 x2 y2]`"#
        ]],
    );
    check(
        "2D-Map\nCairn: Goal 1 2 0 \"\" ICON \"a\n",
        &expect!["line 2: a quotation mark at column 27 is not closed"],
    );
    check(
        "2D-Map\nCairn: ForbiddenLine 1 2 0 \"\" ICON \"a\" 1 2\n",
        &expect![[
            r#"line 2: x2 is missing: expected `TYPE x y th "description" ICON "name" [x1 y1 x2 y2]`"#
        ]],
    );
}

proptest! {
    #[test]
    fn no_text_makes_it_panic(text in "\\PC{0,200}") {
        let outcome = parse(&text);
        prop_assert!(outcome.is_err() || text.contains("2D-Map"));
    }

    #[test]
    fn no_damage_makes_it_panic(cut in 0_usize..160, noise in "[\\PC\n]{0,8}", keep in 0_usize..160) {
        let head: String = SMALL.chars().take(cut).collect();
        let tail: String = SMALL.chars().skip(keep).collect();
        if let Ok(map) = parse(&format!("{head}{noise}{tail}")) {
            let finite = map.lines.iter().all(|l| l.length().is_finite());
            prop_assert!(finite && map.points.iter().all(|p| p.norm().is_finite()));
        }
    }

    #[test]
    fn written_maps_are_read_back(
        lines in proptest::collection::vec((-9999..9999, -9999..9999, -9999..9999, -9999..9999), 0..20),
        points in proptest::collection::vec((-99_999..99_999, -99_999..99_999), 0..20),
        name in "[a-zA-Z0-9 ]{0,12}",
    ) {
        let mut text = format!("2D-Map\nResolution: 25\nCairn: Goal 5 6 0 \"x\" ICON \"{name}\"\nLINES\n");
        for (a, b, c, d) in lines {
            writeln!(text, "{a} {b} {c} {d}").unwrap();
        }
        text += "DATA\n";
        for (x, y) in points {
            writeln!(text, "{x} {y}").unwrap();
        }
        let mut map = parse(&text).unwrap();
        map.warnings.clear();
        let mut again = parse(&map.to_string()).unwrap();
        again.warnings.clear();
        prop_assert_eq!(map, again);
    }
}

#[test]
fn the_later_kinds_of_map_are_read_alike() {
    let plain = parse(SMALL).unwrap();
    for category in ["2D-Map-Ex", "2D-Map-Ex2", "2D-Map-Ex3", "2D-Map-Ex4"] {
        let later = SMALL.replacen("2D-Map", category, 1);
        assert_eq!(parse(&later).unwrap(), plain, "{category}");
        // More kinds of header lines are kept as they are.
        let more = later.replacen("LINES", "ChildCairn: Goal 1 2 3 \"\" ICON \"g\"\nLINES", 1);
        assert_eq!(parse(&more).unwrap().info[0].0, "ChildCairn");
    }
    for none in ["2D-Map-Ex5", "2D-Map-", "2d-map", "2D-MapEx"] {
        let said = parse(&SMALL.replacen("2D-Map", none, 1)).unwrap_err().to_string();
        assert!(said.contains(none) && said.contains("`2D-Map-Ex4`"), "{said}");
    }
}

#[test]
fn a_map_of_several_scanners_has_all_of_their_walls() {
    let text = "2D-Map-Ex2\nSources: SickLaser Front\nNumLines: 1\nFrontNumLines: 1\n\
                FrontNumPoints: 1\nResolution: 20\nFrontResolution: 50\nLINES\n0 0 1000 0\n\
                Front_LINES\n0 0 0 1000\nFront_DATA\n500 500\n";
    let map = parse(text).unwrap();
    assert_eq!((map.lines.len(), map.points.len()), (2, 1));
    assert_eq!(map.resolution_m, Some(0.05));
    let named = MapWarning::Sources { names: "SickLaser, Front".to_owned() };
    assert_eq!(map.warnings, [named]);
    let wrong = |from: &str, to: &str| {
        let text = text.replacen(from, to, 1);
        parse(&text).unwrap_err().to_string()
    };
    assert!(wrong("FrontNumPoints: 1", "FrontNumPoints: 2").contains("FrontNumPoints states 2"));
    assert!(wrong("Front_DATA", "Front_LINES").contains("line 12: `Front_LINES` was already"));
    let rear = wrong("Front_LINES", "Rear_LINES");
    assert!(rear.contains("line 10: x1 is `Rear_LINES`"), "{rear}");
    assert!(wrong("Sources: SickLaser Front", "Sources:").contains("from 1 to 32 names"));
    assert!(wrong("NumLines: 1\n", "Sources: A\n").contains("`Sources` was already given"));
    // Counts may stand before the sources.
    let moved = text.replacen(
        "Sources: SickLaser Front\nNumLines: 1",
        "NumLines: 2\nSources: SickLaser Front",
        1,
    );
    assert!(parse(&moved).unwrap_err().to_string().contains("NumLines states 2"));
    // Sections without a name, where the usual source is not among those named.
    assert_eq!(parse("2D-Map-Ex\nSources: A\nLINES\n0 0 1 1\n").unwrap().lines.len(), 1);
}
