//! The control step of a wired robot allocates nothing once it runs.
#![expect(clippy::unwrap_used, reason = "a failing helper fails its test")]

use missions::{Mission, Run};
use run_context::RunSeed;

/// Allocations of the quietest second out of several: news for the log may allocate, steps may not.
fn quietest_second(name: &str, from_s: u64, seconds: u64) -> u64 {
    let mission = Mission::load(name, &[]).unwrap();
    let mut run = Run::new(mission, RunSeed(1)).unwrap();
    (0..from_s * 100).for_each(|_| run.step());
    let second = |run: &mut Run| {
        allocation_counter::measure(|| (0..100).for_each(|_| run.step())).count_total
    };
    (0..seconds).map(|_| second(&mut run)).min().unwrap()
}

#[test]
fn following_a_trail_with_every_node_allocates_nothing() {
    assert_eq!(quietest_second("doorbell", 26, 8), 0);
}

#[test]
fn following_tags_allocates_nothing() {
    assert_eq!(quietest_second("tag-trail", 14, 8), 0);
}

#[test]
fn driving_straight_allocates_nothing() {
    assert_eq!(quietest_second("one-obstacle", 5, 5), 0);
}

#[test]
fn driving_by_hand_and_reading_along_allocates_nothing() {
    assert_eq!(quietest_second("artemic-e4", 5, 5), 0);
}
