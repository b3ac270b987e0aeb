//! Ways for a robot on a map of cells: in metres, with room for its outline, as wide as can be had.

use geometry::{Se2, Vec2};
use grid_maps::{Cell, CellBox, SolidCells, Window, squared_distances};

use crate::{Budget, FreeFloor, GridMethod, GridOutcome, GridSearch};

/// Room besides the robot's own radius that a way keeps if it can, metres, the widest first; and how much longer a metre of
/// such a way counts: a narrow one must be shorter to be worth it.
const ROOMS: [(f64, f64); 3] = [(0.15, 1.0), (0.06, 1.2), (0.01, 1.4)];

/// A robot that stands nearer to something solid than its radius sets out to a free cell at most so far away, metres.
const STEP_OUT_M: f64 = 0.8;

/// Cells that a search for straight lines may expand before eight directions must do.
const N_EXPANDED_MAX: u64 = 400_000;

/// Why there is no way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoWay {
    /// The goal is solid, outside of the map, or has no room for the robot.
    GoalBlocked,
    /// Nothing free is near the robot.
    Enclosed,
    /// No way connects the two.
    NotConnected,
}

/// A way on a map.
#[derive(Clone, Debug, PartialEq)]
pub struct MapWay {
    /// Its corners (m, map), ends included.
    pub corners: Vec<Vec2>,
    /// Room that it keeps besides the robot's own radius, metres.
    pub room_m: f64,
}

/// A map, prepared for planning.
///
/// Memory: about 20 bytes for each cell.
#[derive(Clone, Debug)]
pub struct MapPlanner {
    squared: Window<u32>,
    cell_m: f64,
    map_from_cells: Se2,
    cells_from_map: Se2,
    search: GridSearch,
}

impl MapPlanner {
    /// Of the solid cells of a map with sides of `cell_m`, whose lower left corner lies at `map_from_cells`. O(cells).
    ///
    /// `None` for a map without cells or with too many.
    pub fn new(solid: &SolidCells, cell_m: f64, map_from_cells: Se2) -> Option<Self> {
        let area = CellBox { min: Cell::new(0, 0), width: solid.width(), height: solid.height() };
        if area.is_empty() || cell_m.is_nan() || cell_m <= 0.0 {
            return None;
        }
        let mut cells = Window::filled(area, false).ok()?;
        for row in 0..solid.height() as i32 {
            for (column, value) in (0..).zip(cells.row_mut(row)) {
                *value = solid.is_solid(Cell::new(column, row));
            }
        }
        let squared = squared_distances(&cells, |is_solid| is_solid);
        let search = GridSearch::new(FreeFloor::new(&cells, |is_solid| is_solid)?);
        let cells_from_map = map_from_cells.inverse();
        Some(Self { squared, cell_m, map_from_cells, cells_from_map, search })
    }

    /// A way from one place (m, map) to another for a disc of `radius_m`. It keeps 15 cm more room than that if it can and
    /// that is not much longer, else less. `obstacles` are points (m, map) that the map does not know; to them it keeps its radius. Equal calls give
    /// equal ways. O(cells + obstacles).
    ///
    /// # Errors
    ///
    /// [`NoWay`].
    pub fn plan(
        &mut self,
        from: Vec2,
        to: Vec2,
        radius_m: f64,
        obstacles: &[Vec2],
    ) -> Result<MapWay, NoWay> {
        let [start, goal] = [self.cell_of(from), self.cell_of(to)];
        let mut why = NoWay::GoalBlocked;
        let mut best: Option<(f64, MapWay)> = None;
        for (room_m, weight) in ROOMS {
            let Some(mut floor) = self.floor(radius_m + room_m) else { break };
            for &obstacle in obstacles {
                floor.block_disc(self.cell_of(obstacle), radius_m / self.cell_m);
            }
            self.search.set_floor(floor);
            if !self.search.floor().is_free(goal) {
                continue;
            }
            let Some(set_out) = self.nearest_free(start) else {
                why = NoWay::Enclosed;
                continue;
            };
            why = NoWay::NotConnected;
            if let Some(turns) = self.find(set_out, goal) {
                let corners = self.corners(from, to, set_out == start, &turns);
                let length_m: f64 = corners.windows(2).map(|ends| (ends[1] - ends[0]).norm()).sum();
                if best.as_ref().is_none_or(|(least, _)| weight * length_m < *least) {
                    best = Some((weight * length_m, MapWay { corners, room_m }));
                }
            }
        }
        best.map(|(_, way)| way).ok_or(why)
    }

    fn find(&mut self, start: Cell, goal: Cell) -> Option<Vec<Cell>> {
        let budget = Budget { n_expanded_max: N_EXPANDED_MAX };
        let mut found = self.search.find(start, goal, GridMethod::AnyAngle, budget);
        if found == GridOutcome::BudgetSpent {
            found = self.search.find(start, goal, GridMethod::JumpPoints, Budget::UNLIMITED);
        }
        match found {
            GridOutcome::Found(way) => Some(way.turns),
            _ => None,
        }
    }

    /// Where one may go with a disc of that radius.
    fn floor(&self, radius_m: f64) -> Option<FreeFloor> {
        let limit = (radius_m / self.cell_m + 0.5).powi(2);
        FreeFloor::new(&self.squared, |squared| f64::from(squared) < limit)
    }

    /// The cell itself if it is free, else the nearest free one that is not far; of equally near ones the lowest, then
    /// the leftmost.
    fn nearest_free(&self, cell: Cell) -> Option<Cell> {
        let floor = self.search.floor();
        let reach = (STEP_OUT_M / self.cell_m).ceil() as i32;
        let square =
            (-reach..=reach).flat_map(|row| (-reach..=reach).map(move |column| (column, row)));
        let free = square.filter(|(column, row)| {
            let there =
                Cell::new(cell.column.saturating_add(*column), cell.row.saturating_add(*row));
            column * column + row * row <= reach * reach && floor.is_free(there)
        });
        let (column, row) = free.min_by_key(|(column, row)| column * column + row * row)?;
        Some(Cell::new(cell.column + column, cell.row + row))
    }

    fn corners(&self, from: Vec2, to: Vec2, from_itself: bool, turns: &[Cell]) -> Vec<Vec2> {
        let last = turns.len().saturating_sub(1);
        let mut corners = Vec::with_capacity(turns.len() + 1);
        corners.push(from);
        for (i, &cell) in turns.iter().enumerate() {
            if i == last {
                corners.push(to);
            } else if i > 0 || !from_itself {
                corners.push(self.place_of(cell));
            }
        }
        corners
    }

    fn cell_of(&self, place: Vec2) -> Cell {
        let at = self.cells_from_map.transform_point(place) / self.cell_m;
        // Casts saturate: far away is outside.
        Cell::new(at.x.floor() as i32, at.y.floor() as i32)
    }

    fn place_of(&self, cell: Cell) -> Vec2 {
        let middle = Vec2::new(f64::from(cell.column) + 0.5, f64::from(cell.row) + 0.5);
        self.map_from_cells.transform_point(middle * self.cell_m)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two rooms of 3 m with a wall between them that has a door of `door_m` in the middle; turned and moved in the map.
    fn planner(door_m: f64) -> (MapPlanner, Se2) {
        let (width, height) = (124_usize, 64_usize);
        let area = CellBox { min: Cell::new(0, 0), width, height };
        let mut cells = Window::filled(area, false).unwrap();
        for row in 0..height as i32 {
            for column in 0..width as i32 {
                let border = !(2..62).contains(&row) || !(2..122).contains(&column);
                let in_door = (f64::from(row) + 0.5 - 32.0).abs() < 0.5 * door_m / 0.05;
                let wall = (61..63).contains(&column) && !in_door;
                *cells.get_mut(Cell::new(column, row)).unwrap() = border || wall;
            }
        }
        let at = Se2::new(4.0, -2.0, 0.7);
        let solid = SolidCells::new(&cells, |is_solid| is_solid, true);
        (MapPlanner::new(&solid, 0.05, at).unwrap(), at)
    }

    #[test]
    fn a_way_leads_through_a_door_that_is_wide_enough_and_keeps_its_distance() {
        for (door_m, expected) in [(1.0, true), (0.66, true), (0.5, false)] {
            let (mut planner, at) = planner(door_m);
            let [from, to] =
                [(0.8, 0.8), (5.0, 2.5)].map(|(x, y)| at.transform_point(Vec2::new(x, y)));
            let found = planner.plan(from, to, 0.3, &[]);
            assert_eq!(found.is_ok(), expected, "{door_m} {found:?}");
            let corners = match found {
                Ok(way) => way.corners,
                Err(why) => {
                    assert_eq!(why, NoWay::NotConnected);
                    continue;
                }
            };
            assert_eq!((corners[0], *corners.last().unwrap()), (from, to));
            // Walked in steps of a centimetre: how near the posts of the door it comes, in the frame of the cells.
            let posts = [0.5, -0.5].map(|side| Vec2::new(3.1, 1.6 + side * door_m));
            let mut least_m = f64::INFINITY;
            for pair in corners.windows(2) {
                for k in 0..=100 {
                    let p = at
                        .inverse()
                        .transform_point(pair[0] + (pair[1] - pair[0]) * (f64::from(k) / 100.0));
                    least_m = posts.iter().map(|post| (post - p).norm()).fold(least_m, f64::min);
                }
            }
            let room_m = if door_m > 0.95 { 0.4 } else { 0.27 };
            assert!(least_m > room_m, "{door_m}: {least_m} m");
        }
    }

    /// Posts that the map does not know close the door, or half of it.
    #[test]
    fn what_is_not_on_the_map_is_driven_around_or_closes_the_way() {
        let (mut planner, at) = planner(1.6);
        let [from, to] = [(0.8, 0.8), (5.0, 2.5)].map(|(x, y)| at.transform_point(Vec2::new(x, y)));
        let posts = |ys: &[f64]| -> Vec<Vec2> {
            ys.iter().map(|y| at.transform_point(Vec2::new(3.1, *y))).collect()
        };
        let half = posts(&[1.0, 1.2, 1.4]);
        let way = planner.plan(from, to, 0.3, &half).unwrap();
        for pair in way.corners.windows(2) {
            for k in 0..=100 {
                let p = pair[0] + (pair[1] - pair[0]) * (f64::from(k) / 100.0);
                let least_m =
                    half.iter().map(|post| (post - p).norm()).fold(f64::INFINITY, f64::min);
                assert!(least_m > 0.24, "{least_m} m");
            }
        }
        let whole = posts(&[1.0, 1.3, 1.6, 1.9, 2.2]);
        assert_eq!(planner.plan(from, to, 0.3, &whole), Err(NoWay::NotConnected));
        assert!(planner.plan(from, to, 0.3, &[]).is_ok(), "forgotten");
    }

    #[test]
    fn goals_in_walls_and_robots_at_walls_are_told_apart() {
        let (mut planner, at) = planner(1.0);
        let place = |x: f64, y: f64| at.transform_point(Vec2::new(x, y));
        assert_eq!(
            planner.plan(place(1.0, 1.0), place(0.05, 1.0), 0.3, &[]),
            Err(NoWay::GoalBlocked)
        );
        assert_eq!(
            planner.plan(place(1.0, 1.0), place(99.0, 1.0), 0.3, &[]),
            Err(NoWay::GoalBlocked)
        );
        // Nearer to the wall than its radius: it sets out to where it has room.
        let corners = planner.plan(place(0.25, 1.5), place(1.5, 1.5), 0.3, &[]).unwrap().corners;
        assert_eq!(corners[0], place(0.25, 1.5));
        let second = at.inverse().transform_point(corners[1]);
        assert!(second.x >= 0.4, "{corners:?}");
        assert_eq!(planner.plan(place(-5.0, 1.5), place(1.5, 1.5), 0.3, &[]), Err(NoWay::Enclosed));
    }
}
