//! A mission with a laser goes through the mapper as any log does, and gives its world back.
#![expect(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::sync::Arc;

use geometry::{Segment, Vec2};
use grid_maps::{Thresholds, files::map_server};
use missions::{Mission, sense, world_of};
use run_context::RunSeed;
use simulator::floor_plan::{FloorPlanRules, read};
use surveys::{Clock, Survey, SurveyConfig};

/// Spacing of the places on mapped walls that are looked up, m.
const EVERY_M: f64 = 0.05;

fn places(wall: Segment) -> impl Iterator<Item = Vec2> {
    let n = (wall.length() / EVERY_M).ceil().max(1.0) as u32;
    (0..=n).map(move |i| wall.point_at(f64::from(i) / f64::from(n)))
}

fn distance_m(place: Vec2, corners: &[Vec2]) -> f64 {
    let sides = corners.iter().zip(corners.iter().cycle().skip(1));
    let to_side = |(&a, &b): (&Vec2, &Vec2)| {
        let along = b - a;
        let part = ((place - a).dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
        (a + along * part - place).norm()
    };
    sides.map(to_side).fold(f64::INFINITY, f64::min)
}

/// Mean distance from the walls of the map of one laser's recording to the true ones, and the size of a cell, m.
fn mapped(mission: &str, sensor: &str) -> (f64, f64, usize) {
    let mission = Mission::load(mission, &[]).unwrap();
    let (world, _) = world_of(&mission, RunSeed(1)).unwrap();
    let sensed = sense(mission, RunSeed(1)).unwrap();
    let (_, recording) = sensed.recordings.into_iter().find(|(name, _)| name == sensor).unwrap();
    let world_from_map = recording.truth[0].pose;
    let mut survey =
        Survey::new(Arc::new(recording), SurveyConfig::default(), Clock::stopped()).unwrap();
    while survey.progress().n_done < survey.progress().n_scans {
        survey.step().unwrap();
    }
    let outcome = survey.finish().unwrap();
    let lattice = *outcome.map.lattice();
    let states = outcome.map.window().unwrap().map(|prob| Thresholds::default().state_of(prob));
    let (picture, yaml) = map_server::draw_states(&states, &lattice, "map.pgm").unwrap();
    let text = yaml.with_picture(&picture).unwrap().to_text();
    let rules = FloorPlanRules { unknown_is_solid: false, cell_m: None, world_from_map };
    let borders = read(&text, &rules).unwrap().walls;
    let nearest = |place: Vec2| {
        let wall_m = world.static_map().nearest_distance(place, 5.0).unwrap_or(5.0);
        let things = world.things().iter();
        things.map(|t| distance_m(place, t.spec.polygon.corners())).fold(wall_m, f64::min)
    };
    let distances: Vec<f64> = borders.into_iter().flat_map(places).map(nearest).collect();
    let mean_m = distances.iter().sum::<f64>() / distances.len().max(1) as f64;
    (mean_m, lattice.resolution_m, distances.len())
}

#[test]
fn a_recorded_laser_mission_gives_its_world_back() {
    let (mean_m, cell_m, n_places) = mapped("laser-ward", "carrier/front");
    println!("mean wall distance {mean_m:.4} m of {n_places} places, cells of {cell_m} m");
    assert!(n_places > 500, "{n_places}");
    assert!(mean_m <= cell_m, "{mean_m} m");
}
