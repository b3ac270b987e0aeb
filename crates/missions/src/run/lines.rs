//! The three lines of a robot's navigation node: to its robot, to the pheromone server, to the ground.
//!
//! Each is bytes over a link, with the other node behind it, or direct: the same messages handed over
//! at once. End A of a link is the navigation node.

use geometry::{Se2, Transform2};
use messages::{Command, Observations, Order, Report, Sensed, Smell};
use pheromones::{Field, SenseConfig, Server, ServerConfig, ServerCounters};
use robot_models::WheelSpeeds;
use run_context::{Stamp, StateHash};
use simulator::{BodyId, World};
use virtual_robots::{Board, MotorReference, Port};
use wire::{
    ground_link::{ToGround, ToVehicle},
    link::{End, Link},
};

use super::{direct::DirectRobot, direct_ground::DirectGround, tap::Tap};
use crate::{
    asked::Asked,
    cut::{Cuts, Direction},
    transport::{Transport, TransportError},
};
use drivers::{
    Driver, GoalNews, GroundClient, GroundStation, GroundStationEvent, PheromoneClient,
    failure_text, sonar_report,
};

/// Packets read along on a line, waiting to be fetched: receiving node, bytes, text.
pub(super) type Packets = Vec<(&'static str, Vec<u8>, String)>;

/// Working memory of a node, kept between steps so that none is allocated.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    /// What reached the navigation node in this step.
    pub(super) observations: Observations,
    received: Vec<u8>,
    out: Vec<u8>,
    /// What the ground learnt in this step.
    pub(super) events: Vec<GroundStationEvent>,
}

/// Bytes between the navigation node and a robot's board.
pub(super) struct WiredRobot {
    pub(super) link: Link,
    pub(super) board: Box<dyn Board>,
    pub(super) driver: Box<dyn Driver>,
    pub(super) reference: MotorReference,
}

/// A robot elsewhere.
///
/// When it is dropped, whatever the reason, the robot is told to stop and the session is closed.
pub(super) struct RemoteRobot {
    transport: Box<dyn Transport>,
    driver: Box<dyn Driver>,
    cuts: Cuts,
    /// When bytes were exchanged last.
    now: Stamp,
    /// Why its line is of no use any more; taken once it has been told.
    broken: Option<TransportError>,
    is_broken: bool,
}

impl RemoteRobot {
    pub(super) fn new(transport: Box<dyn Transport>, driver: Box<dyn Driver>) -> Self {
        let (cuts, now) = (Cuts::default(), Stamp::ZERO);
        Self { transport, driver, cuts, now, broken: None, is_broken: false }
    }

    fn send(&mut self, now: Stamp, bytes: &[u8]) {
        self.now = now;
        if !self.cuts.away {
            let sent = self.transport.send(now, bytes);
            self.note(sent);
        }
    }

    fn receive(&mut self, now: Stamp, into: &mut Vec<u8>) {
        let heard = into.len();
        let received = self.transport.receive(now, into);
        self.note(received);
        if self.cuts.back {
            into.truncate(heard);
        }
    }

    fn note(&mut self, done: Result<(), TransportError>) {
        if let Err(error) = done
            && !std::mem::replace(&mut self.is_broken, true)
        {
            self.broken = Some(error);
        }
    }
}

impl Drop for RemoteRobot {
    fn drop(&mut self) {
        let mut out = Vec::new();
        self.driver.disconnect(self.now, &mut out);
        // If the line is broken, the robot's own watchdog has to stop it.
        let _unheard = self.transport.send(self.now, &out);
    }
}

/// The line to the robot.
pub(super) enum RobotLine {
    Wired(Box<WiredRobot>),
    Direct(Box<DirectRobot>),
    Remote(Box<RemoteRobot>),
}

impl std::fmt::Debug for RobotLine {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Wired(_) => "Wired",
            Self::Direct(_) => "Direct",
            Self::Remote(_) => "Remote",
        })
    }
}

impl RobotLine {
    /// The robot's own node first, then what reaches the navigation node.
    pub(super) fn observe(
        &mut self,
        now: Stamp,
        world: &World,
        body: Option<BodyId>,
        scratch: &mut Scratch,
        trace: Option<(&mut Tap, &mut Packets)>,
    ) {
        scratch.received.clear();
        scratch.out.clear();
        match self {
            Self::Direct(robot) => {
                if let Some(body) = body {
                    robot.sense(now, world, body, &mut scratch.observations);
                }
            }
            Self::Wired(robot) => {
                let Some(body) = body else { return };
                let WiredRobot { link, board, driver, reference } = &mut **robot;
                link.receive(End::B, now, &mut scratch.received);
                let port = Port { received: &scratch.received, out: &mut scratch.out };
                if let Some(wanted) = board.step(now, world, body, &mut [port]) {
                    *reference = wanted;
                }
                link.send(End::B, now, &scratch.out);
                let arrived_at_robot = scratch.received.len();
                scratch.out.clear();
                link.receive(End::A, now, &mut scratch.received);
                let (to_robot, to_navigation) = scratch.received.split_at(arrived_at_robot);
                driver.step(now, to_navigation, &mut scratch.observations, &mut scratch.out);
                link.send(End::A, now, &scratch.out);
                read_along(trace, to_robot, to_navigation);
            }
            Self::Remote(robot) => {
                robot.receive(now, &mut scratch.received);
                let (observations, out) = (&mut scratch.observations, &mut scratch.out);
                robot.driver.step(now, &scratch.received, observations, out);
                robot.send(now, &scratch.out);
                read_along(trace, &scratch.out, &scratch.received);
            }
        }
    }

    /// Sends a command of the navigator to the robot.
    pub(super) fn command(&mut self, now: Stamp, command: &Command, scratch: &mut Scratch) {
        scratch.out.clear();
        match self {
            Self::Direct(robot) => robot.obey(command),
            Self::Wired(robot) => {
                robot.driver.command(now, command, &mut scratch.out);
                robot.link.send(End::A, now, &scratch.out);
            }
            Self::Remote(robot) => {
                robot.driver.command(now, command, &mut scratch.out);
                robot.send(now, &scratch.out);
            }
        }
    }

    /// Tells a robot elsewhere to stand. Its driver will not know: to it no time passes.
    pub(super) fn hold(&mut self) {
        if let Self::Remote(robot) = self {
            let mut out = Vec::new();
            robot.driver.hold(&mut out);
            robot.send(robot.now, &out);
        }
    }

    /// Cuts or mends it; away is towards the robot.
    pub(super) fn set_cut(&mut self, direction: Direction, cut: bool) {
        match self {
            Self::Wired(robot) => cut_link(&mut robot.link, direction, cut),
            Self::Direct(robot) => robot.set_cut(direction, cut),
            Self::Remote(robot) => robot.cuts.set(direction, cut),
        }
    }

    /// Why the line to a robot elsewhere is of no use any more, once.
    pub(super) fn take_break(&mut self) -> Option<TransportError> {
        match self {
            Self::Remote(robot) => robot.broken.take(),
            Self::Wired(_) | Self::Direct(_) => None,
        }
    }

    /// Whether the navigation node hears from its robot.
    pub(super) fn is_connected(&self) -> bool {
        match self {
            Self::Wired(robot) => robot.driver.is_connected(),
            Self::Direct(robot) => robot.is_connected(),
            Self::Remote(robot) => robot.driver.is_connected() && !robot.is_broken,
        }
    }

    /// What the wheels of the simulated body should do: speeds and acceleration.
    pub(super) fn reference(&self, world: &World, body: BodyId) -> (WheelSpeeds, f64) {
        let model = &world.body(body).model;
        match self {
            Self::Wired(robot) => (robot.reference.wheels, robot.reference.acceleration_mps2),
            Self::Direct(robot) => (robot.reference(model), model.limits.acceleration_max_mps2),
            Self::Remote(_) => (WheelSpeeds::ZERO, model.limits.acceleration_max_mps2),
        }
    }

    pub(super) fn absorb_state(&self, hash: &mut StateHash) {
        match self {
            Self::Wired(robot) => robot.board.absorb_state(hash),
            Self::Direct(robot) => robot.absorb_state(hash),
            Self::Remote(_) => {}
        }
    }
}

/// Cuts or mends a link whose end A is the navigation node.
fn cut_link(link: &mut Link, direction: Direction, cut: bool) {
    let [away, back] = direction.ways();
    if away {
        link.set_cut(End::A, cut);
    }
    if back {
        link.set_cut(End::B, cut);
    }
}

fn read_along(trace: Option<(&mut Tap, &mut Packets)>, outward: &[u8], inward: &[u8]) {
    if let Some((tap, packets)) = trace {
        tap.outward(outward, &mut |to, bytes, text| packets.push((to, bytes, text)));
        tap.inward(inward, &mut |to, bytes, text| packets.push((to, bytes, text)));
    }
}

/// Bytes between the navigation node and the pheromone server.
#[derive(Debug)]
pub(super) struct WiredServer {
    link: Link,
    server: Server,
    client: PheromoneClient,
}

/// The line to the pheromone server.
#[derive(Debug)]
pub(super) enum ServerLine {
    /// There is no server.
    Nothing,
    /// Bytes; the server keeps one receiver per radio channel.
    Wired(Box<WiredServer>),
    /// Answers at the next step.
    Direct { sense: SenseConfig, asked: Option<(u8, Se2)>, cuts: Cuts },
}

impl ServerLine {
    pub(super) fn wired(link: Link, config: ServerConfig, client: PheromoneClient) -> Self {
        let server = Server::new(config);
        Self::Wired(Box::new(WiredServer { link, server, client }))
    }

    /// The server's node first, then what reaches the navigation node.
    pub(super) fn observe(
        &mut self,
        now: Stamp,
        field: Option<&Field>,
        scratch: &mut Scratch,
        trace: Option<(&mut Tap, &mut Packets)>,
    ) {
        let Some(field) = field else { return };
        match self {
            Self::Nothing => {}
            Self::Direct { sense, asked, cuts } => {
                if let Some((query, pose)) = asked.take()
                    && !cuts.any()
                {
                    let found = field.sense(pose, sense);
                    let (left, right) = (found.left, found.right);
                    let value = Sensed::Smell(Smell { query, left, right });
                    scratch.observations.push(now, value);
                }
            }
            Self::Wired(wired) => {
                let WiredServer { link, server, client } = &mut **wired;
                scratch.received.clear();
                scratch.out.clear();
                link.receive(End::B, now, &mut scratch.received);
                server.receive(field, &scratch.received, &mut scratch.out);
                link.send(End::B, now, &scratch.out);
                let arrived_at_server = scratch.received.len();
                scratch.out.clear();
                link.receive(End::A, now, &mut scratch.received);
                let (to_server, to_navigation) = scratch.received.split_at(arrived_at_server);
                client.step(now, to_navigation, &mut scratch.observations, &mut scratch.out);
                link.send(End::A, now, &scratch.out);
                read_along(trace, to_server, to_navigation);
            }
        }
    }

    /// Sends a question of the navigator.
    pub(super) fn command(&mut self, now: Stamp, command: &Command, scratch: &mut Scratch) {
        match self {
            Self::Nothing => {}
            Self::Direct { asked, .. } => {
                if let Command::QueryPheromones { query, map_from_base } = *command {
                    *asked = Some((query, map_from_base.se2()));
                }
            }
            Self::Wired(wired) => {
                scratch.out.clear();
                wired.client.command(now, command, &mut scratch.out);
                wired.link.send(End::A, now, &scratch.out);
            }
        }
    }

    /// Cuts or mends it; away is towards the server.
    pub(super) fn set_cut(&mut self, direction: Direction, cut: bool) {
        match self {
            Self::Nothing => {}
            Self::Wired(wired) => cut_link(&mut wired.link, direction, cut),
            Self::Direct { cuts, .. } => cuts.set(direction, cut),
        }
    }

    pub(super) fn link(&self) -> Option<&Link> {
        match self {
            Self::Wired(wired) => Some(&wired.link),
            Self::Nothing | Self::Direct { .. } => None,
        }
    }

    /// What the server counted, where there is a link to it.
    pub(super) fn traffic(&self) -> Option<ServerCounters> {
        match self {
            Self::Wired(wired) => Some(wired.server.counters()),
            Self::Nothing | Self::Direct { .. } => None,
        }
    }
}

/// An order from the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum GroundOrder {
    GoTo(Se2),
    Stop,
    /// To forget its goal and connect to the robot anew.
    Restart,
}

/// What leaves the ground in a step.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct FromGround {
    pub(super) order: Option<GroundOrder>,
    pub(super) question: Option<Asked>,
}

/// Bytes between the navigation node and the ground.
#[derive(Debug)]
pub(super) struct WiredGround {
    pub(super) link: Link,
    pub(super) station: GroundStation,
    pub(super) client: GroundClient,
}

/// The line to the ground: decision node or ground station.
#[derive(Debug)]
pub(super) enum GroundLine {
    Wired(Box<WiredGround>),
    Direct(DirectGround),
}

/// What the ground knows of the last goal that it sent a robot to, from the robot's reports.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Telemetry {
    /// There is none: nothing was sent yet, or the last order was to stop.
    #[default]
    NoGoal,
    /// No report of its end has come.
    UnderWay,
    /// The robot stands there.
    Arrived,
    /// It will not come there; why, in the words of the ground's table.
    Failed(&'static str),
}

impl GroundLine {
    /// The ground's node first, then what reaches the navigation node.
    pub(super) fn observe(
        &mut self,
        now: Stamp,
        FromGround { order, question }: FromGround,
        telemetry: &mut Telemetry,
        scratch: &mut Scratch,
        trace: Option<(&mut Tap, &mut Packets)>,
    ) {
        scratch.events.clear();
        match self {
            Self::Direct(ground) => {
                if let Some(value) = question.and_then(|asked| ground.pass(asked)) {
                    scratch.observations.push(now, value);
                }
                if let Some(order) = ground.step(now, order, telemetry) {
                    let value = Sensed::Order(match order {
                        GroundOrder::GoTo(pose) => {
                            Order::GoTo { goal_in_map: Transform2::new(pose) }
                        }
                        GroundOrder::Stop => Order::Stop,
                        GroundOrder::Restart => {
                            scratch.events.extend(ground.heard(ToGround::Restarted));
                            Order::Restart
                        }
                    });
                    scratch.observations.push(now, value);
                }
            }
            Self::Wired(wired) => {
                let WiredGround { link, station, client } = &mut **wired;
                scratch.received.clear();
                scratch.out.clear();
                match order {
                    Some(GroundOrder::GoTo(pose)) => {
                        station.go_to(now, on_the_wire(pose), &mut scratch.out);
                    }
                    Some(GroundOrder::Stop) => {
                        station.send(now, ToVehicle::Stop, &mut scratch.out);
                    }
                    Some(GroundOrder::Restart) => {
                        station.send(now, ToVehicle::Restart, &mut scratch.out);
                    }
                    None => {}
                }
                if let Some(asked) = question {
                    station.send(now, asked.message(), &mut scratch.out);
                }
                link.receive(End::B, now, &mut scratch.received);
                station.step(now, &scratch.received, &mut scratch.events, &mut scratch.out);
                link.send(End::B, now, &scratch.out);
                let arrived_at_ground = scratch.received.len();
                scratch.out.clear();
                link.receive(End::A, now, &mut scratch.received);
                let (to_ground, to_vehicle) = scratch.received.split_at(arrived_at_ground);
                client.step(now, to_vehicle, &mut scratch.observations, &mut scratch.out);
                link.send(End::A, now, &scratch.out);
                read_along(trace, to_ground, to_vehicle);
                scratch.events.iter().for_each(|event| telemetry.hear(*event));
            }
        }
    }

    /// Sends a report of the navigator to the ground.
    pub(super) fn command(
        &mut self,
        now: Stamp,
        command: &Command,
        telemetry: &mut Telemetry,
        scratch: &mut Scratch,
    ) {
        match self {
            Self::Direct(ground) => match command {
                Command::Report(Report::Arrived) => ground.report(Telemetry::Arrived, telemetry),
                Command::Report(Report::Failed(reason)) => {
                    ground.report(Telemetry::Failed(reason.as_str()), telemetry);
                }
                Command::Report(Report::LinkEcho) => {
                    scratch.events.extend(ground.heard(ToGround::LinkTest));
                }
                Command::Report(Report::Sonar(ranges_m)) => {
                    scratch.events.extend(ground.heard(sonar_report(ranges_m)));
                }
                _ => {}
            },
            Self::Wired(wired) => {
                scratch.out.clear();
                wired.client.command(now, command, &mut scratch.out);
                wired.link.send(End::A, now, &scratch.out);
            }
        }
    }

    /// Cuts or mends it; away is towards the ground.
    pub(super) fn set_cut(&mut self, direction: Direction, cut: bool) {
        match self {
            Self::Wired(wired) => cut_link(&mut wired.link, direction, cut),
            Self::Direct(ground) => ground.set_cut(direction, cut),
        }
    }

    pub(super) fn link(&self) -> Option<&Link> {
        match self {
            Self::Wired(wired) => Some(&wired.link),
            Self::Direct(_) => None,
        }
    }
}

impl Telemetry {
    /// The robot has not answered for as long as the ground waits.
    pub(super) const SILENT: Self = Self::Failed("the robot does not answer the ground");

    fn hear(&mut self, event: GroundStationEvent) {
        // The station lets through only what is about its last goal.
        let GroundStationEvent::Goal { news, .. } = event else { return };
        match news {
            GoalNews::UnderWay => {}
            GoalNews::Arrived => self.end(Self::Arrived),
            GoalNews::Failed(code) => self.end(Self::Failed(failure_text(code))),
            GoalNews::Forgotten => self.end(Self::Failed("the robot does not know of it any more")),
            GoalNews::Silent => self.end(Self::SILENT),
        }
    }

    /// The end of the goal that is under way; without one there is nothing to end.
    pub(super) fn end(&mut self, end: Self) {
        if *self == Self::UnderWay {
            *self = end;
        }
    }
}

/// A goal as the ground link sends it: whole millimetres and degrees.
fn on_the_wire(pose: Se2) -> [i16; 3] {
    // Casts from floats saturate.
    [1000.0 * pose.x_m, 1000.0 * pose.y_m, pose.yaw_rad.to_degrees()].map(|v| v.round() as i16)
}
