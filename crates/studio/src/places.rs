//! Where on the map a goal can lie: not where everybody at the page sees that nothing can stand.

use geometry::{Segment, Vec2};
use missions::{Scene, SceneThing};

/// A goal this near to a wall is in it, metres: half of what is drawn.
const WALL_M: f64 = 0.05;

/// Refuses a goal that lies in a thing or in a wall; `put_down` are the things of the run.
///
/// The robot itself knows neither: it would search for a way for seconds before it gave up.
///
/// # Errors
///
/// What is there, as a sentence for the person at the page.
pub(crate) fn check_goal(scene: &Scene, put_down: &[SceneThing], goal: Vec2) -> Result<(), String> {
    let place = format!("({:.2}, {:.2}) m", goal.x, goal.y);
    let mut things = scene.things.iter().chain(put_down);
    if let Some(thing) =
        things.find(|thing| thing.kind != "door" && is_within(&thing.corners_m, goal))
    {
        return Err(format!(
            "no robot can stand at {place}: {} is there; choose a free place",
            thing.name
        ));
    }
    let is_near =
        |wall: &missions::SceneWall| distance_m(&Segment { a: wall.a, b: wall.b }, goal) < WALL_M;
    if scene.walls.iter().any(is_near) {
        return Err(format!("no robot can stand at {place}: a wall is there; choose a free place"));
    }
    Ok(())
}

/// Whether a point lies in a polygon of any shape: a ray from it crosses the outline an odd number of times.
fn is_within(corners: &[Vec2], point: Vec2) -> bool {
    let edges = corners.iter().zip(corners.iter().cycle().skip(1));
    let crossings = edges.filter(|(a, b)| {
        (a.y > point.y) != (b.y > point.y)
            && point.x < a.x + (point.y - a.y) / (b.y - a.y) * (b.x - a.x)
    });
    crossings.count() % 2 == 1
}

fn distance_m(segment: &Segment, point: Vec2) -> f64 {
    let along = segment.b - segment.a;
    let length2 = along.dot(&along);
    let at = if length2 > 0.0 {
        ((point - segment.a).dot(&along) / length2).clamp(0.0, 1.0)
    } else {
        0.0
    };
    (point - (segment.a + at * along)).norm()
}

#[cfg(test)]
mod tests {
    use missions::{Intervention, Mission, Run};
    use run_context::RunSeed;

    use super::*;

    #[test]
    fn a_goal_in_a_thing_or_a_wall_is_refused_and_beside_it_taken() {
        let mission = Mission::load("doorbell", &[]).unwrap();
        let mut run = Run::new(mission, RunSeed(1)).unwrap();
        let check = |run: &Run, x, y| check_goal(&run.scene(), &run.view().things, Vec2::new(x, y));
        let scene = run.scene();
        let bed = scene.things.iter().find(|thing| thing.name == "bed").unwrap();
        let middle = bed.corners_m.iter().sum::<Vec2>() / bed.corners_m.len() as f64;
        let said = check(&run, middle.x, middle.y).unwrap_err();
        assert!(said.contains("bed") && said.contains("free place"), "{said}");
        // Just inside and just outside of each of its corners.
        for &corner in &bed.corners_m {
            let (inside, outside) =
                (corner + 0.05 * (middle - corner), corner - 0.1 * (middle - corner));
            assert!(check(&run, inside.x, inside.y).is_err());
            let beside = check(&run, outside.x, outside.y);
            assert!(beside.is_ok() || beside.unwrap_err().contains("wall"), "{outside}");
        }
        let wall = &scene.walls[0];
        let on_wall = wall.a + 0.3 * (wall.b - wall.a);
        assert!(check(&run, on_wall.x, on_wall.y).unwrap_err().contains("wall"));
        // The entrance, and a place that a box takes and gives back.
        assert_eq!(check(&run, 5.0, 3.5), Ok(()));
        assert_eq!(check(&run, 0.0, -0.5), Ok(()));
        run.apply(Intervention::PlaceBox { at: Vec2::new(0.0, -0.5), size_m: 0.4 }).unwrap();
        assert!(check(&run, 0.1, -0.5).is_err());
    }
}
