//! What a sensor returns for a given scene, and what a reading says about one.
//!
//! [`SonarModel`] is the ultrasonic ring of a Pioneer: a cone, a nearest strong enough echo,
//! surfaces that mirror sound away. [`FiringSchedule`] says which sensor fires when. [`LaserModel`] is
//! a scanning range finder, [`Sweep`] fires its beams one after the other while the robot moves, and
//! [`PlanarScan`] is what a client makes of one's readings. The scene is anything that rays can be cast into ([`geometry::RayCaster`]), whose tags are indices into a
//! list of [`Material`]s.
//!
//! [`TagReader`] reads passive radio tags in the floor, one at a time.
//!
//! The other way round, what a reading says about the world: [`ConeModel`] and the source's
//! [`ArcProfile`], with Bayes' rule in [`bayes`] and the older composition in [`elfes_moravec`].

pub mod bayes;
pub mod elfes_moravec;
mod firing;
mod inverse_sonar;
mod laser;
mod material;
mod sonar;
mod tag_reader;

pub use firing::{Firing, FiringSchedule};
pub use inverse_sonar::{ArcFocus, ArcProfile, ConeModel, ProfileForm, Region};
pub use laser::{Beam, BeamSight, LaserEcho, LaserKind, LaserModel, PlanarScan, ScanBeam, Sweep};
pub use material::{
    Light, Material, PERSON_TAG, ROBOT_TAG, WALL_TAG, material_by_name, materials, materials_like,
};
pub use sonar::{Echo, EchoCause, ModelRange, SonarModel};
pub use tag_reader::{TagHint, TagMemory, TagReader, TagReaderModel};
