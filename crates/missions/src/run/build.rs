//! Putting a mission in place: the world with what the seed adds, the robots, the decision node.

use geometry::{Polygon, Ray, RayCaster, Se2, SegmentWorld, Vec2};
use path_following::Path;
use rand_core::Rng;
use run_context::{RandomStream, RunSeed, Stamp};
use simulator::{
    BodyId, PersonSpec, RobotPlacement, ThingKind, ThingSpec, World, WorldError, WorldSpec,
};

use super::{error::RunError, limits::STEP, tags, vehicle::Vehicle};
use crate::{
    intervention::InterventionError,
    mission::{
        Mission, SettingError, Wrong, overlap,
        plan::{BoxRegion, LinkPlan, PersonPlan, PlannedKind, RandomBoxes, RobotPlan, ThingPlan},
        rectangle,
    },
    node::decision::DecisionNode,
};

/// Places tried for a random box before the run is refused.
const TRIES_MAX: u32 = 2000;
/// How far to look for walls beside a random box, m.
const PASSAGE_LOOK_M: f64 = 5.0;
/// Things on the floor from which on no box is put down any more.
const N_THINGS_MAX: usize = 2000;
/// Least and greatest side of a box that is put down, m.
const BOX_SIZES_M: std::ops::RangeInclusive<f64> = 0.05..=3.0;

/// The world and how many things it has at the beginning.
pub(super) fn world(mission: &Mission, seed: RunSeed) -> Result<(World, u64), RunError> {
    let plan = &mission.parts().world;
    let static_map = SegmentWorld::with_points(
        plan.walls.iter().copied(),
        plan.points.iter().copied(),
        plan.point_size_m,
    );
    let mut things: Vec<ThingSpec> = plan.things.iter().filter_map(thing_spec).collect();
    let people: Vec<PersonSpec> = plan.people.iter().map(|p| person_spec(p, seed)).collect();
    for (table, boxes) in plan.random_boxes.iter().enumerate() {
        random_boxes(mission, seed, (table, boxes), &static_map, &mut things)?;
    }
    let n_things = things.len() as u64;
    let refuse = |source| refused(mission, source);
    let spec = WorldSpec { static_map, things, people };
    let mut world = World::new(spec, seed, STEP).map_err(refuse)?;
    if let Some(floor) = mission.parts().tags.as_ref().and_then(|plan| tags::floor(plan, seed)) {
        world.set_floor_tags(floor);
    }
    Ok((world, n_things))
}

fn thing_spec(plan: &ThingPlan) -> Option<ThingSpec> {
    let kind = match plan.kind {
        PlannedKind::Furniture => ThingKind::Furniture,
        PlannedKind::Box => ThingKind::Box,
        PlannedKind::Door => ThingKind::Door,
    };
    // A rectangle with checked sides is always a polygon.
    let polygon = Polygon::new(plan.corners.clone()).ok()?;
    Some(ThingSpec {
        name: plan.name.clone(),
        kind,
        polygon,
        material: plan.material,
        movable: false,
    })
}

fn person_spec(plan: &PersonPlan, seed: RunSeed) -> PersonSpec {
    let mut rng = seed.stream(&format!("person/{}", plan.name));
    let speed_mps = plan.speed_mps + plan.speed_spread_mps * uniform(&mut rng);
    let starts_at_s = plan.starts_at_s + plan.starts_spread_s * uniform(&mut rng);
    PersonSpec {
        name: plan.name.clone(),
        route: plan.route.clone(),
        speed_mps,
        starts_at: Stamp::from_millis((starts_at_s * 1e3).round() as u64),
        repeats: plan.repeats,
        yields: plan.yields,
        radius_m: plan.radius_m,
    }
}

/// An even draw from [0, 1).
fn uniform(rng: &mut RandomStream) -> f64 {
    // 53 bits are what an f64 in [0, 1) can hold.
    (rng.next_u64() >> 11) as f64 * 2.0_f64.powi(-53)
}

fn random_boxes(
    mission: &Mission,
    seed: RunSeed,
    (table, boxes): (usize, &RandomBoxes),
    walls: &SegmentWorld,
    things: &mut Vec<ThingSpec>,
) -> Result<(), RunError> {
    let mut rng = seed.stream(&format!("random_boxes/{}", boxes.name));
    for n in 0..boxes.count {
        let name =
            if boxes.count == 1 { boxes.name.clone() } else { format!("{} {}", boxes.name, n + 1) };
        let place = (0..TRIES_MAX).find_map(|_| {
            let pose = draw_pose(mission, &boxes.region, &mut rng)?;
            is_fit(mission, boxes, pose, walls, things).then_some(pose)
        });
        let Some(pose) = place else {
            let key = format!("world.random_boxes[{table}].count");
            let (n, seed) = (boxes.count, seed.0);
            let found =
                format!("{n} (no place for `{name}` after {TRIES_MAX} tries with seed {seed})");
            let allowed =
                "fewer, or the region larger, or size_m, passage_m or clearance_m smaller";
            let wrong = Wrong::prose(key, found, allowed);
            return Err(RunError::Setting(Box::new(mission.locate(wrong))));
        };
        things.extend(thing_spec(&ThingPlan {
            name,
            kind: PlannedKind::Box,
            corners: rectangle(pose, boxes.size_m),
            material: boxes.material,
        }));
    }
    Ok(())
}

/// A pose in the region; its heading is that of the trail where there is one.
fn draw_pose(mission: &Mission, region: &BoxRegion, rng: &mut RandomStream) -> Option<Se2> {
    let [a, b, c] = [uniform(rng), uniform(rng), uniform(rng)];
    match *region {
        BoxRegion::AlongTrail { from_m, to_m, offset_max_m } => {
            let trail = mission.parts().pheromones.as_ref()?.trails.first()?;
            let path = Path::polyline(trail).ok()?;
            let s = from_m + a * (to_m - from_m);
            let on_trail = path.pose_at(s);
            let offset_m = offset_max_m * (2.0 * b - 1.0);
            let heading = on_trail.yaw_rad;
            let left = Vec2::new(-heading.sin(), heading.cos());
            let at = on_trail.position() + left * offset_m;
            // Turned against the trail by up to 45 degrees; a square looks the same beyond.
            let turn = (c - 0.5) * std::f64::consts::FRAC_PI_2;
            Some(Se2::new(at.x, at.y, heading + turn))
        }
        BoxRegion::Area([x0, y0, x1, y1]) => {
            let yaw = c * std::f64::consts::TAU;
            Some(Se2::new(x0 + a * (x1 - x0), y0 + b * (y1 - y0), yaw))
        }
    }
}

/// Whether a box there keeps its distances and leaves a passage on one side at least.
fn is_fit(
    mission: &Mission,
    boxes: &RandomBoxes,
    pose: Se2,
    walls: &SegmentWorld,
    things: &[ThingSpec],
) -> bool {
    let corners = rectangle(pose, boxes.size_m);
    let keep = boxes.clearance_m;
    let grown = rectangle(pose, boxes.size_m.add_scalar(2.0 * keep));
    if walls.touches_polygon(&corners)
        || mission.parts().world.is_solid(pose.position())
        || things.iter().any(|t| overlap(&grown, t.polygon.corners()))
    {
        return false;
    }
    let far = |p: Vec2, radius_m: f64| {
        (p - pose.position()).norm() > radius_m + keep + 0.5 * boxes.size_m.norm()
    };
    let parts = mission.parts();
    if !parts.robots.iter().all(|r| far(r.start.position(), r.model.radius_m))
        || !parts.world.people.iter().all(|p| far(p.route[0], p.radius_m))
    {
        return false;
    }
    boxes.passage_m == 0.0 || widest_side_m(mission, boxes, pose, walls) >= boxes.passage_m
}

/// The wider of the two gaps between the box and the walls, across the trail (or across the box's own
/// axis where there is no trail), m.
fn widest_side_m(mission: &Mission, boxes: &RandomBoxes, pose: Se2, walls: &SegmentWorld) -> f64 {
    let trail = mission.parts().pheromones.as_ref().and_then(|p| p.trails.first());
    let path = trail.and_then(|t| Path::polyline(t).ok());
    let along = path.map_or(pose.yaw_rad, |p| p.project(pose.position()).heading_rad);
    let left = Vec2::new(-along.sin(), along.cos());
    let reach = rectangle(pose, boxes.size_m)
        .iter()
        .map(|&c| (c - pose.position()).dot(&left).abs())
        .fold(0.0, f64::max);
    let gap = |direction: Vec2| {
        let ray = Ray { origin: pose.position(), direction };
        walls.cast(&ray, PASSAGE_LOOK_M).map_or(PASSAGE_LOOK_M, |hit| hit.distance_m) - reach
    };
    gap(left).max(gap(-left))
}

/// What the simulator refuses, with the place of the table that it is about.
fn refused(mission: &Mission, source: WorldError) -> RunError {
    let named = match &source {
        WorldError::Range { name, .. }
        | WorldError::DuplicateName { name }
        | WorldError::SpawnBlocked { name, .. }
        | WorldError::SpawnOutside { name, .. }
        | WorldError::ThingBlocked { name, .. }
        | WorldError::Material { name, .. }
        | WorldError::EmptyRoute { name }
        | WorldError::Errors { name, .. }
        | WorldError::Sonar { name, .. } => name.as_str(),
        _ => "",
    };
    let parts = mission.parts();
    let file = mission.file();
    let group = parts.robots.iter().find(|r| r.name == named).map(|r| r.group.as_str());
    let robot = file.robots.iter().position(|r| Some(r.name.as_str()) == group);
    let thing = || file.world.things.iter().position(|t| t.name == named);
    let person = || file.world.people.iter().position(|p| p.name == named);
    let key = robot
        .map(|i| format!("robots[{i}].start"))
        .or_else(|| thing().map(|i| format!("world.things[{i}].at_m")))
        .or_else(|| person().map(|i| format!("world.people[{i}].route_m")))
        .unwrap_or_else(|| "world".to_owned());
    let SettingError { origin, position, key, .. } = mission.locate(Wrong::prose(key, "", ""));
    let place = match position {
        Some((line, column)) => format!("{origin}:{line}:{column}: {key}"),
        None => format!("{origin}: {key}"),
    };
    RunError::World { place, source }
}

/// Puts the bodies of the robots into the world; one that is elsewhere has none.
pub(super) fn bodies(
    mission: &Mission,
    world: &mut World,
) -> Result<Vec<Option<BodyId>>, RunError> {
    let body = |plan: &RobotPlan| match plan.link {
        LinkPlan::Tcp { .. } | LinkPlan::Serial { .. } => Ok(None),
        LinkPlan::Memory(_) | LinkPlan::Direct => {
            world.add_robot(placement(plan)).map(Some).map_err(|source| refused(mission, source))
        }
    };
    mission.parts().robots.iter().map(body).collect()
}

/// The robots' nodes, each with its body in the world unless it is elsewhere.
pub(super) fn vehicles(
    mission: &Mission,
    seed: RunSeed,
    world: &mut World,
) -> Result<Vec<Vehicle>, RunError> {
    let bodies = bodies(mission, world)?;
    let vehicle = |(index, body)| Vehicle::new(mission, index, body, seed);
    bodies.into_iter().enumerate().map(vehicle).collect()
}

fn placement(plan: &RobotPlan) -> RobotPlacement {
    RobotPlacement {
        name: plan.name.clone(),
        model: plan.model.clone(),
        world_from_base: plan.start,
        errors: plan.errors,
        sonar: plan.sonar,
    }
}

/// The decision node.
pub(super) fn decision(mission: &Mission) -> Option<DecisionNode> {
    mission.parts().decision.as_ref().map(DecisionNode::new)
}

/// Puts a cardboard box with sides along the axes into the world.
pub(super) fn place_box(
    world: &mut World,
    name: &str,
    at: Vec2,
    size_m: f64,
) -> Result<(), InterventionError> {
    if !BOX_SIZES_M.contains(&size_m) {
        let what = "the side of a box";
        return Err(InterventionError::OutOfRange { what, allowed: "from 0.05 to 3 m" });
    }
    if !(at.x.abs() <= 10_000.0 && at.y.abs() <= 10_000.0) {
        let what = "the place of a box";
        return Err(InterventionError::OutOfRange { what, allowed: "within 10000 m" });
    }
    let refuse =
        |reason: String| InterventionError::NoRoom { x_m: at.x, y_m: at.y, size_m, reason };
    let corners = rectangle(Se2::new(at.x, at.y, 0.0), Vec2::new(size_m, size_m));
    if world.static_map().touches_polygon(&corners) {
        return Err(refuse("a wall is there".to_owned()));
    }
    if let Some(thing) = world.things().iter().find(|t| overlap(t.spec.polygon.corners(), &corners))
    {
        return Err(refuse(format!("{} is there", thing.spec.name)));
    }
    if world.things().len() >= N_THINGS_MAX {
        return Err(refuse(format!("there are {N_THINGS_MAX} things already; take some away")));
    }
    let polygon = Polygon::new(corners).map_err(|e| refuse(e.to_string()))?;
    let material = sensor_models::material_by_name("cardboard").map_or(0, |(index, _)| index);
    let kind = ThingKind::Box;
    let spec = ThingSpec { name: name.to_owned(), kind, polygon, material, movable: true };
    world.place_thing(spec).map(|_id| ()).map_err(|e| refuse(e.to_string()))
}
