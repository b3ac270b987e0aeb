//! Cutting a robot's lines: which line, which way, and the words that files and recordings have for it.
//!
//! The navigation node is where all lines begin: `to_…` is what it sends, `from_…` is what it hears.

use serde::{Deserialize, Serialize};

/// A line of a robot's navigation node.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Line {
    /// To its robot: commands out, information packets in.
    Robot,
    /// To the pheromone server: questions out, answers in.
    Pheromones,
    /// To the ground, which is the decision node or a ground station: reports out, orders in.
    Ground,
    /// To one of its lasers, counted from 0: requests out, scans in.
    Laser(u8),
}

/// The lines that have a word of their own in files; a laser's is its name.
impl settings::Choice for Line {
    const ALL: &'static [Self] = &[Self::Robot, Self::Pheromones, Self::Ground];

    fn key(self) -> &'static str {
        match self {
            Self::Robot => "robot",
            Self::Pheromones => "pheromones",
            Self::Ground => "ground",
            Self::Laser(_) => "laser",
        }
    }

    fn about(self) -> &'static str {
        match self {
            Self::Robot => "to its body: commands out, what it senses in",
            Self::Pheromones => "to the pheromone server: questions out, answers in",
            Self::Ground => "to the decision node or a ground station: reports out, orders in",
            Self::Laser(_) => "to a laser: requests out, scans in",
        }
    }
}

/// Which way bytes cannot pass any more.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Direction {
    /// Neither way.
    Both,
    /// Away from the navigation node.
    Away,
    /// Towards the navigation node.
    Back,
}

impl Line {
    /// The word for a direction of it in files.
    pub fn direction_name(self, direction: Direction) -> &'static str {
        match (self, direction) {
            (_, Direction::Both) => "both",
            (Self::Robot, Direction::Away) => "to_robot",
            (Self::Robot, Direction::Back) => "from_robot",
            (Self::Pheromones, Direction::Away) => "to_server",
            (Self::Pheromones, Direction::Back) => "from_server",
            (Self::Ground, Direction::Away) => "to_ground",
            (Self::Ground, Direction::Back) => "from_ground",
            (Self::Laser(_), Direction::Away) => "to_laser",
            (Self::Laser(_), Direction::Back) => "from_laser",
        }
    }

    /// For people: what is cut.
    pub(crate) fn describe(self, direction: Direction) -> &'static str {
        match (self, direction) {
            (Self::Robot, Direction::Both) => "the line to the robot, both ways,",
            (Self::Robot, Direction::Away) => "the line to the robot",
            (Self::Robot, Direction::Back) => "the line from the robot",
            (Self::Pheromones, Direction::Both) => "the line to the pheromone server, both ways,",
            (Self::Pheromones, Direction::Away) => "the line to the pheromone server",
            (Self::Pheromones, Direction::Back) => "the line from the pheromone server",
            (Self::Ground, Direction::Both) => "the line to the ground, both ways,",
            (Self::Ground, Direction::Away) => "the line to the ground",
            (Self::Ground, Direction::Back) => "the line from the ground",
            (Self::Laser(_), Direction::Both) => "the line to a laser, both ways,",
            (Self::Laser(_), Direction::Away) => "the line to a laser",
            (Self::Laser(_), Direction::Back) => "the line from a laser",
        }
    }
}

impl Direction {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Both, Self::Away, Self::Back];

    /// Whether bytes away from the navigation node are meant, and bytes back to it.
    pub fn ways(self) -> [bool; 2] {
        [self != Self::Back, self != Self::Away]
    }
}

/// What does not pass on a line that carries messages instead of bytes: away from the navigation node,
/// and back to it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Cuts {
    pub(crate) away: bool,
    pub(crate) back: bool,
}

impl Cuts {
    /// Cuts or mends.
    pub(crate) fn set(&mut self, direction: Direction, cut: bool) {
        let [away, back] = direction.ways();
        self.away = if away { cut } else { self.away };
        self.back = if back { cut } else { self.back };
    }

    pub(crate) fn any(self) -> bool {
        self.away || self.back
    }
}
