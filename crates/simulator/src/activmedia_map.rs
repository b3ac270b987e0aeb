//! `ActivMedia` 2-D maps (`.map`): the walls, points and marked places of the Pioneer's own tools.
//!
//! Text. The first line is `2D-Map`, or one of `2D-Map-Ex` to `2D-Map-Ex4`; then `Key: values` lines; then a line `LINES` with one
//! `x1 y1 x2 y2` per line and a line `DATA` with one `x y` per line, either of which may be missing.
//! Coordinates are millimetres in the file and metres here. Lines end with LF or CRLF; empty lines
//! are skipped.
//!
//! A map from several scanners has a line `Sources: SickLaser Front …`. Each but `SickLaser` has keys and sections of its
//! own with its name before them: `FrontNumLines`, `Front_LINES`, `Front_DATA`. All of them are walls alike.
//!
//! Source: `ArMap` of ARIA 2.10 as `AriaCoda` has it, for the five first lines and the names of keys.
//!
//! [`parse`] accepts what those tools write and refuses the rest with the line's number. A
//! section with *fewer* entries than its header states was cut short and is an error; one with
//! *more* was edited by hand, which is a [`MapWarning`].

mod read;
mod write;

use geometry::{Se2, Segment, SegmentWorld, Vec2};
use sensor_models::WALL_TAG;

pub use read::{MapFileError, parse};

/// Side of the square that stands for a point when the file states no resolution, metres.
const POINT_SIZE_M: f64 = 0.02;

/// The content of a map file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MapFile {
    /// Walls, metres, in the order of the file.
    pub lines: Vec<Segment>,
    /// Points that a scanner saw, metres, in the order of the file.
    pub points: Vec<Vec2>,
    /// Spacing of the points, metres, if stated.
    pub resolution_m: Option<f64>,
    /// Marked places and areas: the `Cairn:` lines, in the order of the file.
    pub things: Vec<CairnObject>,
    /// The first robot's home, if any.
    pub home: Option<Se2>,
    /// Header lines that are kept as they are, such as `MapInfo`: key, and the text after the colon.
    pub info: Vec<(String, String)>,
    /// What looked odd but did not hinder.
    pub warnings: Vec<MapWarning>,
}

/// A marked place, line or area of a map: what the file calls a cairn.
#[derive(Clone, Debug, PartialEq)]
pub struct CairnObject {
    /// Its type, such as `Goal`, `GoalWithHeading`, `RobotHome`, `ForbiddenLine`, `ForbiddenArea`.
    pub kind: String,
    /// Where it is; the heading of an area turns the area.
    pub pose: Se2,
    /// Its name, possibly empty.
    pub name: String,
    /// Its description, possibly empty.
    pub description: String,
    /// The text in the place of `ICON`.
    pub icon: String,
    /// Two ends of a line or opposite corners of an area, metres, before the heading turns them.
    pub area: Option<[Vec2; 2]>,
}

/// Something odd about a map that can be used all the same.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum MapWarning {
    /// The map is of several scanners, which may have seen the same wall twice.
    Sources {
        /// Their names, as prose.
        names: String,
    },
    /// A section has more entries than its header states.
    MoreThanStated {
        /// `NumLines` or `NumPoints`, with the source before it if there are several.
        key: String,
        /// What the header states.
        stated: usize,
        /// What the section has.
        found: usize,
    },
    /// A line without length, which stops nothing and is left out of the world.
    EmptyLine {
        /// Line of the file, counted from 1.
        line: usize,
    },
}

impl std::fmt::Display for MapWarning {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::MoreThanStated { key, stated, found } => {
                write!(f, "{key} states {stated}, but there are {found}; all are used")
            }
            Self::Sources { names } => {
                write!(f, "lines and points of several sources ({names}) are walls alike")
            }
            Self::EmptyLine { line } => write!(f, "line {line}: a wall without length is left out"),
        }
    }
}

impl CairnObject {
    /// The corners of an area or the ends of a line in the map, metres, counter-clockwise for an
    /// area; empty for a place. The heading turns them about the map's origin.
    pub fn outline(&self) -> Vec<Vec2> {
        let Some([a, b]) = self.area else { return Vec::new() };
        let turned = |x_m, y_m| Se2::new(0.0, 0.0, self.pose.yaw_rad).rotate(Vec2::new(x_m, y_m));
        if self.kind.ends_with("Line") {
            return vec![turned(a.x, a.y), turned(b.x, b.y)];
        }
        let (low, high) = (a.inf(&b), a.sup(&b));
        vec![
            turned(low.x, low.y),
            turned(high.x, low.y),
            turned(high.x, high.y),
            turned(low.x, high.y),
        ]
    }
}

impl MapFile {
    /// The solid part of the map: lines as walls, points as small squares of the resolution's
    /// size (20 mm when there is none), all of
    /// plaster. Forbidden lines are not solid.
    pub fn to_segment_world(&self) -> SegmentWorld {
        let solid = self.lines.iter().filter(|line| line.a != line.b);
        SegmentWorld::with_points(
            solid.map(|&line| (line, WALL_TAG)),
            self.points.iter().map(|&point| (point, WALL_TAG)),
            self.resolution_m.unwrap_or(POINT_SIZE_M),
        )
    }

    /// The things of one kind.
    pub fn things_of<'a>(&'a self, kind: &'a str) -> impl Iterator<Item = &'a CairnObject> + 'a {
        self.things.iter().filter(move |thing| thing.kind == kind)
    }
}
