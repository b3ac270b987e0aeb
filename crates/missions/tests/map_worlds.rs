//! Missions whose world is a map: where the walls come from, and what is said of maps that are wrong.

#![expect(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::{fs, path::Path};

use geometry::{Ray, RayCaster, Vec2};
use missions::{Mission, Run, world_of};
use run_context::RunSeed;

/// 6 × 5 cells of 0.5 m: a room with a pillar; the lower right corner is not known.
const PICTURE: &str = "P2\n6 5\n255\n0 0 0 0 0 0\n0 254 254 254 254 0\n0 254 254 0 254 0\n\
                       0 254 254 254 205 205\n0 0 0 0 205 205\n";
const YAML: &str = "# A room\nimage: room.pgm\nresolution: 0.5\norigin: [-1.0, -2.0, 0.0]\nnegate: 0\n\
                    occupied_thresh: 0.65\nfree_thresh: 0.196\n";

const MISSION: &str = "[mission]\nname = \"room\"\n[world]\nmap = \"maps/room.yaml\"\n[[robots]]\n\
                       name = \"r\"\nmodel = \"pioneer3dx\"\nstart = [0.0, -0.5, 90.0]\n\
                       [robots.mind]\nhow.method = \"straight\"\n";

struct Place(tempfile::TempDir);

impl Place {
    fn new() -> Self {
        let place = Self(tempfile::tempdir().unwrap());
        fs::create_dir(place.0.path().join("maps")).unwrap();
        place.write("maps/room.pgm", PICTURE);
        place.write("maps/room.yaml", YAML);
        place.write("room.toml", MISSION);
        place
    }

    fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        fs::write(self.0.path().join(name), content).unwrap();
    }

    fn load(&self, overrides: &[&str]) -> Result<Mission, String> {
        let overrides: Vec<String> = overrides.iter().map(ToString::to_string).collect();
        let path = self.0.path().join("room.toml");
        let folder = format!("{}/", self.0.path().display());
        Mission::load(path.to_str().unwrap(), &overrides)
            .map_err(|error| error.to_string().replace(&folder, ""))
    }
}

/// From a place along x and y, metres.
fn sight(mission: &Mission, x: f64, y: f64) -> (f64, f64) {
    let (world, _) = world_of(mission, mission.seed()).unwrap();
    let look = |direction| {
        let ray = Ray { origin: Vec2::new(x, y), direction };
        world.static_map().cast(&ray, 99.0).map_or(99.0, |hit| hit.distance_m)
    };
    (look(Vec2::x()), look(Vec2::y()))
}

#[test]
fn the_walls_are_where_the_map_has_them() {
    let place = Place::new();
    let mission = place.load(&[]).unwrap();
    // Free from (-0.5, -1.5) on; the pillar from (0.5, -1) to (1, -0.5).
    assert_eq!(sight(&mission, 0.0, -0.75), (0.5, 0.75));
    assert_eq!(sight(&mission, 0.0, -1.25), (1.0, 1.25));
    // All of the map is drawn, with half a metre around it.
    let drawn = Run::new(mission, RunSeed(1)).unwrap().scene().bounds_m;
    assert_eq!(drawn.map(|m| (100.0 * m).round() as i64), [-150, -250, 250, 100]);
    let open = place.load(&["world.unknown=free"]).unwrap();
    assert_eq!(sight(&open, 0.0, -1.25), (99.0, 1.25));
    // A quarter turn about its own frame's origin, and 1 m to the right.
    let turned = place.load(&["world.map_at=[1, 0, 90]", "robots.start=[1.5,0,0]"]).unwrap();
    let (along, aside) = sight(&turned, 1.75, 0.0);
    assert!((along - 0.75).abs() < 1e-12 && (aside - 0.5).abs() < 1e-12, "{along} {aside}");
    // Walls of the mission itself are added.
    let wall = "[[world.walls]]\nline_m = [[0.375, -2.0], [0.375, 2.0]]\n[[robots]]";
    place.write("room.toml", MISSION.replace("[[robots]]", wall));
    assert_eq!(sight(&place.load(&[]).unwrap(), 0.125, -0.75), (0.25, 0.75));
    let said = place.load(&["robots.start=[0.2, -0.5, 90]"]).unwrap_err();
    assert!(said.contains("touches no wall"), "{said}");
}

#[test]
fn a_resolved_mission_carries_its_map() {
    let place = Place::new();
    let mission = place.load(&["world.unknown=free"]).unwrap();
    let read: Vec<_> =
        mission.read_from().iter().map(|p| p.file_name().unwrap().to_owned()).collect();
    assert_eq!(read, ["room.toml", "room.yaml", "room.pgm"]);
    let text = mission.to_toml();
    let again = Mission::parse("again", &text, &[]).unwrap();
    assert_eq!(again.to_toml(), text);
    assert_eq!(sight(&again, 0.0, -1.25), sight(&mission, 0.0, -1.25));
}

#[test]
fn maps_of_lines_and_of_letters_are_worlds_too() {
    let place = Place::new();
    place.write("maps/room.yaml", "2D-Map-Ex\nLINES\n2000 -1000 2000 1000\n");
    assert_eq!(sight(&place.load(&[]).unwrap(), 0.0, 0.0), (2.0, 99.0));
    place.write("maps/room.yaml", "type octile\nheight 3\nwidth 3\nmap\n@@@\n@.@\n@@@\n");
    let said = place.load(&["world.map_at=[-1.5,-1.5,0]", "robots.start=[0,0,0]"]).unwrap();
    assert_eq!(sight(&said, 0.0, 0.0), (0.5, 0.5));
    assert!(said.warnings().iter().any(|w| w.contains("world.map") && w.contains("1 m is taken")));
    let large = place
        .load(&["world.map_at=[-4.5,-4.5,0]", "world.map_cell_m=3", "robots.start=[0,0,0]"])
        .unwrap();
    assert_eq!(sight(&large, 0.0, 0.0), (1.5, 1.5));
    assert!(large.warnings().iter().all(|w| !w.contains("world.map")));
}

#[test]
fn nobody_starts_within_what_is_solid() {
    let place = Place::new();
    // Outside of the walls there is only what nobody knows.
    let said = place.load(&["robots.start=[50, 50, 0]"]).unwrap_err();
    assert!(said.contains("robots[0].start") && said.contains("free space of the map"), "{said}");
    assert!(place.load(&["robots.start=[50, 50, 0]", "world.unknown=free"]).is_ok());
}

/// A change to a file, and what is said then.
fn check(file: &str, from: &str, to: &str, words: &[&str]) {
    let place = Place::new();
    let whole = fs::read_to_string(place.0.path().join(file)).unwrap();
    assert!(whole.contains(from), "{from}");
    place.write(file, whole.replacen(from, to, 1));
    let said = place.load(&[]).unwrap_err();
    for word in words {
        assert!(said.contains(word), "{word:?} is not in {said:?}");
    }
}

#[test]
fn a_map_that_is_wrong_is_named_with_its_line() {
    let yaml = "maps/room.yaml";
    let picture = "maps/room.pgm";
    let image = ["maps/room.yaml:2:1: world.map", "\"room.pgm\"", "whole PGM or PNG"];
    let with_image = |more: &'static str| [&image[..], &[more]].concat();
    check(
        yaml,
        "0.5",
        "0.00001",
        &["maps/room.yaml:3:1", "`0.00001`", "more than 0.0001 and at most 10"],
    );
    check(yaml, "0.5", "11", &["maps/room.yaml:3:1", "`11`"]);
    check(yaml, "negate: 0\n", "", &["maps/room.yaml:6:1", "negate"]);
    check(
        yaml,
        "room.pgm",
        "hall.pgm",
        &["maps/room.yaml:2:1", "\"hall.pgm\"", "hall.pgm: No such file"],
    );
    check(picture, "6 5", "6 4", &with_image("PGM"));
    check(picture, "6 5", "6 6", &with_image("cut short"));
    check(picture, "P2", "P3", &with_image("P5 or P2"));
    check(picture, "255", "999", &with_image("at most 255"));
    check(
        picture,
        PICTURE,
        "P2\n1 1\n255\n0\n",
        &["maps/room.yaml", "1 × 1 cells", "at least 2 × 2"],
    );
    check(picture, PICTURE, "P2\n2 2\n255\n0 0 0 0\n", &["none of the 4 cells is free", "negate"]);
    check(
        yaml,
        "[-1.0, -2.0, 0.0]",
        "[90000.0, 0, 0]",
        &["maps/room.yaml: world.map", "within 10000 m"],
    );
}

#[test]
fn a_key_about_a_map_that_is_wrong_is_named_where_it_stands() {
    let mission = "room.toml";
    check(
        mission,
        "room.yaml",
        "room.pgm",
        &["room.toml:4:7: world.map", "the YAML beside the picture"],
    );
    check(
        mission,
        "room.yaml",
        "hall.yaml",
        &["room.toml:4:7: world.map", "hall.yaml: No such file"],
    );
    check(
        mission,
        "room.yaml",
        "room.map.gz",
        &["room.toml:4:7", "gunzip --keep maps/room.map.gz"],
    );
    check(
        mission,
        "[[robots]]",
        "unknown = \"solid\"\n[[robots]]",
        &["room.toml:5:11", "one of `wall`, `free`"],
    );
    check(
        mission,
        "[[robots]]",
        "map_cell_m = 0.1\n[[robots]]",
        &["world.map_cell_m", "absent: the map itself"],
    );
    check(
        mission,
        "map = \"maps/room.yaml\"",
        "map_cell_m = 0.1",
        &["room.toml:4:14", "no world.map"],
    );
    check(mission, "[[robots]]", "map_at = [0, 0, 400]\n[[robots]]", &["world.map_at"]);
}

#[test]
fn shipped_missions_find_their_maps_everywhere() {
    for name in Mission::shipped() {
        let mission = Mission::load(name, &[]).unwrap();
        assert!(mission.read_from().is_empty());
        let again = Mission::parse(name, &mission.to_toml(), &[]).unwrap();
        assert_eq!(again.to_toml(), mission.to_toml());
    }
    assert!(Path::new("/").is_absolute());
}
