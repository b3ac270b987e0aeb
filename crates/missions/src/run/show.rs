//! The changing part of what a run shows, and its figures.

use super::{
    Run,
    limits::N_SONARS_SHOWN,
    metrics::RobotMetrics,
    scene,
    signals::{self, RobotNow},
    vehicle::Vehicle,
};
use crate::{
    cut::Line as Which,
    node::decision::DecisionNode,
    summary::{Figure, Summary},
    view::{Pose, ViewDecision, ViewFigures, ViewPerson, ViewRobot, ViewState, ViewTimer},
};

impl Run {
    /// What changes.
    pub fn view(&self) -> ViewState {
        view(self, self.vehicles.len())
    }

    /// What changes, with no more than the first `n_robots` robots: a view of a swarm takes longer than its
    /// step. [`Run::poses`] has the rest.
    pub fn view_of_first(&self, n_robots: usize) -> ViewState {
        view(self, n_robots)
    }

    /// The run in figures.
    pub fn summary(&self) -> Summary {
        summary(self)
    }
}

/// What changes, as of now, with the first `n_robots` robots.
fn view(run: &Run, n_robots: usize) -> ViewState {
    let person = |p: &simulator::Person| ViewPerson {
        name: p.spec.name.clone(),
        at: Pose {
            x_m: p.position.x,
            y_m: p.position.y,
            yaw_rad: geometry::wrap_to_pi(p.heading.y.atan2(p.heading.x)),
        },
        radius_m: p.spec.radius_m,
    };
    let added = run.world.things().iter().filter(|t| t.id.0 >= run.n_initial_things);
    let mut view = ViewState {
        t_s: run.now().as_secs_f64(),
        step: run.steps,
        verdict: run.verdict.clone(),
        robots: run
            .vehicles
            .iter()
            .zip(&run.metrics)
            .take(n_robots)
            .map(|(v, m)| robot(run, v, m))
            .collect(),
        people: run.world.people().iter().map(person).collect(),
        things: added.map(|t| scene::thing(t, true)).collect(),
        devices_on: run.devices.is_on().collect(),
        decision: run.decision.as_ref().map(decision),
        figures: figures(run),
        signals: Vec::new(),
    };
    view.signals = signals::of_run(&view);
    view
}

fn robot(run: &Run, vehicle: &Vehicle, metrics: &RobotMetrics) -> ViewRobot {
    let mind = vehicle.navigator().view();
    let shown = |ranges: &[f64], n: usize| ranges[..n.min(N_SONARS_SHOWN)].to_vec();
    let base = vehicle.base();
    let body = vehicle.body.map(|id| run.world.body(id));
    let estimate = mind.map_from_base.se2();
    let wheels = body.map_or_else(|| base.wheel_speeds(), |b| b.wheel_speeds);
    let mut view = ViewRobot {
        truth: body.map_or(estimate, |b| b.world_from_base.se2()).into(),
        estimate: estimate.into(),
        ellipse: [mind.ellipse.semi_major_m, mind.ellipse.semi_minor_m, mind.ellipse.yaw_rad],
        wheels_mps: [wheels.left_mps, wheels.right_mps],
        sonar_m: shown(base.ranges_m(), base.ranges_m().len()),
        scans: vehicle.scans().cloned().collect(),
        bubble_m: shown(&mind.bubble_limits_m, mind.n_sonars),
        phase: vehicle.phase_name(),
        task: vehicle.task(&mind),
        avoider_state: mind.avoider_state,
        avoider_name: mind.avoider_name,
        goal: mind.goal_in_map.map(|g| g.se2().into()),
        target_m: mind.target_in_map,
        preview_m: mind.preview_in_map.to_vec(),
        intensities: mind.intensities.map(|(left, right)| [left, right]),
        cross_track_m: metrics.cross_track_m,
        stalled: body.map_or_else(|| base.is_touched(), |b| b.stalled[0] || b.stalled[1]),
        touching: body.is_some_and(|b| b.touching),
        clearance_m: vehicle.body.map(|id| run.world.clearance_m(id)),
        battery_v: base.battery.map(|battery| battery.voltage_v),
        failure: vehicle.failure(),
        signals: Vec::new(),
    };
    view.signals = signals::of_robot(&RobotNow { view: &view, vehicle, metrics });
    view
}

fn decision(node: &DecisionNode) -> ViewDecision {
    let machine = node.machine();
    let functions = machine.program().functions();
    let timers = machine.timers().filter_map(|t| {
        let total_ms = timer_total_ms(functions, usize::from(t.index))?;
        Some(ViewTimer {
            index: usize::from(t.index),
            remaining_ms: t.remaining.as_millis() as u64,
            total_ms,
            on: t.output,
        })
    });
    ViewDecision {
        scans: node.n_scans(),
        resources: node.resources().map(|(name, byte)| (name.to_owned(), byte)).collect(),
        timers: timers.collect(),
        run: machine.is_running(),
        outputs: machine.outputs(),
        drives_outputs: machine.drives_outputs(),
        fault: machine.fault().map(|fault| fault.code.id()),
        clock: machine.clock().to_string(),
        n_watchdog_resets: machine.n_watchdog_resets(),
        n_events: machine.n_events(),
        last_move: (machine.n_moves(), machine.move_state().name()),
    }
}

/// What a timer of the program is set to, ms.
fn timer_total_ms(functions: &[decision::Function], index: usize) -> Option<u64> {
    let timer = functions.iter().find(|f| f.timer().map(usize::from) == Some(index))?;
    u64::try_from(timer.timer_time()?.as_millis()).ok()
}

fn figures(run: &Run) -> ViewFigures {
    let Some(first) = run.metrics.first() else { return ViewFigures::default() };
    let all_known = run.metrics.iter().all(RobotMetrics::is_simulated);
    ViewFigures {
        path_length_m: Some(first.path_length_m),
        time_s: first.has_goal().then(|| first.under_way_s(run.steps)),
        clearance_min_m: first.clearance_seen_m(),
        contacts: all_known.then(|| run.metrics.iter().map(|m| m.contacts).sum()),
        cross_track_rms_m: first.cross_track_rms_m(),
        cross_track_max_m: first.cross_track_max_m(),
    }
}

/// The run in figures: those of the first robot, and sums over all.
fn summary(run: &Run) -> Summary {
    let mut figures = vec![
        figure("time_s", Some(run.now().as_secs_f64()), "virtual time of the run"),
        figure("robots", Some(run.vehicles.len() as f64), "number of robots"),
    ];
    if let (Some(m), Some(vehicle)) = (run.metrics.first(), run.vehicles.first()) {
        robot_figures(run, m, &mut figures);
        link_figures(run, vehicle, &mut figures);
        if let Some(n_reads) = vehicle.n_tag_reads() {
            figures.push(figure("tag_reads", Some(n_reads as f64), "tags that its readers read"));
        }
    }
    if !run.vehicles.is_empty() {
        let rolling = Some(run.n_rolling() as f64);
        figures.push(figure("rolling_robots", rolling, "robots that do not stand, or may not"));
    }
    if run.vehicles.len() > 1 {
        let arrived = run.vehicles.iter().filter(|v| v.has_arrived()).count();
        figures.push(figure("arrived_robots", Some(arrived as f64), "robots that report arrival"));
    }
    if let Some(decision) = &run.decision {
        let moves = Some(decision.n_moves_sent() as f64);
        figures.push(figure("moves_sent", moves, "MOVE sent by the decision program"));
        let cycle = Some(decision.cycle_max_ms());
        let about =
            "longest scan of the decision node at the thesis's 0.4 ms a function (at most 200)";
        figures.push(figure("decision_cycle_max_ms", cycle, about));
        let image = Some(decision.machine().program().image().len() as f64);
        figures.push(figure("decision_image_bytes", image, "size of the program (at most 4096)"));
        decision_figures(decision, &mut figures);
    }
    Summary {
        mission: run.mission.name().to_owned(),
        seed: run.seed.0,
        steps: run.steps,
        verdict: run.verdict.clone(),
        figures,
        state_hash: run.state_hash().to_string(),
    }
}

fn decision_figures(decision: &DecisionNode, figures: &mut Vec<Figure>) {
    let machine = decision.machine();
    let (resets, events) = (machine.n_watchdog_resets() as f64, machine.n_events() as f64);
    let faults = f64::from(u8::from(machine.fault().is_some()));
    figures.extend([
        figure("decision_watchdog_resets", Some(resets), "restarts by its watchdog (R8004)"),
        figure("decision_faults", Some(faults), "1 if the program stopped with an error (R8…)"),
        figure("decision_events", Some(events), "entries that EVENT wrote into the log"),
        figure(
            "decision_clock_s",
            Some(machine.clock().second_of_day()),
            "time of day on the decision node's clock",
        ),
    ]);
}

/// What is not known, of a robot elsewhere or before an arrival, has no value.
fn robot_figures(run: &Run, m: &RobotMetrics, figures: &mut Vec<Figure>) {
    let arrival_s = m.arrival_step.map(|s| s as f64 * 0.01);
    let all_known = run.metrics.iter().all(RobotMetrics::is_simulated);
    let contacts: u64 = run.metrics.iter().map(|m| m.contacts).sum();
    let clearances = run.metrics.iter().filter_map(RobotMetrics::clearance_seen_m);
    let known = |value: f64| m.is_simulated().then_some(value);
    figures.extend([
        figure("arrival_s", arrival_s, "when the mission's first robot reported arrival"),
        figure("drive_time_s", m.drive_time_s(), "first robot: from its goal to its arrival"),
        figure("path_length_m", Some(m.path_length_m), "first robot: way driven"),
        figure(
            "way_since_cut_m",
            m.way_since_cut_m(),
            "first robot: way after a line was cut, until the next order",
        ),
        figure("contacts", all_known.then_some(contacts as f64), "contacts of all robots"),
        figure(
            "clearance_min_m",
            clearances.reduce(f64::min).filter(|_| all_known),
            "least distance of any robot to anything within 5 m",
        ),
        figure(
            "cross_track_rms_m",
            m.cross_track_rms_m(),
            "first robot: distance from the trail or path while following",
        ),
        figure("cross_track_max_m", m.cross_track_max_m(), "the same, greatest"),
        figure(
            "turn_reversals",
            known(m.n_turn_reversals as f64),
            "first robot: changes of turning direction",
        ),
        figure(
            "turn_rate_rms_radps",
            m.turn_rate_rms_radps(),
            "first robot: turn rate while moving",
        ),
        figure("energy_jpkg", known(m.energy_jpkg), "first robot: work of the wheels per mass"),
    ]);
}

fn link_figures(run: &Run, vehicle: &Vehicle, figures: &mut Vec<Figure>) {
    let busy = |which| vehicle.line(which).and_then(|line| line.busy_ratio(run.now()));
    let [robot, server, ground] = [Which::Robot, Which::Pheromones, Which::Ground].map(busy);
    let traffic = vehicle.traffic();
    let received = traffic.map(|t| t.received_bytes as f64);
    let questions = traffic.map(|t| t.n_questions as f64);
    let errors = traffic.map(|t| t.n_errors as f64);
    // Of a server that the mission has not there is nothing to say.
    let cycle_about = match run.mission.parts().pheromones {
        Some(_) => {
            "first robot: longest dialogue of a control cycle with the pheromone server, as it took on the line (at most 200)"
        }
        None => "first robot: longest dialogue with a pheromone server; the mission has none",
    };
    figures.extend([
        figure("robot_link_ratio", robot, "first robot: busier direction of its link, time used"),
        figure("pheromone_link_ratio", server, "the same of the link to the server"),
        figure("pheromone_received_bytes", received, "characters that the server received"),
        figure("pheromone_questions", questions, "questions that it answered"),
        figure(
            "pheromone_errors",
            errors,
            "frames that it received in vain: broken or no question",
        ),
        figure("ground_link_ratio", ground, "the same of the link to the ground"),
        figure("navigation_cycle_max_ms", vehicle.cycle_max_ms(), cycle_about),
    ]);
}

fn figure(name: &'static str, value: Option<f64>, about: &'static str) -> Figure {
    Figure { name, value, about }
}
