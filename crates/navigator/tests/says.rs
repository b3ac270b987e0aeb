//! What the parts of a mind say while a robot is on its way.

#![expect(clippy::unwrap_used, clippy::print_stdout, reason = "a test")]

mod bed;

use bed::{Bed, boxed, trail, wall};
use geometry::{Base, Map, Se2, Transform2, Vec2};
use messages::{LinkState, Order, Sensed};
use navigator::Phase;

fn said(bed: &Bed) -> [String; 7] {
    bed.navigator.says().parts().map(|(_, sentence)| sentence.to_string())
}

#[test]
fn every_part_says_what_it_is_about_and_why() {
    let mut walls = vec![wall(-2.0, 1.2, 12.0, 1.2), wall(-2.0, -1.2, 12.0, -1.2)];
    walls.extend(boxed(Vec2::new(4.0, 0.1), Vec2::new(0.4, 0.4), 0.2));
    let field = trail(&[(0.0, 0.0), (10.0, 0.0)]);
    let mut bed = Bed::new(|s| s, walls, field, Se2::IDENTITY, 1);
    let [at, around, to, .., health] = said(&bed);
    assert_eq!(at, "unknown: the wheels have not been heard of yet");
    assert_eq!(around, "0 echoes remembered");
    assert_eq!(to, "nowhere: nothing was ordered");
    assert_eq!(health, "nothing is wrong");
    let goal_in_map = Transform2::<Map, Base>::new(Se2::new(8.0, 0.0, 0.5));
    bed.tell(Sensed::Order(Order::GoTo { goal_in_map }));
    let mut heard = Vec::new();
    for _ in 0..20_000 {
        bed.tick();
        let phase = bed.navigator.phase();
        if heard.last().is_none_or(|(last, _)| *last != phase) {
            heard.push((phase, said(&bed)));
        }
        if phase == Phase::FollowTrail {
            // Some steps later than it began.
            *heard.last_mut().unwrap() = (phase, said(&bed));
        }
        if phase == Phase::Arrived {
            break;
        }
    }
    let of = |phase: Phase| &heard.iter().find(|(p, _)| *p == phase).unwrap().1;
    let [at, around, to, how, follow, guard, _] = of(Phase::FollowTrail);
    println!("{heard:#?}");
    assert!(at.starts_with("by its wheels and the tags it reads, within "), "{at}");
    assert!(around.contains("echoes remembered, the nearest thing heard "), "{around}");
    assert_eq!(to, "to (8.0, 0.0), within 60 mm, as ordered");
    assert!(how.starts_with("along the trail that was found by asking; "), "{how}");
    assert!(follow.starts_with("steers by what the antennas smell"), "{follow}");
    assert!(guard.contains(" m/s, "), "{guard}");
    let guard = &of(Phase::Avoid)[5];
    assert!(guard.starts_with("goes around something: "), "{guard}");
    bed.tell(Sensed::Link(LinkState::Down));
    (0..2).for_each(|_| bed.tick());
    assert_eq!(said(&bed)[6], "the robot does not answer");
}
