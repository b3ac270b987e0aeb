//! One robot's body: where it is, how its wheels turn, what it touches.

use std::{sync::Arc, time::Duration};

use geometry::{Base, Se2, Transform2, Twist, Vec2, frames};
use robot_models::{Drivetrain, RobotModel, WheelSpeeds, ramp};
use run_context::{RandomStream, RunSeed, StateHash};
use sensor_models::SonarModel;

use crate::{
    collide,
    spec::{RobotPlacement, WorldError},
};

/// A robot's body in the world. Read it; the world alone writes it.
#[derive(Clone, Debug)]
pub struct Body {
    /// Its unique name.
    pub name: String,
    /// What kind of robot it is.
    pub model: Arc<RobotModel>,
    /// Where it truly is.
    pub world_from_base: Transform2<frames::World, Base>,
    /// Speeds of the wheels' rims as the encoders see them, after the last step.
    pub wheel_speeds: WheelSpeeds,
    /// Left and right pulses since it was put into the world.
    pub encoder_ticks: [i64; 2],
    /// Left and right: the wheel was stopped by something that touches this side.
    pub stalled: [bool; 2],
    /// Whether the footprint touches something (until 1 mm lies between).
    pub touching: bool,
    /// How often it has come to touch something.
    pub contacts: u64,
    /// Its sonars.
    pub sonar: SonarModel,
    /// What the wheels should reach.
    pub wheel_reference: WheelSpeeds,
    /// How fast they may change, metres per second squared.
    pub acceleration_mps2: f64,
    /// True way of the point midway between the wheels so far, metres.
    pub travelled_m: f64,
    pub(crate) drivetrain: Drivetrain,
    pub(crate) rng: RandomStream,
    /// Footprint in the world frame, metres.
    pub(crate) corners: Vec<Vec2>,
    pub(crate) bounding_radius_m: f64,
    /// The body may move this far before it can touch a wall, metres; negative: unknown.
    pub(crate) wall_slack_m: f64,
    /// Left and right half of the footprint, base frame, metres.
    pub(crate) halves: [Vec<Vec2>; 2],
}

impl Body {
    pub(crate) fn new(placement: RobotPlacement, seed: RunSeed) -> Result<Self, WorldError> {
        let RobotPlacement { name, model, world_from_base, errors, sonar } = placement;
        let errors =
            errors.checked().map_err(|source| WorldError::Errors { name: name.clone(), source })?;
        let sonar =
            sonar.checked().map_err(|source| WorldError::Sonar { name: name.clone(), source })?;
        let mut body = Self {
            rng: seed.stream(&format!("body/{name}")),
            name,
            world_from_base: Transform2::new(world_from_base),
            wheel_speeds: WheelSpeeds::ZERO,
            encoder_ticks: [0; 2],
            stalled: [false; 2],
            touching: false,
            contacts: 0,
            sonar,
            wheel_reference: WheelSpeeds::ZERO,
            acceleration_mps2: model.limits.acceleration_max_mps2,
            travelled_m: 0.0,
            drivetrain: Drivetrain::new(model.drive, errors),
            corners: vec![Vec2::zeros(); model.footprint.corners().len()],
            bounding_radius_m: model.bounding_radius_m(),
            wall_slack_m: -1.0,
            halves: collide::halves(model.footprint.corners()),
            model,
        };
        body.place(world_from_base);
        Ok(body)
    }

    /// Puts the body somewhere without moving its wheels.
    pub(crate) fn place(&mut self, world_from_base: Se2) {
        self.world_from_base = Transform2::new(world_from_base);
        transform_into(world_from_base, self.model.footprint.corners(), &mut self.corners);
    }

    /// Its footprint, world frame, metres, counter-clockwise.
    pub fn footprint(&self) -> &[Vec2] {
        &self.corners
    }

    /// Its centre, world frame, metres.
    pub fn position(&self) -> Vec2 {
        self.world_from_base.se2().position()
    }

    /// The wheels' mean speeds during the next step, and their speeds at its end.
    pub(crate) fn next_speeds(&self, dt: Duration) -> (WheelSpeeds, WheelSpeeds) {
        let end = ramp(self.wheel_speeds, self.wheel_reference, self.acceleration_mps2, dt);
        let mean = WheelSpeeds {
            left_mps: 0.5 * (self.wheel_speeds.left_mps + end.left_mps),
            right_mps: 0.5 * (self.wheel_speeds.right_mps + end.right_mps),
        };
        (mean, end)
    }

    /// Counts a contact unless it goes on from before.
    pub(crate) fn touch(&mut self) {
        self.contacts += u64::from(!self.touching);
        self.touching = true;
    }

    /// Where a part of `twist` (0 to 1) would lead.
    pub(crate) fn ahead(&self, twist: Twist, part: f64) -> Se2 {
        let scaled = Twist {
            dx_m: part * twist.dx_m,
            dy_m: part * twist.dy_m,
            dyaw_rad: part * twist.dyaw_rad,
        };
        self.world_from_base.se2().compose(Se2::exp(scaled))
    }

    pub(crate) fn absorb(&self, hash: &mut StateHash) {
        let pose = self.world_from_base.se2();
        let numbers = [
            pose.x_m,
            pose.y_m,
            pose.yaw_rad,
            self.wheel_speeds.left_mps,
            self.wheel_speeds.right_mps,
            self.wheel_reference.left_mps,
            self.wheel_reference.right_mps,
            self.acceleration_mps2,
            self.travelled_m,
        ];
        for number in numbers {
            hash.absorb(number);
        }
        for side in 0..2 {
            hash.absorb_u64(self.encoder_ticks[side].cast_unsigned());
            hash.absorb_u64(self.stalled[side].into());
        }
        hash.absorb_u64(self.touching.into());
        hash.absorb_u64(self.contacts);
    }
}

/// Replaces `out` by `points` moved by `pose`; one sine and cosine for all.
pub(crate) fn transform_into(pose: Se2, points: &[Vec2], out: &mut Vec<Vec2>) {
    let (s, c) = pose.yaw_rad.sin_cos();
    out.clear();
    out.extend(
        points
            .iter()
            .map(|p| Vec2::new(pose.x_m + c * p.x - s * p.y, pose.y_m + s * p.x + c * p.y)),
    );
}
