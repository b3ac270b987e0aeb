//! The ground station at the far end of a line: it says what lies on the desk, and writes there what it hears.

use drivers::{GroundClient, GroundLinkConfig, GroundStation};
use geometry::Se2;
use run_context::RunSeed;
use wire::ground_link::ToVehicle;

use super::{
    desk::{Desk, GroundOrder},
    direct_ground::DirectGround,
};
use crate::{
    cut::Line as Which,
    mission::{Mission, plan::LinkPlan},
    run::{
        error::RunError,
        line::{Around, Far, Line, LineName, Pipe},
    },
};

#[derive(Debug)]
struct Station(GroundStation);

impl Far for Station {
    fn step(&mut self, around: &mut Around<'_>, received: &[u8], out: &mut Vec<u8>) {
        let now = around.now;
        let Desk { order, question, telemetry, events } = &mut *around.desk;
        match order.take() {
            Some(GroundOrder::GoTo(pose)) => {
                self.0.go_to(now, on_the_wire(pose), out);
            }
            Some(GroundOrder::Stop) => self.0.send(now, ToVehicle::Stop, out),
            Some(GroundOrder::Restart) => self.0.send(now, ToVehicle::Restart, out),
            None => {}
        }
        if let Some(asked) = question.take() {
            self.0.send(now, asked.message(), out);
        }
        self.0.step(now, received, events, out);
        for event in &*events {
            telemetry.hear(*event);
        }
    }
}

/// A goal as the ground link sends it: whole millimetres and degrees.
fn on_the_wire(pose: Se2) -> [i16; 3] {
    // Casts from floats saturate.
    [1000.0 * pose.x_m, 1000.0 * pose.y_m, pose.yaw_rad.to_degrees()].map(|v| v.round() as i16)
}

/// The line to the ground: of the decision node that is wired to the robot, else of a ground station, which is a
/// radio modem, or direct where the robot's own line is. The ground waits as long for the robot's answers as the
/// decision node's plan says, and as the way there and back takes.
pub(super) fn line(mission: &Mission, index: usize, seed: RunSeed) -> Result<Line, RunError> {
    let parts = mission.parts();
    let robot = &parts.robots[index];
    let decides = parts.decision.as_ref().filter(|d| d.robot == Some(index));
    let plan = match (decides, &robot.link) {
        (Some(decides), _) => decides.link.clone(),
        (None, LinkPlan::Direct) => LinkPlan::Direct,
        (None, _) => super::pipe::modem(),
    };
    let answer_within = decides.map(|d| d.answer_within);
    let mut timing = GroundLinkConfig::default();
    let pipe = if let LinkPlan::Memory(config) = &plan {
        if let Some(within) = answer_within {
            timing.retry_period = within / timing.n_tries;
        }
        timing.retry_period += 2 * (config.latency + config.jitter);
        let (near, far) = (GroundClient::new(timing.clone()), Station(GroundStation::new(timing)));
        let stream = format!("link/{}/ground", robot.name);
        super::pipe::wired(config, (&robot.name, &stream, seed), Box::new(near), Box::new(far))?
    } else {
        let within = answer_within.unwrap_or(timing.retry_period * timing.n_tries);
        Pipe::Direct(Box::new(DirectGround::new(within)))
    };
    let named = LineName {
        which: Which::Ground,
        name: "ground".to_owned(),
        far: "decision",
        protocol: Some("ground_link".to_owned()),
        baud: plan.baud(),
    };
    Ok(Line::new(named, pipe))
}
