//! Occupancy grids: tiles that grow, free space of whole scans, distance fields, map files.
//!
//! | to do | use |
//! | --- | --- |
//! | find the cell of a place, exact at its borders | [`Lattice`] |
//! | keep evidence of a building of any size | [`LogOddsMap`] |
//! | put a laser scan into it | [`ScanInserter`] |
//! | put a sonar's cone into it | [`ConeInserter`]; [`for_each_cell`] for anything else |
//! | work on a dense piece | [`LogOddsMap::prob_window`], [`Window`] |
//! | match scans against obstacles | [`DistanceField`] |
//! | cast rays by the million | [`RayMap`] |
//! | find the walls in a map, as lines | [`SolidCells`] |
//! | read and write what others read | [`files`] |
//!
//! A cell that nobody observed is unknown, and unknown is not one half. Nothing here touches files,
//! clocks or threads, and nothing depends on the order in which tiles came to be.
//!
//! ```
//! use geometry::{Se2, Vec2};
//! use grid_maps::{
//!     BeamFan, EvidenceModel, Lattice, LogOddsMap, MapError, ScanInserter, ScanRules, State,
//!     Thresholds, files,
//! };
//!
//! let lattice = Lattice::new(Vec2::zeros(), 0.05)?;
//! let mut map = LogOddsMap::new(lattice, EvidenceModel::default())?;
//! // A wall 2 m in front of a laser of 181 beams, seen four times.
//! let fan = BeamFan::uniform(-0.9, 0.01, 181)?;
//! let ranges_m: Vec<f64> = fan.directions().iter().map(|beam| 2.0 / beam.x).collect();
//! let mut inserter = ScanInserter::new(ScanRules::new(30.0, 0.05));
//! for _ in 0..4 {
//!     inserter.insert(&mut map, &fan, Se2::new(1.0, 0.0, 0.0), &ranges_m);
//! }
//! let state = |x, y| map.state(lattice.cell_of(Vec2::new(x, y)), &Thresholds::default());
//! assert_eq!(state(2.0, 0.3), State::Free);
//! assert_eq!(state(3.0, 0.3), State::Occupied);
//! assert_eq!(state(4.0, 0.3), State::Unknown);
//!
//! let area = map.bounds().ok_or(MapError::Empty)?;
//! let states = map.state_window(area, &Thresholds::default())?;
//! let (picture, text) = files::map_server::draw_states(&states, &lattice, "wall.pgm")?;
//! assert!(files::write_pgm(&picture).starts_with(b"P5\n"));
//! assert!(text.to_text().starts_with("image: wall.pgm\n"));
//! # Ok::<(), MapError>(())
//! ```

mod cone;
mod distance_field;
mod error;
pub mod files;
mod lattice;
mod log_odds;
mod ray;
mod ray_map;
mod scan;
mod solid;
mod spans;
mod tile_grid;
mod window;

pub use cone::{ConeInserter, ConeShape, for_each_cell};
pub use distance_field::{DistanceField, FieldSample, NO_OBSTACLE, squared_distances};
pub use error::MapError;
pub use lattice::{CELL_LIMIT, Cell, CellBox, Lattice};
pub use log_odds::{
    Entropy, EvidenceModel, LogOddsMap, STEPS_PER_LOGODDS, State, Thresholds, UNKNOWN_STEP,
    entropy_bits, logodds_of, prob_of,
};
pub use ray::RayWalk;
pub use ray_map::RayMap;
pub use scan::{BeamFan, ScanInserter, ScanReport, ScanRules};
pub use solid::{Border, SolidCells};
pub use tile_grid::{TILE_SIDE_CELLS, Tile, TileGrid};
pub use window::{WINDOW_CELLS_MAX, Window};
