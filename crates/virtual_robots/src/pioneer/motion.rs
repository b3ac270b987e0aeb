//! Set points to wheel speeds: what the robot's own controller does between two commands.
//!
//! Translation and rotation are ramped separately under the limits SETV, SETA, SETRV and SETRA;
//! wheel speeds (VEL2) are ramped together under SETA, so that the path keeps its curvature.
//! Headings and distances are reached by a proportional controller that never asks for more speed
//! than it can still take off before the goal, v ≤ √(2 a s). A reached heading goes on being held.
//!
//! Differences from the real firmware: that one runs a PID per wheel on motor currents, of which
//! the gains KP, KV and KI remain only as reported numbers.

use std::{
    f64::consts::{PI, TAU},
    time::Duration,
};

use geometry::wrap_to_pi;
use robot_models::{BodyVelocity, DriveGeometry, WheelSpeeds, ramp};

/// Speed asked for per unit of remaining way or angle, 1/s. Higher is stiffer; the loop
/// runs at 100 Hz, so that anything well below that is stable.
const GAIN_HZ: f64 = 4.0;

/// A heading this close, rad, counts as reached: a tick of the encoders is about 0.02° of turn.
const HEADING_REACHED_RAD: f64 = 0.25 * PI / 180.0;

/// A distance this close, m, counts as reached.
const DISTANCE_REACHED_M: f64 = 0.001;

/// By how much the wheels are ahead of what is known of their way, s: it was counted a step of 10 ms
/// ago, and they go on for half of the next one.
const AHEAD_S: f64 = 0.015;

/// What a client can set with SETV, SETA, SETRV and SETRA.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct MotionLimits {
    pub(super) speed_mps: f64,
    pub(super) acceleration_mps2: f64,
    pub(super) deceleration_mps2: f64,
    pub(super) turn_rate_radps: f64,
    pub(super) turn_acceleration_radps2: f64,
    pub(super) turn_deceleration_radps2: f64,
}

/// The robot's motion controller.
#[derive(Clone, Debug)]
pub(super) struct Motion {
    pub(super) limits: MotionLimits,
    mode: Mode,
    /// The watchdog keeps it standing; the set points are kept.
    suspended: bool,
    velocity: BodyVelocity,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Mode {
    Wheels(WheelSpeeds),
    Body { translation: Translation, rotation: Rotation },
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Translation {
    Speed {
        mps: f64,
    },
    /// Stop where the signed odometer shows this.
    Until {
        odometer_m: f64,
    },
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Rotation {
    Rate { radps: f64 },
    Heading { rad: f64 },
}

const STAND: Translation = Translation::Speed { mps: 0.0 };
const STRAIGHT: Rotation = Rotation::Rate { radps: 0.0 };
const REST: Mode = Mode::Body { translation: STAND, rotation: STRAIGHT };

impl Motion {
    pub(super) fn new(limits: MotionLimits) -> Self {
        Self { limits, mode: REST, suspended: false, velocity: BodyVelocity::default() }
    }

    /// VEL: goes straight at that speed; the rotation set point stays.
    pub(super) fn set_speed(&mut self, speed_mps: f64) {
        self.set_translation(Translation::Speed { mps: speed_mps });
    }

    /// MOVE: goes that far from where the odometer is; zero decelerates to a stand, wherever that
    /// is.
    pub(super) fn move_by(&mut self, distance_m: f64, odometer_m: f64) {
        let there = Translation::Until { odometer_m: odometer_m + distance_m };
        self.set_translation(if distance_m == 0.0 { STAND } else { there });
    }

    /// RVEL, ROTATE: turns at that rate; the translation set point stays.
    pub(super) fn set_turn_rate(&mut self, radps: f64) {
        self.set_rotation(Rotation::Rate { radps });
    }

    /// HEAD: turns the short way round to that heading and holds it.
    pub(super) fn set_heading(&mut self, heading_rad: f64) {
        self.set_rotation(Rotation::Heading { rad: wrap_to_pi(heading_rad) });
    }

    /// VEL2: one speed for each wheel.
    pub(super) fn set_wheels(&mut self, wheels: WheelSpeeds) {
        self.mode = Mode::Wheels(wheels);
    }

    /// STOP: decelerates to a stand.
    pub(super) fn stop(&mut self) {
        self.mode = REST;
    }

    /// The watchdog: decelerates to a stand and keeps its set points.
    pub(super) fn suspend(&mut self) {
        self.suspended = true;
    }

    /// The client is back: the set points count again.
    ///
    /// Source: Pioneer 3 Operations Manual, safety watchdogs: activity, motion included, goes on as
    /// soon as communication is restored.
    pub(super) fn resume(&mut self) {
        self.suspended = false;
    }

    /// `E_STOP` and switched-off motors: stands now, whatever the limits.
    pub(super) fn stop_at_once(&mut self) {
        self.stop();
        self.velocity = BodyVelocity::default();
    }

    /// Bumpers are pressed in front or behind: motion towards them ends now, whatever the limits,
    /// and its set point is forgotten; motion away from them and turning go on.
    pub(super) fn hold_back(&mut self, [front, rear]: [bool; 2], odometer_m: f64) {
        let held = |mps: f64| (front && mps > 0.0) || (rear && mps < 0.0);
        match self.mode {
            Mode::Body { translation, rotation } => {
                if held(translation.speed_mps(odometer_m, &self.limits)) {
                    self.mode = Mode::Body { translation: STAND, rotation };
                }
            }
            Mode::Wheels(target) => {
                if held(target.left_mps + target.right_mps) {
                    self.stop_at_once();
                }
            }
        }
        if held(self.velocity.linear_mps) {
            self.velocity.linear_mps = 0.0;
        }
    }

    /// The frame of headings turns by `yaw_rad`: a heading that is held turns along.
    pub(super) fn turn_frame(&mut self, yaw_rad: f64) {
        if let Mode::Body { rotation: Rotation::Heading { rad }, .. } = &mut self.mode {
            *rad = wrap_to_pi(*rad - yaw_rad);
        }
    }

    /// The heading it servos to, if it does.
    pub(super) fn heading_setpoint_rad(&self) -> Option<f64> {
        match self.mode {
            Mode::Body { rotation: Rotation::Heading { rad }, .. } => Some(rad),
            _ => None,
        }
    }

    /// The velocity it asks of the motors now.
    pub(super) fn velocity(&self) -> BodyVelocity {
        self.velocity
    }

    /// The wheel speeds to ask for now, `dt` after the last time.
    pub(super) fn step(
        &mut self,
        heading_rad: f64,
        odometer_m: f64,
        drive: &DriveGeometry,
        dt: Duration,
    ) -> WheelSpeeds {
        match if self.suspended { REST } else { self.mode } {
            Mode::Wheels(target) => self.step_wheels(target, drive, dt),
            Mode::Body { translation, rotation } => {
                let limits = self.limits;
                let speed_mps = translation.speed_mps(odometer_m, &limits);
                let radps = rotation.rate_radps(heading_rad, &limits);
                self.velocity = BodyVelocity {
                    linear_mps: approach(
                        self.velocity.linear_mps,
                        speed_mps,
                        [limits.acceleration_mps2, limits.deceleration_mps2],
                        dt,
                    ),
                    angular_radps: approach(
                        self.velocity.angular_radps,
                        radps,
                        [limits.turn_acceleration_radps2, limits.turn_deceleration_radps2],
                        dt,
                    ),
                };
                drive.wheel_speeds(self.velocity)
            }
        }
    }

    fn step_wheels(
        &mut self,
        target: WheelSpeeds,
        drive: &DriveGeometry,
        dt: Duration,
    ) -> WheelSpeeds {
        let excess = (fastest_mps(target) / self.limits.speed_mps).max(1.0);
        let target = WheelSpeeds {
            left_mps: target.left_mps / excess,
            right_mps: target.right_mps / excess,
        };
        let current = drive.wheel_speeds(self.velocity);
        let slower = fastest_mps(target) < fastest_mps(current);
        let acceleration_mps2 =
            if slower { self.limits.deceleration_mps2 } else { self.limits.acceleration_mps2 };
        let wheels = ramp(current, target, acceleration_mps2, dt);
        self.velocity = drive.body_velocity(wheels);
        wheels
    }

    /// After VEL2 the rotation has no set point of its own: it becomes straight on.
    fn set_translation(&mut self, translation: Translation) {
        let rotation = match self.mode {
            Mode::Body { rotation, .. } => rotation,
            Mode::Wheels(_) => STRAIGHT,
        };
        self.mode = Mode::Body { translation, rotation };
    }

    /// After VEL2 the translation has no set point of its own: the robot stands and turns.
    fn set_rotation(&mut self, rotation: Rotation) {
        let translation = match self.mode {
            Mode::Body { translation, .. } => translation,
            Mode::Wheels(_) => STAND,
        };
        self.mode = Mode::Body { translation, rotation };
    }
}

impl Translation {
    fn speed_mps(self, odometer_m: f64, limits: &MotionLimits) -> f64 {
        match self {
            Self::Speed { mps } => mps.clamp(-limits.speed_mps, limits.speed_mps),
            Self::Until { odometer_m: end_m } => {
                let rest_m = end_m - odometer_m;
                if rest_m.abs() < DISTANCE_REACHED_M {
                    return 0.0;
                }
                // Braking so early that v² / 2a and the way that is not known yet end there.
                let ahead_mps = limits.deceleration_mps2 * AHEAD_S;
                let stoppable_mps =
                    (ahead_mps * ahead_mps + 2.0 * limits.deceleration_mps2 * rest_m.abs()).sqrt()
                        - ahead_mps;
                let speed_max_mps = stoppable_mps.min(limits.speed_mps);
                servo(rest_m, speed_max_mps, limits.deceleration_mps2)
            }
        }
    }
}

impl Rotation {
    fn rate_radps(self, heading_rad: f64, limits: &MotionLimits) -> f64 {
        match self {
            Self::Rate { radps } => radps.clamp(-limits.turn_rate_radps, limits.turn_rate_radps),
            Self::Heading { rad } => {
                let rest_rad = wrap_to_pi(rad - heading_rad);
                if rest_rad.abs() < HEADING_REACHED_RAD {
                    return 0.0;
                }
                servo(rest_rad, limits.turn_rate_radps, limits.turn_deceleration_radps2)
            }
        }
    }
}

/// Speed towards something `rest` away: proportional, below `speed_max`, and never faster than
/// `deceleration` can still stop within `rest`.
fn servo(rest: f64, speed_max: f64, deceleration: f64) -> f64 {
    // v = √(2 a s)
    let stoppable = (2.0 * deceleration * rest.abs()).sqrt();
    (GAIN_HZ * rest.abs()).min(stoppable).min(speed_max).copysign(rest)
}

/// `current` after `dt` of approaching `target`; the rate is the first of `rates` (per second) when
/// that means getting faster, else the second.
fn approach(current: f64, target: f64, rates: [f64; 2], dt: Duration) -> f64 {
    let faster = current * target >= 0.0 && target.abs() > current.abs();
    let change_max = dt.as_secs_f64() * if faster { rates[0] } else { rates[1] };
    let change = target - current;
    if change.abs() <= change_max { target } else { current + change_max.copysign(change) }
}

fn fastest_mps(wheels: WheelSpeeds) -> f64 {
    wheels.left_mps.abs().max(wheels.right_mps.abs())
}

/// Degrees to radians in [−π, π).
pub(super) fn heading_from_deg(heading_deg: f64) -> f64 {
    wrap_to_pi(heading_deg * TAU / 360.0)
}
