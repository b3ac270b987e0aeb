//! What the parts of a mind say of themselves: one sentence each, written out only when somebody reads it.

use std::fmt;

use geometry::Vec2;
use messages::FailureReason;

use crate::values::PoseHealth;

/// What one part is about, and why. `Display` writes the sentence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sentence {
    /// *Where am I*: how, how well (standard deviation, m), and how old that is (s).
    At {
        /// What says so.
        by: &'static str,
        /// Longer half axis of the 1 σ ellipse, metres.
        within_m: f64,
        /// How far it can be relied on.
        health: PoseHealth,
    },
    /// Its wheels have said nothing yet.
    NotHeard,
    /// *Around*: how many echoes, and the nearest reading of the ring (m).
    Around {
        /// Echoes remembered.
        n_echoes: usize,
        /// The shortest of the latest ranges, metres.
        nearest_m: Option<f64>,
        /// Something touches the robot.
        is_touched: bool,
    },
    /// *Where to*: the goal (m, map), as ordered, and the exactness asked for (m).
    To {
        /// The goal.
        goal: Vec2,
        /// How near to it the robot must stand, metres.
        within_m: f64,
    },
    /// There is no goal.
    NoGoal,
    /// *How*: by which method, and how much of its way is ahead (m).
    By {
        /// The method.
        method: &'static str,
        /// Way ahead that is known, metres.
        ahead_m: f64,
    },
    /// *Follow*: what it does, and how far off it was last (m).
    Follows {
        /// The law or turn.
        law: &'static str,
        /// Off the line or path, metres to the right.
        off_m: f64,
    },
    /// *Guard*: what the wheels were told last, forward (m/s), and slower than asked for by this factor.
    Passes {
        /// Speed that was passed on, metres per second.
        told_mps: f64,
        /// Of what was asked for; 1 for all of it.
        ratio: f64,
    },
    /// The guard goes around something: its machine's state, and attempts so far.
    GoesAround {
        /// The machine's state in words.
        state: &'static str,
        /// Attempts on this obstacle.
        n_attempts: u32,
    },
    /// *Health*: nothing is wrong.
    Well,
    /// The link is silent.
    LinkDown,
    /// Motors are off.
    MotorsOff,
    /// The task was given up.
    GaveUp(FailureReason),
}

/// One sentence of each part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Says {
    /// Where it is.
    pub where_am_i: Sentence,
    /// What is around.
    pub around: Sentence,
    /// Where it goes.
    pub where_to: Sentence,
    /// By which way.
    pub how: Sentence,
    /// With which law.
    pub follow: Sentence,
    /// What is done about things in the way.
    pub guard: Sentence,
    /// Whether that still makes sense.
    pub health: Sentence,
}

impl Says {
    /// The parts' names and sentences, in the order in which they are asked.
    pub fn parts(&self) -> [(&'static str, Sentence); 7] {
        [
            ("where am I", self.where_am_i),
            ("around", self.around),
            ("where to", self.where_to),
            ("how", self.how),
            ("follow", self.follow),
            ("guard", self.guard),
            ("health", self.health),
        ]
    }
}

impl fmt::Display for Sentence {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::At { by, within_m, health } => {
                write!(f, "by {by}, within {:.0} mm", 1e3 * within_m)?;
                match health {
                    PoseHealth::Sure => Ok(()),
                    PoseHealth::Unsure => f.write_str(", not sure"),
                    PoseHealth::Lost => f.write_str(", lost"),
                }
            }
            Self::NotHeard => f.write_str("unknown: the wheels have not been heard of yet"),
            Self::Around { n_echoes, nearest_m, is_touched } => {
                write!(f, "{n_echoes} echoes remembered")?;
                if let Some(nearest_m) = nearest_m {
                    write!(f, ", the nearest thing heard {nearest_m:.2} m away")?;
                }
                f.write_str(if is_touched { ", something touches the robot" } else { "" })
            }
            Self::To { goal, within_m } => {
                write!(
                    f,
                    "to ({:.1}, {:.1}), within {:.0} mm, as ordered",
                    goal.x,
                    goal.y,
                    1e3 * within_m
                )
            }
            Self::NoGoal => f.write_str("nowhere: nothing was ordered"),
            Self::By { method, ahead_m } if ahead_m > 0.0 => {
                write!(f, "{method}; {ahead_m:.1} m of it are known")
            }
            Self::By { method, .. } => f.write_str(method),
            Self::Follows { law, off_m } => {
                write!(f, "{law}, {:.0} mm off its line", 1e3 * off_m.abs())
            }
            Self::Passes { told_mps, ratio } if ratio < 0.995 => write!(
                f,
                "{told_mps:.2} m/s, {:.0} % of what was asked for: a robot that went deaf would touch something",
                1e2 * ratio
            ),
            Self::Passes { told_mps, .. } => write!(f, "{told_mps:.2} m/s, all that was asked for"),
            Self::GoesAround { state, n_attempts } => {
                write!(f, "goes around something: {state}, attempts so far: {n_attempts}")
            }
            Self::Well => f.write_str("nothing is wrong"),
            Self::LinkDown => f.write_str("the robot does not answer"),
            Self::MotorsOff => f.write_str("the motors are off"),
            Self::GaveUp(reason) => write!(f, "gave up: {}", reason.as_str()),
        }
    }
}
