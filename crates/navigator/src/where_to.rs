//! *Where to*: the goal that was ordered, what to visit on the way, the task's clock and its progress.

use geometry::{Base, Map, Transform2, Vec2};
use run_context::Stamp;

use crate::{says::Sentence, settings::NavigatorSettings, values::Goal};

/// So much nearer to the goal than ever before is progress, metres.
const PROGRESS_M: f64 = 0.25;

/// The part; see the module.
#[derive(Clone, Debug)]
pub(crate) struct Task {
    within_m: f64,
    within_rad: f64,
    goal: Option<Goal>,
    /// Intermediate goals of the direct method and how many are behind.
    via: Vec<Vec2>,
    n_via_done: usize,
    clock: TaskClock,
    nearest_m: f64,
}

/// Since when a task has been under way, and when it last made progress.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TaskClock {
    pub(crate) since: Stamp,
    pub(crate) progress_at: Stamp,
}

impl Task {
    pub(crate) fn new(s: &NavigatorSettings) -> Self {
        Self {
            within_m: s.goal_tolerance_m,
            within_rad: s.heading_tolerance_rad,
            goal: None,
            via: Vec::new(),
            n_via_done: 0,
            clock: TaskClock { since: Stamp::ZERO, progress_at: Stamp::ZERO },
            nearest_m: f64::INFINITY,
        }
    }

    pub(crate) fn says(&self) -> Sentence {
        self.goal.map_or(Sentence::NoGoal, |goal| Sentence::To {
            goal: goal.point(),
            within_m: goal.within_m,
        })
    }

    /// Intermediate goals (m, map) of every task to come.
    pub(crate) fn set_via(&mut self, via_in_map: Vec<Vec2>) {
        self.via = via_in_map;
    }

    /// A new task; whether its goal is a pose at all.
    pub(crate) fn begin(&mut self, now: Stamp, map_from_base: Transform2<Map, Base>) -> bool {
        let pose = map_from_base.se2();
        if !(pose.x_m.is_finite() && pose.y_m.is_finite() && pose.yaw_rad.is_finite()) {
            return false;
        }
        let (within_m, within_rad) = (self.within_m, self.within_rad);
        self.goal = Some(Goal { map_from_base, within_m, within_rad });
        self.clock = TaskClock { since: now, progress_at: now };
        true
    }

    /// The task has ended, well or not; its goal is still shown.
    pub(crate) fn end(&mut self) {
        self.n_via_done = 0;
        self.nearest_m = f64::INFINITY;
    }

    /// The goal counts no more.
    pub(crate) fn forget(&mut self) {
        self.end();
        self.goal = None;
    }

    pub(crate) fn goal(&self) -> Option<Goal> {
        self.goal
    }

    pub(crate) fn clock(&self) -> TaskClock {
        self.clock
    }

    pub(crate) fn note_progress(&mut self, now: Stamp) {
        self.clock.progress_at = now;
    }

    /// Coming nearer to the goal is progress.
    pub(crate) fn watch(&mut self, now: Stamp, position: Vec2) {
        let Some(goal) = self.goal else { return };
        let distance_m = (goal.point() - position).norm();
        if distance_m < self.nearest_m - PROGRESS_M {
            self.nearest_m = distance_m;
            self.note_progress(now);
        }
    }

    /// What to drive to first in a straight line.
    pub(crate) fn first_target(&self) -> Option<Vec2> {
        self.via.first().copied().or(self.goal.map(|goal| goal.point()))
    }

    /// What was driven to in a straight line is reached; the next, if there is one.
    pub(crate) fn reached(&mut self, now: Stamp) -> Option<Vec2> {
        self.n_via_done += 1;
        self.note_progress(now);
        self.nearest_m = f64::INFINITY;
        let goal = self.goal.map(|goal| goal.point());
        let is_last = self.n_via_done == self.via.len();
        self.via.get(self.n_via_done).copied().or(goal.filter(|_| is_last))
    }
}
