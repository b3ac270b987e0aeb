//! A map that was made of a recording is a world: its walls are where the true ones are.

use std::sync::Arc;

use geometry::{Se2, Segment, Vec2};
use grid_maps::{Thresholds, files::map_server};
use simulator::floor_plan::{FloorPlanRules, read};
use surveys::{Clock, Survey, SurveyConfig, testing};

/// Spacing of the places on true walls that are looked up, m.
const EVERY_M: f64 = 0.05;

fn places(wall: Segment) -> impl Iterator<Item = Vec2> {
    let n = (wall.length() / EVERY_M).ceil().max(1.0) as u32;
    (0..=n).map(move |i| wall.point_at(f64::from(i) / f64::from(n)))
}

#[test]
fn a_mapped_room_has_its_walls_again() {
    let recording = Arc::new(testing::room(400));
    let world_from_map = recording.truth[0].pose;
    let mut survey = Survey::new(recording, SurveyConfig::default(), Clock::stopped()).unwrap();
    while survey.progress().n_done < survey.progress().n_scans {
        survey.step().unwrap();
    }
    let outcome = survey.finish().unwrap();
    let lattice = *outcome.map.lattice();
    let states = outcome.map.window().unwrap().map(|prob| Thresholds::default().state_of(prob));
    let (picture, yaml) = map_server::draw_states(&states, &lattice, "map.pgm").unwrap();
    let text = yaml.with_picture(&picture).unwrap().to_text();
    let truth = testing::walls();
    for unknown_is_solid in [true, false] {
        let rules = FloorPlanRules { unknown_is_solid, cell_m: None, world_from_map };
        let plan = read(&text, &rules).unwrap();
        // From the map to the truth: parts of true walls that no beam ever met cannot be in it. Solid unknown space ends
        // where nobody looked, so only the borders of occupied cells are compared.
        let borders = if unknown_is_solid { Vec::new() } else { plan.walls.clone() };
        let distances: Vec<f64> = borders
            .into_iter()
            .flat_map(places)
            .filter_map(|place| truth.nearest_distance(place, 5.0))
            .collect();
        let mean_m = distances.iter().sum::<f64>() / distances.len().max(1) as f64;
        println!(
            "mean wall distance {mean_m:.4} m of {} places, cells of {} m",
            distances.len(),
            lattice.resolution_m
        );
        assert!(unknown_is_solid || distances.len() > 500, "{}", distances.len());
        assert!(mean_m <= lattice.resolution_m, "{mean_m} m");
        // Where the robot drove it is free.
        let driven = |pose: &Se2| plan.is_solid(pose.position());
        let n_solid = outcome
            .trajectory
            .iter()
            .map(|p| world_from_map.compose(p.pose))
            .filter(driven)
            .count();
        assert_eq!(n_solid, 0);
    }
}
