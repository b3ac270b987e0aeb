//! SLAM with a scanning laser: scans are tracked on a local map, keyframes tied into a graph, loops closed.

pub mod config;
pub mod correlative;
mod local_map;
mod loops;
mod mapper;
pub mod points;
mod sight;
pub mod surfels;

pub use config::{
    LaserConfig, LoopConfig, MotionConfig, PointsConfig, RefineConfig, TrackingConfig,
};
pub use local_map::LocalMap;
pub use mapper::{Closure, Keyframe, LaserSlam, Rejection, StepReport, Tracking};
