//! Where several robots stand: where they were told to, or beside the first, in its sight.

use std::{f64::consts::TAU, sync::Arc};

use anyhow::bail;
use geometry::{Ray, RayCaster as _, Se2, Vec2};
use robot_models::{OdometryErrors, RobotModel};
use sensor_models::SonarModel;
use simulator::{BodyId, RobotPlacement, World};

/// Free space between two robots that are put beside each other, metres.
const GAP_M: f64 = 0.4;
/// Rings around the first robot that are tried.
const N_RINGS: u32 = 30;

/// Puts robots called `names` into the world: the first where `given` says or at `home`, the next
/// ones where `given` says or as near to the first as there is room that it could drive to straight.
///
/// # Errors
///
/// What keeps a robot from a place that was given, or that there is no room.
pub(super) fn place(
    world: &mut World,
    model: &Arc<RobotModel>,
    names: &[String],
    given: &[Se2],
    home: Se2,
) -> anyhow::Result<Vec<BodyId>> {
    let first = given.first().copied().unwrap_or(home);
    let mut bodies = Vec::new();
    for (index, name) in names.iter().enumerate() {
        let placement = |world_from_base| RobotPlacement {
            name: name.clone(),
            model: Arc::clone(model),
            world_from_base,
            errors: OdometryErrors::default(),
            sonar: SonarModel::default(),
        };
        let body = match given.get(index) {
            Some(&pose) => world.add_robot(placement(pose))?,
            None if index == 0 => world.add_robot(placement(first))?,
            None => {
                let spacing_m = 2.0 * model.bounding_radius_m() + GAP_M;
                let found = around(first, spacing_m)
                    .filter(|pose| sees(world, first.position(), pose.position()))
                    .collect::<Vec<_>>()
                    .into_iter()
                    .find_map(|pose| world.add_robot(placement(pose)).ok());
                let Some(body) = found else {
                    bail!(
                        "there is no room for robot {} of {} beside the first at ({:.2}, {:.2}) m",
                        index + 1,
                        names.len(),
                        first.x_m,
                        first.y_m
                    )
                };
                body
            }
        };
        bodies.push(body);
    }
    Ok(bodies)
}

/// Poses with the heading of `first` on rings around it, the nearest first; its left and right
/// before its front and back.
fn around(first: Se2, spacing_m: f64) -> impl Iterator<Item = Se2> {
    (1..=N_RINGS).flat_map(move |ring| {
        let n_places = 6 * ring;
        (0..n_places).map(move |place| {
            let bearing_rad = first.yaw_rad + TAU * (0.25 + f64::from(place) / f64::from(n_places));
            let way = f64::from(ring) * spacing_m * Vec2::new(bearing_rad.cos(), bearing_rad.sin());
            Se2::new(first.x_m + way.x, first.y_m + way.y, first.yaw_rad)
        })
    })
}

/// Whether no wall is between two places.
fn sees(world: &World, from: Vec2, to: Vec2) -> bool {
    let way = to - from;
    let ray = Ray { origin: from, direction: way.normalize() };
    world.static_map().cast(&ray, way.norm()).is_none()
}

/// The middle of the walls.
pub(super) fn middle(world: &World) -> Se2 {
    let bounds = world.static_map().bounds();
    let middle = (bounds.min + bounds.max) / 2.0;
    if middle.x.is_finite() && middle.y.is_finite() {
        Se2::new(middle.x, middle.y, 0.0)
    } else {
        Se2::IDENTITY
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use geometry::{Segment, SegmentWorld};
    use run_context::RunSeed;
    use simulator::WorldSpec;

    use super::*;

    /// A room of 6 by 4 m, cut in two by a wall at x = 3 m.
    fn world() -> World {
        let corners =
            [(0.0, 0.0), (6.0, 0.0), (6.0, 4.0), (0.0, 4.0)].map(|(x, y)| Vec2::new(x, y));
        let mut walls: Vec<_> =
            (0..4).map(|i| (Segment { a: corners[i], b: corners[(i + 1) % 4] }, 0)).collect();
        walls.push((Segment { a: Vec2::new(3.0, 0.0), b: Vec2::new(3.0, 4.0) }, 0));
        let spec = WorldSpec::of_walls(SegmentWorld::new(walls));
        World::new(spec, RunSeed(1), Duration::from_millis(10)).unwrap()
    }

    fn names(n: usize) -> Vec<String> {
        (0..n).map(|i| format!("robot{i}")).collect()
    }

    #[test]
    fn robots_stand_apart_and_in_one_room() {
        let model = Arc::new(RobotModel::by_name("pioneer3dx").unwrap());
        let mut world = world();
        let home = Se2::new(1.5, 2.0, 1.0);
        let bodies = place(&mut world, &model, &names(5), &[], home).unwrap();
        let places: Vec<Vec2> = bodies.iter().map(|&id| world.body(id).position()).collect();
        assert_eq!(places[0], home.position());
        for (i, one) in places.iter().enumerate() {
            assert!(one.x > 0.25 && one.x < 2.75, "{places:?}");
            for other in &places[..i] {
                assert!((one - other).norm() > 2.0 * model.bounding_radius_m(), "{places:?}");
            }
        }
        // Beyond the wall there would be room, but it is another room.
        let error = place(&mut self::world(), &model, &names(20), &[], home).unwrap_err();
        assert!(error.to_string().contains("no room for robot"), "{error}");
    }

    #[test]
    fn places_that_are_given_are_kept_and_checked() {
        let model = Arc::new(RobotModel::by_name("pioneer3dx").unwrap());
        let given = [Se2::new(1.5, 1.0, 0.0), Se2::new(4.5, 3.0, 2.0)];
        let mut world = world();
        let bodies = place(&mut world, &model, &names(3), &given, Se2::IDENTITY).unwrap();
        assert_eq!(world.body(bodies[1]).world_from_base.se2(), given[1]);
        // On top of the first.
        let twice = [given[0], given[0]];
        let error =
            place(&mut self::world(), &model, &names(2), &twice, Se2::IDENTITY).unwrap_err();
        assert!(error.to_string().contains("robot"), "{error}");
    }
}
