//! What of a run is a number over time: one table that the page, the recording and the guide share.
//!
//! A signal is described once, in [`SIGNALS`]: its name, what people read, in which plot or table it stands, and how
//! it is read of a run. The page draws its curves and tables from this list, its history and recordings
//! keep its columns by name, and a test writes it into the guide. To show one more number, add a line here.

use super::{metrics::RobotMetrics, vehicle::Vehicle};
use crate::view::{Scene, ViewRobot, ViewState};

/// A robot as its signals are read of it.
#[derive(Debug)]
pub(super) struct RobotNow<'r> {
    /// What is shown of it.
    pub(super) view: &'r ViewRobot,
    /// All that there is of it.
    pub(super) vehicle: &'r Vehicle,
    /// Its figures.
    pub(super) metrics: &'r RobotMetrics,
}

/// A number that a screen can show at every moment of a run.
#[derive(Debug)]
pub struct Signal {
    /// Its name in messages, recordings and files; the unit ends it. SI units.
    pub id: &'static str,
    /// What people read.
    pub title: &'static str,
    /// The plot of [`PLOTS`] in which it is drawn, and the name of its curve there.
    pub curve: Option<(&'static str, &'static str)>,
    /// It stands in the table of figures.
    pub is_figure: bool,
    /// It is measured from outside: of a robot elsewhere nobody can know it.
    pub is_seen_from_outside: bool,
    /// A sentence for people.
    pub about: &'static str,
    read: Read,
}

/// How a signal is read.
#[derive(Clone, Copy, Debug)]
enum Read {
    /// Of each robot.
    Robot(fn(&RobotNow<'_>) -> Option<f64>),
    /// Of the run.
    Run(fn(&ViewState) -> Option<f64>),
}

/// Curves that share an axis.
#[derive(Debug)]
pub struct Plot {
    /// Its name.
    pub id: &'static str,
    /// What people read.
    pub title: &'static str,
    /// The unit of its axis; empty for none.
    pub unit: &'static str,
    /// Its axis counts so many of a signal's value: 1000 for metres shown as millimetres.
    pub per_si_ratio: f64,
    /// What its axis shows at least, in its unit, so that a calm run does not look wild.
    pub least: [f64; 2],
    /// What is said while there is no value.
    pub empty: &'static str,
    is_offered: fn(&Scene) -> bool,
}

impl Plot {
    /// Whether a mission has what it plots.
    pub fn is_offered(&self, scene: &Scene) -> bool {
        (self.is_offered)(scene)
    }
}

impl Signal {
    /// One value for each robot, in [`ViewRobot::signals`](crate::ViewRobot::signals).
    pub fn is_of_robot(&self) -> bool {
        matches!(self.read, Read::Robot(_))
    }

    /// The signals of each robot, in the order of [`ViewRobot::signals`](crate::ViewRobot::signals).
    pub fn of_robots() -> impl Iterator<Item = &'static Self> {
        SIGNALS.iter().filter(|signal| signal.is_of_robot())
    }

    /// The signals of the run, in the order of [`ViewState::signals`].
    pub fn of_run() -> impl Iterator<Item = &'static Self> {
        SIGNALS.iter().filter(|signal| !signal.is_of_robot())
    }
}

/// What every robot's signals are now.
pub(super) fn of_robot(robot: &RobotNow<'_>) -> Vec<Option<f64>> {
    let value = |signal: &Signal| match signal.read {
        Read::Robot(read) => Some(read(robot).filter(|value| value.is_finite())),
        Read::Run(_) => None,
    };
    SIGNALS.iter().filter_map(value).collect()
}

/// What the run's signals are now.
pub(super) fn of_run(view: &ViewState) -> Vec<Option<f64>> {
    let value = |signal: &Signal| match signal.read {
        Read::Run(read) => Some(read(view).filter(|value| value.is_finite())),
        Read::Robot(_) => None,
    };
    SIGNALS.iter().filter_map(value).collect()
}

fn has_robot(scene: &Scene) -> bool {
    !scene.robots.is_empty()
}

/// The plots, as they stand on the page.
pub const PLOTS: [Plot; 5] = [
    Plot {
        id: "cross",
        title: "Cross-track error",
        unit: "mm",
        per_si_ratio: 1000.0,
        least: [-50.0, 50.0],
        empty: "no path is being followed",
        is_offered: has_robot,
    },
    Plot {
        id: "wheels",
        title: "Wheel speeds",
        unit: "mm/s",
        per_si_ratio: 1000.0,
        least: [0.0, 350.0],
        empty: "no robot",
        is_offered: has_robot,
    },
    Plot {
        id: "smell",
        title: "Pheromone intensity",
        unit: "",
        per_si_ratio: 1.0,
        least: [0.0, 10.0],
        empty: "no pheromones sensed",
        is_offered: |scene| scene.pheromones.is_some() || scene.tags.is_some(),
    },
    Plot {
        id: "clearance",
        title: "Clearance",
        unit: "m",
        per_si_ratio: 1.0,
        least: [0.0, 1.0],
        empty: "not known of this robot",
        is_offered: has_robot,
    },
    Plot {
        id: "place",
        title: "Localisation",
        unit: "mm",
        per_si_ratio: 1000.0,
        least: [0.0, 50.0],
        empty: "no robot",
        is_offered: has_robot,
    },
];

/// A robot's signal that only stands in a plot.
const CURVE: Signal = Signal {
    id: "",
    title: "",
    curve: None,
    is_figure: false,
    is_seen_from_outside: false,
    about: "",
    read: Read::Robot(|_| None),
};
/// A figure of the run.
const FIGURE: Signal = Signal { is_figure: true, read: Read::Run(|_| None), ..CURVE };

/// All signals, in the order in which tables show them.
pub const SIGNALS: [Signal; 16] = [
    Signal {
        id: "path_length_m",
        title: "Path length",
        about: "way that the first robot has driven",
        read: Read::Run(|view| view.figures.path_length_m),
        ..FIGURE
    },
    Signal {
        id: "time_s",
        title: "Time",
        about: "since the first robot was given its goal, until it arrived",
        read: Read::Run(|view| view.figures.time_s),
        ..FIGURE
    },
    Signal {
        id: "clearance_min_m",
        title: "Clearance, least",
        is_seen_from_outside: true,
        about: "least distance of the first robot to anything so far",
        read: Read::Run(|view| view.figures.clearance_min_m),
        ..FIGURE
    },
    Signal {
        id: "contacts",
        title: "Contacts",
        is_seen_from_outside: true,
        about: "contacts of all robots so far",
        read: Read::Run(|view| view.figures.contacts.map(|n| n as f64)),
        ..FIGURE
    },
    Signal {
        id: "cross_track_rms_m",
        title: "Cross-track, rms",
        is_seen_from_outside: true,
        about: "root mean square of the first robot's distance from its trail or path while it follows it",
        read: Read::Run(|view| view.figures.cross_track_rms_m),
        ..FIGURE
    },
    Signal {
        id: "cross_track_max_m",
        title: "Cross-track, max",
        is_seen_from_outside: true,
        about: "the same, the greatest distance",
        read: Read::Run(|view| view.figures.cross_track_max_m),
        ..FIGURE
    },
    Signal {
        id: "speed_mps",
        title: "Speed",
        is_figure: true,
        about: "of the robot's middle, forwards",
        read: Read::Robot(|now| Some(0.5 * (now.view.wheels_mps[0] + now.view.wheels_mps[1]))),
        ..CURVE
    },
    Signal {
        id: "position_error_m",
        title: "Position error",
        curve: Some(("place", "error")),
        is_figure: true,
        is_seen_from_outside: true,
        about: "between where the robot is and where it believes it is",
        read: Read::Robot(|now| {
            let (truth, estimate) = (now.view.truth, now.view.estimate);
            let is_here = now.vehicle.body.is_some();
            is_here.then(|| (truth.x_m - estimate.x_m).hypot(truth.y_m - estimate.y_m))
        }),
    },
    Signal {
        id: "position_doubt_m",
        title: "Position doubt",
        curve: Some(("place", "doubt")),
        about: "longer half axis of the region in which the robot believes itself to be with 95 %",
        read: Read::Robot(|now| Some(now.view.ellipse[0])),
        ..CURVE
    },
    Signal {
        id: "clearance_m",
        title: "Clearance",
        curve: Some(("clearance", "clearance")),
        is_figure: true,
        is_seen_from_outside: true,
        about: "from the robot's outline to the nearest surface",
        read: Read::Robot(|now| now.view.clearance_m),
    },
    Signal {
        id: "battery_v",
        title: "Battery",
        is_figure: true,
        about: "as the robot reports it",
        read: Read::Robot(|now| now.view.battery_v),
        ..CURVE
    },
    Signal {
        id: "cross_track_m",
        title: "Cross-track error",
        curve: Some(("cross", "error")),
        is_seen_from_outside: true,
        about: "to the left of the trail or path that is followed; true, not believed",
        read: Read::Robot(|now| now.metrics.cross_track_m),
        ..CURVE
    },
    Signal {
        id: "wheel_left_mps",
        title: "Left wheel",
        curve: Some(("wheels", "left")),
        about: "speed of the left wheel",
        read: Read::Robot(|now| Some(now.view.wheels_mps[0])),
        ..CURVE
    },
    Signal {
        id: "wheel_right_mps",
        title: "Right wheel",
        curve: Some(("wheels", "right")),
        about: "speed of the right wheel",
        read: Read::Robot(|now| Some(now.view.wheels_mps[1])),
        ..CURVE
    },
    Signal {
        id: "intensity_left",
        title: "Left antenna",
        curve: Some(("smell", "left")),
        about: "what the left antenna smells",
        read: Read::Robot(|now| now.view.intensities.map(|pair| pair[0])),
        ..CURVE
    },
    Signal {
        id: "intensity_right",
        title: "Right antenna",
        curve: Some(("smell", "right")),
        about: "what the right antenna smells",
        read: Read::Robot(|now| now.view.intensities.map(|pair| pair[1])),
        ..CURVE
    },
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_told_apart_and_every_curve_has_its_plot() {
        for (index, signal) in SIGNALS.iter().enumerate() {
            assert!(!signal.id.is_empty() && !signal.title.is_empty() && !signal.about.is_empty());
            assert!(SIGNALS[..index].iter().all(|other| other.id != signal.id), "{}", signal.id);
            assert!(signal.is_figure || signal.curve.is_some(), "{} is nowhere", signal.id);
            if let Some((plot, name)) = signal.curve {
                assert!(PLOTS.iter().any(|p| p.id == plot), "{plot}");
                assert!(signal.is_of_robot() && !name.is_empty(), "plots are of robots");
            }
        }
        for plot in &PLOTS {
            let mut curves = SIGNALS.iter().filter_map(|signal| signal.curve);
            assert!(curves.any(|(id, _)| id == plot.id), "{} has no curve", plot.id);
        }
    }
}
