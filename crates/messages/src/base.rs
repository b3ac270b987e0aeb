//! What is known of a robot's base, from the latest that its devices said.

use robot_models::WheelSpeeds;
use run_context::Stamp;

use crate::{Battery, Contacts, Motors, Observation, OdometryReading, Ring, Sensed};

/// The latest of what a robot's own board reports; nothing that it has not said.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BaseState {
    /// What the wheels say.
    pub odometry: Option<OdometryReading>,
    /// What time that is about.
    pub about: Stamp,
    /// The ranges of its ring.
    pub ring: Option<Ring>,
    /// What touches it.
    pub contacts: Option<Contacts>,
    /// Whether its motors follow.
    pub motors: Option<Motors>,
    /// How its battery stands.
    pub battery: Option<Battery>,
}

impl BaseState {
    /// Takes what is about the base; the rest is not looked at.
    pub fn take(&mut self, observation: &Observation) {
        match observation.value {
            Sensed::Odometry(odometry) => {
                self.odometry = Some(odometry);
                self.about = observation.about;
            }
            Sensed::Ring(ring) => self.ring = Some(ring),
            Sensed::Contact(contacts) => self.contacts = Some(contacts),
            Sensed::Motors(motors) => self.motors = Some(motors),
            Sensed::Battery(battery) => self.battery = Some(battery),
            Sensed::Scan(_)
            | Sensed::Tag(_)
            | Sensed::Smell(_)
            | Sensed::Order(_)
            | Sensed::Link(_) => {}
        }
    }

    /// The measured wheel speeds; standing where nothing was said.
    pub fn wheel_speeds(&self) -> WheelSpeeds {
        self.odometry.map_or(WheelSpeeds::ZERO, |odometry| odometry.wheel_speeds)
    }

    /// Whether it says that it moves.
    pub fn is_moving(&self) -> bool {
        self.odometry.is_some_and(|odometry| odometry.moving)
    }

    /// Whether anything touches it, as far as it has said.
    pub fn is_touched(&self) -> bool {
        self.contacts.is_some_and(|contacts| contacts.any())
    }

    /// The ranges of its ring, metres; empty without one.
    pub fn ranges_m(&self) -> &[f64] {
        self.ring.as_ref().map_or(&[], Ring::ranges_m)
    }
}
