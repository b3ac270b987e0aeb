//! Worlds from maps: what is solid in them, and what is said of those that are wrong.

#![expect(clippy::unwrap_used, reason = "a failing helper fails its test")]

use geometry::{Ray, RayCaster, Se2, SegmentWorld, Vec2};
use grid_maps::{
    Cell, CellBox, Lattice, RayMap, State, Window,
    files::{GreyImage, MapYaml, Mode},
};
use proptest::{collection::vec, prelude::*};
use simulator::floor_plan::{FloorPlan, FloorPlanRules, MapFormat, read};

const HERE: Se2 = Se2::IDENTITY;

fn rules(unknown_is_solid: bool, world_from_map: Se2) -> FloorPlanRules {
    FloorPlanRules { unknown_is_solid, cell_m: None, world_from_map }
}

fn world(plan: &FloorPlan) -> SegmentWorld {
    SegmentWorld::new(plan.walls.iter().map(|wall| (*wall, 0)))
}

/// A picture of greys, top row first, with the description, in one text.
fn text(width: usize, greys: &[u8], yaml: &MapYaml) -> String {
    let height = greys.len() / width;
    let picture = GreyImage::new(width, height, greys.to_vec(), None).unwrap();
    yaml.with_picture(&picture).unwrap().to_text()
}

fn said(text: &str) -> String {
    read(text, &rules(true, HERE)).unwrap_err().to_string()
}

proptest! {
    /// Oracle: a walk from cell to cell of the picture, in its own frame.
    #[test]
    fn rays_end_where_a_walk_through_the_cells_ends(
        greys in vec(prop_oneof![2 => Just(0_u8), 9 => Just(254), 1 => Just(205)], 20 * 15),
        (x, y, yaw) in (-9.0..9.0, -9.0..9.0, -3.0..3.0_f64),
        (map_x, map_y, map_yaw) in (-9.0..9.0, -9.0..9.0, -3.0..3.0_f64),
        from in vec((0.1..1.9, 0.1..1.4_f64, -3.1..3.1_f64), 30),
        unknown_is_solid: bool,
    ) {
        let yaml = MapYaml::new("x", 0.1, Se2::new(x, y, yaw));
        let world_from_map = Se2::new(map_x, map_y, map_yaw);
        let text = text(20, &greys, &yaml);
        let Ok(plan) = read(&text, &rules(unknown_is_solid, world_from_map)) else { return Ok(()) };
        let walls = world(&plan);
        let area = CellBox { min: Cell::new(0, 0), width: 20, height: 15 };
        let upwards: Vec<u8> = greys.chunks(20).rev().flatten().copied().collect();
        let solid = |grey: u8| grey == 0 || (grey == 205 && unknown_is_solid);
        let cells = Window::from_values(area, upwards).unwrap().map(solid);
        let oracle = RayMap::new(Lattice::new(Vec2::zeros(), 0.1).unwrap(), &cells, |c| c);
        let world_from_picture = world_from_map.compose(yaml.origin);
        for (x, y, angle) in from {
            let (from, direction) = (Vec2::new(x, y), Vec2::new(angle.cos(), angle.sin()));
            let origin = world_from_picture.transform_point(from);
            let cell = Cell::new((x * 10.0) as i32, (y * 10.0) as i32);
            prop_assert_eq!(plan.is_solid(origin), cells.get(cell).unwrap());
            if plan.is_solid(origin) {
                continue;
            }
            let ray = Ray { origin, direction: world_from_picture.rotate(direction) };
            let found = walls.cast(&ray, 1.0).map(|hit| hit.distance_m);
            if let Some(expected) = oracle.cast_ray(from, direction, 1.0) {
                let is_end = |found: f64| (found - expected).abs() < 1e-9;
                // At the very end of the range rounding decides.
                let agrees = found.is_some_and(is_end) || (expected - 1.0).abs() < 1e-9;
                prop_assert!(agrees, "{found:?} {expected}");
                continue;
            }
            // The frame of the picture is solid, too, where unknown space is.
            let is_frame = |found: f64| {
                let end = from + direction * found;
                let edge = |v: f64, size: f64| v.abs() < 1e-9 || (v - size).abs() < 1e-9;
                unknown_is_solid && (edge(end.x, 2.0) || edge(end.y, 1.5))
                    || (found - 1.0).abs() < 1e-9
            };
            prop_assert!(found.is_none_or(is_frame), "{found:?}");
        }
    }
}

/// 0 and 254 in the middle, 205 around.
const GREYS: [u8; 16] =
    [205, 205, 205, 205, 205, 0, 254, 205, 205, 254, 254, 205, 205, 205, 205, 205];

#[test]
fn unknown_space_is_wall_or_free_by_choice() {
    let yaml = MapYaml::new("x", 0.5, Se2::new(-1.0, -1.0, 0.0));
    let text = text(4, &GREYS, &yaml);
    // Of the four cells in the middle the upper left one is occupied.
    let plan = read(&text, &rules(true, HERE)).unwrap();
    assert_eq!((plan.format, plan.walls.len()), (MapFormat::MapServer, 6));
    assert!(plan.is_solid(Vec2::new(-0.2, 0.2)) && plan.is_solid(Vec2::new(0.9, 0.9)));
    assert!(!plan.is_solid(Vec2::new(0.2, 0.2)) && plan.is_solid(Vec2::new(77.0, 0.2)));
    assert_eq!((plan.extent.min, plan.extent.max), (Vec2::new(-1.0, -1.0), Vec2::new(1.0, 1.0)));
    let plan = read(&text, &rules(false, HERE)).unwrap();
    assert_eq!(plan.walls.len(), 4);
    assert!(plan.is_solid(Vec2::new(-0.2, 0.2)) && !plan.is_solid(Vec2::new(0.9, 0.9)));
    assert!(!plan.is_solid(Vec2::new(77.0, 0.2)) && plan.notes.is_empty());
}

#[test]
fn modes_thresholds_and_negatives_mean_what_the_map_server_means() {
    let solid_cells = |yaml: &MapYaml| {
        let plan = read(&text(4, &GREYS, yaml), &rules(false, HERE)).unwrap();
        let at = |i: i32| plan.is_solid(Vec2::new(f64::from(i % 4) + 0.5, f64::from(i / 4) + 0.5));
        (0..16).filter(|&i| at(i)).count()
    };
    let yaml = MapYaml::new("x", 1.0, HERE);
    assert_eq!(solid_cells(&yaml), 1);
    assert_eq!(solid_cells(&MapYaml { negate: true, ..yaml.clone() }), 15);
    assert_eq!(solid_cells(&MapYaml { negate: true, occupied_prob: 0.9, ..yaml.clone() }), 3);
    assert_eq!(solid_cells(&MapYaml { mode: Mode::Scale, ..yaml.clone() }), 1);
    // In raw maps a grey is its percentage: 0 is free, above 100 nobody knows.
    let plan = read(&text(4, &GREYS, &MapYaml { mode: Mode::Raw, ..yaml }), &rules(false, HERE));
    assert_eq!(plan.unwrap().notes, ["no cell of the map is occupied"]);
}

#[test]
fn a_grey_that_tools_mean_as_unknown_and_that_counts_as_free_is_told() {
    let yaml = MapYaml { free_prob: 0.25, ..MapYaml::new("x", 1.0, HERE) };
    let plan = read(&text(4, &GREYS, &yaml), &rules(true, HERE)).unwrap();
    assert_eq!(plan.notes.len(), 1);
    assert!(plan.notes[0].starts_with("12 pixels have the grey 205"), "{:?}", plan.notes);
}

#[test]
fn maps_of_the_other_formats_are_worlds_too() {
    let octile = "type octile\nheight 3\nwidth 4\nmap\n@@@@\n@.O@\n@@@@\n";
    let plan = read(octile, &rules(true, Se2::new(1.0, 0.0, 0.0))).unwrap();
    assert_eq!((plan.format, plan.walls.len()), (MapFormat::MovingAi, 4));
    assert!(plan.notes[0].contains("1 m is taken"), "{:?}", plan.notes);
    let corners =
        |plan: &FloorPlan| plan.walls.iter().map(|w| w.a.x.max(w.b.x)).fold(0.0, f64::max);
    assert!((corners(&plan) - 3.0).abs() < 1e-12);
    let small = FloorPlanRules { cell_m: Some(0.1), ..rules(false, HERE) };
    let plan = read(octile, &small).unwrap();
    assert!((corners(&plan) - 0.4).abs() < 1e-12 && plan.notes.is_empty());

    let lines = "2D-Map-Ex3\nLINES\n0 0 2000 0\n";
    let plan = read(lines, &rules(true, Se2::new(0.0, 1.0, std::f64::consts::FRAC_PI_2))).unwrap();
    assert_eq!(plan.format, MapFormat::ActivMedia);
    assert!((plan.walls[0].b - Vec2::new(0.0, 3.0)).norm() < 1e-12);
    assert!(!plan.is_solid(plan.walls[0].b));
    assert_eq!(
        read(lines, &small).unwrap_err().to_string(),
        "the map itself says how large a cell is: leave the size of cells out"
    );
}

proptest! {
    /// Oracle: every pair of cells, by the corners of the squares' distances.
    #[test]
    fn the_widest_place_is_the_one_with_most_room(
        greys in vec(prop_oneof![1 => Just(0_u8), 6 => Just(254), 1 => Just(205)], 13 * 9),
        unknown_is_solid: bool,
    ) {
        let yaml = MapYaml::new("x", 0.1, Se2::new(0.4, -2.0, 0.0));
        let Ok(plan) = read(&text(13, &greys, &yaml), &rules(unknown_is_solid, HERE)) else { return Ok(()) };
        let upwards: Vec<u8> = greys.chunks(13).rev().flatten().copied().collect();
        let is_solid = |x: i32, y: i32| {
            !(0..13).contains(&x) || !(0..9).contains(&y) || {
                let grey = upwards[(y * 13 + x) as usize];
                grey == 0 || grey == 205 && unknown_is_solid
            }
        };
        let room = |x: i32, y: i32| {
            let others = (-1..10).flat_map(|j| (-1..14).map(move |i| (i, j)));
            let far = |(i, j): (i32, i32)| f64::from(i - x).hypot(f64::from(j - y));
            others.filter(|&(i, j)| is_solid(i, j)).map(far).fold(f64::INFINITY, f64::min)
        };
        let cells = (0..9).flat_map(|y| (0..13).map(move |x| (x, y)));
        let most = cells.map(|(x, y)| room(x, y)).fold(0.0, f64::max);
        let (place, room_m) = plan.widest_place().unwrap();
        let cell = (place - Vec2::new(0.4, -2.0)) / 0.1;
        let (x, y) = (cell.x.floor() as i32, cell.y.floor() as i32);
        prop_assert!(!is_solid(x, y) && (room(x, y) - most).abs() < 1e-9, "{place} {most}");
        prop_assert!((cell.x.fract() - 0.5).abs() < 1e-6 && (room_m - 0.1 * (most - 0.5)).abs() < 1e-9);
    }
}

#[test]
fn wrong_maps_are_named_with_what_to_do() {
    let yaml = MapYaml::new("building.pgm", 0.05, HERE);
    assert!(said("hello").contains("found `hello`, expected the YAML of a ROS map"));
    assert!(said("").contains("expected the YAML"));
    assert!(said(&yaml.to_text()).contains("`building.pgm` is not in the text"));
    let one = text(1, &[0], &yaml);
    assert!(said(&one).contains("1 × 1 cells: a world needs at least 2 × 2"), "{}", said(&one));
    let black = text(4, &[0; 16], &yaml);
    let none_free = said(&black);
    assert!(
        none_free.contains("none of the 16 cells is free (16 occupied, 0 unknown)"),
        "{none_free}"
    );
    let coarse = one.replace("resolution: 0.05", "resolution: 11");
    let error = read(&coarse, &rules(true, HERE)).unwrap_err();
    assert_eq!(error.line(), Some(3));
    assert!(error.to_string().contains("found `11`, expected metres for a pixel"), "{error}");
    // A chessboard has four sides of each black cell.
    let board: Vec<u8> =
        (0..1600 * 1600).map(|i| if (i + i / 1600) % 2 == 0 { 0 } else { 254 }).collect();
    let noisy = read(&text(1600, &board, &yaml), &rules(false, HERE)).unwrap_err().to_string();
    assert!(noisy.contains("straight pieces of wall: at most 2097152"), "{noisy}");
}

#[test]
fn states_are_kept_apart() {
    // A picture in scale mode with greys between the thresholds: undecided counts as unknown.
    let yaml = MapYaml {
        mode: Mode::Scale,
        occupied_prob: 0.9,
        free_prob: 0.1,
        ..MapYaml::new("x", 1.0, HERE)
    };
    let greys = [0, 255, 128, 60];
    let plan = |solid| read(&text(2, &greys, &yaml), &rules(solid, HERE)).unwrap();
    let count = |plan: &FloorPlan| {
        let centres = [(0.5, 0.5), (1.5, 0.5), (0.5, 1.5), (1.5, 1.5)];
        centres.iter().filter(|(x, y)| plan.is_solid(Vec2::new(*x, *y))).count()
    };
    assert_eq!((count(&plan(true)), count(&plan(false))), (3, 2));
    assert_ne!(State::Unknown, State::Free);
}
