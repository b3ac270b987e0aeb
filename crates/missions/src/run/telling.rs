//! What is worth telling of one robot: changes of its phase, of its goal and of its lines, in words for the log.

use std::collections::VecDeque;

use geometry::Se2;
use messages::{LinkState, Sensed};
use navigator::{Navigator, Phase, PoseHealth};

use super::words;
use crate::view::LogLevel;

/// News of one robot.
#[derive(Debug)]
pub(super) struct Telling {
    name: String,
    /// Whether it was given a path; otherwise what it follows is a trail.
    has_path: bool,
    last_phase: Phase,
    last_goal: Option<Se2>,
    last_health: PoseHealth,
    /// Its driver has lost it and not found it again.
    is_lost: bool,
    news: VecDeque<(LogLevel, String)>,
}

impl Telling {
    pub(super) fn new(name: &str, has_path: bool) -> Self {
        Self {
            name: name.to_owned(),
            has_path,
            last_phase: Phase::Idle,
            last_goal: None,
            last_health: PoseHealth::Sure,
            is_lost: false,
            news: VecDeque::new(),
        }
    }

    /// The navigator was told something.
    pub(super) fn hear(&mut self, value: &Sensed) {
        let Sensed::Link(state) = value else { return };
        let is_lost = *state == LinkState::Down;
        if std::mem::replace(&mut self.is_lost, is_lost) != is_lost {
            let (level, text) = link_news(is_lost);
            self.push(level, &format!(" {text}"));
        }
    }

    /// What follows the robot's name.
    pub(super) fn push(&mut self, level: LogLevel, text: &str) {
        self.news.push_back((level, format!("{}{text}", self.name)));
    }

    /// Puts a change of phase into words, and of how far the robot relies on where it believes to be.
    pub(super) fn phase(&mut self, navigator: &Navigator) {
        let health = navigator.pose_health();
        if std::mem::replace(&mut self.last_health, health) != health {
            let (level, text) = health_news(health);
            self.push(level, &format!(": {text}"));
        }
        let phase = navigator.phase();
        let view = navigator.view();
        let goal = view.goal_in_map.map(|goal| goal.se2());
        let is_new_goal = phase == Phase::AimAtTrail && goal != self.last_goal;
        self.last_goal = goal;
        if phase == self.last_phase && !is_new_goal {
            return;
        }
        self.last_phase = phase;
        let (level, text) = match phase {
            Phase::Arrived => (LogLevel::Good, "stands at its goal".to_owned()),
            Phase::Failed(reason) => {
                (LogLevel::Bad, format!("gives up: {}", words::failure(reason, view.scouting)))
            }
            Phase::AimAtTrail => (LogLevel::Info, words::task(&view, self.has_path)),
            Phase::Avoid | Phase::Wait | Phase::Blind | Phase::LostTrail => {
                (LogLevel::Warn, words::phase(phase, self.has_path).to_owned())
            }
            _ => (LogLevel::Info, words::phase(phase, self.has_path).to_owned()),
        };
        self.push(level, &format!(": {text}"));
    }

    /// The oldest news that was not told yet.
    pub(super) fn take(&mut self) -> Option<(LogLevel, String)> {
        self.news.pop_front()
    }

    pub(super) fn has_path(&self) -> bool {
        self.has_path
    }
}

fn health_news(health: PoseHealth) -> (LogLevel, &'static str) {
    match health {
        PoseHealth::Sure => (LogLevel::Info, "is sure where it is"),
        PoseHealth::Unsure => (LogLevel::Warn, "is not sure where it is on its map, and goes on"),
        PoseHealth::Lost => {
            let text = "is lost: what it sees does not fit its map where it believes to be; it goes on: stop it, or put it \
                        where it should be";
            (LogLevel::Bad, text)
        }
    }
}

fn link_news(is_lost: bool) -> (LogLevel, &'static str) {
    if is_lost {
        let text = "does not answer any more: told to stop, and left alone until its watchdog has stopped it";
        (LogLevel::Bad, text)
    } else {
        (LogLevel::Info, "answers again")
    }
}
