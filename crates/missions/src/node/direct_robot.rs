//! A robot without bytes: what a firmware and a driver would do together, for swarms of hundreds.
//!
//! The navigator cannot tell the difference, except that nothing is delayed, lost or rounded to
//! millimetres. A line that is cut has the same effects as one with bytes: the robot's watchdog stops it
//! when it hears nothing, and a driver that hears nothing stops the robot first and says so.

use std::time::Duration;

use geometry::wrap_to_pi;
use messages::{
    Battery, Command, Contacts, LinkState, Motors, N_RING_MAX, Observations, OdometryReading, Ring,
    Sensed, age_ms,
};
use robot_models::{BodyVelocity, Odometry, RobotModel, WheelSpeeds};
use run_context::{RandomStream, Stamp, StateHash};
use sensor_models::FiringSchedule;
use simulator::{BodyId, World};

use virtual_robots::MotorReference;

use super::desk::Desk;
use crate::{
    cut::{Cuts, Direction},
    run::line::{Around, Direct},
};

/// Turn rate asked for per angle that is left, 1/s.
const HEADING_GAIN_HZ: f64 = 4.0;
/// A heading this near is reached, rad.
const HEADING_REACHED_RAD: f64 = 0.0044;
/// The watchdog of the robot and of the driver: as a robot with bytes and its driver have them.
const WATCHDOG: Duration = Duration::from_secs(2);
/// Time without a report after which the driver takes the robot for lost.
const SILENCE_MAX: Duration = Duration::from_secs(1);
/// Time without a sign that the robot hears after which the driver takes it for lost.
const DEAFNESS_MAX: Duration = Duration::from_secs(3);
/// Time for which the driver says nothing to a robot that it has lost.
const LOST_FOR: Duration = Duration::from_millis(2500);
/// The battery of a robot without a board never empties, V.
const BATTERY_V: f64 = 12.6;
/// Wheels slower than this stand, m/s.
const STANDING_MPS: f64 = 0.001;

/// One robot on a direct link.
#[derive(Debug)]
pub(super) struct DirectRobot {
    odometry: Odometry,
    schedule: FiringSchedule,
    rng: RandomStream,
    ranges_m: [f64; N_RING_MAX],
    /// Every reading so far, in order.
    heard: StateHash,
    stamps: [Stamp; N_RING_MAX],
    fresh: u16,
    n_sonars: usize,
    last_step: Stamp,
    next_status: Stamp,
    status_period: Duration,
    is_up: bool,
    mode: Mode,
    motors_enabled: bool,
    cuts: Cuts,
    /// Since when commands and reports do not arrive.
    deaf_since: Option<Stamp>,
    unheard_since: Option<Stamp>,
    /// Since when the driver has taken it for lost.
    lost_since: Option<Stamp>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Mode {
    Wheels(WheelSpeeds),
    Heading(f64),
}

impl DirectRobot {
    pub(super) fn new(model: &RobotModel, range_max_m: f64, rng: RandomStream) -> Self {
        let n_sonars = model.sonars.len().min(N_RING_MAX);
        let sensors: Vec<usize> = (0..n_sonars).collect();
        let chains = sensors.chunks(model.ring.chain_len.max(1)).map(<[usize]>::to_vec).collect();
        Self {
            odometry: Odometry::new(model.drive),
            schedule: FiringSchedule::new(chains, model.ring.ping_period),
            rng,
            ranges_m: [range_max_m; N_RING_MAX],
            heard: StateHash::new(),
            stamps: [Stamp::ZERO; N_RING_MAX],
            fresh: 0,
            n_sonars,
            last_step: Stamp::ZERO,
            next_status: Stamp::ZERO,
            status_period: model.status_period,
            is_up: false,
            mode: Mode::Wheels(WheelSpeeds::ZERO),
            motors_enabled: false,
            cuts: Cuts::default(),
            deaf_since: None,
            unheard_since: None,
            lost_since: None,
        }
    }

    /// What a cut line brings about on its two sides.
    fn watch(&mut self, now: Stamp, observations: &mut Observations) {
        let since = |was: Option<Stamp>, cut: bool| cut.then(|| was.unwrap_or(now));
        self.deaf_since = since(self.deaf_since, self.cuts.away);
        self.unheard_since = since(self.unheard_since, self.cuts.back);
        let over = |was: Option<Stamp>, limit| was.is_some_and(|was| now.since(was) >= limit);
        if over(self.deaf_since, WATCHDOG) {
            self.mode = Mode::Wheels(WheelSpeeds::ZERO);
        }
        let lost = over(self.deaf_since, DEAFNESS_MAX) || over(self.unheard_since, SILENCE_MAX);
        if lost && self.lost_since.is_none() {
            self.lost_since = Some(now);
            if !self.cuts.away {
                self.mode = Mode::Wheels(WheelSpeeds::ZERO);
            }
            observations.push(now, Sensed::Link(LinkState::Down));
        } else if !self.cuts.any() && over(self.lost_since, LOST_FOR) {
            self.lost_since = None;
            self.is_up = false;
        }
    }

    /// Fires sonars, counts ticks and reports when it is time.
    fn sense(
        &mut self,
        now: Stamp,
        world: &World,
        body_id: BodyId,
        observations: &mut Observations,
    ) {
        let body = world.body(body_id);
        self.odometry.update(body.encoder_ticks[0], body.encoder_ticks[1]);
        for firing in self.schedule.due(self.last_step, now) {
            let i = firing.sensor_index;
            self.ranges_m[i] = world.ping(body_id, i, &mut self.rng).range_m;
            self.heard.absorb(self.ranges_m[i]);
            // It meets the world as it is now, up to a step after it was due.
            self.stamps[i] = now;
            self.fresh |= 1 << i;
        }
        self.last_step = now;
        self.watch(now, observations);
        if self.cuts.back || self.lost_since.is_some() {
            return;
        }
        if !self.is_up {
            self.is_up = true;
            observations.push(now, Sensed::Link(LinkState::Up));
        }
        if now >= self.next_status {
            self.next_status = now + self.status_period;
            let speeds = body.wheel_speeds;
            let moving =
                speeds.left_mps.abs() > STANDING_MPS || speeds.right_mps.abs() > STANDING_MPS;
            let enabled = self.motors_enabled;
            observations.push(now, Sensed::Motors(Motors { enabled }));
            observations.push(now, Sensed::Battery(Battery { voltage_v: BATTERY_V }));
            let contacts = Contacts { stalled: body.stalled, ..Contacts::default() };
            observations.push(now, Sensed::Contact(contacts));
            let odom_from_base = self.odometry.odom_from_base();
            let odometry = OdometryReading { odom_from_base, wheel_speeds: speeds, moving };
            observations.push(now, Sensed::Odometry(odometry));
            if self.n_sonars > 0 {
                let ring = Ring {
                    ranges_m: self.ranges_m,
                    ages_ms: self.stamps.map(|measured| age_ms(measured, now)),
                    n_sensors: self.n_sonars,
                    fresh: std::mem::take(&mut self.fresh),
                };
                observations.push(now, Sensed::Ring(ring));
            }
        }
    }

    /// What the wheels should do.
    fn wheels(&self, model: &RobotModel) -> WheelSpeeds {
        if !self.motors_enabled {
            return WheelSpeeds::ZERO;
        }
        match self.mode {
            Mode::Wheels(wheels) => wheels,
            Mode::Heading(heading) => {
                let left = wrap_to_pi(heading - self.odometry.odom_from_base().se2().yaw_rad);
                if left.abs() < HEADING_REACHED_RAD {
                    return WheelSpeeds::ZERO;
                }
                // Never faster than can still be braked: ω ≤ √(2 α φ).
                let limits = &model.limits;
                let braking = (2.0 * limits.turn_acceleration_max_radps2 * left.abs()).sqrt();
                let rate = (HEADING_GAIN_HZ * left.abs())
                    .min(braking)
                    .min(limits.turn_rate_max_radps)
                    .copysign(left);
                model.drive.wheel_speeds(BodyVelocity { linear_mps: 0.0, angular_radps: rate })
            }
        }
    }
}

impl Direct for DirectRobot {
    fn step(&mut self, around: &mut Around<'_>, observations: &mut Observations) {
        if let Some(body) = around.body {
            self.sense(around.now, around.world, body, observations);
        }
    }

    fn command(&mut self, command: &Command, _desk: &mut Desk) {
        if self.cuts.away || self.lost_since.is_some() {
            return;
        }
        match command {
            Command::Drive(wheels) => self.mode = Mode::Wheels(*wheels),
            Command::TurnTo { heading_in_odom_rad } => {
                self.mode = Mode::Heading(*heading_in_odom_rad);
            }
            Command::Stop => self.mode = Mode::Wheels(WheelSpeeds::ZERO),
            Command::EnableMotors(on) => self.motors_enabled = *on,
            Command::QueryPheromones { .. } | Command::Report(_) => {}
        }
    }

    fn set_cut(&mut self, direction: Direction, cut: bool) {
        self.cuts.set(direction, cut);
    }

    /// Whether the driver has the robot.
    fn is_connected(&self) -> bool {
        self.is_up && self.lost_since.is_none()
    }

    fn reference(&self, model: &RobotModel) -> Option<MotorReference> {
        let acceleration_mps2 = model.limits.acceleration_max_mps2;
        Some(MotorReference { wheels: self.wheels(model), acceleration_mps2 })
    }

    fn absorb_state(&self, hash: &mut StateHash) {
        let pose = self.odometry.odom_from_base().se2();
        for value in [pose.x_m, pose.y_m, pose.yaw_rad] {
            hash.absorb(value);
        }
        hash.absorb_u64(self.heard.value());
    }
}
