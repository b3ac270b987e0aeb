//! The pheromone server at the far end of a line, or its answers without bytes.

use std::sync::Arc;

use drivers::{PheromoneClient, PheromoneClientConfig};
use geometry::Se2;
use messages::{Command, Observations, Sensed, Smell};
use pheromones::{Field, SenseConfig, Server, ServerConfig};
use run_context::RunSeed;

use crate::{
    cut::{Cuts, Direction, Line as Which},
    mission::{Mission, plan::LinkPlan},
    run::{
        error::RunError,
        line::{Around, Direct, Far, Line, LineName, Pipe, Traffic},
    },
};

/// The server keeps one receiver per radio channel; this is one of them.
#[derive(Debug)]
struct Channel {
    field: Arc<Field>,
    server: Server,
}

impl Far for Channel {
    fn step(&mut self, _around: &mut Around<'_>, received: &[u8], out: &mut Vec<u8>) {
        self.server.receive(&self.field, received, out);
    }

    fn traffic(&self) -> Option<Traffic> {
        let counted = self.server.counters();
        Some(Traffic {
            received_bytes: counted.n_bytes_received,
            n_questions: counted.n_requests,
            n_errors: counted.n_errors(),
        })
    }
}

/// Answers at the next step.
#[derive(Debug)]
struct DirectServer {
    field: Arc<Field>,
    sense: SenseConfig,
    asked: Option<(u8, Se2)>,
    cuts: Cuts,
}

impl Direct for DirectServer {
    fn step(&mut self, around: &mut Around<'_>, observations: &mut Observations) {
        if let Some((query, pose)) = self.asked.take()
            && !self.cuts.any()
        {
            let found = self.field.sense(pose, &self.sense);
            let (left, right) = (found.left, found.right);
            observations.push(around.now, Sensed::Smell(Smell { query, left, right }));
        }
    }

    fn command(&mut self, command: &Command, _desk: &mut super::desk::Desk) {
        if let Command::QueryPheromones { query, map_from_base } = *command {
            self.asked = Some((query, map_from_base.se2()));
        }
    }

    fn set_cut(&mut self, direction: Direction, cut: bool) {
        self.cuts.set(direction, cut);
    }
}

/// The line to the server; `None` when the mission has none.
pub(super) fn line(
    mission: &Mission,
    index: usize,
    seed: RunSeed,
) -> Result<Option<Line>, RunError> {
    let Some(plan) = &mission.parts().pheromones else { return Ok(None) };
    let field = Arc::clone(&plan.field);
    let pipe = if let LinkPlan::Memory(config) = &plan.link {
        let name = &mission.parts().robots[index].name;
        // Robot numbers on the wire go round after 256; every robot has a channel of its own.
        let robot_id = (index % 256) as u8;
        let near = PheromoneClientConfig { robot_id, ..PheromoneClientConfig::default() };
        let server = Server::new(ServerConfig {
            sense: plan.sense,
            scale_ratio: plan.scale_ratio,
            ..ServerConfig::default()
        });
        let (near, far) = (PheromoneClient::new(near), Channel { field, server });
        let stream = format!("link/{name}/pheromones");
        super::pipe::wired(config, (name, &stream, seed), Box::new(near), Box::new(far))?
    } else {
        let (sense, cuts) = (plan.sense, Cuts::default());
        Pipe::Direct(Box::new(DirectServer { field, sense, asked: None, cuts }))
    };
    let named = LineName {
        which: Which::Pheromones,
        name: "pheromones".to_owned(),
        far: "server",
        protocol: Some("pheromone_link".to_owned()),
        baud: plan.link.baud(),
    };
    Ok(Some(Line::new(named, pipe)))
}
