//! Checks of `[world] map`: the walls of a building, out of its map.

use std::{mem, sync::Arc};

use geometry::Vec2;
use simulator::floor_plan::{FloorPlanError, FloorPlanRules, read};

use super::super::{error::Wrong, file::WorldFile, plan::WorldPlan, words::UnknownCells};
use super::common::{Checked, chosen, pose, range};

/// How far from the origin anything may lie, metres.
const FAR_M: f64 = 10_000.0;
/// Free space drawn around a map, metres.
const MARGIN_M: f64 = 0.5;

/// Adds the walls of a mission's map, all of one material.
pub(super) fn add(plan: &mut WorldPlan, file: &WorldFile, material: u32) -> Checked<()> {
    let unknown: UnknownCells = chosen("world.unknown", &file.unknown)?;
    let unknown_is_solid = unknown == UnknownCells::Wall;
    let world_from_map = pose("world.map_at", file.map_at)?;
    let cell = |side_m| range("world.map_cell_m", side_m, 1e-4..=10.0, "from 0.0001 to 10 m");
    let cell_m = file.map_cell_m.map(cell).transpose()?;
    let Some(text) = &file.map else {
        if file.map_cell_m.is_some() {
            let allowed = "absent, because the mission has no world.map";
            return Err(Wrong::new("world.map_cell_m", file.map_cell_m, allowed));
        }
        return Ok(());
    };
    let rules = FloorPlanRules { unknown_is_solid, cell_m, world_from_map };
    let mut map = read(text, &rules).map_err(|error| match error {
        FloorPlanError::SizeTwice => {
            let allowed = "absent: the map itself says how large its cells are";
            Wrong::new("world.map_cell_m", file.map_cell_m, allowed)
        }
        error => wrong_map("world.map", &error),
    })?;
    let within = |p: Vec2| p.x.abs() <= FAR_M && p.y.abs() <= FAR_M;
    if !(map.extent.is_empty() || within(map.extent.min) && within(map.extent.max)) {
        let (low, high) = (map.extent.min, map.extent.max);
        let found =
            format!("a map from ({:.1}, {:.1}) to ({:.1}, {:.1}) m", low.x, low.y, high.x, high.y);
        let allowed =
            "within 10000 m of the origin: world.map_at moves it, and so does the map's own origin";
        return Err(Wrong::prose("world.map", found, allowed));
    }
    let is_default = |(bound, usual): (&f64, f64)| bound.to_bits() == usual.to_bits();
    let is_left_out = plan.bounds.iter().zip(WorldFile::default().bounds_m).all(is_default);
    if is_left_out && !map.extent.is_empty() {
        let drawn = map.extent.grown(MARGIN_M);
        plan.bounds = [drawn.min.x, drawn.min.y, drawn.max.x, drawn.max.y];
    }
    plan.walls.extend(mem::take(&mut map.walls).into_iter().map(|wall| (wall, material)));
    plan.n_borders = if map.cells().is_some() { plan.walls.len() } else { 0 };
    plan.points.extend(mem::take(&mut map.points).into_iter().map(|point| (point, material)));
    plan.point_size_m = map.point_size_m;
    plan.map = Some(Arc::new(map));
    Ok(())
}

/// What is wrong with a map, as a setting with its line.
pub(crate) fn wrong_map(key: &str, error: &FloorPlanError) -> Wrong {
    let wrong = match error {
        FloorPlanError::Cells(grid_maps::MapError::Text { found, expected, .. }) => {
            Wrong::prose(key, found, expected)
        }
        error => Wrong::prose(key, error.to_string(), "a map with walls and free space"),
    };
    match error.line() {
        Some(line) => wrong.within(line, 1),
        None => wrong,
    }
}
