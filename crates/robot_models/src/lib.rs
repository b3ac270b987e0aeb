//! How small wheeled robots move, count their wheels, and lose their way doing so.
//!
//! Differential-drive kinematics ([`DriveGeometry`], [`ramp`]), encoders and dead reckoning
//! ([`Encoder`], [`Odometry`]), the errors that make dead reckoning drift ([`OdometryErrors`],
//! [`Drivetrain`]), how uncertain it therefore is ([`PoseCovariance`]), and the catalogue of
//! robots as data ([`RobotModel`]).
//!
//! Equation numbers are those of Susnea (c. 2009), doctoral thesis, Univ. Galati ("the thesis").

mod catalogue;
mod covariance;
mod devices;
mod drive;
mod drivetrain;
mod model_error;
mod odometry;

pub use catalogue::{LineModel, RingTiming, RobotModel, SonarMount, UnknownModel};
pub use covariance::{OdometryNoise, PoseCovariance, UncertaintyEllipse};
pub use devices::{BatteryModel, BumperMount, Devices, FloorSensorMount, InfraredMount};
pub use drive::{BodyVelocity, DriveGeometry, DriveLimits, WheelSpeeds, WheelTravel, ramp};
pub use drivetrain::{Drivetrain, Encoder, ErrorRange, OdometryErrors};
pub use model_error::ModelError;
pub use odometry::{Odometry, OdometryRule};
