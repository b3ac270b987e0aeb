//! *Health*: whether the robot and the server still answer and the task stays within its limits; reasons to give up.

use std::time::Duration;

use messages::{FailureReason, LinkState, Motors};
use run_context::Stamp;

use crate::{phase::Phase, says::Sentence, settings::NavigatorSettings, where_to::TaskClock};

/// The part; see the module.
#[derive(Clone, Debug)]
pub(crate) struct Health {
    link_up: bool,
    motors: Option<Motors>,
    link_limit_s: f64,
    task_limit_s: f64,
    progress_limit_s: f64,
    server_limit_s: f64,
}

impl Health {
    pub(crate) fn new(s: &NavigatorSettings) -> Self {
        Self {
            link_up: true,
            motors: None,
            link_limit_s: s.link_limit_s,
            task_limit_s: s.task_limit_s,
            progress_limit_s: s.progress_limit_s,
            server_limit_s: s.server_limit_s,
        }
    }

    pub(crate) fn says(&self, phase: Phase) -> Sentence {
        match phase {
            Phase::Failed(reason) => Sentence::GaveUp(reason),
            _ if !self.link_up => Sentence::LinkDown,
            _ if self.motors_are_off() => Sentence::MotorsOff,
            _ => Sentence::Well,
        }
    }

    pub(crate) fn take_link(&mut self, state: LinkState) {
        self.link_up = state == LinkState::Up;
    }

    pub(crate) fn take_motors(&mut self, motors: Motors) {
        self.motors = Some(motors);
    }

    /// Whether the motors have said that they are off.
    pub(crate) fn motors_are_off(&self) -> bool {
        self.motors.is_some_and(|motors| !motors.enabled)
    }

    /// Why the task must be given up: the wheels were last heard of at `heard_at`, and the server has been silent
    /// for `server_silent`.
    pub(crate) fn limit_reached(
        &self,
        now: Stamp,
        heard_at: Stamp,
        task: TaskClock,
        server_silent: Duration,
    ) -> Option<FailureReason> {
        let over = |since: Stamp, limit_s: f64| now.since(since).as_secs_f64() > limit_s;
        if over(heard_at.max(task.since), self.link_limit_s) || !self.link_up {
            Some(FailureReason::LinkLost)
        } else if over(task.since, self.task_limit_s) {
            Some(FailureReason::TimedOut)
        } else if over(task.progress_at, self.progress_limit_s) {
            Some(FailureReason::NoProgress)
        } else if server_silent.as_secs_f64() > self.server_limit_s {
            Some(FailureReason::ServerSilent)
        } else {
            None
        }
    }
}
