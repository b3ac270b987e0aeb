//! A person's hand on a robot: speeds that hold for a moment and have to be renewed.
//!
//! While the hand holds the robot, the robot's own mind may think and ask, but not move it. The hand that is not
//! felt for [`DRIVE_HOLD`] has let go, whatever the reason (a released key, a closed page, a broken line), and the
//! robot is stopped. It then stands until it is given a goal.

use std::time::Duration;

use messages::Command;
use robot_models::{BodyVelocity, DriveLimits, RobotModel, WheelSpeeds};
use run_context::Stamp;

/// How long a speed holds that is not renewed: three renewals of a page at ten a second may be lost, and at
/// the greatest speed the robot goes 0.4 m and its braking distance.
pub const DRIVE_HOLD: Duration = Duration::from_millis(500);
/// Greatest speed by hand, m/s: what Pioneers allow when they are switched on.
const SPEED_MAX_MPS: f64 = 0.75;
/// Greatest turning rate by hand, rad/s: as fast as a person can still steer by.
const TURN_RATE_MAX_RADPS: f64 = 1.5;
/// How often the robot is told again.
const TELL_PERIOD: Duration = Duration::from_millis(100);

/// The hand, on the robot or not.
#[derive(Debug, Default)]
pub(super) struct Hand {
    held: Option<Held>,
    news: Option<&'static str>,
}

#[derive(Clone, Copy, Debug)]
struct Held {
    wheels: WheelSpeeds,
    /// When it has let go unless it is felt again.
    until: Stamp,
    next_telling: Stamp,
    /// The motors are switched on first.
    is_new: bool,
}

/// What a robot may be driven at by hand.
pub(super) fn limits(model: &RobotModel) -> DriveLimits {
    let own = model.limits;
    DriveLimits {
        speed_max_mps: own.speed_max_mps.min(SPEED_MAX_MPS),
        turn_rate_max_radps: own.turn_rate_max_radps.min(TURN_RATE_MAX_RADPS),
        ..own
    }
}

/// The wheels' speeds for what a person asks for, scaled down together to what the robot may do.
pub(super) fn wheels(model: &RobotModel, velocity: BodyVelocity) -> WheelSpeeds {
    model.drive.limited(model.drive.wheel_speeds(velocity), &limits(model))
}

impl Hand {
    /// Feels the hand. Whether it is new on the robot, whose mind then has to forget its task.
    pub(super) fn feel(&mut self, now: Stamp, wheels: WheelSpeeds) -> bool {
        let is_new = self.held.is_none();
        if is_new {
            self.news = Some("driven by hand");
        }
        let is_new = is_new || self.held.is_some_and(|held| held.is_new);
        let (until, next_telling) = (now + DRIVE_HOLD, now);
        self.held = Some(Held { wheels, until, next_telling, is_new });
        is_new
    }

    /// The robot is somebody else's now.
    pub(super) fn let_go(&mut self) {
        self.held = None;
    }

    /// Puts the hand's commands in place of those by which the robot's mind would move it.
    pub(super) fn step(&mut self, now: Stamp, commands: &mut Vec<Command>) {
        let Some(held) = &mut self.held else { return };
        commands.retain(|command| {
            !matches!(command, Command::Drive(_) | Command::TurnTo { .. } | Command::Stop)
        });
        if held.is_new {
            held.is_new = false;
            commands.push(Command::EnableMotors(true));
        }
        if now >= held.until {
            commands.push(Command::Stop);
            self.held = None;
            self.news = Some("let go by hand, and stopped");
        } else if now >= held.next_telling {
            held.next_telling = now + TELL_PERIOD;
            commands.push(Command::Drive(held.wheels));
        }
    }

    pub(super) fn is_on(&self) -> bool {
        self.held.is_some()
    }

    /// What is worth telling, once.
    pub(super) fn take_news(&mut self) -> Option<&'static str> {
        self.news.take()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(ms: u64) -> Stamp {
        Stamp::from_millis(ms)
    }

    fn pioneer() -> RobotModel {
        RobotModel::by_name("pioneer3dx").unwrap()
    }

    const FORWARD: WheelSpeeds = WheelSpeeds { left_mps: 0.2, right_mps: 0.2 };

    #[test]
    fn a_hand_that_is_not_felt_again_has_let_go_after_half_a_second() {
        let mut hand = Hand::default();
        assert!(hand.feel(at(0), FORWARD), "it is new");
        let mut seen = Vec::new();
        for ms in (0..1000).step_by(10) {
            let mut commands = vec![Command::Drive(WheelSpeeds { left_mps: 1.0, right_mps: 1.0 })];
            hand.step(at(ms), &mut commands);
            seen.push((ms, commands));
        }
        assert_eq!(seen[0].1, [Command::EnableMotors(true), Command::Drive(FORWARD)]);
        assert!(seen[1].1.is_empty(), "the mind's own wish is not passed on");
        assert_eq!(seen[10].1, [Command::Drive(FORWARD)]);
        let stops: Vec<u64> =
            seen.iter().filter(|(_, c)| c.contains(&Command::Stop)).map(|(ms, _)| *ms).collect();
        assert_eq!(stops, [500]);
        assert!(seen[51].1.len() == 1 && !hand.is_on(), "then the mind has the robot again");
    }

    #[test]
    fn a_hand_that_is_felt_again_holds_on() {
        let mut hand = Hand::default();
        for ms in (0..3000).step_by(10) {
            if ms % 400 == 0 {
                assert_eq!(hand.feel(at(ms), FORWARD), ms == 0);
            }
            let mut commands = Vec::new();
            hand.step(at(ms), &mut commands);
            assert!(!commands.contains(&Command::Stop), "at {ms} ms");
        }
        assert!(hand.is_on());
        hand.let_go();
        let mut commands = vec![Command::Stop];
        hand.step(at(3000), &mut commands);
        assert_eq!(commands, [Command::Stop], "an order took the robot: nothing is added or taken");
    }

    /// Against the thesis's (2.1): v = (v_R + v_L) / 2, ω = (v_R − v_L) / b.
    #[test]
    fn too_much_is_scaled_down_together() {
        let model = pioneer();
        let of = |linear_mps, angular_radps| {
            let w = wheels(&model, BodyVelocity { linear_mps, angular_radps });
            (
                f64::midpoint(w.left_mps, w.right_mps),
                (w.right_mps - w.left_mps) / model.drive.wheelbase_m,
            )
        };
        let near =
            |(v, w): (f64, f64), (a, b): (f64, f64)| (v - a).abs() < 1e-9 && (w - b).abs() < 1e-9;
        assert!(near(of(0.3, -0.5), (0.3, -0.5)));
        assert!(near(of(-1.5, 1.0), (-0.75, 0.5)), "half of both");
        assert!(near(of(0.3, 3.0), (0.15, 1.5)));
        assert!(near(of(f64::NAN, 0.0), (0.0, 0.0)));
    }
}
