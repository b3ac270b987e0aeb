//! `[world]`: walls, things, people, boxes.

use serde::{Deserialize, Serialize};

/// `[world]`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct WorldFile {
    /// Lower left and upper right corner of what is drawn: x0, y0, x1, y1 (m).
    pub bounds_m: [f64; 4],
    /// A map whose walls are added: a file relative to the mission's, or its text, if it has lines.
    #[serde(skip_serializing_if = "Option::is_none", alias = "map_file")]
    pub map: Option<String>,
    /// What cells of the map that nobody knows are, and what is outside of it: `wall` or `free`.
    pub unknown: String,
    /// Where the map's own frame lies: x, y (m), yaw (degrees).
    pub map_at: [f64; 3],
    /// Side of a cell where the map does not say it (Moving AI), m; absent: 1 there.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub map_cell_m: Option<f64>,
    /// Walls.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub walls: Vec<WallFile>,
    /// Names of rooms, for people.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub rooms: Vec<RoomFile>,
    /// Furniture, boxes, doors.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub things: Vec<ThingFile>,
    /// People and the routes they walk.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub people: Vec<PersonFile>,
    /// Boxes put down at random by the seed.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub random_boxes: Vec<RandomBoxesFile>,
}

impl Default for WorldFile {
    fn default() -> Self {
        Self {
            bounds_m: [-5.0, -5.0, 5.0, 5.0],
            map: None,
            unknown: "wall".into(),
            map_at: [0.0; 3],
            map_cell_m: None,
            walls: Vec::new(),
            rooms: Vec::new(),
            things: Vec::new(),
            people: Vec::new(),
            random_boxes: Vec::new(),
        }
    }
}

/// `[[world.walls]]`: a line of wall through two or more corners.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct WallFile {
    /// Corners, x and y (m).
    pub line_m: Vec<[f64; 2]>,
    /// Whether the last corner is joined to the first.
    pub closed: bool,
    /// Material, which decides how sound comes back.
    pub material: String,
}

impl Default for WallFile {
    fn default() -> Self {
        Self { line_m: Vec::new(), closed: false, material: "plaster".into() }
    }
}

/// `[[world.rooms]]`.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct RoomFile {
    /// The room's name.
    pub name: String,
    /// Where the name is written, x and y (m).
    pub at_m: [f64; 2],
}

/// `[[world.things]]`: a rectangle that stands on the floor.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct ThingFile {
    /// Unique name.
    pub name: String,
    /// `furniture`, `box` or `door`.
    pub kind: String,
    /// Material.
    pub material: String,
    /// Centre, x and y (m).
    pub at_m: [f64; 2],
    /// Turned counter-clockwise by, degrees.
    pub yaw_deg: f64,
    /// Length along x and y before turning (m).
    pub size_m: [f64; 2],
}

impl Default for ThingFile {
    fn default() -> Self {
        Self {
            name: String::new(),
            kind: "furniture".into(),
            material: "wood".into(),
            at_m: [0.0, 0.0],
            yaw_deg: 0.0,
            size_m: [0.4, 0.4],
        }
    }
}

/// `[[world.people]]`: somebody who walks along a route.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct PersonFile {
    /// Unique name.
    pub name: String,
    /// Corners of the route, x and y (m); the person stands at the first until it starts.
    pub route_m: Vec<[f64; 2]>,
    /// Walking speed, m/s.
    pub speed_mps: f64,
    /// Up to this much is added to the speed at random, m/s.
    pub speed_spread_mps: f64,
    /// Starts at, seconds.
    pub starts_at_s: f64,
    /// Up to this much is added to the start at random, seconds.
    pub starts_spread_s: f64,
    /// Whether the route is walked to and fro for ever.
    pub repeats: bool,
    /// Whether the person stops for a robot in front.
    pub yields: bool,
    /// Radius of the body, m.
    pub radius_m: f64,
}

impl Default for PersonFile {
    fn default() -> Self {
        Self {
            name: String::new(),
            route_m: Vec::new(),
            speed_mps: 0.8,
            speed_spread_mps: 0.0,
            starts_at_s: 0.0,
            starts_spread_s: 0.0,
            repeats: false,
            yields: true,
            radius_m: 0.25,
        }
    }
}

/// `[[world.random_boxes]]`: boxes placed by the seed, along the trail or in an area.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct RandomBoxesFile {
    /// Name; a number is added when there is more than one.
    pub name: String,
    /// How many.
    pub count: usize,
    /// Sides (m).
    pub size_m: [f64; 2],
    /// Material.
    pub material: String,
    /// Between these arc lengths of the first trail (m); empty: anywhere in `area_m`.
    pub along_trail_m: Vec<f64>,
    /// Greatest distance of the centre from the trail, to either side (m).
    pub offset_max_m: f64,
    /// Lower left and upper right corner of the area (m); used when `along_trail_m` is empty.
    pub area_m: Vec<f64>,
    /// Least free width beside the box, on at least one side, so that a robot can pass (m).
    pub passage_m: f64,
    /// Least distance to other things, people and robots (m).
    pub clearance_m: f64,
}

impl Default for RandomBoxesFile {
    fn default() -> Self {
        Self {
            name: "box".into(),
            count: 1,
            size_m: [0.3, 0.3],
            material: "cardboard".into(),
            along_trail_m: Vec::new(),
            offset_max_m: 0.1,
            area_m: Vec::new(),
            passage_m: 0.9,
            clearance_m: 0.6,
        }
    }
}
