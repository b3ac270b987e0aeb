//! One robot: its lines, its mind, and what it does with its body.

use std::sync::Arc;

use decision::MoveReport;
use geometry::Transform2;
use messages::{BaseState, Command, FailureReason};
use navigator::{Method, Navigator, NavigatorView, Phase};
use robot_models::{RobotModel, WheelSpeeds};
use run_context::{RunSeed, Stamp, StateHash};
use simulator::{BodyId, World};

use super::{
    dialogue::Dialogue,
    error::RunError,
    hand::Hand,
    known_map,
    line::{Around, Line, Scratch, Traffic},
    orders::{OrderBy, Orders},
    ring_log::RingLog,
    scan_log::ScanLog,
    tags::TagReaders,
    tap::Packet,
    teleoperator::Teleoperator,
    telling::Telling,
    words,
};
use crate::{
    asked::Asked,
    cut::{Direction, Line as Which},
    mission::Mission,
    node::{desk::GroundOrder, wiring},
    sensing::step::SensedStep,
    view::{LogLevel, SceneLink, ViewScan},
};

/// Wheels slower than this stand, m/s: ramps end at 0, and rounding leaves no more.
const STANDING_MPS: f64 = 1e-9;

/// One robot with its lines and its mind.
#[derive(Debug)]
pub(super) struct Vehicle {
    pub(super) name: String,
    /// Its body; `None` for a robot elsewhere.
    pub(super) body: Option<BodyId>,
    model: Arc<RobotModel>,
    lines: Vec<Line>,
    tag_readers: Option<TagReaders>,
    navigator: Navigator,
    /// Who drives it by hand.
    teleoperator: Option<Teleoperator>,
    hand: Hand,
    orders: Orders,
    base: BaseState,
    telling: Telling,
    dialogue: Dialogue,
    ring_log: RingLog,
    scan_log: ScanLog,
    commands: Vec<Command>,
    scratch: Scratch,
}

impl Vehicle {
    /// Robot `index` of a mission.
    pub(super) fn new(
        mission: &Mission,
        index: usize,
        body: Option<BodyId>,
        seed: RunSeed,
    ) -> Result<Self, RunError> {
        let plan = &mission.parts().robots[index];
        let map_from_odom = Transform2::new(plan.start);
        let mut navigator = Navigator::new((*plan.navigator).clone(), map_from_odom);
        if let Some(path) = &plan.path {
            navigator.set_path(path.clone());
        }
        navigator.set_intermediate_goals(plan.via.clone());
        let plans = plan.navigator.settings().method == Method::Map;
        known_map::give(&mut navigator, mission, plan, seed)
            .map_err(|problem| RunError::Settings { robot: plan.name.clone(), problem })?;
        Ok(Self {
            name: plan.name.clone(),
            body,
            model: Arc::clone(&plan.model),
            lines: wiring::lines(mission, index, seed)?,
            tag_readers: plan.tag_readers.as_ref().map(|readers| {
                TagReaders::new(readers, seed.stream(&format!("tags/{}", plan.name)))
            }),
            navigator,
            teleoperator: plan.teleoperator.as_ref().map(|t| Teleoperator::new(t, &plan.model)),
            hand: Hand::default(),
            orders: Orders::default(),
            base: BaseState::default(),
            telling: Telling::new(&plan.name, plans || plan.path.is_some()),
            dialogue: Dialogue::default(),
            ring_log: RingLog::new(plan),
            scan_log: ScanLog::new(plan),
            commands: Vec::with_capacity(16),
            scratch: Scratch::default(),
        })
    }

    /// Gives an order to the ground's end of its line; it leaves at the next step. A robot that was halted takes none.
    pub(super) fn order(&mut self, order: GroundOrder, by: OrderBy) {
        if !self.orders.give(order, by) {
            return;
        }
        self.hand.let_go();
        if let Some(person) = &mut self.teleoperator {
            person.let_go();
        }
    }

    /// The ground asks it something, or to begin anew; the answer, or its absence, is news.
    pub(super) fn ask(&mut self, asked: Asked, now: Stamp) {
        if asked == Asked::Restart {
            self.order(GroundOrder::Restart, OrderBy::Person);
        }
        self.orders.ask(asked, now);
    }

    /// Somebody drives it by hand, until [`DRIVE_HOLD`](super::hand::DRIVE_HOLD) after the last call.
    pub(super) fn drive_by_hand(&mut self, now: Stamp, wheels: WheelSpeeds) {
        if !self.hand.is_on() {
            self.order(GroundOrder::Stop, OrderBy::Hand);
        }
        self.hand.feel(now, wheels);
    }

    /// Ends its task for good: its mind stops it at the next step and obeys nobody any more.
    pub(super) fn halt(&mut self) {
        self.orders.halt();
        self.hand.let_go();
        if let Some(person) = self.teleoperator.as_mut().filter(|person| !person.has_driven_all()) {
            person.let_go();
        }
    }

    /// If it is elsewhere: tells it to stand, at once.
    pub(super) fn hold(&mut self) {
        self.lines.iter_mut().for_each(Line::hold);
    }

    /// Cuts or mends one of its lines; nothing without such a line.
    pub(super) fn set_cut(&mut self, which: Which, direction: Direction, cut: bool) {
        if let Some(line) = self.lines.iter_mut().find(|line| line.which() == which) {
            line.set_cut(direction, cut);
        }
    }

    /// Its line of that kind.
    pub(super) fn line(&self, which: Which) -> Option<&Line> {
        self.lines.iter().find(|line| line.which() == which)
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
        let is_heard = self.line(Which::Robot).is_some_and(Line::is_connected);
        let odometry = self.base.odometry.filter(|_| is_heard)?;
        Some(!odometry.moving)
    }

    /// Whether it is on its way for a MOVE of the decision program.
    pub(super) fn is_on_program_move(&self) -> bool {
        self.orders.is_on_program_move()
    }

    /// What the ground knows of the last MOVE that it was given: its number, what became of it and
    /// why; `None` while it is under way.
    pub(super) fn program_move(&self) -> Option<(u64, MoveReport, &'static str)> {
        self.orders.program_move()
    }

    /// One step: lines deliver, the mind thinks, lines take what it wants. Reads the world, changes only itself.
    pub(super) fn step(&mut self, now: Stamp, world: &World) {
        let Self { lines, commands, scratch, orders, .. } = self;
        scratch.observations.clear();
        commands.clear();
        orders.desk.events.clear();
        let mut around = Around { now, world, body: self.body, desk: &mut orders.desk };
        for line in &mut *lines {
            line.step(&mut around, scratch);
        }
        if let (Some(readers), Some(body)) = (&mut self.tag_readers, self.body) {
            readers.sense(now, world, body, &mut scratch.observations);
        }
        orders.filter(now, self.navigator.phase(), &mut scratch.observations);
        self.navigator.step(now, &scratch.observations, commands);
        if let (Some(person), Some(body)) = (&mut self.teleoperator, self.body) {
            person.step(now, world.body(body).world_from_base.se2(), commands);
        }
        self.hand.step(now, commands);
        orders.hold_back(commands);
        for command in &*commands {
            for line in &mut *lines {
                line.command(now, command, &mut orders.desk, scratch);
            }
        }
        let truth = self.body.map(|body| world.body(body).world_from_base.se2());
        let Self { ring_log, scan_log, scratch, .. } = self;
        ring_log.step(now, truth, &scratch.observations);
        scan_log.step(now, |about| ring_log.truth_at(about), &scratch.observations);
        self.look_back(now);
        self.tell();
    }

    /// Hands its wheel references to its body.
    pub(super) fn apply(&self, world: &mut World) {
        let Some(body) = self.body else { return };
        let wanted = self.lines.iter().find_map(|line| line.reference(&self.model));
        if let Some(wanted) = wanted {
            world.set_acceleration(body, wanted.acceleration_mps2);
            world.set_wheel_reference(body, wanted.wheels);
        }
        self.tag_readers.iter().for_each(|readers| readers.apply(world));
    }

    /// What the step says to those who keep count.
    fn look_back(&mut self, now: Stamp) {
        for observation in &self.scratch.observations {
            self.base.take(observation);
            self.orders.hear(&observation.value);
            self.telling.hear(&observation.value);
            self.dialogue.hear(now, &observation.value);
        }
        let telling = &mut self.telling;
        self.orders.take_answers(now, |level, text| telling.push(level, &format!(" {text}")));
        for command in &self.commands {
            self.dialogue.say(now, command);
        }
    }

    /// Puts what has changed into words.
    fn tell(&mut self) {
        let telling = &mut self.telling;
        for line in &mut self.lines {
            line.take_news(|level, text| telling.push(level, &format!(": {text}")));
        }
        let by_hand = self.hand.take_news();
        let led = || self.teleoperator.as_mut().and_then(Teleoperator::take_news);
        if let Some(text) = by_hand.or_else(led) {
            telling.push(LogLevel::Info, &format!(": {text}"));
            return;
        }
        telling.phase(&self.navigator);
    }

    /// The oldest news that was not told yet.
    pub(super) fn take_news(&mut self) -> Option<(LogLevel, String)> {
        self.telling.take()
    }

    /// Whether it stands at the goal of the last order, by its own account, or was driven to the end of its path
    /// by hand.
    pub(super) fn has_arrived(&self) -> bool {
        if self.teleoperator.as_ref().is_some_and(Teleoperator::has_driven_all) {
            return true;
        }
        !self.orders.is_under_way() && self.navigator.phase() == Phase::Arrived
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
        by_hand.unwrap_or_else(|| words::phase(self.navigator.phase(), self.telling.has_path()))
    }

    /// What it does about its goal, in a sentence; `view` is its navigator's.
    pub(super) fn task(&self, view: &NavigatorView<'_>) -> String {
        words::task(view, self.telling.has_path())
    }

    /// What it sensed in the last step.
    pub(super) fn sensed(&self) -> SensedStep<'_> {
        SensedStep { scans: self.scan_log.rows(), ..self.ring_log.sensed() }
    }

    /// What each of its lasers saw last; nothing of one that is not heard any more.
    pub(super) fn scans(&self) -> impl Iterator<Item = &ViewScan> {
        let is_heard = |scan: &&ViewScan| {
            let line = self.line(Which::Laser(scan.scanner as u8));
            line.is_some_and(Line::is_connected)
        };
        self.scan_log.latest().filter(is_heard)
    }

    /// Whether it gave up for that reason, or for any, and the ground knows.
    pub(super) fn has_given_up(&self, reason: Option<FailureReason>) -> bool {
        let Phase::Failed(why) = self.navigator.phase() else { return false };
        self.orders.failure().is_some() && reason.is_none_or(|reason| reason == why)
    }

    /// Why it gave up, if it did.
    pub(super) fn failure(&self) -> Option<String> {
        match self.navigator.phase() {
            Phase::Failed(reason) => Some(words::failure(reason, self.navigator.view().scouting)),
            _ => self.orders.failure().map(str::to_owned),
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
        self.dialogue.longest_ms()
    }

    /// How often its readers have read a tag; `None` without readers.
    pub(super) fn n_tag_reads(&self) -> Option<u64> {
        self.tag_readers.as_ref().map(TagReaders::n_reads)
    }

    /// What the servers at the ends of its lines counted.
    pub(super) fn traffic(&self) -> Option<Traffic> {
        self.lines.iter().find_map(Line::traffic)
    }

    /// Its lines as screens show them, of robot number `robot`; `of` is its name where there are several.
    pub(super) fn scene_links(
        &self,
        robot: usize,
        of: Option<&str>,
    ) -> impl Iterator<Item = SceneLink> {
        self.lines.iter().map(move |line| line.scene(robot, of))
    }

    pub(super) fn n_lines(&self) -> usize {
        self.lines.len()
    }

    /// Begins or ends reading along on its lines.
    pub(super) fn set_trace(&mut self, on: bool) {
        self.lines.iter_mut().for_each(|line| line.set_trace(on));
    }

    /// Hands over what passed its lines: the line's place among them, and the packet.
    pub(super) fn drain_taps(&mut self, mut take: impl FnMut(usize, Packet)) {
        for (place, line) in self.lines.iter_mut().enumerate() {
            line.tap().into_iter().flat_map(super::tap::Tap::drain).for_each(|p| take(place, p));
        }
    }

    pub(super) fn absorb_state(&self, hash: &mut StateHash) {
        self.lines.iter().for_each(|line| line.absorb_state(hash));
        let view = self.navigator.view();
        let pose = view.map_from_base.se2();
        for value in [pose.x_m, pose.y_m, pose.yaw_rad, view.follower_error] {
            hash.absorb(value);
        }
        hash.absorb_u64(u64::from(view.avoider_state));
        hash.absorb_bytes(view.phase.name().as_bytes());
        self.orders.absorb_state(hash);
        if let Some(person) = &self.teleoperator {
            person.absorb_state(hash);
        }
        self.tag_readers.iter().for_each(|readers| readers.absorb_state(hash));
    }
}
