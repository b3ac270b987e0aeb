//! Whether what the mission asks for has happened.
//!
//! Requirements that something happens are decided when it does or when its deadline passes;
//! requirements that something never happens hold until the end. A run ends when its greatest duration
//! is over, when something that must happen has missed its deadline, or half a second after everything that must
//! happen has.

use run_context::Stamp;
use simulator::World;

use super::{metrics::RobotMetrics, vehicle::Vehicle};
use crate::{
    mission::plan::{GoalPose, Requirement, RobotPlan},
    node::devices::Devices,
    verdict::{Check, Verdict},
};

/// Steps between the last thing that must happen and the end: what goes wrong at once still counts.
const AFTERMATH_STEPS: u32 = 50;

/// Of a group that did not arrive, so many robots are named with their reasons.
const N_REASONS_MAX: usize = 3;

/// What is judged.
pub(super) struct Facts<'a> {
    pub(super) now: Stamp,
    pub(super) is_over: bool,
    pub(super) n_moves: u64,
    pub(super) n_events: u64,
    pub(super) n_watchdog_resets: u64,
    pub(super) vehicles: &'a [Vehicle],
    pub(super) metrics: &'a [RobotMetrics],
    pub(super) devices: &'a Devices,
    pub(super) robots: &'a [RobotPlan],
    pub(super) world: &'a World,
}

/// Follows the requirements of a mission.
#[derive(Debug)]
pub(super) struct Judge {
    items: Vec<Item>,
    aftermath: u32,
}

#[derive(Debug)]
struct Item {
    requirement: Requirement,
    state: State,
    /// Distance (m) and turn (rad) from the goal when it was reached: the robot may have gone on since.
    reached: Option<(f64, f64)>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Open,
    Done(Stamp),
    Missed,
}

impl Judge {
    pub(super) fn new(requirements: &[Requirement]) -> Self {
        let item =
            |r: &Requirement| Item { requirement: r.clone(), state: State::Open, reached: None };
        Self { items: requirements.iter().map(item).collect(), aftermath: 0 }
    }

    /// The verdict, once it is certain.
    pub(super) fn step(&mut self, facts: &Facts<'_>) -> Option<Verdict> {
        let mut n_events = 0;
        let (mut all_done, mut any_missed) = (true, false);
        for item in &mut self.items {
            let Some((happened, by)) = item.event(facts) else { continue };
            n_events += 1;
            if item.state == State::Open && happened {
                item.state = State::Done(facts.now);
                item.reached = item.lone_error(facts);
            } else if item.state == State::Open && facts.now >= by {
                item.state = State::Missed;
            }
            all_done &= matches!(item.state, State::Done(_));
            any_missed |= item.state == State::Missed;
        }
        if n_events > 0 && all_done {
            self.aftermath += 1;
        }
        let ends = facts.is_over || any_missed || self.aftermath > AFTERMATH_STEPS;
        ends.then(|| Verdict::from_checks(self.items.iter().map(|i| i.check(facts)).collect()))
    }
}

impl Item {
    /// For a requirement that something happens: whether it has, and its deadline.
    fn event(&self, facts: &Facts<'_>) -> Option<(bool, Stamp)> {
        match &self.requirement {
            Requirement::Arrived { robots, by, min_ratio, .. } => {
                if matches!(self.state, State::Done(_)) {
                    return Some((true, *by));
                }
                let n = robots.iter().filter(|&&r| self.stands_there(r, facts)).count();
                Some((n as f64 >= min_ratio * robots.len() as f64, *by))
            }
            Requirement::GaveUp { robots, reason, way_max_m, by } => {
                let happened = |&robot: &usize| {
                    let vehicle = &facts.vehicles[robot];
                    vehicle.has_given_up(*reason)
                        && vehicle.stands(facts.world) == Some(true)
                        && way_max_m.is_none_or(|max_m| way_since_cut_m(robot, facts) <= max_m)
                };
                let done = matches!(self.state, State::Done(_));
                Some((done || robots.iter().all(happened), *by))
            }
            Requirement::SwitchedOn { device, by } => {
                Some((facts.devices.first_on(*device).is_some_and(|t| t <= *by), *by))
            }
            _ => None,
        }
    }

    /// How far the one robot of an arrival is from its goal (m) and turned from it (rad); nothing for groups.
    fn lone_error(&self, facts: &Facts<'_>) -> Option<(f64, f64)> {
        match &self.requirement {
            Requirement::Arrived { robots, pose, .. } => match robots[..] {
                [robot] => Some(error(robot, *pose, facts)),
                _ => None,
            },
            _ => None,
        }
    }

    /// Whether a robot says that it has arrived and truly stands where it should, having driven its path if it
    /// was given one.
    fn stands_there(&self, robot: usize, facts: &Facts<'_>) -> bool {
        let Requirement::Arrived { pose, within_m, within_rad, .. } = &self.requirement else {
            return false;
        };
        facts.vehicles[robot].has_arrived() && has_driven_all(robot, facts) && {
            let (distance_m, turn_rad) = error(robot, *pose, facts);
            distance_m <= *within_m && turn_rad <= *within_rad
        }
    }

    fn check(&self, facts: &Facts<'_>) -> Check {
        let all_known = facts.metrics.iter().all(RobotMetrics::is_simulated);
        let unknown = || (false, "not known of a robot elsewhere".to_owned());
        let (name, passed, text) = match &self.requirement {
            Requirement::NoContact if !all_known => {
                let (passed, text) = unknown();
                ("no contact", passed, text)
            }
            Requirement::ClearanceMin(_) if !all_known => {
                let (passed, text) = unknown();
                ("clearance", passed, text)
            }
            Requirement::NoContact => {
                let n: u64 = facts.metrics.iter().map(|m| m.contacts).sum();
                ("no contact", n == 0, format!("{n} contacts (allowed 0)"))
            }
            Requirement::MovesSent(wanted) => {
                let n = facts.n_moves;
                ("moves sent", n == *wanted, format!("{n} MOVE sent (wanted {wanted})"))
            }
            Requirement::EventsLogged(wanted) => {
                let n = facts.n_events;
                ("events logged", n == *wanted, format!("{n} events logged (wanted {wanted})"))
            }
            Requirement::WatchdogResets(wanted) => {
                let n = facts.n_watchdog_resets;
                let text = format!("{n} restarts by the watchdog (wanted {wanted})");
                ("watchdog", n == *wanted, text)
            }
            Requirement::ClearanceMin(wanted) => clearance(*wanted, facts),
            Requirement::CrossTrackRmsMax(wanted) => cross_track(*wanted, facts),
            Requirement::Stayed { robots, within_m } => {
                let most = robots.iter().map(|&r| facts.metrics[r].strayed_max_m);
                let most = most.fold(0.0, f64::max);
                let text = format!("{most:.2} m from the start at most (allowed {within_m:.2} m)");
                ("stayed", most <= *within_m, text)
            }
            Requirement::GaveUp { robots, way_max_m, by, .. } => {
                let done = matches!(self.state, State::Done(_));
                ("gave up", done, self.giving_up_text(robots, *way_max_m, *by, facts))
            }
            Requirement::SwitchedOn { device, by } => {
                let label = facts.devices.label(*device);
                match facts.devices.first_on(*device) {
                    Some(t) => ("switched on", t <= *by, format!("{label} at {t} (by {by})")),
                    None => ("switched on", false, format!("{label} never (by {by})")),
                }
            }
            Requirement::Arrived { robots, .. } => {
                ("arrived", matches!(self.state, State::Done(_)), self.arrival_text(robots, facts))
            }
        };
        Check { name: name.to_owned(), passed, text }
    }

    /// Of one robot what it did, of many how many did.
    fn giving_up_text(
        &self,
        robots: &[usize],
        way_max_m: Option<f64>,
        by: Stamp,
        facts: &Facts<'_>,
    ) -> String {
        let &[robot] = robots else {
            let n = robots.iter().filter(|&&r| facts.vehicles[r].has_given_up(None)).count();
            return format!("{n} of {} robots gave up (wanted: all)", robots.len());
        };
        let vehicle = &facts.vehicles[robot];
        let said = match (self.state, vehicle.failure()) {
            (State::Done(t), Some(reason)) => format!("at {t} ({reason})"),
            (State::Done(t), None) => format!("at {t}"),
            (_, Some(reason)) => format!("for another reason or too late ({reason}; by {by})"),
            _ => format!("not by {by}"),
        };
        let rest = match vehicle.stands(facts.world) {
            Some(true) => "stands",
            Some(false) => "still rolls",
            None => "may roll or stand",
        };
        let way_m = way_since_cut_m(robot, facts);
        let way = match way_max_m {
            Some(max_m) if way_m.is_finite() => {
                format!(", {way_m:.2} m after the cut (allowed {max_m:.2} m)")
            }
            Some(_) => ", no line was cut".to_owned(),
            None => String::new(),
        };
        format!("{said}, {rest}{way}")
    }

    fn arrival_text(&self, robots: &[usize], facts: &Facts<'_>) -> String {
        let Requirement::Arrived { pose, within_m, within_rad, min_ratio, by, .. } =
            &self.requirement
        else {
            return String::new();
        };
        let allowed_deg = within_rad.to_degrees();
        let (&[robot], pose) = (robots, *pose) else {
            let absent: Vec<usize> =
                robots.iter().copied().filter(|&r| !self.stands_there(r, facts)).collect();
            let n = robots.len() - absent.len();
            let needed = (min_ratio * robots.len() as f64).ceil();
            let mut text = format!(
                "{n} of {} robots within {within_m:.2} m, {allowed_deg:.0}° (at least {needed:.0})",
                robots.len()
            );
            if self.state == State::Missed {
                let reasons = absent.iter().take(N_REASONS_MAX).map(|&r| {
                    let vehicle = &facts.vehicles[r];
                    format!(
                        "; {}: {}",
                        vehicle.name,
                        vehicle.failure().unwrap_or_else(|| vehicle.phase_name().to_owned())
                    )
                });
                text.extend(reasons);
                if absent.len() > N_REASONS_MAX {
                    text.push_str("; …");
                }
            }
            return text;
        };
        let (distance_m, turn_rad) = self.reached.unwrap_or_else(|| error(robot, pose, facts));
        let vehicle = &facts.vehicles[robot];
        let said = match (self.state, vehicle.failure()) {
            (State::Done(t), _) => format!("at {t}"),
            (_, Some(reason)) => format!("gave up ({reason})"),
            _ if vehicle.has_arrived() && !has_driven_all(robot, facts) => {
                let sides = facts.metrics[robot].sides();
                let (passed_m, way_m) = sides.map_or((0.0, 0.0), |s| (s.passed_m(), s.way_m()));
                format!("but only {passed_m:.1} m of {way_m:.1} m of its path were driven")
            }
            _ => format!("not arrived by {by}, {}", vehicle.phase_name()),
        };
        format!(
            "{}: {distance_m:.2} m, {:.0}° from the goal, {said} (allowed {within_m:.2} m, {allowed_deg:.0}°)",
            vehicle.name,
            turn_rad.to_degrees()
        )
    }
}

/// Name, outcome and words of the least distance of all robots, at least `wanted_m`.
fn clearance(wanted_m: f64, facts: &Facts<'_>) -> (&'static str, bool, String) {
    let least = facts.metrics.iter().map(RobotMetrics::clearance_min_m);
    let least = least.fold(f64::INFINITY, f64::min);
    let seen = facts.metrics.iter().filter_map(RobotMetrics::clearance_seen_m);
    let text = match seen.reduce(f64::min) {
        Some(seen_m) => format!("nearest surface {seen_m:.2} m away"),
        None => "no surface within 5 m".to_owned(),
    };
    ("clearance", least >= wanted_m, format!("{text} (at least {wanted_m:.2} m)"))
}

/// The same of the first robot's distance from what it follows, at most `wanted_m`.
fn cross_track(wanted_m: f64, facts: &Facts<'_>) -> (&'static str, bool, String) {
    let has_path =
        facts.robots.first().is_some_and(|r| r.path.is_some() || r.teleoperator.is_some());
    let what = if has_path { "path" } else { "trail" };
    match facts.metrics.first().and_then(RobotMetrics::cross_track_rms_m) {
        Some(rms) => {
            let text = format!("{rms:.3} m off the {what}, rms (allowed {wanted_m:.3} m)");
            ("cross track", rms <= wanted_m, text)
        }
        None => ("cross track", false, format!("the {what} was never followed")),
    }
}

/// Way that a robot has driven since one of its lines was cut, m; infinite if none was.
fn way_since_cut_m(robot: usize, facts: &Facts<'_>) -> f64 {
    facts.metrics[robot].way_since_cut_m().unwrap_or(f64::INFINITY)
}

/// Whether a robot has driven the path that it was given; true without one.
fn has_driven_all(robot: usize, facts: &Facts<'_>) -> bool {
    facts.metrics[robot].sides().is_none_or(super::sides::Sides::is_driven)
}

/// True distance (m) and turn (rad, ≥ 0) of a robot from where it should be.
fn error(robot: usize, pose: GoalPose, facts: &Facts<'_>) -> (f64, f64) {
    let goal = pose.resolve(facts.robots[robot].start);
    let at = facts.metrics[robot].pose();
    let distance_m = (goal.position() - at.position()).norm();
    (distance_m, geometry::wrap_to_pi(goal.yaw_rad - at.yaw_rad).abs())
}
