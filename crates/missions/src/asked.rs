//! What the ground asks a robot beside goals and stops: its sonars, whether the link is there, to begin anew.

use wire::ground_link::ToVehicle;

/// A question, or the order to begin anew, which is answered as one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Asked {
    /// Whether the robot hears the ground, and the ground it.
    Link,
    /// What the eight front sonars measure.
    Sonar,
    /// To forget its goal and connect to the robot anew.
    Restart,
}

impl Asked {
    /// All of them.
    pub(crate) const ALL: [Self; 3] = [Self::Link, Self::Sonar, Self::Restart];

    /// What is done, for the log.
    pub(crate) const fn done(self) -> &'static str {
        match self {
            Self::Link => "the link is tested",
            Self::Sonar => "a sonar report is asked for",
            Self::Restart => "a restart is ordered",
        }
    }

    /// The message of the link.
    pub(crate) const fn message(self) -> ToVehicle {
        match self {
            Self::Link => ToVehicle::LinkTest,
            Self::Sonar => ToVehicle::ReportSonar,
            Self::Restart => ToVehicle::Restart,
        }
    }
}
