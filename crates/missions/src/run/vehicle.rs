//! One robot's nodes: navigation with its three lines, and what stands at their other ends.

use std::{sync::Arc, time::Duration};

use decision::MoveReport;
use drivers::{
    DriverConfig, GroundClient, GroundLinkConfig, GroundStation, LineTiming, PheromoneClient,
    PheromoneClientConfig,
};
use geometry::{Se2, Transform2};
use messages::{BaseState, Command, FailureReason, LinkState, Order, Sensed, Smell};
use navigator::{Navigator, NavigatorView, Phase};
use pheromones::{Field, ServerConfig, ServerCounters};
use robot_models::{RobotModel, WheelSpeeds};
use run_context::{RunSeed, Stamp, StateHash};
use simulator::{BodyId, World};
use virtual_robots::{BatteryConfig, BoardConfig, MotorReference};
use wire::link::{End, Link, LinkConfig};

pub(super) use super::lines::GroundOrder;
use super::{
    RunError,
    direct::DirectRobot,
    direct_ground::DirectGround,
    hand::Hand,
    inquiry::Inquiry,
    lines::{
        FromGround, GroundLine, Packets, RemoteRobot, RobotLine, Scratch, ServerLine, Telemetry,
        WiredGround, WiredRobot,
    },
    ring_log::RingLog,
    tags::TagReaders,
    tap::Tap,
    teleoperator::Teleoperator,
    words,
};
use crate::{
    asked::Asked,
    cut::{Cuts, Direction, Line},
    mission::{
        Mission,
        plan::{LinkPlan, RobotPlan},
    },
    transport::{SerialTransport, TcpTransport, Transport},
    view::LogLevel,
};

/// Wheels slower than this stand, m/s: ramps end at 0, and rounding leaves no more.
const STANDING_MPS: f64 = 1e-9;

/// A question that nobody has answered for so long is given up, whatever line it went over.
const ANSWER_WITHIN: Duration = Duration::from_secs(10);

/// One robot with its nodes.
#[derive(Debug)]
pub(super) struct Vehicle {
    pub(super) name: String,
    /// Its body; `None` for a robot elsewhere.
    pub(super) body: Option<BodyId>,
    robot: RobotLine,
    server: ServerLine,
    ground: GroundLine,
    tag_readers: Option<TagReaders>,
    navigator: Navigator,
    /// Who drives it by hand.
    teleoperator: Option<Teleoperator>,
    hand: Hand,
    ring_log: RingLog,
    /// Time per byte of the three links, zero without limit.
    byte_times: [Duration; 3],
    order: Option<GroundOrder>,
    /// An order was given and has not reached the navigator yet.
    order_under_way: bool,
    /// A question of the ground that leaves at the next step.
    question: Option<Asked>,
    inquiry: Inquiry,
    telemetry: Telemetry,
    /// The last MOVE of the decision program that it was given.
    program_move: Option<ProgramMove>,
    base: BaseState,
    last_phase: Phase,
    last_goal: Option<Se2>,
    news: Vec<(LogLevel, String)>,
    /// Takes no more orders.
    halts: Halt,
    /// Its driver has lost it and not found it again.
    is_lost: bool,
    asked_at: Option<(u8, Stamp)>,
    cycle_max_ms: Option<f64>,
    /// Whether it was given a path; otherwise what it follows is a trail.
    has_path: bool,
    commands: Vec<Command>,
    scratch: Scratch,
    taps: Option<Box<[(Tap, Packets); 3]>>,
    model: Arc<RobotModel>,
    link_base: usize,
}

/// Who gives an order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum OrderBy {
    /// The decision program, with a MOVE of that number.
    Program(u64),
    /// Somebody at the ground station, or the mission's plan.
    Person,
    /// Somebody who drives it by hand from now on.
    Hand,
    /// The decision node, because its program has stopped.
    Failsafe,
}

/// A MOVE of the decision program, as long as nobody has given it another.
#[derive(Clone, Copy, Debug)]
struct ProgramMove {
    number: u64,
    /// What became of it when somebody else gave an order; before that the telemetry says it.
    end: Option<(MoveReport, &'static str)>,
}

impl Vehicle {
    /// The nodes of robot `index`.
    pub(super) fn new(
        mission: &Mission,
        index: usize,
        body: Option<BodyId>,
        seed: RunSeed,
    ) -> Result<Self, RunError> {
        let parts = mission.parts();
        let plan = &parts.robots[index];
        let settings = |problem: String| RunError::Settings { robot: plan.name.clone(), problem };
        let map_from_odom = Transform2::new(plan.start);
        let mut navigator = Navigator::new((*plan.navigator).clone(), map_from_odom);
        if let Some(path) = &plan.path {
            navigator.set_path(path.clone());
        }
        navigator.set_intermediate_goals(plan.via.clone());
        let decides = parts.decision.as_ref().filter(|d| d.robot == Some(index));
        let answer_within = decides.map(|d| d.answer_within);
        let ground_link = decides.map_or_else(|| default_ground_link(plan), |d| d.link.clone());
        let server_link = parts.pheromones.as_ref().map(|p| p.link.clone());
        let baud = |link: &LinkPlan| link.baud();
        let byte_time = |baud: u32| match baud {
            0 => Duration::ZERO,
            baud => Duration::from_secs(10) / baud,
        };
        let bauds = [baud(&plan.link), server_link.as_ref().map_or(0, baud), baud(&ground_link)];
        Ok(Self {
            name: plan.name.clone(),
            body,
            robot: robot_line(plan, seed)?,
            server: server_line(mission, index, seed).map_err(settings)?,
            ground: ground_line(&ground_link, answer_within, plan, seed).map_err(settings)?,
            tag_readers: plan.tag_readers.as_ref().map(|readers| {
                TagReaders::new(readers, seed.stream(&format!("tags/{}", plan.name)))
            }),
            navigator,
            teleoperator: plan.teleoperator.as_ref().map(|t| Teleoperator::new(t, &plan.model)),
            hand: Hand::default(),
            ring_log: RingLog::new(plan),
            byte_times: bauds.map(byte_time),
            order: None,
            order_under_way: false,
            question: None,
            inquiry: Inquiry::default(),
            telemetry: Telemetry::default(),
            program_move: None,
            base: BaseState::default(),
            last_phase: Phase::Idle,
            last_goal: None,
            news: Vec::new(),
            halts: Halt::No,
            is_lost: false,
            asked_at: None,
            cycle_max_ms: None,
            has_path: plan.path.is_some(),
            commands: Vec::with_capacity(16),
            scratch: Scratch::default(),
            taps: None,
            model: Arc::clone(&plan.model),
            link_base: 3 * index,
        })
    }

    /// Gives an order to the ground's end of the ground link; it leaves at the next step. From now on
    /// nothing is believed of the goal before. A robot that was halted takes none.
    pub(super) fn order(&mut self, order: GroundOrder, by: OrderBy) {
        if self.halts != Halt::No {
            return;
        }
        self.end_program_move(order, by);
        self.order = Some(order);
        self.order_under_way = true;
        self.hand.let_go();
        self.telemetry = match order {
            GroundOrder::GoTo(_) => Telemetry::UnderWay,
            GroundOrder::Stop | GroundOrder::Restart => Telemetry::NoGoal,
        };
        if let Some(person) = &mut self.teleoperator {
            person.let_go();
        }
    }

    /// The ground asks it something, or to begin anew; the answer, or its absence, is news.
    pub(super) fn ask(&mut self, asked: Asked, now: Stamp) {
        if self.halts != Halt::No {
            return;
        }
        match asked {
            Asked::Restart => self.order(GroundOrder::Restart, OrderBy::Person),
            Asked::Link | Asked::Sonar => self.question = Some(asked),
        }
        self.inquiry.begin(asked, now);
    }

    /// Somebody drives it by hand, until [`DRIVE_HOLD`](super::DRIVE_HOLD) after the last call.
    pub(super) fn drive_by_hand(&mut self, now: Stamp, wheels: WheelSpeeds) {
        if !self.hand.is_on() {
            self.order(GroundOrder::Stop, OrderBy::Hand);
        }
        self.hand.feel(now, wheels);
    }

    /// Ends its task for good: its mind stops it at the next step and obeys nobody any more. The ground is told to
    /// send a stop, so that it repeats no goal; one that is still on its way to the robot is not obeyed.
    pub(super) fn halt(&mut self) {
        self.halts = Halt::Due;
        self.order = Some(GroundOrder::Stop);
        self.order_under_way = false;
        self.hand.let_go();
        if let Some(person) = self.teleoperator.as_mut().filter(|person| !person.has_driven_all()) {
            person.let_go();
        }
    }

    /// If it is elsewhere: tells it to stand, at once.
    pub(super) fn hold(&mut self) {
        self.robot.hold();
    }

    /// Cuts or mends one of its lines.
    pub(super) fn set_cut(&mut self, line: Line, direction: Direction, cut: bool) {
        match line {
            Line::Robot => self.robot.set_cut(direction, cut),
            Line::Pheromones => self.server.set_cut(direction, cut),
            Line::Ground => self.ground.set_cut(direction, cut),
        }
    }

    /// Whether its wheels stand; `None` when nobody knows, which is so of a robot elsewhere that is not
    /// heard.
    pub(super) fn stands(&self, world: &World) -> Option<bool> {
        if let Some(body) = self.body {
            let wheels = world.body(body).wheel_speeds;
            return Some(
                [wheels.left_mps, wheels.right_mps].iter().all(|v| v.abs() < STANDING_MPS),
            );
        }
        let odometry = self.base.odometry.filter(|_| self.robot.is_connected())?;
        Some(!odometry.moving)
    }

    /// A new order ends the MOVE before: one that was under way will not be done any more, and from
    /// one that was done the robot is sent away.
    fn end_program_move(&mut self, order: GroundOrder, by: OrderBy) {
        if let OrderBy::Program(number) = by {
            self.program_move = Some(ProgramMove { number, end: None });
            return;
        }
        let Some(program_move) = &mut self.program_move else { return };
        if program_move.end.is_some_and(|(report, _)| report != MoveReport::Done) {
            return;
        }
        let is_done = program_move.end.is_some() || self.telemetry == Telemetry::Arrived;
        program_move.end = Some(match (self.telemetry, order) {
            (Telemetry::Failed(reason), _) => (MoveReport::Failed, reason),
            (_, GroundOrder::GoTo(_)) if is_done => {
                (MoveReport::Left, "the robot is sent elsewhere")
            }
            (_, GroundOrder::GoTo(_)) => (MoveReport::Failed, "somebody sent the robot elsewhere"),
            _ if is_done && by == OrderBy::Hand => {
                (MoveReport::Left, "the robot is driven away by hand")
            }
            _ if is_done => (MoveReport::Done, "the robot stands there"),
            _ if by == OrderBy::Failsafe => (MoveReport::Failed, "the program has stopped"),
            _ if by == OrderBy::Hand => (MoveReport::Failed, "somebody drives the robot by hand"),
            (_, GroundOrder::Restart) => (MoveReport::Failed, "somebody restarted the robot"),
            _ => (MoveReport::Failed, "somebody stopped the robot"),
        });
    }

    /// Whether it is on its way for a MOVE of the decision program.
    pub(super) fn is_on_program_move(&self) -> bool {
        self.program_move.is_some_and(|m| m.end.is_none()) && self.telemetry == Telemetry::UnderWay
    }

    /// What the ground knows of the last MOVE that it was given: its number, what became of it and
    /// why; `None` while it is under way.
    pub(super) fn program_move(&self) -> Option<(u64, MoveReport, &'static str)> {
        let ProgramMove { number, end } = self.program_move?;
        let (report, why) = match (end, self.telemetry) {
            (Some(end), _) => end,
            (None, Telemetry::Arrived) => (MoveReport::Done, "the robot stands there"),
            (None, Telemetry::Failed(reason)) => (MoveReport::Failed, reason),
            (None, _) => return None,
        };
        Some((number, report, why))
    }

    /// One step of all its nodes. Reads the world, changes only itself.
    pub(super) fn step(&mut self, now: Stamp, world: &World, field: Option<&Field>) {
        let Self { robot, server, ground, commands, scratch, taps, .. } = self;
        scratch.observations.clear();
        commands.clear();
        let [robot_tap, server_tap, ground_tap] = match taps.as_deref_mut() {
            None => [None, None, None],
            Some([a, b, c]) => [a, b, c].map(|(tap, packets)| Some((tap, packets))),
        };
        robot.observe(now, world, self.body, scratch, robot_tap);
        server.observe(now, field, scratch, server_tap);
        let said = FromGround { order: self.order.take(), question: self.question.take() };
        ground.observe(now, said, &mut self.telemetry, scratch, ground_tap);
        if let (Some(readers), Some(body)) = (&mut self.tag_readers, self.body) {
            readers.sense(now, world, body, &mut scratch.observations);
        }
        if self.halts != Halt::No {
            scratch.observations.retain(|seen| !matches!(seen.value, Sensed::Order(_)));
        }
        if self.halts == Halt::Due && is_busy(self.navigator.phase()) {
            let value = Sensed::Order(Order::Stop);
            scratch.observations.push(now, value);
        }
        self.navigator.step(now, &scratch.observations, commands);
        if let (Some(person), Some(body)) = (&mut self.teleoperator, self.body) {
            person.step(now, world.body(body).world_from_base.se2(), commands);
        }
        self.hand.step(now, commands);
        if self.halts != Halt::No {
            commands.retain(|c| !matches!(c, Command::Drive(_) | Command::TurnTo { .. }));
        }
        if self.halts == Halt::Due {
            self.halts = Halt::Done;
            commands.push(Command::Stop);
        }
        for command in &*commands {
            robot.command(now, command, scratch);
            server.command(now, command, scratch);
            ground.command(now, command, &mut self.telemetry, scratch);
        }
        let truth = self.body.map(|body| world.body(body).world_from_base.se2());
        self.ring_log.step(now, truth, &self.scratch.observations);
        self.measure(now);
        self.tell();
    }

    /// Hands its wheel references to its body.
    pub(super) fn apply(&self, world: &mut World) {
        let Some(body) = self.body else { return };
        let (wheels, acceleration_mps2) = self.robot.reference(world, body);
        world.set_acceleration(body, acceleration_mps2);
        world.set_wheel_reference(body, wheels);
        self.tag_readers.iter().for_each(|readers| readers.apply(world));
    }

    /// Begin and end markers of a control cycle: from the question about the robot's own pose to the
    /// answer that the wheel reference follows from, as it took in virtual time. What the node computes
    /// takes none here.
    fn measure(&mut self, now: Stamp) {
        for observation in &self.scratch.observations {
            self.base.take(observation);
            match observation.value {
                Sensed::Order(_) => self.order_under_way = false,
                Sensed::Odometry(_)
                | Sensed::Ring(_)
                | Sensed::Scan(_)
                | Sensed::Contact(_)
                | Sensed::Motors(_)
                | Sensed::Battery(_)
                | Sensed::Tag(_) => {}
                Sensed::Link(state) => {
                    let is_lost = state == LinkState::Down;
                    if std::mem::replace(&mut self.is_lost, is_lost) != is_lost {
                        self.news.push(link_news(&self.name, is_lost));
                    }
                }
                Sensed::Smell(Smell { query, .. }) => {
                    if let Some((asked, at)) = self.asked_at
                        && asked == query
                    {
                        let cycle_ms = now.since(at).as_secs_f64() * 1e3;
                        let longest = self.cycle_max_ms.map_or(cycle_ms, |max| max.max(cycle_ms));
                        self.cycle_max_ms = Some(longest);
                        self.asked_at = None;
                    }
                }
            }
        }
        let late = self.inquiry.give_up(now, ANSWER_WITHIN);
        let heard = self.scratch.events.iter().filter_map(|event| self.inquiry.hear(*event, now));
        let heard: Vec<_> = heard.chain(late).collect();
        for (level, text) in heard {
            self.news.push((level, format!("{} {text}", self.name)));
        }
        for command in &self.commands {
            if let Command::QueryPheromones { query, .. } = command {
                self.asked_at = Some((*query, now));
            }
        }
    }

    /// Puts a change of phase into words.
    fn tell(&mut self) {
        if let Some(error) = self.robot.take_break() {
            self.news.push((LogLevel::Bad, format!("{}: {error}", self.name)));
        }
        let by_hand = self.hand.take_news();
        let led = || self.teleoperator.as_mut().and_then(Teleoperator::take_news);
        if let Some(text) = by_hand.or_else(led) {
            self.news.push((LogLevel::Info, format!("{}: {text}", self.name)));
            return;
        }
        let phase = self.navigator.phase();
        let view = self.navigator.view();
        let goal = view.goal_in_map.map(|goal| goal.se2());
        let is_new_goal = phase == Phase::AimAtTrail && goal != self.last_goal;
        self.last_goal = goal;
        if phase == self.last_phase && !is_new_goal {
            return;
        }
        self.last_phase = phase;
        let (level, text) = match phase {
            Phase::Arrived => (LogLevel::Good, "stands at its goal".to_owned()),
            Phase::Failed(reason) => {
                (LogLevel::Bad, format!("gives up: {}", words::failure(reason, view.scouting)))
            }
            Phase::AimAtTrail => (LogLevel::Info, self.task(&view)),
            Phase::Avoid | Phase::Wait | Phase::LostTrail => {
                (LogLevel::Warn, words::phase(phase, self.has_path).to_owned())
            }
            _ => (LogLevel::Info, words::phase(phase, self.has_path).to_owned()),
        };
        self.news.push((level, format!("{}: {text}", self.name)));
    }

    /// The oldest news that was not told yet.
    pub(super) fn take_news(&mut self) -> Option<(LogLevel, String)> {
        (!self.news.is_empty()).then(|| self.news.remove(0))
    }

    /// Whether it stands at the goal of the last order, by its own account, or was driven to the end of its path
    /// by hand.
    pub(super) fn has_arrived(&self) -> bool {
        if self.teleoperator.as_ref().is_some_and(Teleoperator::has_driven_all) {
            return true;
        }
        !self.order_under_way && self.navigator.phase() == Phase::Arrived
    }

    /// Whether somebody has just begun to drive it by hand.
    pub(super) fn sets_off_by_hand(&self) -> bool {
        self.teleoperator.as_ref().is_some_and(Teleoperator::sets_off)
    }

    /// What it is busy with, in a word or two.
    pub(super) fn phase_name(&self) -> &'static str {
        if self.hand.is_on() {
            return "driven by hand";
        }
        let by_hand = self.teleoperator.as_ref().and_then(Teleoperator::phase_name);
        by_hand.unwrap_or_else(|| words::phase(self.navigator.phase(), self.has_path))
    }

    /// What it does about its goal, in a sentence; `view` is its navigator's.
    pub(super) fn task(&self, view: &NavigatorView<'_>) -> String {
        words::task(view, self.has_path)
    }

    /// What it sensed in the last step.
    pub(super) fn ring_log(&self) -> &RingLog {
        &self.ring_log
    }

    /// Whether it gave up for that reason, or for any, and the ground knows.
    pub(super) fn has_given_up(&self, reason: Option<FailureReason>) -> bool {
        let Phase::Failed(why) = self.navigator.phase() else { return false };
        matches!(self.telemetry, Telemetry::Failed(_)) && reason.is_none_or(|reason| reason == why)
    }

    /// Why it gave up, if it did.
    pub(super) fn failure(&self) -> Option<String> {
        match self.navigator.phase() {
            Phase::Failed(reason) => Some(words::failure(reason, self.navigator.view().scouting)),
            _ => match self.telemetry {
                Telemetry::Failed(reason) => Some(reason.to_owned()),
                _ => None,
            },
        }
    }

    /// Whether it follows a trail on purpose, or is driven along a path.
    pub(super) fn is_following(&self) -> bool {
        let by_hand = self.teleoperator.as_ref().is_some_and(Teleoperator::is_driving);
        by_hand || self.navigator.phase() == Phase::FollowTrail
    }

    pub(super) fn navigator(&self) -> &Navigator {
        &self.navigator
    }

    /// The latest that the navigation node has received of the robot's own devices.
    pub(super) fn base(&self) -> &BaseState {
        &self.base
    }

    /// The longest control cycle so far, ms; `None` before the first.
    pub(super) fn cycle_max_ms(&self) -> Option<f64> {
        self.cycle_max_ms
    }

    /// Share of time that the busier direction of each link was in use: robot, server, ground.
    pub(super) fn utilisations(&self, now: Stamp) -> [Option<f64>; 3] {
        let robot = match &self.robot {
            RobotLine::Wired(robot) => Some(&robot.link),
            RobotLine::Direct(_) | RobotLine::Remote(_) => None,
        };
        let links = [robot, self.server.link(), self.ground.link()];
        let time_s = now.as_secs_f64().max(1e-9);
        std::array::from_fn(|i| {
            let link = links[i]?;
            let sent = |end| link.counters(end).n_sent;
            let busier = sent(End::A).max(sent(End::B)) as f64;
            Some(busier * self.byte_times[i].as_secs_f64() / time_s)
        })
    }

    /// How often its readers have read a tag; `None` without readers.
    pub(super) fn n_tag_reads(&self) -> Option<u64> {
        self.tag_readers.as_ref().map(TagReaders::n_reads)
    }

    /// What the pheromone server at the end of its link counted.
    pub(super) fn server_traffic(&self) -> Option<ServerCounters> {
        self.server.traffic()
    }

    /// Begins or ends reading along on its links.
    pub(super) fn set_trace(&mut self, on: bool) {
        let fresh = || {
            let taps = [Tap::of_robot(&self.model), Tap::pheromones(), Tap::ground()];
            Box::new(taps.map(|tap| (tap, Packets::new())))
        };
        self.taps = on.then(fresh);
    }

    /// Hands over what passed its links: link index, receiving node, bytes, text.
    pub(super) fn drain_taps(
        &mut self,
        mut take: impl FnMut(usize, &'static str, Vec<u8>, String),
    ) {
        for (i, (_, packets)) in self.taps.iter_mut().flat_map(|t| t.iter_mut()).enumerate() {
            for (to, bytes, text) in packets.drain(..) {
                take(self.link_base + i, to, bytes, text);
            }
        }
    }

    pub(super) fn absorb_state(&self, hash: &mut StateHash) {
        self.robot.absorb_state(hash);
        let view = self.navigator.view();
        let pose = view.map_from_base.se2();
        for value in [pose.x_m, pose.y_m, pose.yaw_rad, view.follower_error] {
            hash.absorb(value);
        }
        hash.absorb_u64(u64::from(view.avoider_state));
        hash.absorb_bytes(view.phase.name().as_bytes());
        self.inquiry.absorb_state(hash);
        if let Some(person) = &self.teleoperator {
            person.absorb_state(hash);
        }
        self.tag_readers.iter().for_each(|readers| readers.absorb_state(hash));
    }
}

/// Whether somebody ended its task for good.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Halt {
    No,
    Due,
    Done,
}

/// Whether a navigator may move its robot.
fn is_busy(phase: Phase) -> bool {
    !matches!(phase, Phase::Idle | Phase::Arrived | Phase::Failed(_))
}

fn link_news(name: &str, is_lost: bool) -> (LogLevel, String) {
    if is_lost {
        let text = "does not answer any more: told to stop, and left alone until its watchdog has";
        (LogLevel::Bad, format!("{name} {text} stopped it"))
    } else {
        (LogLevel::Info, format!("{name} answers again"))
    }
}

/// The line of a ground station when no decision node is wired to the robot: a radio modem, or
/// direct where the robot's own link is.
fn default_ground_link(plan: &RobotPlan) -> LinkPlan {
    match plan.link {
        LinkPlan::Direct => LinkPlan::Direct,
        _ => LinkPlan::Memory(LinkConfig {
            baud: Some(9600),
            latency: Duration::from_millis(5),
            ..LinkConfig::default()
        }),
    }
}

/// The outer wheel of a curve turns at up to so many times the cruising speed.
const OUTER_WHEEL_RATIO: f64 = 1.6;

fn robot_line(plan: &RobotPlan, seed: RunSeed) -> Result<RobotLine, RunError> {
    let transport_error = |source| RunError::Transport { robot: plan.name.clone(), source };
    let settings = |problem: String| RunError::Settings { robot: plan.name.clone(), problem };
    let sonar_range_max_m = plan.sonar.range_max_m;
    let driver = |line: LineTiming| {
        let navigator = plan.navigator.settings();
        let config = DriverConfig {
            wheel_speed_max_mps: OUTER_WHEEL_RATIO * navigator.speed_mps,
            acceleration_mps2: navigator.acceleration_mps2,
            range_max_m: sonar_range_max_m,
            line,
        };
        drivers::driver(&plan.model, &config).map_err(|e| settings(e.to_string()))
    };
    let remote = |transport: Box<dyn Transport>| {
        let driver = driver(LineTiming::default())?;
        Ok(RobotLine::Remote(Box::new(RemoteRobot::new(transport, driver))))
    };
    Ok(match &plan.link {
        LinkPlan::Direct => {
            let rng = seed.stream(&format!("robot/{}", plan.name));
            RobotLine::Direct(Box::new(DirectRobot::new(&plan.model, sonar_range_max_m, rng)))
        }
        LinkPlan::Memory(config) => {
            let rng = seed.stream(&format!("link/{}/robot", plan.name));
            let link = Link::new(config, rng).map_err(|e| settings(e.to_string()))?;
            let rng = seed.stream(&format!("robot/{}", plan.name));
            let board = BoardConfig { name: plan.name.clone(), battery: BatteryConfig::default() };
            let board = virtual_robots::board(&plan.model, &board, rng);
            RobotLine::Wired(Box::new(WiredRobot {
                link,
                board: board.map_err(|e| settings(e.to_string()))?,
                driver: driver(LineTiming { baud: config.baud, latency: config.latency })?,
                reference: MotorReference {
                    wheels: WheelSpeeds::ZERO,
                    acceleration_mps2: plan.model.limits.acceleration_max_mps2,
                },
            }))
        }
        LinkPlan::Tcp { address } => {
            remote(Box::new(TcpTransport::connect(address).map_err(transport_error)?))?
        }
        LinkPlan::Serial { device, baud } => {
            remote(Box::new(SerialTransport::open(device, *baud).map_err(transport_error)?))?
        }
    })
}

fn server_line(mission: &Mission, index: usize, seed: RunSeed) -> Result<ServerLine, String> {
    let Some(plan) = &mission.parts().pheromones else { return Ok(ServerLine::Nothing) };
    let LinkPlan::Memory(config) = &plan.link else {
        let cuts = Cuts::default();
        return Ok(ServerLine::Direct { sense: plan.sense, asked: None, cuts });
    };
    let name = &mission.parts().robots[index].name;
    let rng = seed.stream(&format!("link/{name}/pheromones"));
    let link = Link::new(config, rng).map_err(|e| e.to_string())?;
    // Robot numbers on the wire go round after 256; every robot has a channel of its own.
    let robot_id = (index % 256) as u8;
    let client = PheromoneClient::new(PheromoneClientConfig {
        robot_id,
        ..PheromoneClientConfig::default()
    });
    let config = ServerConfig {
        sense: plan.sense,
        scale_ratio: plan.scale_ratio,
        ..ServerConfig::default()
    };
    Ok(ServerLine::wired(link, config, client))
}

/// The line to the ground. The ground waits as long for the robot's answers as `answer_within` says, and
/// as the way there and back takes.
fn ground_line(
    link: &LinkPlan,
    answer_within: Option<Duration>,
    plan: &RobotPlan,
    seed: RunSeed,
) -> Result<GroundLine, String> {
    let mut timing = GroundLinkConfig::default();
    let LinkPlan::Memory(config) = link else {
        let within = answer_within.unwrap_or(timing.retry_period * timing.n_tries);
        return Ok(GroundLine::Direct(DirectGround::new(within)));
    };
    let rng = seed.stream(&format!("link/{}/ground", plan.name));
    if let Some(within) = answer_within {
        timing.retry_period = within / timing.n_tries;
    }
    timing.retry_period += 2 * (config.latency + config.jitter);
    Ok(GroundLine::Wired(Box::new(WiredGround {
        link: Link::new(config, rng).map_err(|e| e.to_string())?,
        station: GroundStation::new(timing.clone()),
        client: GroundClient::new(timing),
    })))
}
