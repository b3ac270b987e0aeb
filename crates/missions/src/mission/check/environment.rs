//! Checks of `[world]`, `[[devices]]` and `[pheromones]`.

use geometry::{Polygon, Se2, Segment, SegmentWorld, Vec2};
use pheromones::{Field, Perception, SenseConfig};

use super::super::{
    error::Wrong,
    file::{
        DeviceFile, MissionFile, PersonFile, PheromonesFile, RandomBoxesFile, ThingFile, WallFile,
    },
    plan::{
        BoxRegion, DevicePlan, DeviceWiring, FailsafeOutput, PersonPlan, PheromonePlan,
        RandomBoxes, RobotPlan, ThingPlan, WorldPlan,
    },
    words::{DeviceKind, LineKind},
};
use super::common::{Checked, chosen, line, picked, point, range, unique};

/// `[world]`.
pub(super) fn world(file: &MissionFile, trails: Option<&PheromonePlan>) -> Checked<WorldPlan> {
    let world = &file.world;
    let [x0, y0, x1, y1] = world.bounds_m;
    if !(x0 < x1 && y0 < y1 && world.bounds_m.iter().all(|v| v.abs() <= 10_000.0)) {
        let allowed = "x0, y0, x1, y1 with x0 < x1 and y0 < y1, within 10000 m";
        return Err(Wrong::new("world.bounds_m", world.bounds_m, allowed));
    }
    unique("world.things", world.things.iter().map(|t| t.name.as_str()))?;
    unique("world.people", world.people.iter().map(|p| p.name.as_str()))?;
    let mut plan = WorldPlan { bounds: world.bounds_m, point_size_m: 0.02, ..WorldPlan::default() };
    super::map::add(&mut plan, world, material("world.map", "plaster")?)?;
    for (i, wall) in world.walls.iter().enumerate() {
        add_wall(&mut plan, &format!("world.walls[{i}]"), wall)?;
    }
    for (i, room) in world.rooms.iter().enumerate() {
        let at = point(format!("world.rooms[{i}].at_m"), room.at_m)?;
        plan.rooms.push((room.name.clone(), at));
    }
    for (i, one) in world.things.iter().enumerate() {
        plan.things.push(thing(&format!("world.things[{i}]"), one)?);
    }
    for (i, one) in world.people.iter().enumerate() {
        plan.people.push(person(&format!("world.people[{i}]"), one)?);
    }
    unique("world.random_boxes", world.random_boxes.iter().map(|b| b.name.as_str()))?;
    for (i, boxes) in world.random_boxes.iter().enumerate() {
        plan.random_boxes.push(random_boxes(&format!("world.random_boxes[{i}]"), boxes, trails)?);
    }
    Ok(plan)
}

fn material(key: &str, name: &str) -> Checked<u32> {
    let names = sensor_models::materials().iter().map(|m| m.name).zip(0_u32..);
    picked(&format!("{key}.material"), name, names)
}

fn add_wall(plan: &mut WorldPlan, key: &str, wall: &WallFile) -> Checked<()> {
    let material = material(key, &wall.material)?;
    if wall.line_m.len() < 2 {
        let found = format!("{} corners", wall.line_m.len());
        return Err(Wrong::prose(format!("{key}.line_m"), found, "two or more corners"));
    }
    let corner = |(j, &p): (usize, &[f64; 2])| point(format!("{key}.line_m[{j}]"), p);
    let corners = wall.line_m.iter().enumerate().map(corner).collect::<Checked<Vec<Vec2>>>()?;
    plan.walls.extend(corners.windows(2).map(|w| (Segment { a: w[0], b: w[1] }, material)));
    if let (true, Some(&a), Some(&b)) = (wall.closed, corners.last(), corners.first()) {
        plan.walls.push((Segment { a, b }, material));
    }
    Ok(())
}

fn thing(key: &str, file: &ThingFile) -> Checked<ThingPlan> {
    let kind = chosen(&format!("{key}.kind"), &file.kind)?;
    for (axis, size) in file.size_m.into_iter().enumerate() {
        range(format!("{key}.size_m[{axis}]"), size, 0.01..=100.0, "from 0.01 to 100 m")?;
    }
    let at = point(format!("{key}.at_m"), file.at_m)?;
    range(format!("{key}.yaw_deg"), file.yaw_deg, -360.0..=360.0, "from -360 to 360 degrees")?;
    let world_from_thing = Se2::new(at.x, at.y, file.yaw_deg.to_radians());
    Ok(ThingPlan {
        name: file.name.clone(),
        kind,
        corners: rectangle(world_from_thing, Vec2::new(file.size_m[0], file.size_m[1])),
        material: material(key, &file.material)?,
    })
}

/// The corners of a rectangle of that size about a pose, counter-clockwise (m).
pub(crate) fn rectangle(centre: Se2, size: Vec2) -> Vec<Vec2> {
    [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)]
        .map(|(x, y)| centre.transform_point(Vec2::new(x * size.x, y * size.y)))
        .to_vec()
}

fn person(key: &str, file: &PersonFile) -> Checked<PersonPlan> {
    if file.route_m.is_empty() {
        let allowed = "one or more corners; the first is where the person stands";
        return Err(Wrong::new(format!("{key}.route_m"), &file.route_m, allowed));
    }
    let corner = |(j, &p): (usize, &[f64; 2])| point(format!("{key}.route_m[{j}]"), p);
    let at = |name: &str| format!("{key}.{name}");
    Ok(PersonPlan {
        name: file.name.clone(),
        route: file.route_m.iter().enumerate().map(corner).collect::<Checked<_>>()?,
        speed_mps: range(at("speed_mps"), file.speed_mps, 0.05..=3.0, "from 0.05 to 3 m/s")?,
        speed_spread_mps: range(
            at("speed_spread_mps"),
            file.speed_spread_mps,
            0.0..=3.0,
            "from 0 to 3 m/s",
        )?,
        starts_at_s: range(
            at("starts_at_s"),
            file.starts_at_s,
            0.0..=86_400.0,
            "from 0 to 86400 s",
        )?,
        starts_spread_s: range(
            at("starts_spread_s"),
            file.starts_spread_s,
            0.0..=86_400.0,
            "from 0 to 86400 s",
        )?,
        repeats: file.repeats,
        yields: file.yields,
        radius_m: range(at("radius_m"), file.radius_m, 0.05..=1.0, "from 0.05 to 1 m")?,
    })
}

fn random_boxes(
    key: &str,
    file: &RandomBoxesFile,
    trails: Option<&PheromonePlan>,
) -> Checked<RandomBoxes> {
    let at = |name: &str| format!("{key}.{name}");
    if file.count > 1000 {
        return Err(Wrong::new(at("count"), file.count, "at most 1000"));
    }
    for (axis, size) in file.size_m.into_iter().enumerate() {
        range(format!("{key}.size_m[{axis}]"), size, 0.01..=10.0, "from 0.01 to 10 m")?;
    }
    let region = match (file.along_trail_m.as_slice(), file.area_m.as_slice()) {
        (&[from_m, to_m], []) if 0.0 <= from_m && from_m <= to_m => {
            if trails.is_none_or(|t| t.trails.is_empty()) {
                let allowed = "absent, because the mission has no [pheromones] with trails_m";
                return Err(Wrong::new(at("along_trail_m"), &file.along_trail_m, allowed));
            }
            let offset_max_m =
                range(at("offset_max_m"), file.offset_max_m, 0.0..=100.0, "from 0 to 100 m")?;
            BoxRegion::AlongTrail { from_m, to_m, offset_max_m }
        }
        ([], &[x0, y0, x1, y1]) if x0 < x1 && y0 < y1 => BoxRegion::Area([x0, y0, x1, y1]),
        _ => {
            let allowed =
                "two arc lengths, the smaller first, or instead area_m with x0, y0, x1, y1";
            return Err(Wrong::new(at("along_trail_m"), &file.along_trail_m, allowed));
        }
    };
    Ok(RandomBoxes {
        name: file.name.clone(),
        count: file.count,
        size_m: Vec2::new(file.size_m[0], file.size_m[1]),
        material: material(key, &file.material)?,
        region,
        passage_m: range(at("passage_m"), file.passage_m, 0.0..=10.0, "from 0 to 10 m")?,
        clearance_m: range(at("clearance_m"), file.clearance_m, 0.0..=10.0, "from 0 to 10 m")?,
    })
}

/// `[[devices]]`, with inputs and outputs that exist and belong to one device each.
pub(super) fn devices(file: &MissionFile) -> Checked<Vec<DevicePlan>> {
    unique("devices", file.devices.iter().map(|d| d.name.as_str()))?;
    let check = |(i, d): (usize, &DeviceFile)| device(&format!("devices[{i}]"), d);
    let plans = file.devices.iter().enumerate().map(check).collect::<Checked<Vec<_>>>()?;
    for (i, device) in file.devices.iter().enumerate() {
        for (key, of) in
            [("input", (|d| d.input) as fn(&DeviceFile) -> Option<u8>), ("output", |d| d.output)]
        {
            let Some(number) = of(device) else { continue };
            if let Some(other) = file.devices[..i].iter().find(|d| of(d) == Some(number)) {
                let allowed = format!("a number of its own; `{}` has this one", other.name);
                return Err(Wrong::new(format!("devices[{i}].{key}"), number, allowed));
            }
        }
    }
    Ok(plans)
}

fn device(key: &str, file: &DeviceFile) -> Checked<DevicePlan> {
    let kind: DeviceKind = chosen(&format!("{key}.kind"), &file.kind)?;
    let number = |name: &str, value: Option<u8>| match value {
        Some(n) if n > 15 => Err(Wrong::new(format!("{key}.{name}"), n, "from 0 to 15")),
        other => Ok(other),
    };
    let input = number("input", file.input)?;
    let output = number("output", file.output)?;
    if let Some(output) = output.filter(|_| kind.is_input()) {
        let allowed = format!("absent: a {} is an input", file.kind);
        return Err(Wrong::new(format!("{key}.output"), output, allowed));
    }
    if let Some(input) = input.filter(|_| !kind.is_input()) {
        let allowed = format!("absent: a {} is an output", file.kind);
        return Err(Wrong::new(format!("{key}.input"), input, allowed));
    }
    let failsafe: FailsafeOutput = chosen(&format!("{key}.failsafe"), &file.failsafe)?;
    if kind.is_input() && failsafe != FailsafeOutput::Off {
        let allowed = format!("absent: a {} is an input", file.kind);
        return Err(Wrong::new(format!("{key}.failsafe"), &file.failsafe, allowed));
    }
    let missing = || Wrong::prose(format!("{key}.output"), "absent", "a number from 0 to 15");
    let wiring = match kind {
        DeviceKind::Button => DeviceWiring::Button { input },
        DeviceKind::Motion => DeviceWiring::Motion { input, zone: zone(key, file)? },
        DeviceKind::Latch => DeviceWiring::Latch { output: output.ok_or_else(missing)?, failsafe },
        DeviceKind::Lamp => DeviceWiring::Lamp { output: output.ok_or_else(missing)?, failsafe },
    };
    let label = if file.label.is_empty() { &file.name } else { &file.label };
    let at = point(format!("{key}.at_m"), file.at_m)?;
    Ok(DevicePlan { name: file.name.clone(), label: label.clone(), at, wiring })
}

fn zone(key: &str, file: &DeviceFile) -> Checked<Polygon> {
    let key = format!("{key}.area_m");
    let corner = |(j, &p): (usize, &[f64; 2])| point(format!("{key}[{j}]"), p);
    let corners = file.area_m.iter().enumerate().map(corner).collect::<Checked<Vec<Vec2>>>()?;
    Polygon::new(corners).map_err(|e| {
        Wrong::prose(&key, e.to_string(), "three or more corners of a simple polygon, in order")
    })
}

/// `[pheromones]`.
pub(super) fn pheromones(file: &PheromonesFile) -> Checked<PheromonePlan> {
    let key = "pheromones";
    let cell_m = range("pheromones.cell_m", file.cell_m, 0.02..=2.0, "from 0.02 to 2 m")?;
    for (name, n) in [("width", file.width), ("height", file.height)] {
        if !(1..=2000).contains(&n) {
            return Err(Wrong::new(format!("{key}.{name}"), n, "from 1 to 2000 cells"));
        }
    }
    if !matches!(file.width_cells, 1 | 3 | 5) {
        return Err(Wrong::new("pheromones.width_cells", file.width_cells, "1, 3 or 5"));
    }
    if !(1..=127).contains(&file.value) {
        return Err(Wrong::new("pheromones.value", file.value, "from 1 to 127"));
    }
    let sigma = range("pheromones.sigma_m", file.sigma_m, 0.05..=5.0, "from 0.05 to 5 m")?;
    let spacing = range(
        "pheromones.antenna_spacing_m",
        file.antenna_spacing_m,
        0.02..=2.0,
        "from 0.02 to 2 m",
    )?;
    let perception = chosen("pheromones.perception", &file.perception)?;
    let trails = trails(file)?;
    let field = match &file.map {
        Some(text) => Field::from_text(text, cell_m).map_err(|e| {
            Wrong::prose("pheromones.map", e.to_string(), "a matrix of values from 0 to 127")
        })?,
        None => drawn_field(file, &trails)?,
    };
    Ok(PheromonePlan {
        field: field.into(),
        trails,
        sense: SenseConfig {
            perception,
            sigma_m: sigma,
            antenna_spacing_m: spacing,
            strict: perception == Perception::Listing,
        },
        scale_ratio: range(
            "pheromones.scale_ratio",
            file.scale_ratio,
            0.001..=1.0,
            "from 0.001 to 1",
        )?,
        link: line("pheromones.line", &file.line, LineKind::SIMULATED)?,
    })
}

fn trails(file: &PheromonesFile) -> Checked<Vec<Vec<Vec2>>> {
    let mut trails = Vec::new();
    for (i, trail) in file.trails_m.iter().enumerate() {
        let key = format!("pheromones.trails_m[{i}]");
        if trail.len() < 2 {
            return Err(Wrong::new(key, trail, "two or more corners"));
        }
        let corner = |(j, &p): (usize, &[f64; 2])| point(format!("{key}[{j}]"), p);
        trails.push(trail.iter().enumerate().map(corner).collect::<Checked<Vec<Vec2>>>()?);
    }
    Ok(trails)
}

fn drawn_field(file: &PheromonesFile, trails: &[Vec<Vec2>]) -> Checked<Field> {
    let mut field = Field::new(file.width, file.height, file.cell_m).map_err(|e| {
        Wrong::prose("pheromones.width", e.to_string(), "a grid that fits into memory")
    })?;
    for (i, trail) in trails.iter().enumerate() {
        let inside = |p: &Vec2| {
            let limit = |n: usize| n as f64 * file.cell_m / 2.0;
            p.x.abs() <= limit(file.width) && p.y.abs() <= limit(file.height)
        };
        if let Some(j) = trail.iter().position(|p| !inside(p)) {
            let allowed = "a corner on the grid, which is centred on the origin";
            let found = [trail[j].x, trail[j].y];
            return Err(Wrong::new(format!("pheromones.trails_m[{i}][{j}]"), found, allowed));
        }
        field.draw_wide_trail(trail, file.value, file.width_cells);
    }
    Ok(field)
}

/// No robot starts inside a wall or a thing, in a person or in another robot; no person stands in a thing. Robots
/// elsewhere have no body here.
pub(super) fn starts_are_free(
    file: &MissionFile,
    world: &WorldPlan,
    robots: &[RobotPlan],
) -> Checked<()> {
    people_are_free(world)?;
    let walls = SegmentWorld::with_points(
        world.walls.iter().copied(),
        world.points.iter().copied(),
        world.point_size_m,
    );
    let blocked = |robot: &RobotPlan, allowed: String| {
        let table = file.robots.iter().position(|table| table.name == robot.group);
        let start = [robot.start.x_m, robot.start.y_m, robot.start.yaw_rad.to_degrees()];
        Err(Wrong::new(format!("robots[{}].start", table.unwrap_or_default()), start, allowed))
    };
    for robot in robots {
        let name = &robot.name;
        let footprint = robot.model.footprint.transformed(robot.start);
        if walls.touches_polygon(footprint.corners()) {
            return blocked(robot, format!("a place where `{name}` touches no wall"));
        }
        if world.is_solid(robot.start.position()) {
            let allowed = format!(
                "a place in the free space of the map for `{name}`; this is within a wall, or in what the map \
                 does not know (world.unknown)"
            );
            return blocked(robot, allowed);
        }
        if let Some(thing) = world.things.iter().find(|t| overlap(&t.corners, footprint.corners()))
        {
            let thing = &thing.name;
            return blocked(robot, format!("a place where `{name}` does not touch `{thing}`"));
        }
        let touched =
            |p: &&PersonPlan| footprint.distance(p.route[0]) <= p.radius_m && !robot.is_elsewhere();
        if let Some(person) = world.people.iter().find(touched) {
            let person = &person.name;
            let allowed = format!("a place where `{name}` does not touch the person `{person}`");
            return blocked(robot, allowed);
        }
    }
    match first_two_that_touch(robots) {
        Some((first, second)) => {
            let (name, other) = (&second.name, &first.name);
            blocked(second, format!("a place where `{name}` does not touch the robot `{other}`"))
        }
        None => Ok(()),
    }
}

/// Two robots whose footprints share a point; the one that comes first in the mission is the first. Cost: about linear
/// in the robots, unless many of them have one x.
fn first_two_that_touch(robots: &[RobotPlan]) -> Option<(&RobotPlan, &RobotPlan)> {
    let reach_m = |robot: &RobotPlan| robot.model.bounding_radius_m();
    let most_m = robots.iter().map(reach_m).fold(0.0, f64::max);
    let mut by_x: Vec<usize> = (0..robots.len()).filter(|&i| !robots[i].is_elsewhere()).collect();
    by_x.sort_by(|&a, &b| robots[a].start.x_m.total_cmp(&robots[b].start.x_m));
    let mut touching: Option<(usize, usize)> = None;
    for (n, &i) in by_x.iter().enumerate() {
        let one = &robots[i];
        let near = |j: &&usize| robots[**j].start.x_m - one.start.x_m <= 2.0 * most_m;
        for &j in by_x[n + 1..].iter().take_while(near) {
            let other = &robots[j];
            let apart_m = (one.start.position() - other.start.position()).norm();
            if apart_m > reach_m(one) + reach_m(other) {
                continue;
            }
            let outline = |robot: &RobotPlan| robot.model.footprint.transformed(robot.start);
            let pair = (i.min(j), i.max(j));
            if touching.is_none_or(|first| (pair.1, pair.0) < (first.1, first.0))
                && overlap(outline(one).corners(), outline(other).corners())
            {
                touching = Some(pair);
            }
        }
    }
    touching.map(|(first, second)| (&robots[first], &robots[second]))
}

/// No person stands in a thing when the run begins.
fn people_are_free(world: &WorldPlan) -> Checked<()> {
    for (i, person) in world.people.iter().enumerate() {
        let stands_in = |thing: &&ThingPlan| {
            Polygon::new(thing.corners.clone())
                .is_ok_and(|outline| outline.distance(person.route[0]) <= person.radius_m)
        };
        if let Some(thing) = world.things.iter().find(stands_in) {
            let (name, thing) = (&person.name, &thing.name);
            let allowed = format!("a place where `{name}` does not touch `{thing}`");
            let at = [person.route[0].x, person.route[0].y];
            return Err(Wrong::new(format!("world.people[{i}].route_m[0]"), at, allowed));
        }
    }
    Ok(())
}

/// Whether two convex polygons share a point, by separating axes.
pub(crate) fn overlap(one: &[Vec2], two: &[Vec2]) -> bool {
    let separated = |a: &[Vec2], b: &[Vec2]| {
        (0..a.len()).any(|i| {
            let edge = a[(i + 1) % a.len()] - a[i];
            let outward = Vec2::new(edge.y, -edge.x);
            b.iter().all(|&p| (p - a[i]).dot(&outward) > 0.0)
        })
    };
    !separated(one, two) && !separated(two, one)
}
