//! Worlds from maps: the walls of a building, out of whatever map people have of it.
//!
//! | format | told by | walls |
//! | --- | --- | --- |
//! | ROS's map server (YAML with its picture in it) | a line `image: …` | the border around its solid cells |
//! | Moving AI | `type octile` | the border around its solid cells |
//! | `ActivMedia` 2-D map | `2D-Map` | its lines and points |
//!
//! Solid are the occupied cells and, where the caller wants it, those that nobody knows, with
//! everything outside of the picture. Everything is exact: a wall runs along the sides of cells.

use geometry::{Aabb, Se2, Segment, Vec2};
use grid_maps::{
    Cell, CellBox, MapError, SolidCells, State, Thresholds, Window,
    files::{MapYaml, Mode, map_server, moving_ai},
    squared_distances,
};

use crate::activmedia_map::{self, MapFileError};

/// Side of the square that stands for a point when the file states no resolution, metres.
const POINT_SIZE_M: f64 = 0.02;
/// Straight pieces of wall that a world may have. Real buildings at 5 cm have ten thousands.
const PIECES_MAX: usize = 1 << 21;
/// The grey that tools write for cells that nobody knows.
const UNKNOWN_GREY: u8 = 205;

/// What kind of map a text is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MapFormat {
    /// A map of ROS's map server.
    MapServer,
    /// A map of the Moving AI laboratory.
    MovingAi,
    /// A 2-D map of the `ActivMedia` tools.
    ActivMedia,
}

/// How a map becomes a world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FloorPlanRules {
    /// Whether cells that nobody knows, and everything outside of the picture, are solid.
    pub unknown_is_solid: bool,
    /// Side of a cell where the file cannot say it (Moving AI), metres; `None`: 1 m there.
    pub cell_m: Option<f64>,
    /// Where the map's frame lies in the world.
    pub world_from_map: Se2,
}

/// The solid part of a map, in the world frame.
#[derive(Clone, Debug)]
pub struct FloorPlan {
    /// What it was read from.
    pub format: MapFormat,
    /// Straight pieces of wall, metres; what is solid lies to their left where the map has cells.
    pub walls: Vec<Segment>,
    /// Solid points, metres.
    pub points: Vec<Vec2>,
    /// Side of the square that stands for a point, metres.
    pub point_size_m: f64,
    /// Around all of the map, its free space included, metres.
    pub extent: Aabb,
    /// What was guessed, left out or looks odd, a sentence each.
    pub notes: Vec<String>,
    cells: Option<Cells>,
}

/// The cells of a map that has cells.
#[derive(Clone, Debug)]
struct Cells {
    solid: SolidCells,
    side_m: f64,
    picture_from_world: Se2,
}

/// A map that cannot become a world.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FloorPlanError {
    /// None of the formats.
    #[error(
        "found `{found}`, expected the YAML of a ROS map (`image: …`), an ActivMedia map \
         (`2D-Map`) or a Moving AI map (`type octile`)"
    )]
    Format {
        /// How it begins.
        found: String,
    },
    /// An `ActivMedia` map that cannot be read.
    #[error(transparent)]
    ActivMedia(#[from] MapFileError),
    /// A map of cells that cannot be read.
    #[error(transparent)]
    Cells(#[from] MapError),
    /// A description whose picture is in a file of its own, which is not here.
    #[error("the picture `{image}` is not in the text")]
    PictureElsewhere {
        /// Its name.
        image: String,
    },
    /// Too few cells for a room.
    #[error(
        "{width} × {height} cells: a world needs at least 2 × 2; check that `image` names the \
         picture of the map"
    )]
    TooSmall {
        /// Cells along x.
        width: usize,
        /// Cells along y.
        height: usize,
    },
    /// Nothing that a robot could stand on.
    #[error(
        "none of the {n_cells} cells is free ({n_occupied} occupied, {n_unknown} unknown): check \
         negate, occupied_thresh and free_thresh, or take unknown space as free"
    )]
    NothingFree {
        /// All cells.
        n_cells: usize,
        /// Occupied ones.
        n_occupied: usize,
        /// Unknown ones.
        n_unknown: usize,
    },
    /// A size for cells whose file says it.
    #[error("the map itself says how large a cell is: leave the size of cells out")]
    SizeTwice,
    /// More border than a world can hold.
    #[error(
        "{n_pieces} straight pieces of wall: at most {PIECES_MAX}; the picture looks like noise or \
         a photograph: take one that is black and white, or coarser"
    )]
    TooManyPieces {
        /// How many there would be.
        n_pieces: usize,
    },
}

impl FloorPlanError {
    /// The line of the text that is wrong, counted from 1, where it is one.
    pub fn line(&self) -> Option<usize> {
        match self {
            Self::Cells(MapError::Text { line, .. }) => Some(*line),
            Self::ActivMedia(error) => error.line(),
            Self::Format { .. } => Some(1),
            _ => None,
        }
    }
}

impl MapFormat {
    /// What the text of a map is, by how it begins; `None` for none of them.
    pub fn of(text: &str) -> Option<Self> {
        let text = text.trim_start_matches('\u{feff}').trim_start();
        if text.starts_with("2D-Map") {
            Some(Self::ActivMedia)
        } else if text.starts_with("type ") {
            Some(Self::MovingAi)
        } else if text.lines().any(|l| ["image:", "resolution:"].iter().any(|k| l.starts_with(k))) {
            Some(Self::MapServer)
        } else {
            None
        }
    }
}

/// Reads a map. O(bytes of the text + cells + walls).
///
/// ```
/// use simulator::floor_plan::{FloorPlanRules, read};
///
/// let text = "type octile\nheight 3\nwidth 4\nmap\n@@@@\n@..@\n@@@@\n";
/// let world_from_map = geometry::Se2::new(0.0, 0.0, 0.0);
/// let rules = FloorPlanRules { unknown_is_solid: true, cell_m: Some(0.5), world_from_map };
/// let plan = read(text, &rules)?;
/// assert_eq!(plan.walls.len(), 4);
/// assert!(plan.is_solid(geometry::Vec2::new(0.2, 0.2)));
/// assert!(!plan.is_solid(geometry::Vec2::new(1.0, 0.7)));
/// # Ok::<(), simulator::floor_plan::FloorPlanError>(())
/// ```
///
/// # Errors
///
/// [`FloorPlanError`]; nothing is read halfway.
pub fn read(text: &str, rules: &FloorPlanRules) -> Result<FloorPlan, FloorPlanError> {
    let found = || text.trim_start().lines().next().unwrap_or("").chars().take(40).collect();
    let format = MapFormat::of(text).ok_or_else(|| FloorPlanError::Format { found: found() })?;
    if rules.cell_m.is_some() && format != MapFormat::MovingAi {
        return Err(FloorPlanError::SizeTwice);
    }
    match format {
        MapFormat::ActivMedia => Ok(lines_and_points(&activmedia_map::parse(text)?, rules)),
        MapFormat::MovingAi => {
            let states = moving_ai::read(text)?;
            let mut notes = Vec::new();
            if rules.cell_m.is_none() {
                notes.push("the map says no size of its cells: 1 m is taken".to_owned());
            }
            of_states(&states, rules.cell_m.unwrap_or(1.0), rules.world_from_map, rules, notes)
                .map(|plan| FloorPlan { format, ..plan })
        }
        MapFormat::MapServer => map_of_server(text, rules),
    }
}

fn map_of_server(text: &str, rules: &FloorPlanRules) -> Result<FloorPlan, FloorPlanError> {
    let yaml = MapYaml::parse(text)?;
    let Some(picture) = yaml.picture() else {
        return Err(FloorPlanError::PictureElsewhere { image: yaml.image });
    };
    let picture = picture?;
    let map = map_server::read(&picture, &yaml)?;
    let mut notes = Vec::new();
    let n_grey: usize =
        picture.values().iter().map(|grey| usize::from(*grey == UNKNOWN_GREY)).sum();
    let counts_as_free = f64::from(255 - UNKNOWN_GREY) / 255.0 < yaml.free_prob;
    if yaml.mode == Mode::Trinary && !yaml.negate && n_grey > 0 && counts_as_free {
        notes.push(format!(
            "{n_grey} pixels have the grey {UNKNOWN_GREY}, which most tools write for unknown, and count as free \
             because free_thresh = {}; 0.196 makes them unknown",
            yaml.free_prob
        ));
    }
    let states = map.states(&Thresholds::default());
    let world_from_picture = rules.world_from_map.compose(map.map_from_picture);
    of_states(&states, map.resolution_m, world_from_picture, rules, notes)
}

/// The border around the solid cells of a picture.
fn of_states(
    states: &Window<State>,
    side_m: f64,
    world_from_picture: Se2,
    rules: &FloorPlanRules,
    mut notes: Vec<String>,
) -> Result<FloorPlan, FloorPlanError> {
    let (width, height) = (states.area().width, states.area().height);
    if width < 2 || height < 2 {
        return Err(FloorPlanError::TooSmall { width, height });
    }
    let is_solid = |state| match state {
        State::Occupied => true,
        State::Free => false,
        State::Unknown => rules.unknown_is_solid,
    };
    let solid = SolidCells::new(states, is_solid, rules.unknown_is_solid);
    let n_cells = width * height;
    let count = |what| states.values().iter().filter(|state| **state == what).count();
    let (n_occupied, n_unknown) = (count(State::Occupied), count(State::Unknown));
    if solid.n_solid() == n_cells {
        return Err(FloorPlanError::NothingFree { n_cells, n_occupied, n_unknown });
    }
    if n_occupied == 0 {
        notes.push("no cell of the map is occupied".to_owned());
    }
    let borders = solid.borders();
    if borders.len() > PIECES_MAX {
        return Err(FloorPlanError::TooManyPieces { n_pieces: borders.len() });
    }
    let placed = |p: Vec2| world_from_picture.transform_point(p);
    let walls = borders.iter().map(|border| {
        let Segment { a, b } = border.segment(side_m);
        Segment { a: placed(a), b: placed(b) }
    });
    let far = Vec2::new(width as f64 * side_m, height as f64 * side_m);
    let corners = [Vec2::zeros(), Vec2::new(far.x, 0.0), far, Vec2::new(0.0, far.y)].map(placed);
    Ok(FloorPlan {
        format: MapFormat::MapServer,
        walls: walls.collect(),
        points: Vec::new(),
        point_size_m: POINT_SIZE_M,
        extent: Aabb::around(corners),
        notes,
        cells: Some(Cells { solid, side_m, picture_from_world: world_from_picture.inverse() }),
    })
}

fn lines_and_points(map: &activmedia_map::MapFile, rules: &FloorPlanRules) -> FloorPlan {
    let placed = |p: Vec2| rules.world_from_map.transform_point(p);
    let solid = map.lines.iter().filter(|line| line.a != line.b);
    let walls: Vec<_> =
        solid.map(|line| Segment { a: placed(line.a), b: placed(line.b) }).collect();
    let points: Vec<_> = map.points.iter().map(|&point| placed(point)).collect();
    let mut notes: Vec<_> = map.warnings.iter().map(ToString::to_string).collect();
    if walls.is_empty() && points.is_empty() {
        notes.push("the map has neither lines nor points".to_owned());
    }
    let ends = walls.iter().flat_map(|line| [line.a, line.b]).chain(points.iter().copied());
    FloorPlan {
        format: MapFormat::ActivMedia,
        extent: Aabb::around(ends),
        point_size_m: map.resolution_m.unwrap_or(POINT_SIZE_M),
        walls,
        points,
        notes,
        cells: None,
    }
}

impl FloorPlan {
    /// Its solid cells, the side of one (m), and where their lower left corner lies in the world; `None` for a map of
    /// lines and points.
    pub fn cells(&self) -> Option<(&SolidCells, f64, Se2)> {
        let Cells { solid, side_m, picture_from_world } = self.cells.as_ref()?;
        Some((solid, *side_m, picture_from_world.inverse()))
    }

    /// The place (world frame, m) that is farthest from everything solid, and how far that is, m: somewhere to put a
    /// robot. The middle of a cell; of equally wide ones the lowest, then the leftmost. Where nothing is known beyond
    /// the picture its border counts as solid. `None` for a map of lines and points. O(cells).
    pub fn widest_place(&self) -> Option<(Vec2, f64)> {
        let cells = self.cells.as_ref()?;
        let (width, height) = (cells.solid.width(), cells.solid.height());
        // A ring of cells around the picture, so that its border counts.
        let area = CellBox { min: Cell::new(-1, -1), width: width + 2, height: height + 2 };
        let mut solid = Window::filled(area, true).ok()?;
        for row in 0..height as i32 {
            for (column, value) in (-1..).zip(solid.row_mut(row)) {
                let inside = (0..width as i32).contains(&column);
                *value = !inside || cells.solid.is_solid(Cell::new(column, row));
            }
        }
        let distances = squared_distances(&solid, |is_solid| is_solid);
        let widest = distances.iter().fold(None, |widest: Option<(Cell, u32)>, (cell, squared)| {
            if widest.is_some_and(|(_, most)| most >= squared) {
                widest
            } else {
                Some((cell, squared))
            }
        });
        let (cell, squared) = widest.filter(|(_, squared)| *squared > 0)?;
        let middle = Vec2::new(f64::from(cell.column) + 0.5, f64::from(cell.row) + 0.5);
        let place = cells.picture_from_world.inverse().transform_point(middle * cells.side_m);
        // From centre to centre, less half a cell of the solid one.
        Some((place, (f64::from(squared).sqrt() - 0.5) * cells.side_m))
    }

    /// Whether a place (world frame, m) lies in a solid cell; on the border of cells the one with
    /// the larger coordinates decides. `false` everywhere in a map of lines and points.
    pub fn is_solid(&self, place: Vec2) -> bool {
        self.cells.as_ref().is_some_and(|cells| {
            let at = cells.picture_from_world.transform_point(place) / cells.side_m;
            // Far away the numbers stop at the ends of their range, which is outside, too.
            cells.solid.is_solid(Cell::new(at.x.floor() as i32, at.y.floor() as i32))
        })
    }
}
