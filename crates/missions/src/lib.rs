//! Mission files, the closed loop, metrics, verdicts and recordings.
//!
//! A [`Mission`] is a checked file: world, robots, wiring, methods, tasks, seed, and what counts as
//! success. A [`Run`] closes the loop: simulator, firmware, links, drivers, navigators, pheromone
//! server and decision node advance together in steps of 10 ms of virtual time. A run ends with a
//! [`Verdict`] and a [`Summary`]. A [`Recorder`] writes it to an MCAP file, a [`Replay`] repeats it and
//! compares the state hash of every step.
//!
//! This is the only crate in which the simulator and the navigator meet. It reads no clock: whoever
//! wants real time paces the calls of [`Run::step`].
//!
//! ```
//! use missions::{Mission, Run};
//!
//! let mission = Mission::load("decision-rig", &[])?;
//! let seed = mission.seed();
//! let mut run = Run::new(mission, seed)?;
//! let verdict = run.run_to_end();
//! assert!(verdict.passed, "{}", verdict.text);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! The same build on the same machine, given the same mission, seed and interventions, produces the
//! same bits, whatever the number of threads.

mod asked;
mod cut;
mod floor;
mod intervention;
mod mission;
mod node;
mod outline;
mod record;
mod replay;
mod run;
mod sensing;
mod summary;
mod transport;
mod verdict;
mod view;

pub use cut::{Direction, Line};
pub use floor::{Floor, FloorError};
pub use intervention::{Intervention, InterventionError, RecordedIntervention};
pub use mission::{
    ExpectedVerdict, Mission, MissionError, SettingError, ShippedInfo, WordList, file,
};
pub use outline::{Mark, Outline};
pub use record::{RecordError, Recorder};
pub use replay::{Divergence, Replay, ReplayError, ReplayReport, Seek};
pub use run::{DRIVE_HOLD, PLOTS, Plot, Run, RunError, SIGNALS, STEP, Signal, can_start, world_of};
pub use sensing::{PoseReport, RingRow, ScanRow, SensedRun, SensedStep, SensorLog, sense};
pub use summary::{Figure, Summary};
pub use transport::{MemoryTransport, SerialTransport, TcpTransport, Transport, TransportError};
pub use verdict::{Check, Verdict};
pub use view::{
    LogItem, LogLevel, Pose, Scene, SceneDevice, SceneFunction, SceneLink, SceneOperand,
    ScenePheromones, SceneProgram, SceneRobot, SceneScanner, SceneSonar, SceneTags, SceneThing,
    SceneWall, TraceItem, ViewDecision, ViewFigures, ViewPerson, ViewPose, ViewRobot, ViewScan,
    ViewState, ViewTimer,
};
