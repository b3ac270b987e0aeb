//! The closed loop: every node of a mission, advanced together in steps of 10 ms.
//!
//! One step: what the mission or a person wants to happen now happens; the devices are read; the
//! decision node scans; every robot's nodes (firmware, links, driver, navigator, pheromone server)
//! run, in parallel when there are many, each touching only its own state and the world as it was; their
//! wheel references are applied in the robots' order; the world moves; figures and requirements are
//! brought up to date.

mod build;
mod dialogue;
pub(crate) mod error;
mod hand;
mod judge;
mod known_map;
mod limits;
pub(crate) mod line;
mod metrics;
mod orders;
mod ring_log;
mod scan_log;
mod scene;
mod show;
mod sides;
mod signals;
mod tags;
mod tap;
mod teleoperator;
mod telling;
mod vehicle;
mod words;

use std::collections::VecDeque;

use geometry::{Se2, Vec2};
use navigator::Method;
use path_following::Path;
use rayon::prelude::*;
use robot_models::BodyVelocity;
use run_context::{RunSeed, Stamp, StateHash};
use simulator::{ThingId, World};

use crate::node::{
    decision::{DecisionNode, Request},
    desk::GroundOrder,
    devices::Devices,
};
use crate::{
    asked::Asked,
    cut::{Direction, Line},
    intervention::{Intervention, InterventionError, RecordedIntervention, to_thousandths},
    mission::{
        Mission,
        plan::{Action, GoalPose},
    },
    sensing::step::SensedStep,
    verdict::Verdict,
    view::{LogItem, LogLevel, TraceItem, ViewPose},
};
pub use error::RunError;
pub use hand::DRIVE_HOLD;
use judge::Judge;
use limits::N_REPORTED_MAX;
pub use limits::STEP;
use metrics::RobotMetrics;
use orders::OrderBy;
pub(crate) use ring_log::rig;
pub(crate) use scan_log::laser_rig;
pub use signals::{PLOTS, Plot, SIGNALS, Signal};
use vehicle::Vehicle;

/// Log entries kept until somebody drains them; older ones are dropped first.
const LOG_MAX: usize = 2000;
/// Trace entries kept until somebody drains them.
const TRACE_MAX: usize = 4000;
/// From this many robots on, their nodes run in parallel.
const PARALLEL_FROM: usize = 8;
/// In swarms every robot's clearance is measured once in so many steps.
const SWARM_TURNS: u64 = 50;
/// Robots per parallel piece of work.
const PIECE: usize = 8;
/// Boxes that may have been put down during a run and stand there still.
const N_BOXES_MAX: usize = 200;
/// Steps that robots may take to come to a stand: from 1 m/s at 0.05 m/s² it takes 20 s.
const HALT_STEPS_MAX: u64 = 3000;
/// Steps for which a robot that is not heard is waited for: more than its watchdog takes.
const UNKNOWN_STEPS_MAX: u64 = 400;
/// How long a pressed button stays pressed.
const PRESS_STEPS: u64 = 50;

/// A running mission.
///
/// Cost: one robot with all its bytes takes a few microseconds a step; memory does not grow with time.
#[derive(Debug)]
pub struct Run {
    mission: Mission,
    seed: RunSeed,
    steps: u64,
    world: World,
    n_initial_things: u64,
    vehicles: Vec<Vehicle>,
    decision: Option<DecisionNode>,
    devices: Devices,
    metrics: Vec<RobotMetrics>,
    judge: Judge,
    verdict: Option<Verdict>,
    next_event: usize,
    /// The step before which everybody was told to stand.
    halted_at: Option<u64>,
    waiting_goals: VecDeque<(usize, GoalPose)>,
    /// Sum over the steps of the way of what moved farthest, m.
    others_moved_m: f64,
    interventions: Vec<RecordedIntervention>,
    log: VecDeque<LogItem>,
    trace: VecDeque<TraceItem>,
    trace_on: bool,
}

/// The world of a mission without its robots, and where its first robot would start, or without robots the widest
/// place of its map: for hosts that put a robot of their own into it.
///
/// # Errors
///
/// [`RunError`] when the world cannot be built.
pub fn world_of(mission: &Mission, seed: RunSeed) -> Result<(World, Option<Se2>), RunError> {
    let (world, _) = build::world(mission, seed)?;
    let parts = mission.parts();
    let widest = || {
        let (place, _) = parts.world.map.as_ref()?.widest_place()?;
        Some(Se2::new(place.x, place.y, 0.0))
    };
    Ok((world, parts.robots.first().map(|robot| robot.start).or_else(widest)))
}

/// Whether a mission can be started with a seed: builds everything that [`Run::new`] does, except that robots
/// elsewhere are not called. Cost: that of a start.
///
/// # Errors
///
/// [`RunError`], the same that [`Run::new`] would give.
pub fn can_start(mission: &Mission, seed: RunSeed) -> Result<(), RunError> {
    let (mut world, _) = build::world(mission, seed)?;
    build::bodies(mission, &mut world).map(|_bodies| ())
}

impl Run {
    /// Puts everything in place: the world with its random boxes and people, the robots, the nodes.
    ///
    /// Missions with `tcp` or `serial` links connect here.
    ///
    /// # Errors
    ///
    /// [`RunError`] when the world cannot be built or a robot elsewhere cannot be reached.
    pub fn new(mission: Mission, seed: RunSeed) -> Result<Self, RunError> {
        let (mut world, n_initial_things) = build::world(&mission, seed)?;
        let vehicles = build::vehicles(&mission, seed, &mut world)?;
        let decision = build::decision(&mission);
        let parts = mission.parts();
        let paths = |trails: &[Vec<Vec2>]| -> Vec<Path> {
            trails.iter().filter_map(|trail| Path::polyline(trail).ok()).collect()
        };
        let of_server = parts.pheromones.as_ref().map_or_else(Vec::new, |p| paths(&p.trails));
        let of_tags = parts.tags.as_ref().map_or_else(Vec::new, |t| paths(&t.trails));
        let metrics = parts
            .robots
            .iter()
            .zip(&vehicles)
            .map(|(r, v)| {
                let by_hand = r.teleoperator.as_ref().map(|t| &t.path);
                let path = by_hand.or(r.path.as_ref());
                let by_tags = r.navigator.settings().method == Method::Tags;
                let trails = if by_tags { &of_tags } else { &of_server };
                let paths = path.map_or_else(|| trails.clone(), |path| vec![path.clone()]);
                let approach_m = r.navigator.settings().approach_m;
                let sides = r.path.as_ref().map(|path| sides::Sides::new(path, approach_m));
                RobotMetrics::new(v.body, r.start, paths, sides)
            })
            .collect();
        let devices = Devices::new(&parts.devices);
        let judge = Judge::new(&parts.success);
        Ok(Self {
            mission,
            seed,
            steps: 0,
            world,
            n_initial_things,
            vehicles,
            decision,
            devices,
            metrics,
            judge,
            verdict: None,
            next_event: 0,
            halted_at: None,
            waiting_goals: VecDeque::new(),
            others_moved_m: 0.0,
            interventions: Vec::new(),
            log: VecDeque::new(),
            trace: VecDeque::new(),
            trace_on: false,
        })
    }

    /// The mission.
    pub fn mission(&self) -> &Mission {
        &self.mission
    }

    /// The seed.
    pub fn seed(&self) -> RunSeed {
        self.seed
    }

    /// Steps taken.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// Virtual time since the beginning.
    pub fn now(&self) -> Stamp {
        Stamp::from_millis(self.steps * 10)
    }

    /// The verdict, once it is certain; it does not change any more.
    pub fn finished(&self) -> Option<&Verdict> {
        self.verdict.as_ref()
    }

    /// Advances by [`STEP`]. A run may go on after its verdict; the verdict stays.
    ///
    /// Does not allocate while nothing is logged or traced.
    pub fn step(&mut self) {
        let now = self.now();
        self.happen(now);
        self.devices.sense(now, self.steps, &self.world);
        self.decide(now);
        self.run_vehicles(now);
        self.world.step();
        self.steps += 1;
        self.observe();
        if self.verdict.is_none() && self.halted_at.is_none() {
            self.judge_step();
        }
    }

    /// Steps until the verdict is certain, which the mission's greatest duration bounds, and on until
    /// every robot stands; see [`Run::step_to_end`].
    pub fn run_to_end(&mut self) -> &Verdict {
        while self.step_to_end() {}
        // The loop ends only with a verdict.
        self.verdict.get_or_insert_with(|| Verdict::from_checks(Vec::new()))
    }

    /// Takes the next step of a run that is to come to an end; `false` when there is none to take.
    ///
    /// Until the verdict that is [`Run::step`], then [`Run::step_to_rest`]: the verdict does not change
    /// any more, but no run ends with turning wheels.
    pub fn step_to_end(&mut self) -> bool {
        if self.verdict.is_none() {
            self.step();
            return true;
        }
        self.step_to_rest()
    }

    /// Takes the next step of a run that is to stop now, with a verdict or without: at first every robot
    /// is told to stand, which is recorded ([`Intervention::Halt`]). `false` when all of them stand, or
    /// when it is in vain, after 30 s or, when a robot elsewhere is not heard, 4 s: the log says so.
    ///
    /// Where a robot is elsewhere, step it in real time.
    pub fn step_to_rest(&mut self) -> bool {
        if self.n_rolling() == 0 {
            return false;
        }
        if self.halted_at.is_none() {
            // Nothing about it can be refused.
            let _accepted = self.apply(Intervention::Halt);
        }
        let halted_at = self.halted_at.unwrap_or(self.steps);
        let rolls = |vehicle: &Vehicle| vehicle.stands(&self.world) == Some(false);
        let any_rolls = self.vehicles.iter().any(rolls);
        let n_steps_max = if any_rolls { HALT_STEPS_MAX } else { UNKNOWN_STEPS_MAX };
        if self.steps - halted_at < n_steps_max {
            self.step();
            return true;
        }
        self.say_who_rolls();
        false
    }

    /// Tells robots elsewhere to stand, now: for whoever is about to call [`Run::step`] no more, or not for
    /// a while. They go on with their task at the next step; simulated ones stand while time does.
    pub fn hold_robots_elsewhere(&mut self) {
        self.vehicles.iter_mut().for_each(Vehicle::hold);
    }

    /// How many robots do not stand, or are not known to.
    fn n_rolling(&self) -> usize {
        let stands = |vehicle: &&Vehicle| vehicle.stands(&self.world) != Some(true);
        self.vehicles.iter().filter(stands).count()
    }

    fn say_who_rolls(&mut self) {
        for i in 0..self.vehicles.len().min(N_REPORTED_MAX) {
            let known = self.vehicles[i].stands(&self.world);
            let text = match known {
                Some(true) => continue,
                Some(false) => "still rolls, long after it was told to stand",
                None => "does not answer: whether it stands is not known",
            };
            let text = format!("{} {text}", self.vehicles[i].name);
            self.note(LogLevel::Bad, text);
        }
    }

    /// Interferes before the next step; what is accepted is recorded for replays.
    ///
    /// # Errors
    ///
    /// [`InterventionError`] when it cannot be done; nothing has changed then.
    pub fn apply(&mut self, intervention: Intervention) -> Result<(), InterventionError> {
        self.interfere(&intervention)?;
        self.interventions.push(RecordedIntervention { step: self.steps, intervention });
        Ok(())
    }

    /// The accepted interventions, in order.
    pub fn interventions(&self) -> &[RecordedIntervention] {
        &self.interventions
    }

    /// What each part of each robot's mind says that it is about, in order: the robot, the part, a sentence.
    pub fn minds(&self) -> impl Iterator<Item = (&str, &'static str, String)> {
        self.vehicles.iter().flat_map(|vehicle| {
            let parts = vehicle.navigator().says().parts();
            parts.map(|(part, sentence)| (vehicle.name.as_str(), part, sentence.to_string()))
        })
    }

    /// Every robot in brief, in order. Does not allocate.
    pub fn poses(&self) -> impl Iterator<Item = ViewPose> {
        self.vehicles.iter().map(|vehicle| {
            let body = vehicle.body.map(|id| self.world.body(id));
            let estimate = || vehicle.navigator().view().map_from_base.se2();
            ViewPose {
                truth: body.map_or_else(estimate, |b| b.world_from_base.se2()).into(),
                touching: body.is_some_and(|b| b.touching),
                arrived: vehicle.has_arrived(),
            }
        })
    }

    /// The resources that the decision program names and the outputs of its timers, with their bytes,
    /// always in the same order; nothing without a program. Does not allocate.
    pub fn decision_resources(&self) -> impl Iterator<Item = (&str, u8)> {
        self.decision.iter().flat_map(DecisionNode::resources)
    }

    /// What each robot reported and measured during the last step, in the robots' order. Does not
    /// allocate.
    pub fn sensed(&self) -> impl Iterator<Item = SensedStep<'_>> {
        self.vehicles.iter().map(Vehicle::sensed)
    }

    /// Switches the collection of decoded packets on or off; it is off at first.
    pub fn set_trace(&mut self, on: bool) {
        self.trace_on = on;
        for vehicle in self.vehicles.iter_mut().take(N_REPORTED_MAX) {
            vehicle.set_trace(on);
        }
        self.trace.clear();
    }

    /// Takes the decoded packets since the last call, oldest first; at most 4000 are kept.
    pub fn drain_trace(&mut self) -> Vec<TraceItem> {
        self.trace.drain(..).collect()
    }

    /// Takes the log entries since the last call, oldest first; at most 2000 are kept.
    pub fn drain_log(&mut self) -> Vec<LogItem> {
        self.log.drain(..).collect()
    }

    /// Hash of the state that can be seen: world, what the robots' sensors returned so far, robots' reports
    /// and phases, decision node, devices. What hides in links and memories shows in it as soon as it has an effect. Cost: linear in robots, people and things.
    pub fn state_hash(&self) -> StateHash {
        let mut hash = StateHash::new();
        hash.absorb_u64(self.steps);
        self.world.absorb_state(&mut hash);
        for vehicle in &self.vehicles {
            vehicle.absorb_state(&mut hash);
        }
        if let Some(decision) = &self.decision {
            decision.absorb_state(&mut hash);
        }
        self.devices.absorb_state(&mut hash);
        hash
    }

    /// What the mission planned for now.
    fn happen(&mut self, now: Stamp) {
        if self.halted_at.is_some() {
            return;
        }
        while let Some(event) = self.mission.parts().events.get(self.next_event) {
            if event.at > now {
                break;
            }
            let event = event.clone();
            self.next_event += 1;
            match event.action {
                Action::Goal { robots, pose } if event.after_arrival => {
                    self.waiting_goals.extend(robots.into_iter().map(|robot| (robot, pose)));
                }
                action => self.act(action),
            }
        }
        self.send_waiting_goals();
    }

    /// The next goal of every robot that has reached the one before.
    fn send_waiting_goals(&mut self) {
        let mut i = 0;
        while let Some(&(robot, pose)) = self.waiting_goals.get(i) {
            // A robot that has just been sent somewhere has not arrived there yet.
            if self.vehicles.get(robot).is_some_and(Vehicle::has_arrived) {
                self.waiting_goals.remove(i);
                self.send_goal(robot, pose);
            } else {
                i += 1;
            }
        }
    }

    fn act(&mut self, action: Action) {
        match action {
            Action::Button { device, pressed } => {
                self.devices.hold(device, pressed);
                let label = self.devices.label(device).to_owned();
                let text = if pressed { "is pressed" } else { "is released" };
                self.note(LogLevel::Info, format!("{label} {text}"));
            }
            Action::Goal { robots, pose } => {
                for robot in robots {
                    self.send_goal(robot, pose);
                }
            }
            Action::Link { robots, line, direction, cut } => {
                for robot in robots {
                    self.set_cut(robot, line, direction, cut);
                }
            }
            Action::Program(action) => {
                let Some(decision) = &mut self.decision else { return };
                decision.act(action);
                self.note(LogLevel::Warn, action.to_string());
            }
            Action::Ask { robots, asked } => {
                for robot in robots {
                    self.ask(robot, asked);
                }
            }
            Action::Stop { robots } => robots.into_iter().for_each(|robot| self.send_stop(robot)),
            Action::PlaceBox { name, at, size_m } => {
                if let Err(error) = self.put_box(&name, at, size_m) {
                    self.note(LogLevel::Warn, error.to_string());
                }
            }
            Action::Remove { name } => {
                let found = self.world.thing_by_name(&name);
                let done = found.is_some_and(|id| self.world.remove_thing(id));
                let text = if done { "is taken away" } else { "is not there any more" };
                self.note(LogLevel::Info, format!("{name} {text}"));
            }
        }
    }

    fn send_goal(&mut self, robot: usize, pose: GoalPose) {
        let goal = pose.resolve(self.mission.parts().robots[robot].start);
        self.vehicles[robot].order(GroundOrder::GoTo(goal), OrderBy::Person);
        self.metrics[robot].goal_given(self.steps, Some(goal));
        if self.vehicles.len() < PARALLEL_FROM {
            let name = self.vehicles[robot].name.clone();
            self.note(LogLevel::Info, format!("goal for {name}: {}", words(goal)));
        }
    }

    fn ask(&mut self, robot: usize, asked: Asked) {
        let now = self.now();
        self.vehicles[robot].ask(asked, now);
        let text = format!("{}: {}", self.vehicles[robot].name, asked.done());
        self.note(LogLevel::Info, text);
    }

    fn send_stop(&mut self, robot: usize) {
        self.vehicles[robot].order(GroundOrder::Stop, OrderBy::Person);
        let name = self.vehicles[robot].name.clone();
        self.note(LogLevel::Warn, format!("{name} is told to stop"));
    }

    fn set_cut(&mut self, robot: usize, line: Line, direction: Direction, cut: bool) {
        self.vehicles[robot].set_cut(line, direction, cut);
        if cut {
            self.metrics[robot].line_cut();
        }
        if robot < N_REPORTED_MAX {
            let (name, what) = (&self.vehicles[robot].name, line.describe(direction));
            let (level, done) =
                if cut { (LogLevel::Warn, "is cut") } else { (LogLevel::Info, "is mended") };
            let text = format!("{name}: {what} {done}");
            self.note(level, text);
        }
    }

    fn interfere(&mut self, intervention: &Intervention) -> Result<(), InterventionError> {
        if self.halted_at.is_some() {
            return Err(InterventionError::Halted);
        }
        let n_robots = self.vehicles.len();
        let check = |robot: usize| {
            let known = (robot < n_robots).then_some(());
            known.ok_or(InterventionError::NoSuchRobot { robot, n_robots })
        };
        match intervention {
            Intervention::PressButton { device } => {
                let index = self.devices.button(device)?;
                self.devices.press(index, self.steps + PRESS_STEPS);
                let label = self.devices.label(index).to_owned();
                self.note(LogLevel::Info, format!("{label} is pressed"));
            }
            Intervention::PlaceBox { at, size_m } => {
                self.put_box("box", *at, *size_m)?;
            }
            Intervention::RemoveThing { id } => {
                let removable = *id >= self.n_initial_things;
                if !removable || !self.world.remove_thing(ThingId(*id)) {
                    return Err(InterventionError::NoSuchThing { id: *id });
                }
                self.note(LogLevel::Info, "a box is taken away".to_owned());
            }
            Intervention::SendGoal { robot, goal_in_map } => {
                check(*robot)?;
                let Se2 { x_m, y_m, yaw_rad } = *goal_in_map;
                if !(x_m.abs() <= 32.0 && y_m.abs() <= 32.0 && yaw_rad.is_finite()) {
                    let what = "the goal's coordinates";
                    return Err(InterventionError::OutOfRange { what, allowed: "within 32 m" });
                }
                self.send_goal(*robot, GoalPose::InMap(*goal_in_map));
            }
            Intervention::Stop { robot } => {
                check(*robot)?;
                self.send_stop(*robot);
            }
            Intervention::Drive { robot, speed_mps, turn_rate_radps } => {
                check(*robot)?;
                if !(speed_mps.is_finite() && turn_rate_radps.is_finite()) {
                    let what = "a speed by hand";
                    return Err(InterventionError::OutOfRange { what, allowed: "a number" });
                }
                let [linear_mps, angular_radps] =
                    [*speed_mps, *turn_rate_radps].map(to_thousandths);
                let model = &self.mission.parts().robots[*robot].model;
                let wheels = hand::wheels(model, BodyVelocity { linear_mps, angular_radps });
                let now = self.now();
                self.vehicles[*robot].drive_by_hand(now, wheels);
            }
            &Intervention::CutLink { robot, line, direction } => {
                check(robot)?;
                self.check_line(robot, line)?;
                self.set_cut(robot, line, direction, true);
            }
            &Intervention::RestoreLink { robot, line, direction } => {
                check(robot)?;
                self.check_line(robot, line)?;
                self.set_cut(robot, line, direction, false);
            }
            Intervention::Halt => {
                self.halted_at = Some(self.steps);
                self.vehicles.iter_mut().for_each(Vehicle::halt);
                self.note(LogLevel::Info, "every robot is told to stand".to_owned());
            }
        }
        Ok(())
    }

    fn check_line(&self, robot: usize, line: Line) -> Result<(), InterventionError> {
        if self.vehicles[robot].line(line).is_some() {
            return Ok(());
        }
        let robot = self.vehicles[robot].name.clone();
        Err(match line {
            Line::Laser(number) => InterventionError::NoSuchLaser { robot, number },
            _ => InterventionError::NoSuchLine { robot },
        })
    }

    fn put_box(
        &mut self,
        name: &str,
        at: geometry::Vec2,
        size_m: f64,
    ) -> Result<(), InterventionError> {
        let n_put_down =
            self.world.things().iter().filter(|thing| thing.id.0 >= self.n_initial_things).count();
        if n_put_down >= N_BOXES_MAX {
            let what = "the number of boxes that were put down";
            return Err(InterventionError::OutOfRange { what, allowed: "at most 200" });
        }
        build::place_box(&mut self.world, name, at, size_m)?;
        self.metrics.iter_mut().for_each(RobotMetrics::forget_clearance);
        let text = format!("a box of {size_m:.2} m is put down at ({:.2}, {:.2}) m", at.x, at.y);
        self.note(LogLevel::Info, text);
        Ok(())
    }

    fn decide(&mut self, now: Stamp) {
        let halted = self.halted_at.is_some();
        let Some(decision) = self.decision.as_mut().filter(|_| !halted) else { return };
        let robot = decision.robot();
        let told = robot.and_then(|r| self.vehicles[r].program_move());
        let (log, steps) = (&mut self.log, self.steps);
        let (vehicles, metrics) = (&mut self.vehicles, &mut self.metrics);
        decision.step(&self.devices, told, |request| match request {
            Request::Tell(level, text) => push_log(log, LogItem { step: steps, level, text }),
            Request::Move(number, goal) => {
                let text = format!("MOVE {number} to {} sent by the decision program", words(goal));
                push_log(log, LogItem { step: steps, level: LogLevel::Info, text });
                if let Some(robot) = robot {
                    vehicles[robot].order(GroundOrder::GoTo(goal), OrderBy::Program(number));
                    metrics[robot].goal_given(steps, Some(goal));
                }
            }
            Request::StopRobot => {
                let Some(vehicle) = robot.map(|r| &mut vehicles[r]) else { return };
                if vehicle.is_on_program_move() {
                    vehicle.order(GroundOrder::Stop, OrderBy::Failsafe);
                    let text = format!("{} is told to stop with the program", vehicle.name);
                    push_log(log, LogItem { step: steps, level: LogLevel::Warn, text });
                }
            }
        });
        self.drive_devices(now);
    }

    fn drive_devices(&mut self, now: Stamp) {
        let Some(decision) = &self.decision else { return };
        let outputs = decision.machine().outputs();
        let mut changed: u64 = 0;
        self.devices.drive(outputs, now, |index| changed |= 1 << index.min(63));
        for index in (0..64).filter(|i| changed >> i & 1 == 1) {
            let text = self.devices.describe(index);
            self.note(LogLevel::Good, text);
        }
    }

    /// Ends the run for good: the decision program stops and the devices go to their fail-safe values.
    /// The state that was recorded and hashed is the one before.
    pub fn close(&mut self) {
        let now = self.now();
        let Some(decision) = &mut self.decision else { return };
        decision.close();
        self.drive_devices(now);
    }

    fn run_vehicles(&mut self, now: Stamp) {
        let world = &self.world;
        if self.vehicles.len() < PARALLEL_FROM {
            self.vehicles.iter_mut().for_each(|vehicle| vehicle.step(now, world));
        } else {
            // Each robot touches only its own state, so the pieces may run in any order.
            self.vehicles
                .par_chunks_mut(PIECE)
                .for_each(|piece| piece.iter_mut().for_each(|v| v.step(now, world)));
        }
        for vehicle in &self.vehicles {
            vehicle.apply(&mut self.world);
        }
    }

    /// Figures, log and trace after a step.
    fn observe(&mut self) {
        let mut farthest_m = self.farthest_person_m();
        for (vehicle, metrics) in self.vehicles.iter().zip(&mut self.metrics) {
            if let Some(body) = vehicle.body {
                let way_m = metrics.update(self.world.body(body), vehicle.is_following());
                farthest_m = farthest_m.max(way_m);
            } else {
                let reported = vehicle.navigator().view().map_from_base.se2();
                metrics.update_reported(reported, vehicle.is_following());
            }
            if vehicle.sets_off_by_hand() {
                metrics.goal_given(self.steps, None);
            }
            metrics.arrival(vehicle.has_arrived(), self.steps);
        }
        self.others_moved_m += farthest_m;
        self.measure_clearances();
        (0..self.vehicles.len().min(N_REPORTED_MAX)).for_each(|i| self.report(i));
    }

    /// How far the fastest person can have come in one step, m.
    fn farthest_person_m(&self) -> f64 {
        let speeds = self.world.people().iter().map(|p| p.spec.speed_mps);
        speeds.fold(0.0, f64::max) * STEP.as_secs_f64()
    }

    /// Every robot's least clearance; in swarms each robot's turn comes twice a second.
    fn measure_clearances(&mut self) {
        let (world, others_moved_m, steps) = (&self.world, self.others_moved_m, self.steps);
        let measure = |metrics: &mut RobotMetrics| metrics.measure_clearance(world, others_moved_m);
        if self.vehicles.len() < PARALLEL_FROM {
            self.metrics.iter_mut().for_each(measure);
            return;
        }
        let turn = (steps % SWARM_TURNS) as usize;
        let piece = self.vehicles.len().div_ceil(SWARM_TURNS as usize);
        let first = (turn * piece).min(self.vehicles.len());
        let last = (first + piece).min(self.vehicles.len());
        self.metrics[first..last].par_iter_mut().with_min_len(PIECE).for_each(measure);
    }

    /// News and packets of one robot, for the log and the trace.
    fn report(&mut self, i: usize) {
        while let Some((level, text)) = self.vehicles[i].take_news() {
            self.note(level, text);
        }
        if self.trace_on {
            self.collect_trace(i);
        }
        if self.metrics[i].take_new_contact() {
            let name = self.vehicles[i].name.clone();
            self.note(LogLevel::Bad, format!("{name} touches something"));
        }
    }

    fn collect_trace(&mut self, vehicle: usize) {
        let step = self.steps;
        let trace = &mut self.trace;
        let first: usize = self.vehicles[..vehicle].iter().map(Vehicle::n_lines).sum();
        self.vehicles[vehicle].drain_taps(|line, (to, bytes, text)| {
            if trace.len() >= TRACE_MAX {
                trace.pop_front();
            }
            trace.push_back(TraceItem { step, link: first + line, to, bytes, text });
        });
    }

    fn judge_step(&mut self) {
        let is_over = self.now() >= self.mission.end();
        let machine = self.decision.as_ref().map(DecisionNode::machine);
        let n_moves = self.decision.as_ref().map_or(0, DecisionNode::n_moves_sent);
        let facts = judge::Facts {
            now: self.now(),
            is_over,
            n_moves,
            n_events: machine.map_or(0, decision::Machine::n_events),
            n_watchdog_resets: machine.map_or(0, decision::Machine::n_watchdog_resets),
            vehicles: &self.vehicles,
            metrics: &self.metrics,
            devices: &self.devices,
            robots: &self.mission.parts().robots,
            world: &self.world,
        };
        if let Some(verdict) = self.judge.step(&facts) {
            let level = if verdict.passed { LogLevel::Good } else { LogLevel::Bad };
            let text = if verdict.passed { "passed: " } else { "" };
            self.note(level, format!("{text}{}", verdict.text));
            self.verdict = Some(verdict);
        }
    }

    fn note(&mut self, level: LogLevel, text: String) {
        push_log(&mut self.log, LogItem { step: self.steps, level, text });
    }
}

/// Appends to a log of bounded length.
fn push_log(log: &mut VecDeque<LogItem>, item: LogItem) {
    if log.len() >= LOG_MAX {
        log.pop_front();
    }
    log.push_back(item);
}

/// A pose for people.
fn words(pose: Se2) -> String {
    format!("({:.2}, {:.2}) m, {:.0}°", pose.x_m, pose.y_m, pose.yaw_rad.to_degrees())
}
