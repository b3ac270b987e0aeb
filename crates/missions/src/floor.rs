//! The floor of a mission's world as cells, for those who plan on cells.

use geometry::{Se2, Segment, SegmentWorld, Vec2};
use grid_maps::{Cell, CellBox, SolidCells, WINDOW_CELLS_MAX, Window};
use run_context::RunSeed;
use simulator::World;

use crate::{Mission, RunError, run::world_of};

/// Side of a cell where neither the map nor the caller says one, metres.
const CELL_M: f64 = 0.05;

/// Part of a cell's side within which something solid makes the cell solid: walls along the sides of cells belong to
/// none.
const WITHIN_RATIO: f64 = 0.998;

/// The floor as cells.
#[derive(Clone, Debug)]
pub struct Floor {
    /// What is solid.
    pub solid: SolidCells,
    /// Side of a cell, metres.
    pub cell_m: f64,
    /// Where the lower left corner of the lower left cell lies.
    pub world_from_floor: Se2,
    /// Named places (m), in the order of the mission.
    pub places: Vec<(String, Vec2)>,
}

/// A floor that cannot be made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FloorError {
    /// The world cannot be built.
    #[error(transparent)]
    World(#[from] RunError),
    /// Too many cells.
    #[error(
        "{width} × {height} cells of {cell_m} m: at most {WINDOW_CELLS_MAX} in all; take larger cells"
    )]
    TooLarge {
        /// Cells of a row.
        width: usize,
        /// Rows.
        height: usize,
        /// Side of a cell, m.
        cell_m: f64,
    },
    /// Nothing that has a size.
    #[error("the world has neither walls nor things: there is nothing to plan around")]
    Empty,
}

impl Floor {
    /// Of a mission's world at its beginning: walls, map, furniture and random boxes; people, doors that open and robots
    /// are not in it. A world that is a map of cells and nothing else keeps its cells; any other is laid out in
    /// cells of `cell_m`, or of the map's, or of 0.05 m, with a border of half a metre around.
    ///
    /// O(cells · log walls).
    ///
    /// # Errors
    ///
    /// [`FloorError`].
    pub fn of_mission(
        mission: &Mission,
        seed: RunSeed,
        cell_m: Option<f64>,
    ) -> Result<Self, FloorError> {
        let plan = &mission.parts().world;
        let places = plan.rooms.clone();
        let file = &mission.file().world;
        let only_map =
            file.walls.is_empty() && file.things.is_empty() && file.random_boxes.is_empty();
        let of_map = plan.map.as_ref().and_then(|map| map.cells());
        if let Some((solid, side_m, world_from_floor)) = of_map
            && only_map
            && cell_m.is_none_or(|cell_m| (cell_m - side_m).abs() < 1e-9)
        {
            return Ok(Self { solid: solid.clone(), cell_m: side_m, world_from_floor, places });
        }
        let cell_m = cell_m.or(of_map.map(|(_, side_m, _)| side_m)).unwrap_or(CELL_M);
        let (world, _) = world_of(mission, seed)?;
        let is_solid = |place: Vec2| plan.is_solid(place);
        Self::of_world(&world, cell_m, is_solid).map(|floor| Self { places, ..floor })
    }

    /// Of a world's walls and things; `is_solid` says what is besides.
    fn of_world(
        world: &World,
        cell_m: f64,
        is_solid: impl Fn(Vec2) -> bool,
    ) -> Result<Self, FloorError> {
        const BORDER_M: f64 = 0.5;
        let walls = world.static_map();
        let things = world.things().iter().map(|thing| &thing.spec.polygon);
        let sides: Vec<(Segment, u32)> =
            things.clone().flat_map(geometry::Polygon::edges).map(|edge| (edge, 0)).collect();
        let sides = SegmentWorld::new(sides);
        let bounds = walls.bounds().union(sides.bounds());
        let size = bounds.size() + Vec2::new(2.0 * BORDER_M, 2.0 * BORDER_M);
        if !(size.x.is_finite() && size.y.is_finite()) {
            return Err(FloorError::Empty);
        }
        let corner = bounds.min - Vec2::new(BORDER_M, BORDER_M);
        let (width, height) =
            ((size.x / cell_m).ceil() as usize, (size.y / cell_m).ceil() as usize);
        let too_large = || FloorError::TooLarge { width, height, cell_m };
        if width.saturating_mul(height) > WINDOW_CELLS_MAX {
            return Err(too_large());
        }
        let area = CellBox { min: Cell::new(0, 0), width, height };
        let mut cells = Window::filled(area, false).map_err(|_size| too_large())?;
        let half_m = 0.5 * WITHIN_RATIO * cell_m;
        let reach_m = half_m * std::f64::consts::SQRT_2;
        let mut row = 0;
        while row < height {
            for (column, value) in cells.row_mut(row as i32).iter_mut().enumerate() {
                let middle = corner + cell_m * Vec2::new(column as f64 + 0.5, row as f64 + 0.5);
                let square =
                    [(-half_m, -half_m), (half_m, -half_m), (half_m, half_m), (-half_m, half_m)]
                        .map(|(x, y)| middle + Vec2::new(x, y));
                let touches = |what: &SegmentWorld| {
                    what.nearest_distance(middle, reach_m).is_some()
                        && what.touches_polygon(&square)
                };
                *value = touches(walls)
                    || touches(&sides)
                    || things.clone().any(|polygon| polygon.contains(middle))
                    || is_solid(middle);
            }
            row += 1;
        }
        let solid = SolidCells::new(&cells, |solid| solid, false);
        let world_from_floor = Se2::new(corner.x, corner.y, 0.0);
        Ok(Self { solid, cell_m, world_from_floor, places: Vec::new() })
    }

    /// The cell of a place (world, m).
    pub fn cell_of(&self, place: Vec2) -> Cell {
        let at = self.world_from_floor.inverse().transform_point(place) / self.cell_m;
        // Casts saturate: what is far away is outside.
        Cell::new(at.x.floor() as i32, at.y.floor() as i32)
    }

    /// The middle of a cell (world, m).
    pub fn place_of(&self, cell: Cell) -> Vec2 {
        let middle = Vec2::new(f64::from(cell.column) + 0.5, f64::from(cell.row) + 0.5);
        self.world_from_floor.transform_point(middle * self.cell_m)
    }
}
