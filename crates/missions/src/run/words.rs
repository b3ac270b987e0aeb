//! What a robot is busy with, in sentences for the log and the page.

use geometry::Vec2;
use messages::FailureReason;
use navigator::{NavigatorView, Phase, Scouting};

/// What the robot does about its goal, or why it does nothing; empty without a goal.
pub(super) fn task(view: &NavigatorView<'_>, has_path: bool) -> String {
    let Some(goal) = view.goal_in_map.map(|goal| goal.se2().position()) else {
        return String::new();
    };
    let place = place(goal);
    match view.phase {
        Phase::AimAtTrail if !has_path => {
            let Scouting { searched_m, n_questions, .. } = view.scouting;
            match n_questions {
                0 => format!("looking for a trail to {place}"),
                n => format!(
                    "looking for a trail to {place}: {searched_m:.0} m walked by asking, {n} questions"
                ),
            }
        }
        Phase::FollowTrail if view.preview_in_map.is_empty() => {
            let away_m = (goal - view.map_from_base.se2().position()).norm();
            format!("on the way to {place}: {away_m:.1} m away in a straight line")
        }
        Phase::FollowTrail => format!("on the way to {place}: {:.1} m to go", view.way_ahead_m),
        Phase::Arrived => format!("stands at {place}"),
        Phase::Failed(reason) => format!("gave up {place}: {}", failure(reason, view.scouting)),
        phase => format!("{}, on the way to {place}", self::phase(phase, has_path)),
    }
}

/// What a robot is doing, in a few words; one that was given a path follows that, and no trail.
pub(super) fn phase(phase: Phase, has_path: bool) -> &'static str {
    match phase {
        Phase::AimAtTrail if has_path => "looking for its path",
        Phase::FollowTrail if has_path => "following its path",
        Phase::Rejoin if has_path => "rejoining its path",
        Phase::LostTrail if has_path => "path lost",
        _ => phase.name(),
    }
}

/// Why it gave up, with how much was searched.
pub(super) fn failure(reason: FailureReason, scouting: Scouting) -> String {
    let Scouting { n_questions, searched_m, nearest_m, is_cut_short } = scouting;
    match (reason, nearest_m) {
        // Nobody was asked: the robot has looked for tags around itself.
        (FailureReason::NoTrail, _) if n_questions == 0 => {
            format!("{}; nothing of one was sensed around the robot", reason.as_str())
        }
        (FailureReason::NoTrail, _) => {
            let why = "the server was asked about {} places around the robot";
            format!("{}; {}", reason.as_str(), why.replace("{}", &n_questions.to_string()))
        }
        (FailureReason::NoTrailToGoal, Some(nearest_m)) => format!(
            "{}; the nearest point of a trail is {nearest_m:.1} m away from it ({searched_m:.0} m of \
             trails searched{} with {n_questions} questions)",
            reason.as_str(),
            if is_cut_short { ", not all," } else { "" },
        ),
        _ => reason.as_str().to_owned(),
    }
}

fn place(goal: Vec2) -> String {
    format!("({:.1}, {:.1})", goal.x, goal.y)
}
