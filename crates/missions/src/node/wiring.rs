//! Which lines a robot's navigation node has.

use run_context::RunSeed;

use super::{base, ground, laser, pheromones};
use crate::{
    mission::Mission,
    run::{error::RunError, line::Line},
};

/// The lines of a robot's navigation node: to its base, to its lasers, to the pheromone server if there is one, to the
/// ground.
pub(crate) fn lines(mission: &Mission, index: usize, seed: RunSeed) -> Result<Vec<Line>, RunError> {
    let plan = &mission.parts().robots[index];
    let mut lines = vec![base::line(plan, seed)?];
    for number in 0..plan.lasers.len() {
        lines.push(laser::line(plan, number, seed)?);
    }
    lines.extend(pheromones::line(mission, index, seed)?);
    lines.push(ground::line(mission, index, seed)?);
    Ok(lines)
}
