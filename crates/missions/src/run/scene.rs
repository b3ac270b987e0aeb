//! The fixed part of what a run shows.

use geometry::{Se2, Vec2};
use path_following::{Path, Piece};
use simulator::{Thing, ThingKind};

use super::{
    Run,
    limits::{N_REPORTED_MAX, N_SONARS_SHOWN},
    vehicle::Vehicle,
};
use crate::{
    mission::{
        parts::Parts,
        plan::{Action, DevicePlan, DeviceWiring, GoalPose, LinkPlan, RobotPlan},
    },
    view::{
        Scene, SceneDevice, SceneFunction, SceneLink, SceneOperand, ScenePheromones, SceneProgram,
        SceneRobot, SceneSonar, SceneTags, SceneThing, SceneWall,
    },
};

impl Run {
    /// What does not change during the run.
    pub fn scene(&self) -> Scene {
        scene(self)
    }
}

fn scene(run: &Run) -> Scene {
    let parts = run.mission.parts();
    let initial = |t: &&Thing| t.id.0 < run.n_initial_things;
    let wall = |&(segment, material): &(geometry::Segment, u32)| SceneWall {
        a: segment.a,
        b: segment.b,
        material: material_name(material),
    };
    Scene {
        bounds_m: parts.world.bounds,
        walls: parts.world.walls.iter().map(wall).collect(),
        points_m: parts.world.points.iter().map(|p| p.0).collect(),
        things: run.world.things().iter().filter(initial).map(|t| thing(t, false)).collect(),
        rooms: parts.world.rooms.clone(),
        devices: parts.devices.iter().map(device).collect(),
        robots: (0..)
            .zip(&parts.robots)
            .map(|(i, plan)| robot(plan, goal_tolerance_m(parts, i)))
            .collect(),
        pheromones: parts.pheromones.as_ref().map(pheromones),
        tags: run.world.floor_tags().map(|tags| SceneTags {
            pitch_m: tags.pitch_m(),
            strengths: tags.tags().map(|(_, tag)| (tag.in_map, tag.strength)).collect(),
        }),
        planned_path_m: planned_path(parts),
        program: parts.decision.as_ref().map(program),
        links: links(&run.vehicles),
    }
}

fn material_name(material: u32) -> String {
    let found = sensor_models::materials().get(material as usize);
    found.map_or_else(String::new, |m| m.name.to_owned())
}

/// A thing as screens show it.
pub(super) fn thing(thing: &Thing, removable: bool) -> SceneThing {
    SceneThing {
        id: thing.id.0,
        name: thing.spec.name.clone(),
        kind: match thing.spec.kind {
            ThingKind::Box => "box",
            ThingKind::Door => "door",
            ThingKind::Furniture | ThingKind::Other => "furniture",
        },
        material: material_name(thing.spec.material),
        corners_m: thing.spec.polygon.corners().to_vec(),
        removable,
    }
}

fn device(plan: &DevicePlan) -> SceneDevice {
    let (kind, area_m, input, output) = match &plan.wiring {
        DeviceWiring::Button { input } => ("button", Vec::new(), *input, None),
        DeviceWiring::Motion { input, zone } => ("motion", zone.corners().to_vec(), *input, None),
        DeviceWiring::Latch { output, .. } => ("latch", Vec::new(), None, Some(*output)),
        DeviceWiring::Lamp { output, .. } => ("lamp", Vec::new(), None, Some(*output)),
    };
    let (name, label) = (plan.name.clone(), plan.label.clone());
    SceneDevice { name, label, kind, at_m: plan.at, area_m, input, output }
}

/// How near a robot has to come to its goal, when the mission says so.
fn goal_tolerance_m(parts: &Parts, robot: usize) -> Option<f64> {
    parts.success.iter().find_map(|requirement| requirement.arrival_within_m(robot))
}

fn robot(plan: &RobotPlan, goal_tolerance_m: Option<f64>) -> SceneRobot {
    let sonar = |mount: &robot_models::SonarMount| SceneSonar {
        base_from_sensor: mount.base_from_sensor.se2(),
        half_angle_rad: plan.sonar.half_angle_rad,
        range_max_m: plan.sonar.range_max_m,
    };
    let by_hand = super::hand::limits(&plan.model);
    SceneRobot {
        name: plan.name.clone(),
        model: plan.model.title.clone(),
        footprint_m: plan.model.footprint.corners().to_vec(),
        sonars: plan.model.sonars.iter().take(N_SONARS_SHOWN).map(sonar).collect(),
        scanners: plan.lasers.iter().map(super::scan_log::scene).collect(),
        start: plan.start,
        tag_readers_m: plan.tag_readers.iter().flat_map(|r| r.in_base.clone()).collect(),
        tag_range_m: plan.tag_readers.as_ref().map_or(0.0, |r| r.model.range_m),
        goal_tolerance_m,
        is_elsewhere: matches!(plan.link, LinkPlan::Tcp { .. } | LinkPlan::Serial { .. }),
        hand_speed_max_mps: by_hand.speed_max_mps,
        hand_turn_rate_max_radps: by_hand.turn_rate_max_radps,
    }
}

fn pheromones(plan: &crate::mission::plan::PheromonePlan) -> ScenePheromones {
    let field = &plan.field;
    let (width, height) = (field.width(), field.height());
    let cells = (0..height).flat_map(|row| (0..width).map(move |col| (col, row)));
    let half = 0.5 * field.cell_size_m();
    // The field counts its rows downwards, as map files do; screens count upwards.
    let top = height.saturating_sub(1);
    ScenePheromones {
        cell_m: field.cell_size_m(),
        width,
        height,
        origin_m: field.cell_centre(0, top) - Vec2::new(half, half),
        values: cells
            .map(|(col, row)| (col, top - row, field.value(col, row)))
            .filter(|&(_, _, value)| value > 0)
            .collect(),
        sigma_m: plan.sense.sigma_m,
        antenna_spacing_m: plan.sense.antenna_spacing_m,
    }
}

/// The first trail; without one, straight lines from the first robot's start over its goals.
fn planned_path(parts: &Parts) -> Vec<Vec2> {
    let of_server = parts.pheromones.as_ref().and_then(|p| p.trails.first());
    if let Some(trail) = of_server.or(parts.tags.as_ref().and_then(|t| t.trails.first())) {
        return trail.clone();
    }
    let Some(first) = parts.robots.first() else { return Vec::new() };
    if let Some(teleoperator) = &first.teleoperator {
        return corners(&teleoperator.path);
    }
    if let Some(path) = &first.path {
        return corners(path);
    }
    let goals = parts.events.iter().filter_map(|event| match &event.action {
        Action::Goal { robots, pose } if robots.contains(&0) => Some(resolved(*pose, first.start)),
        _ => None,
    });
    let path: Vec<Vec2> = std::iter::once(first.start.position()).chain(goals).collect();
    if path.len() < 2 { Vec::new() } else { path }
}

/// Where the pieces of a path meet, and points on its arcs.
fn corners(path: &Path) -> Vec<Vec2> {
    let points = |piece: &Piece| {
        let n_points = if matches!(piece, Piece::Arc(_)) { 6 } else { 1 };
        let (piece, step_m) = (*piece, piece.length_m() / f64::from(n_points));
        (0..n_points).map(move |i| piece.pose_at(f64::from(i) * step_m).position())
    };
    path.pieces().iter().flat_map(points).chain([path.end().position()]).collect()
}

fn resolved(pose: GoalPose, start: Se2) -> Vec2 {
    pose.resolve(start).position()
}

fn program(plan: &crate::mission::plan::DecisionPlan) -> SceneProgram {
    let operand = |o: &decision::Operand, timer: Option<String>| SceneOperand {
        text: o.text.clone(),
        resource: o.resource().map(|id| id.to_string()).or(timer),
        column: o.column,
        length: o.length,
    };
    let function = |f: &decision::Function| SceneFunction {
        line: f.line,
        mnemonic: f.mnemonic.name().to_owned(),
        operands: (0..)
            .zip(&f.operands)
            .map(|(i, o)| operand(o, (i == 0).then(|| timer_output(f)).flatten()))
            .collect(),
    };
    SceneProgram {
        source: plan.source.clone(),
        mode: if plan.listing_mode { "listing" } else { "corrected" },
        functions: plan.program.functions().iter().map(function).collect(),
    }
}

/// The output of the timer that a TIMER sets, which is what its first operand, a number, stands for.
fn timer_output(function: &decision::Function) -> Option<String> {
    function.timer().map(|number| format!("YTMR{number}"))
}

/// The lines of the robots, in the robots' order; the trace names them by their place here.
fn links(vehicles: &[Vehicle]) -> Vec<SceneLink> {
    let several = vehicles.len() > 1;
    // Hundreds of direct robots have no links to look at.
    let shown = vehicles.iter().enumerate().take(N_REPORTED_MAX);
    shown.flat_map(|(i, v)| v.scene_links(i, several.then_some(v.name.as_str()))).collect()
}
