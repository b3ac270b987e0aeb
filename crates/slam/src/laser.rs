//! SLAM with a scanning laser: scans are tracked on a local map, keyframes tied into a graph, loops closed.

mod closure;
pub mod config;
pub mod correlative;
mod keyframe;
mod local_map;
mod loops;
mod mapper;
pub mod points;
mod sight;
pub mod surfels;

pub use closure::{Closure, Rejection};
pub use config::{
    LaserConfig, LoopConfig, MotionConfig, PointsConfig, RefineConfig, TrackingConfig,
};
pub use keyframe::Keyframe;
pub use local_map::LocalMap;
pub use mapper::{LaserSlam, StepReport, Tracking};
