//! What a sensor returns for a given scene: forward models with the errors real sensors have.
//!
//! [`SonarModel`] is the ultrasonic ring of a Pioneer: a cone, a nearest strong enough echo,
//! surfaces that mirror sound away. [`FiringSchedule`] says which sensor fires when. The scene is
//! anything that rays can be cast into ([`geometry::RayCaster`]), whose tags are indices into a
//! list of [`Material`]s.

mod firing;
mod laser;
mod material;
mod sonar;

pub use firing::{Firing, FiringSchedule};
pub use laser::LaserModel;
pub use material::{
    Material, PERSON_TAG, ROBOT_TAG, WALL_TAG, material_by_name, materials, materials_like,
};
pub use sonar::{Echo, EchoCause, ModelRange, SonarModel};
