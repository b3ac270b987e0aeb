//! What a robot's mind is given of the map of its world, where its methods want one.

use std::sync::Arc;

use localisation::{FieldModel, FilterConfig, LikelihoodField, ParticleFilter};
use navigator::{Method, Navigator, PoseMethod};
use path_planning::MapPlanner;
use robot_models::OdometryNoise;
use run_context::RunSeed;

use crate::{
    floor::Floor,
    mission::{Mission, plan::RobotPlan},
};

/// How well it is known where a robot is put, standard deviations in metres and radians.
const START_STD: [f64; 2] = [0.1, 0.05];

/// How the ways of wheels err, at random, for the particles: more than a good robot's do, so that one whose wheels are not as
/// its file says is followed, too.
const WHEEL_STD_RATIO: f64 = 0.03;

/// Gives the map for planning and the particles for localisation, as far as the robot's mind asks for them.
pub(super) fn give(
    navigator: &mut Navigator,
    mission: &Mission,
    plan: &RobotPlan,
    seed: RunSeed,
) -> Result<(), String> {
    let settings = plan.navigator.settings();
    let (plans, weighs) =
        (settings.method == Method::Map, settings.pose_method == PoseMethod::Particles);
    if !(plans || weighs) {
        return Ok(());
    }
    let floor = Floor::of_mission(mission, None).map_err(|e| e.to_string())?;
    let empty = || "the map has no cells, or too many".to_owned();
    if plans {
        let map = MapPlanner::new(&floor.solid, floor.cell_m, floor.world_from_floor);
        navigator.set_map(map.ok_or_else(empty)?);
    }
    if weighs {
        let model = FieldModel::default();
        let field = LikelihoodField::new(&floor.solid, floor.cell_m, floor.world_from_floor, model);
        let noise =
            OdometryNoise { left_std_ratio: WHEEL_STD_RATIO, right_std_ratio: WHEEL_STD_RATIO };
        let config = FilterConfig { drive: settings.drive, noise, ..FilterConfig::default() };
        let rng = seed.stream(&format!("particles/{}", plan.name));
        let field = Arc::new(field.ok_or_else(empty)?);
        let filter = ParticleFilter::at(config, field, rng, plan.start, START_STD);
        navigator.set_particles(filter.map_err(|e| e.to_string())?);
    }
    Ok(())
}
