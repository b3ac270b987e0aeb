//! What was measured, by room, drift and method.

use super::{
    method::{Judged, Kept, Method},
    room::Room,
    task::{EIGHT, FIVE, Task},
};

/// Everything that the report is made of.
#[derive(Debug)]
pub(super) struct Results {
    /// E1 to E4 with five sonars, then with eight.
    pub(super) rooms: Vec<Room>,
    /// What was driven.
    pub(super) tasks: Vec<Task>,
    /// By task, run and method of the task.
    pub(super) judged: Vec<Vec<Vec<Judged>>>,
}

/// A room with its ring, and whether odometry drifts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Case {
    pub(super) name: &'static str,
    pub(super) ring: &'static str,
    pub(super) drifts: bool,
}

impl Case {
    /// With five sonars and drift.
    pub(super) const fn drifting(name: &'static str) -> Self {
        Self { name, ring: FIVE, drifts: true }
    }

    /// With five sonars, without drift.
    pub(super) const fn straight(name: &'static str) -> Self {
        Self { name, ring: FIVE, drifts: false }
    }

    /// What tables say of it: room, sonars, drift.
    pub(super) fn cells(self) -> [String; 3] {
        let sonars = if self.ring == EIGHT { "8" } else { "5" };
        let drift = if self.drifts { "1.0" } else { "0.0" };
        [self.name, sonars, drift].map(str::to_owned)
    }
}

impl Results {
    /// All rooms, rings and drifts in order.
    pub(super) fn cases(&self) -> Vec<Case> {
        let whole = self.tasks.iter().filter(|task| !task.is_half_speed);
        whole
            .map(|task| {
                let Room { name, ring, .. } = self.rooms[task.room];
                Case { name, ring, drifts: task.drift_degpm > 0.0 }
            })
            .collect()
    }

    /// The room of a case.
    pub(super) fn room(&self, case: Case) -> Option<&Room> {
        self.rooms.iter().find(|room| room.name == case.name && room.ring == case.ring)
    }

    /// What a method was worth, run by run; empty where it was not asked.
    pub(super) fn of(&self, case: Case, method: Method) -> Vec<&Judged> {
        self.found(case, false, method)
    }

    /// The same at half the speed.
    pub(super) fn at_half_speed(&self, case: Case, method: Method) -> Vec<&Judged> {
        self.found(case, true, method)
    }

    fn found(&self, case: Case, is_half_speed: bool, method: Method) -> Vec<&Judged> {
        let is_it = |task: &Task| {
            let room = &self.rooms[task.room];
            room.name == case.name
                && room.ring == case.ring
                && (task.drift_degpm > 0.0) == case.drifts
                && task.is_half_speed == is_half_speed
        };
        let mut found = Vec::new();
        for (task, runs) in self.tasks.iter().zip(&self.judged).filter(|(task, _)| is_it(task)) {
            if let Some(index) = task.methods.iter().position(|&m| m == method) {
                found.extend(runs.iter().filter_map(|run| run.get(index)));
            }
        }
        found
    }

    /// What figures need of the first run.
    pub(super) fn kept(&self, case: Case, method: Method) -> Option<&Kept> {
        self.of(case, method).first().and_then(|judged| judged.kept.as_ref())
    }

    /// Mean over the runs; NaN where there is none.
    pub(super) fn mean(&self, case: Case, method: Method, of: impl Fn(&Judged) -> f64) -> f64 {
        mean(&self.of(case, method), of)
    }

    /// Position errors, mean over the runs, metres.
    pub(super) fn rms_m(&self, case: Case, method: Method) -> f64 {
        self.mean(case, method, |judged| judged.rms_m)
    }

    /// The same as a part of odometry's over the same runs.
    pub(super) fn ratio(&self, case: Case, method: Method) -> f64 {
        let (found, odometry) = (self.of(case, method), self.of(case, Method::Odometry));
        let same = &odometry[..found.len().min(odometry.len())];
        mean(&found, |judged| judged.rms_m) / mean(same, |judged| judged.rms_m)
    }

    /// By what a method multiplies the error of odometry, run by run.
    pub(super) fn ratios(&self, case: Case, method: Method) -> Vec<f64> {
        let pairs = self.of(case, method).into_iter().zip(self.of(case, Method::Odometry));
        pairs.map(|(found, odometry)| found.rms_m / odometry.rms_m).collect()
    }
}

/// Mean over some runs; NaN of none.
pub(super) fn mean(judged: &[&Judged], of: impl Fn(&Judged) -> f64) -> f64 {
    judged.iter().map(|judged| of(judged)).sum::<f64>() / judged.len() as f64
}
