//! The floor of a mission's world as cells, for those who plan on cells.

use geometry::{Aabb, Polygon, Se2, SegmentWorld, Vec2};
use grid_maps::{Cell, CellBox, SolidCells, WINDOW_CELLS_MAX, Window};

use crate::{
    Mission,
    mission::plan::{PlannedKind, WorldPlan},
};

/// Side of a cell where neither the map nor the caller says one, metres.
const CELL_M: f64 = 0.05;

/// Part of a cell's side within which something solid makes the cell solid: a wall along the sides of cells makes those on
/// both of its sides solid, or it would be in none.
const WITHIN_RATIO: f64 = 1.002;

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
    /// Of what is known of a mission's world: walls, map and furniture. Doors, random boxes, people and robots are not in
    /// it. A world that is a map of cells and nothing else keeps its cells; any other is laid out in cells of
    /// `cell_m`, or of the map's, or of 0.05 m, with a border of half a metre around.
    ///
    /// O(cells · log walls).
    ///
    /// # Errors
    ///
    /// [`FloorError`].
    pub fn of_mission(mission: &Mission, cell_m: Option<f64>) -> Result<Self, FloorError> {
        let plan = &mission.parts().world;
        let places = plan.rooms.clone();
        let only_map = mission.file().world.walls.is_empty() && furniture(plan).next().is_none();
        let of_map = plan.map.as_ref().and_then(|map| map.cells());
        if let Some((solid, side_m, world_from_floor)) = of_map
            && only_map
            && cell_m.is_none_or(|cell_m| (cell_m - side_m).abs() < 1e-9)
        {
            return Ok(Self { solid: solid.clone(), cell_m: side_m, world_from_floor, places });
        }
        let cell_m = cell_m.or(of_map.map(|(_, side_m, _)| side_m)).unwrap_or(CELL_M);
        Self::laid_out(plan, cell_m).map(|floor| Self { places, ..floor })
    }

    fn laid_out(plan: &WorldPlan, cell_m: f64) -> Result<Self, FloorError> {
        const BORDER_M: f64 = 0.5;
        let walls = SegmentWorld::with_points(
            // Borders of cells are known by their cells.
            plan.walls[plan.n_borders..].iter().copied(),
            plan.points.iter().copied(),
            plan.point_size_m,
        );
        let things: Vec<Polygon> = furniture(plan).collect();
        let sides = things.iter().flat_map(Polygon::edges).map(|edge| (edge, 0));
        let sides = SegmentWorld::new(sides.collect::<Vec<_>>());
        let of_map = plan.map.as_ref().map_or(Aabb::EMPTY, |map| map.extent);
        let bounds = walls.bounds().union(sides.bounds()).union(of_map);
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
        for row in 0..height {
            for (column, value) in cells.row_mut(row as i32).iter_mut().enumerate() {
                let middle = corner + cell_m * Vec2::new(column as f64 + 0.5, row as f64 + 0.5);
                let corners =
                    [(-half_m, -half_m), (half_m, -half_m), (half_m, half_m), (-half_m, half_m)];
                let square = corners.map(|(x, y)| middle + Vec2::new(x, y));
                let touches = |what: &SegmentWorld| {
                    what.nearest_distance(middle, reach_m).is_some()
                        && what.touches_polygon(&square)
                };
                *value = touches(&walls)
                    || touches(&sides)
                    || things.iter().any(|polygon| polygon.contains(middle))
                    || plan.is_solid(middle);
            }
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

/// What stands there all the time.
fn furniture(plan: &WorldPlan) -> impl Iterator<Item = Polygon> + '_ {
    let stays = plan.things.iter().filter(|thing| thing.kind != PlannedKind::Door);
    // Rectangles with checked sides are always polygons.
    stays.filter_map(|thing| Polygon::new(thing.corners.clone()).ok())
}
