//! The two ends of the link between the ground and a vehicle.

use std::time::Duration;

use geometry::{Se2, Transform2};
use messages::{Command, FailureReason, Observations, Order, Report, Sensed};
use run_context::Stamp;
use wire::{
    dle::{ByteOrder, Framing, Receiver},
    ground_link::{ToGround, ToVehicle},
};

use crate::Driver;

/// Time between two stops that nobody answered.
const STOP_PERIOD: Duration = Duration::from_millis(250);

/// How the two ends talk.
#[derive(Clone, Debug, PartialEq)]
pub struct GroundLinkConfig {
    /// Order of the bytes of coordinates.
    pub byte_order: ByteOrder,
    /// Whether DLEs in the payload are doubled.
    pub framing: Framing,
    /// Ground only: time after which an unanswered order is sent again, and from one question after
    /// a goal to the next.
    pub retry_period: Duration,
    /// Ground only: how often an order or a question is sent at most; the vehicle counts as silent
    /// when so many were not answered.
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
/// A goal is acknowledged at once, and its end is reported with its number. A goal that comes a
/// second time, because the answer was lost, is only answered again: by what became of it, if it has
/// ended since. A target of the thesis, which has no number, is acknowledged by a report of state 1
/// as there, so the navigator's own first report of state 1 is not sent again.
#[derive(Clone, Debug)]
pub struct GroundClient {
    config: GroundLinkConfig,
    receiver: Receiver,
    /// The goal or target that the navigator drives to.
    goal: Option<ToVehicle>,
    /// The last numbered goal that has ended, and how.
    ended: Option<(ToVehicle, ToGround)>,
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
            ended: None,
            acknowledged_state: false,
            n_bad: 0,
        }
    }

    /// Takes received bytes; acknowledgements are appended to `out`.
    pub fn step(
        &mut self,
        now: Stamp,
        received: &[u8],
        observations: &mut Observations,
        out: &mut Vec<u8>,
    ) {
        for &byte in received {
            let Some(payload) = self.receiver.push(byte) else { continue };
            match ToVehicle::decode(payload, self.config.byte_order) {
                Ok(message) => {
                    if let Some(order) = self.take(message, out) {
                        let value = Sensed::Order(order);
                        observations.push(now, value);
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
            Report::Arrived => self.end(|number| ToGround::Arrived { number }),
            Report::Failed(reason) => {
                let reason = failure_code(reason);
                self.end(|number| ToGround::Failed { number, reason })
            }
            Report::Sonar(ranges_m) => sonar_report(&ranges_m),
            Report::LinkEcho => ToGround::LinkTest,
        };
        self.send(message, out);
    }

    /// Frames whose payload made no sense.
    pub fn n_bad(&self) -> u64 {
        self.n_bad
    }

    /// The present goal has ended: what is said of it now, and whenever it is asked for again.
    fn end(&mut self, report: impl FnOnce(u8) -> ToGround) -> ToGround {
        match self.goal.take() {
            Some(goal @ ToVehicle::GoTo { number, .. }) => {
                let message = report(number);
                self.ended = Some((goal, message));
                message
            }
            _ => report(0),
        }
    }

    fn take(&mut self, message: ToVehicle, out: &mut Vec<u8>) -> Option<Order> {
        match message {
            ToVehicle::GoTo { number, x_mm, y_mm, heading_deg } => {
                if let Some((_, outcome)) = self.ended.filter(|(goal, _)| *goal == message) {
                    self.send(outcome, out);
                    return None;
                }
                self.send(ToGround::UnderWay { number }, out);
                self.begin(message, [x_mm, y_mm, heading_deg])
            }
            ToVehicle::Target { x_mm, y_mm } => {
                self.send(ToGround::State(1), out);
                // The navigator ends with some heading in any case; without one it is the map's x
                // axis.
                let order = self.begin(message, [x_mm, y_mm, 0]);
                self.acknowledged_state |= order.is_some();
                order
            }
            ToVehicle::Ask { number } => {
                self.send(self.became(number), out);
                None
            }
            ToVehicle::Stop => {
                self.send(ToGround::State(0), out);
                self.forget();
                Some(Order::Stop)
            }
            ToVehicle::Restart => {
                self.forget();
                self.send(ToGround::Restarted, out);
                Some(Order::Restart)
            }
            ToVehicle::ReportSonar => Some(Order::ReportSonar),
            ToVehicle::LinkTest => Some(Order::LinkTest),
        }
    }

    /// A goal in millimetres and degrees, unless it is the present one.
    fn begin(&mut self, message: ToVehicle, goal: [i16; 3]) -> Option<Order> {
        if self.goal.replace(message) == Some(message) {
            return None;
        }
        self.ended = None;
        self.acknowledged_state = false;
        let [x_mm, y_mm, heading_deg] = goal.map(f64::from);
        let goal = Se2::new(0.001 * x_mm, 0.001 * y_mm, heading_deg.to_radians());
        Some(Order::GoTo { goal_in_map: Transform2::new(goal) })
    }

    /// What became of a goal.
    fn became(&self, asked: u8) -> ToGround {
        let is_asked =
            |goal: ToVehicle| matches!(goal, ToVehicle::GoTo { number, .. } if number == asked);
        match (self.goal, self.ended) {
            (Some(goal), _) if is_asked(goal) => ToGround::UnderWay { number: asked },
            (_, Some((goal, outcome))) if is_asked(goal) => outcome,
            _ => ToGround::Unknown { number: asked },
        }
    }

    fn forget(&mut self) {
        (self.goal, self.ended, self.acknowledged_state) = (None, None, false);
    }

    fn send(&self, message: ToGround, out: &mut Vec<u8>) {
        message.encode(self.config.byte_order, self.config.framing, out);
    }
}

impl Driver for GroundClient {
    fn step(
        &mut self,
        now: Stamp,
        received: &[u8],
        observations: &mut Observations,
        out: &mut Vec<u8>,
    ) {
        Self::step(self, now, received, observations, out);
    }

    fn command(&mut self, now: Stamp, command: &Command, out: &mut Vec<u8>) {
        Self::command(self, now, command, out);
    }
}

/// The report of the front sonars, whole centimetres: 655 m and more are sent as 65 535 cm.
pub fn sonar_report(ranges_m: &[f64; 8]) -> ToGround {
    // A cast from a float saturates.
    ToGround::Sonar(ranges_m.map(|range_m| (100.0 * range_m).round() as u16))
}

/// Something the ground learnt.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GroundStationEvent {
    /// The vehicle said something.
    Heard(ToGround),
    /// News of the last goal; never of one before it, nor twice the same.
    Goal {
        /// Which goal.
        number: u8,
        /// What became of it.
        news: GoalNews,
    },
    /// An order without a goal was sent as often as permitted and never answered; a stop is sent on.
    Unanswered(ToVehicle),
}

/// What became of a goal. After all but the first, nothing more is said of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GoalNews {
    /// The vehicle has it.
    UnderWay,
    /// The vehicle stands there.
    Arrived,
    /// The vehicle has given it up, for a reason ([`failure_text`]).
    Failed(u8),
    /// The vehicle had it and does not know it any more: it was switched off and on, stopped or
    /// sent elsewhere by others.
    Forgotten,
    /// The vehicle has been silent for too long. It is told to stop, until it answers that.
    Silent,
}

/// The ground's end: the decision unit or the operator's station.
///
/// A goal is repeated until it is answered, and then asked for once in every
/// [`retry_period`](GroundLinkConfig::retry_period), so that a report that was lost is only late, a vehicle that
/// has forgotten its goal is found out, and a silent one is given up. Reports about other goals than
/// the last are not believed. Restarts, sonar requests and link tests are repeated until answered, at
/// most [`GroundLinkConfig::n_tries`] times. Stop is sent twice at once, as in the thesis, and then four
/// times a second until it is answered, however long that takes; only a goal, a target or a restart ends
/// it before. A newer order replaces one that is still unanswered, and a newer question (sonar, link
/// test) the question before, but no question replaces an order.
#[derive(Clone, Debug)]
pub struct GroundStation {
    config: GroundLinkConfig,
    receiver: Receiver,
    last_number: u8,
    goal: Option<OpenGoal>,
    /// A stop, restart or target that waits for its answer.
    order: Option<Unanswered>,
    /// A sonar request or link test that does.
    question: Option<Unanswered>,
    n_bad: u64,
}

/// The last goal, until its end is known.
#[derive(Clone, Copy, Debug)]
struct OpenGoal {
    number: u8,
    order: ToVehicle,
    is_acknowledged: bool,
    /// When the vehicle was last spoken to about it.
    sent: Stamp,
    /// How often since it last answered.
    n_sent: u32,
}

#[derive(Clone, Copy, Debug)]
struct Unanswered {
    order: ToVehicle,
    sent: Stamp,
    n_sent: u32,
}

impl Unanswered {
    /// Says it again when it is time; `None` when it is given up, which a stop never is.
    fn repeated(
        mut self,
        now: Stamp,
        config: &GroundLinkConfig,
        events: &mut Vec<GroundStationEvent>,
        out: &mut Vec<u8>,
    ) -> Option<Self> {
        let is_stop = self.order == ToVehicle::Stop;
        let period = if is_stop { STOP_PERIOD } else { config.retry_period };
        if now.since(self.sent) < period {
            return Some(self);
        }
        if self.n_sent == config.n_tries {
            events.push(GroundStationEvent::Unanswered(self.order));
            if !is_stop {
                return None;
            }
        }
        (self.sent, self.n_sent) = (now, self.n_sent.saturating_add(1));
        self.order.encode(config.byte_order, config.framing, out);
        Some(self)
    }
}

impl GroundStation {
    /// A station that has said nothing yet. Its first goal has number 1.
    pub fn new(config: GroundLinkConfig) -> Self {
        Self::going_on_after(0, config)
    }

    /// A station that is switched on again: its first goal has the number after `last_number`, so that
    /// a vehicle that was not switched off does not take it for one that it has had.
    pub fn going_on_after(last_number: u8, config: GroundLinkConfig) -> Self {
        let receiver = Receiver::default();
        Self { config, receiver, last_number, goal: None, order: None, question: None, n_bad: 0 }
    }

    /// Sends a goal, in millimetres and degrees of the map, and gives its number. It replaces the goal
    /// before, of which nothing more is heard.
    pub fn go_to(
        &mut self,
        now: Stamp,
        [x_mm, y_mm, heading_deg]: [i16; 3],
        out: &mut Vec<u8>,
    ) -> u8 {
        // 1 to 255, round and round.
        let number = self.last_number % u8::MAX + 1;
        self.last_number = number;
        let order = ToVehicle::GoTo { number, x_mm, y_mm, heading_deg };
        self.say(order, out);
        self.order = None;
        self.goal = Some(OpenGoal { number, order, is_acknowledged: false, sent: now, n_sent: 1 });
        number
    }

    /// Sends an order as it is. Goals go by [`GroundStation::go_to`], which numbers and watches them.
    pub fn send(&mut self, now: Stamp, order: ToVehicle, out: &mut Vec<u8>) {
        self.say(order, out);
        let unanswered = Unanswered { order, sent: now, n_sent: 1 };
        match order {
            ToVehicle::GoTo { .. } | ToVehicle::Ask { .. } => {}
            ToVehicle::Stop => {
                self.say(order, out);
                self.goal = None;
                self.order = Some(Unanswered { n_sent: 2, ..unanswered });
            }
            ToVehicle::Restart | ToVehicle::Target { .. } => {
                self.goal = None;
                self.order = Some(unanswered);
            }
            ToVehicle::ReportSonar | ToVehicle::LinkTest => self.question = Some(unanswered),
        }
    }

    /// Takes received bytes; repeats what is unanswered when it is time.
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
                    for waiting in [&mut self.order, &mut self.question] {
                        *waiting = waiting.filter(|u| !answers(message, u.order));
                    }
                    events.push(GroundStationEvent::Heard(message));
                    self.hear_of_goal(message, events);
                }
                Err(_) => self.n_bad += 1,
            }
        }
        self.watch_goal(now, events, out);
        for waiting in [&mut self.order, &mut self.question] {
            *waiting = waiting.and_then(|u| u.repeated(now, &self.config, events, out));
        }
    }

    /// Takes what a message says about the last goal.
    fn hear_of_goal(&mut self, message: ToGround, events: &mut Vec<GroundStationEvent>) {
        let Some(goal) = &mut self.goal else { return };
        let (number, news) = match message {
            ToGround::UnderWay { number } => (number, GoalNews::UnderWay),
            ToGround::Arrived { number } => (number, GoalNews::Arrived),
            ToGround::Failed { number, reason } => (number, GoalNews::Failed(reason)),
            // A goal that is on its way to the vehicle is not known there yet.
            ToGround::Unknown { number } if goal.is_acknowledged => (number, GoalNews::Forgotten),
            _ => return,
        };
        if number != goal.number {
            return;
        }
        goal.n_sent = 0;
        let is_known = std::mem::replace(&mut goal.is_acknowledged, true);
        if news != GoalNews::UnderWay {
            self.goal = None;
        } else if is_known {
            return;
        }
        events.push(GroundStationEvent::Goal { number, news });
    }

    fn watch_goal(&mut self, now: Stamp, events: &mut Vec<GroundStationEvent>, out: &mut Vec<u8>) {
        let Some(mut goal) = self.goal else { return };
        if now.since(goal.sent) < self.config.retry_period {
            return;
        }
        if goal.n_sent >= self.config.n_tries {
            let news = GoalNews::Silent;
            events.push(GroundStationEvent::Goal { number: goal.number, news });
            // It may hear without being heard, and should not drive on to where nobody waits for it.
            self.send(now, ToVehicle::Stop, out);
            return;
        }
        let ask = ToVehicle::Ask { number: goal.number };
        self.say(if goal.is_acknowledged { ask } else { goal.order }, out);
        (goal.sent, goal.n_sent) = (now, goal.n_sent + 1);
        self.goal = Some(goal);
    }

    /// Number of the goal whose end is not known yet.
    pub fn open_goal(&self) -> Option<u8> {
        self.goal.map(|goal| goal.number)
    }

    /// The order without a goal that waits for its answer; when there is none, the question that does.
    pub fn unanswered(&self) -> Option<ToVehicle> {
        self.order.or(self.question).map(|unanswered| unanswered.order)
    }

    /// Frames whose payload made no sense.
    pub fn n_bad(&self) -> u64 {
        self.n_bad
    }

    fn say(&self, order: ToVehicle, out: &mut Vec<u8>) {
        order.encode(self.config.byte_order, self.config.framing, out);
    }
}

fn answers(message: ToGround, order: ToVehicle) -> bool {
    match order {
        // Any later state, success or failure also proves that the target came through.
        ToVehicle::Target { .. } => matches!(
            message,
            ToGround::State(1..)
                | ToGround::Arrived { number: 0 }
                | ToGround::Failed { number: 0, .. }
        ),
        ToVehicle::Restart => message == ToGround::Restarted,
        ToVehicle::ReportSonar => matches!(message, ToGround::Sonar(_)),
        ToVehicle::LinkTest => message == ToGround::LinkTest,
        ToVehicle::Stop => message == ToGround::State(0),
        ToVehicle::GoTo { .. } | ToVehicle::Ask { .. } => false,
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
