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
    /// All lines, in the order of the links' numbers.
    pub const ALL: [Self; 3] = [Self::Robot, Self::Pheromones, Self::Ground];

    /// The word for it in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Robot => "robot",
            Self::Pheromones => "pheromones",
            Self::Ground => "ground",
        }
    }

    /// The words for its directions in files: both, away from the navigation node, back to it.
    pub fn direction_names(self) -> [&'static str; 3] {
        match self {
            Self::Robot => ["both", "to_robot", "from_robot"],
            Self::Pheromones => ["both", "to_server", "from_server"],
            Self::Ground => ["both", "to_ground", "from_ground"],
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
        }
    }
}

impl Direction {
    /// In the order of [`Line::direction_names`].
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
