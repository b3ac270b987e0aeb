//! Tests of the part that follows tags, on a trail written out in the test.

use sensor_models::{TagHint, TagMemory};

use super::*;

/// A trail along the x axis from 0 to 4 m, three tags wide, and what a tag of it stores.
fn memory(in_map: Vec2) -> TagMemory {
    let beyond_m = (in_map.x - 4.0).max(-in_map.x).max(0.0);
    let strength = (200.0 * (1.0 - in_map.y.hypot(beyond_m) / 0.2)).max(0.0).round() as u8;
    let hint = |towards: f64, end: f64| TagHint {
        look_ahead_in_map: Vec2::new((in_map.x + 0.6 * towards).clamp(0.0, 4.0), 0.0),
        end_in_map: Vec2::new(end, 0.0),
    };
    let hints =
        if strength > 0 { [Some(hint(1.0, 4.0)), Some(hint(-1.0, 0.0))] } else { [None; 2] };
    TagMemory { in_map, strength, hints }
}

fn part(controller: TagController) -> TagTrail {
    let readers_in_base = match controller {
        TagController::Gradient => TagSettings::default().readers_in_base,
        TagController::LookAhead => vec![Vec2::new(0.18, 0.0)],
    };
    let settings = TagSettings { controller, readers_in_base, ..TagSettings::default() };
    TagTrail::new(&settings, 0.38, 0.5).unwrap()
}

/// Every reader reads the tag nearest to it.
fn read_all(part: &mut TagTrail, pose: Se2) {
    for reader in 0..part.settings.readers_in_base.len() as u8 {
        let at = part.reader_in_map(pose, reader).unwrap();
        let in_map = (at * 10.0).map(f64::round) * 0.1;
        part.take(pose, &TagRead { reader, tag: 1, memory: memory(in_map) });
    }
}

/// Asks what to do and turns on the spot as told; the heading when it sets out, `None` when there is nothing.
fn heading_of_setting_out(part: &mut TagTrail, from: Se2, goal: Vec2) -> Option<f64> {
    part.set_goal(Some(goal));
    read_all(part, from);
    look_around(part, from)
}

fn look_around(part: &mut TagTrail, from: Se2) -> Option<f64> {
    assert!(part.begin(from));
    read_all(part, from);
    let mut pose = from;
    for _ in 0..8 {
        match part.aim(pose) {
            Aim::Go => return Some(pose.yaw_rad),
            Aim::Nothing => return None,
            Aim::Turn(heading_rad) => {
                let turn_rad = wrap_to_pi(heading_rad - pose.yaw_rad);
                for _ in 0..50 {
                    let next = Se2::new(pose.x_m, pose.y_m, pose.yaw_rad + turn_rad / 50.0);
                    part.roll(pose, next);
                    pose = next;
                    read_all(part, pose);
                }
                part.turned();
            }
        }
    }
    panic!("it turns for ever");
}

#[test]
fn a_robot_on_the_trail_finds_the_direction_of_its_goal_wherever_it_looks() {
    for goal_x in [4.0, 0.0] {
        for yaw_rad in [0.0, 0.8, 1.6, 2.4, 3.1, -2.4, -1.6, -0.8] {
            let mut part = part(TagController::Gradient);
            let from = Se2::new(2.02, 0.04, yaw_rad);
            let found = heading_of_setting_out(&mut part, from, Vec2::new(goal_x, 0.0)).unwrap();
            let wanted_rad = if goal_x > 2.0 { 0.0 } else { std::f64::consts::PI };
            let off_rad = wrap_to_pi(found - wanted_rad).abs();
            // A robot that looks nearly along the trail towards its goal sets off without turning.
            assert!(
                off_rad < 0.35
                    || (off_rad - wrap_to_pi(yaw_rad - wanted_rad).abs()) < 1e-9
                        && off_rad < TOWARDS_GOAL_RAD,
                "{goal_x} {yaw_rad}: {found}"
            );
        }
    }
}

#[test]
fn at_the_end_of_the_trail_there_is_one_way_only() {
    let mut part = part(TagController::Gradient);
    let goal = Vec2::new(9.0, 0.0);
    let found = heading_of_setting_out(&mut part, Se2::new(4.0, 0.0, 1.5), goal).unwrap();
    assert!(wrap_to_pi(found - std::f64::consts::PI).abs() < 0.3, "{found}");
    let nowhere = Se2::new(2.0, 2.0, 0.0);
    assert_eq!(heading_of_setting_out(&mut part, nowhere, goal), None);
}

#[test]
fn a_tag_tells_the_look_ahead_point_of_the_goals_direction() {
    for (goal_x, wanted_rad) in [(4.0, 0.0), (0.0, std::f64::consts::PI)] {
        let mut part = part(TagController::LookAhead);
        let from = Se2::new(2.02, 0.0, 1.2);
        let found = heading_of_setting_out(&mut part, from, Vec2::new(goal_x, 0.0)).unwrap();
        assert!(wrap_to_pi(found - wanted_rad).abs() < 0.35, "{goal_x}: {found}");
        let pose = Se2::new(2.0, 0.0, found);
        part.set_out();
        read_all(&mut part, pose);
        let TagStep::Drive(wheels) = part.follow(pose, 0.3) else { panic!("there is a point") };
        assert!((wheels.linear_mps() - 0.3).abs() < 1e-9);
    }
}

/// Beyond the end: straight on, back to where the trail was smelled last, and from there the only way there is.
#[test]
fn beyond_its_end_a_robot_goes_back_to_the_trail_and_looks_around_itself() {
    let mut part = part(TagController::Gradient);
    part.set_goal(Some(Vec2::new(9.0, 0.0)));
    part.begin(Se2::new(3.0, 0.0, 0.0));
    let mut pose = Se2::new(3.0, 0.0, 0.0);
    let (mut farthest_m, mut lost) = (0.0_f64, false);
    for _ in 0..3000 {
        read_all(&mut part, pose);
        let wheels = if lost {
            match part.search(pose, 0.6) {
                Search::Found => panic!("it is on its way back: {pose:?}"),
                Search::Drive(wheels) => wheels,
                Search::Turn(heading_rad) => {
                    pose = Se2::new(pose.x_m, pose.y_m, heading_rad);
                    part.turned();
                    WheelReference::STOP
                }
                Search::GaveUp => break,
            }
        } else {
            match part.follow(pose, 0.3) {
                TagStep::Drive(wheels) => wheels,
                TagStep::Lost(side) => {
                    part.lose(pose, side);
                    lost = true;
                    WheelReference::STOP
                }
            }
        };
        let next = pose.compose(Se2::new(
            0.05 * wheels.linear_mps(),
            0.0,
            0.05 * wheels.angular_radps(0.38),
        ));
        part.roll(pose, next);
        pose = next;
        farthest_m = farthest_m.max(pose.x_m);
    }
    assert!((farthest_m - 4.6).abs() < 0.25, "{farthest_m}");
    assert!(pose.x_m < 4.2 && pose.y_m.abs() < 0.1, "{pose:?}");
    let found = look_around(&mut part, pose).unwrap();
    assert!(wrap_to_pi(found - std::f64::consts::PI).abs() < 0.3, "{found}");
}

/// A robot that meets its own way looking back along it turns about; one that stands or goes on does not.
#[test]
fn going_back_is_noticed() {
    let mut part = part(TagController::Gradient);
    part.set_goal(Some(Vec2::new(9.0, 0.0)));
    let mut pose = Se2::IDENTITY;
    let mut go = |part: &mut TagTrail, step: Se2| {
        let next = pose.compose(step);
        part.roll(pose, next);
        pose = next;
        part.about_turn_rad(pose)
    };
    for _ in 0..40 {
        assert_eq!(go(&mut part, Se2::new(0.05, 0.0, 0.0)), None, "straight on");
    }
    // Half a circle of 0.08 m radius to the left, and back beside its own way.
    let n_turns = (0..31).filter(|_| go(&mut part, Se2::new(0.008, 0.0, 0.1)).is_some()).count();
    assert_eq!(n_turns, 0, "a bend alone is none");
    let turn = (0..10).find_map(|_| go(&mut part, Se2::new(0.05, 0.0, 0.0)));
    assert!(turn.unwrap().abs() < 0.1, "{turn:?}");
}

/// To the side that smelled it last, on an arc that ends.
#[test]
fn a_lost_trail_is_looked_for_on_its_side_and_not_for_ever() {
    for (side, sign) in [(Side::Left, 1.0), (Side::Right, -1.0)] {
        let mut part = part(TagController::Gradient);
        let mut pose = Se2::new(2.0, 3.0, 0.0);
        part.last_on = Some(pose.position());
        part.lose(pose, Some(side));
        let (mut turned_rad, mut n_steps) = (0.0, 0);
        loop {
            n_steps += 1;
            assert!(n_steps < 1000, "for ever");
            match part.search(pose, 0.6) {
                Search::Drive(wheels) => {
                    let turn_rad = 0.1 * wheels.angular_radps(0.38);
                    turned_rad += turn_rad;
                    pose = pose.compose(Se2::new(0.1 * wheels.linear_mps(), 0.0, turn_rad));
                }
                Search::Turn(heading_rad) => {
                    pose = Se2::new(pose.x_m, pose.y_m, heading_rad);
                    part.turned();
                }
                Search::GaveUp => break,
                Search::Found => panic!("there is nothing"),
            }
        }
        assert!(
            sign * turned_rad > ARC_MAX_RAD - 0.15 && sign * turned_rad < 4.5,
            "{side:?}: {turned_rad}"
        );
    }
}

#[test]
fn the_number_of_readers_must_fit_the_law() {
    for (controller, n, fits) in [
        (TagController::Gradient, 1, false),
        (TagController::Gradient, 2, true),
        (TagController::Gradient, 3, false),
        (TagController::LookAhead, 0, false),
        (TagController::LookAhead, 1, true),
        (TagController::LookAhead, 2, true),
        (TagController::LookAhead, 3, false),
    ] {
        let readers_in_base = vec![Vec2::zeros(); n];
        let settings = TagSettings { controller, readers_in_base, ..TagSettings::default() };
        assert_eq!(TagTrail::new(&settings, 0.38, 0.5).is_ok(), fits, "{controller:?} {n}");
    }
}
