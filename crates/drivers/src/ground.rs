//! The two ends of the link between the ground and a vehicle.

use std::time::Duration;

use geometry::{Se2, Transform2};
use navigator::{Command, FailureReason, GroundCommand, Observation, Report, Sensed};
use run_context::Stamp;
use wire::{
    dle::{ByteOrder, Framing, Receiver},
    ground_link::{ToGround, ToVehicle},
};

/// Time between two stops that nobody answered.
const STOP_PERIOD: Duration = Duration::from_millis(250);

/// How the two ends talk.
#[derive(Clone, Debug, PartialEq)]
pub struct GroundLinkConfig {
    /// Order of the bytes of coordinates.
    pub byte_order: ByteOrder,
    /// Whether DLEs in the payload are doubled.
    pub framing: Framing,
    /// Ground only: time after which an unanswered order is sent again.
    pub retry_period: Duration,
    /// Ground only: how often an order is sent at most.
    pub n_tries: u32,
}

impl Default for GroundLinkConfig {
    fn default() -> Self {
        Self {
            byte_order: ByteOrder::BigEndian,
            framing: Framing::Stuffed,
            retry_period: Duration::from_secs(1),
            n_tries: 5,
        }
    }
}

/// The vehicle's end: orders become observations, reports become messages.
///
/// A goal is acknowledged at once by a report of state 1, as in the thesis, so the navigator's own
/// first report of state 1 is not sent again. A goal that comes a second time, because the
/// acknowledgement was lost, is only acknowledged. Stop is acknowledged by a report of state 0.
///
/// Differences: in the thesis nothing answers a stop, so whoever sent it cannot know that it was lost.
#[derive(Clone, Debug)]
pub struct GroundClient {
    config: GroundLinkConfig,
    receiver: Receiver,
    goal: Option<ToVehicle>,
    acknowledged_state: bool,
    n_bad: u64,
}

impl GroundClient {
    /// A vehicle that has no goal.
    pub fn new(config: GroundLinkConfig) -> Self {
        Self {
            config,
            receiver: Receiver::default(),
            goal: None,
            acknowledged_state: false,
            n_bad: 0,
        }
    }

    /// Takes received bytes; acknowledgements are appended to `out`.
    pub fn step(
        &mut self,
        now: Stamp,
        received: &[u8],
        observations: &mut Vec<Observation>,
        out: &mut Vec<u8>,
    ) {
        for &byte in received {
            let Some(payload) = self.receiver.push(byte) else { continue };
            match ToVehicle::decode(payload, self.config.byte_order) {
                Ok(message) => {
                    if let Some(order) = self.take(message, out) {
                        let value = Sensed::Ground(order);
                        observations.push(Observation { about: now, value });
                    }
                }
                Err(_) => self.n_bad += 1,
            }
        }
    }

    /// Sends the message of a [`Command::Report`]; other commands are not for this driver.
    pub fn command(&mut self, _now: Stamp, command: &Command, out: &mut Vec<u8>) {
        let Command::Report(report) = command else { return };
        let message = match *report {
            Report::StateEntered(1) if self.acknowledged_state => {
                self.acknowledged_state = false;
                return;
            }
            Report::StateEntered(state) => ToGround::State(state),
            Report::Arrived => {
                self.goal = None;
                ToGround::Arrived
            }
            Report::Failed(reason) => {
                self.goal = None;
                ToGround::Failed(failure_code(reason))
            }
            // A cast from a float saturates: 655 m and more are sent as 65 535 cm.
            Report::Sonar(ranges_m) => {
                ToGround::Sonar(ranges_m.map(|range_m| (100.0 * range_m).round() as u16))
            }
            Report::LinkEcho => ToGround::LinkTest,
        };
        self.send(message, out);
    }

    /// Frames whose payload made no sense.
    pub fn n_bad(&self) -> u64 {
        self.n_bad
    }

    fn take(&mut self, message: ToVehicle, out: &mut Vec<u8>) -> Option<GroundCommand> {
        match message {
            ToVehicle::GoTo { x_mm, y_mm, heading_deg } => {
                self.send(ToGround::State(1), out);
                if self.goal.replace(message) == Some(message) {
                    return None;
                }
                self.acknowledged_state = true;
                // The navigator ends with some heading in any case; without one it is the map's x
                // axis.
                let heading_rad = f64::from(heading_deg.unwrap_or(0)).to_radians();
                let goal = Se2::new(0.001 * f64::from(x_mm), 0.001 * f64::from(y_mm), heading_rad);
                Some(GroundCommand::GoTo { goal_in_map: Transform2::new(goal) })
            }
            ToVehicle::Stop => {
                self.send(ToGround::State(0), out);
                self.goal = None;
                Some(GroundCommand::Stop)
            }
            ToVehicle::Restart => {
                self.goal = None;
                self.send(ToGround::Restarted, out);
                Some(GroundCommand::Restart)
            }
            ToVehicle::ReportSonar => Some(GroundCommand::ReportSonar),
            ToVehicle::LinkTest => Some(GroundCommand::LinkTest),
        }
    }

    fn send(&self, message: ToGround, out: &mut Vec<u8>) {
        message.encode(self.config.byte_order, self.config.framing, out);
    }
}

/// Something the ground learnt.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GroundStationEvent {
    /// The vehicle said something.
    Heard(ToGround),
    /// An order was sent as often as permitted and never answered; a stop is sent on.
    Unanswered(ToVehicle),
}

/// The ground's end: the decision unit or the operator's station.
///
/// Goals, restarts, sonar requests and link tests are repeated until answered, at most
/// [`GroundLinkConfig::n_tries`] times. Stop is sent twice at once, as in the thesis, and then four
/// times a second until it is answered, however long that takes. A newer order replaces one that is
/// still unanswered.
#[derive(Clone, Debug)]
pub struct GroundStation {
    config: GroundLinkConfig,
    receiver: Receiver,
    unanswered: Option<Unanswered>,
    n_bad: u64,
}

#[derive(Clone, Copy, Debug)]
struct Unanswered {
    order: ToVehicle,
    sent: Stamp,
    n_sent: u32,
}

impl GroundStation {
    /// A station that has said nothing yet.
    pub fn new(config: GroundLinkConfig) -> Self {
        Self { config, receiver: Receiver::default(), unanswered: None, n_bad: 0 }
    }

    /// Sends an order.
    pub fn send(&mut self, now: Stamp, order: ToVehicle, out: &mut Vec<u8>) {
        order.encode(self.config.byte_order, self.config.framing, out);
        self.unanswered = match order {
            ToVehicle::Stop => {
                order.encode(self.config.byte_order, self.config.framing, out);
                Some(Unanswered { order, sent: now, n_sent: 2 })
            }
            _ => Some(Unanswered { order, sent: now, n_sent: 1 }),
        };
    }

    /// Takes received bytes; sends an unanswered order again when it is time.
    pub fn step(
        &mut self,
        now: Stamp,
        received: &[u8],
        events: &mut Vec<GroundStationEvent>,
        out: &mut Vec<u8>,
    ) {
        for &byte in received {
            let Some(payload) = self.receiver.push(byte) else { continue };
            match ToGround::decode(payload, self.config.byte_order) {
                Ok(message) => {
                    self.unanswered = self.unanswered.filter(|u| !answers(message, u.order));
                    events.push(GroundStationEvent::Heard(message));
                }
                Err(_) => self.n_bad += 1,
            }
        }
        let Some(unanswered) = &mut self.unanswered else { return };
        let is_stop = unanswered.order == ToVehicle::Stop;
        let period = if is_stop { STOP_PERIOD } else { self.config.retry_period };
        if now.since(unanswered.sent) < period {
            return;
        }
        if unanswered.n_sent == self.config.n_tries {
            events.push(GroundStationEvent::Unanswered(unanswered.order));
            if !is_stop {
                self.unanswered = None;
                return;
            }
        }
        unanswered.sent = now;
        unanswered.n_sent = unanswered.n_sent.saturating_add(1);
        unanswered.order.encode(self.config.byte_order, self.config.framing, out);
    }

    /// The order that waits for its answer.
    pub fn unanswered(&self) -> Option<ToVehicle> {
        self.unanswered.map(|unanswered| unanswered.order)
    }

    /// Frames whose payload made no sense.
    pub fn n_bad(&self) -> u64 {
        self.n_bad
    }
}

fn answers(message: ToGround, order: ToVehicle) -> bool {
    match order {
        // Any later state, success or failure also proves that the goal came through.
        ToVehicle::GoTo { .. } => {
            matches!(message, ToGround::State(1..) | ToGround::Arrived | ToGround::Failed(_))
        }
        ToVehicle::Restart => message == ToGround::Restarted,
        ToVehicle::ReportSonar => matches!(message, ToGround::Sonar(_)),
        ToVehicle::LinkTest => message == ToGround::LinkTest,
        ToVehicle::Stop => message == ToGround::State(0),
    }
}

/// The number that stands for a reason on the wire: its place among [`FailureReason::ALL`], from 1;
/// 255 for one that has no number yet.
pub fn failure_code(reason: FailureReason) -> u8 {
    let place = FailureReason::ALL.iter().position(|&known| known == reason);
    place.and_then(|index| u8::try_from(index + 1).ok()).unwrap_or(u8::MAX)
}

/// What a number from the wire means, for people.
pub fn failure_text(code: u8) -> &'static str {
    let reason = usize::from(code).checked_sub(1).and_then(|index| FailureReason::ALL.get(index));
    reason.map_or("a reason this station does not know", |reason| reason.as_str())
}
