//! How a line is laid, whatever is at its ends.

use std::time::Duration;

use drivers::{Driver, LineTiming};
use run_context::RunSeed;
use wire::link::{Link, LinkConfig};

use crate::{
    mission::plan::LinkPlan,
    run::{
        error::RunError,
        line::{Elsewhere, Far, Pipe, Wired},
    },
    transport::{SerialTransport, TcpTransport, Transport},
};

/// A pipe of bytes whose far end is elsewhere; `None` where that is simulated.
pub(super) fn elsewhere(
    plan: &LinkPlan,
    robot: &str,
    near: impl FnOnce(LineTiming) -> Result<Box<dyn Driver>, RunError>,
) -> Result<Option<Pipe>, RunError> {
    let refuse = |source| RunError::Transport { robot: robot.to_owned(), source };
    let transport: Box<dyn Transport> = match plan {
        LinkPlan::Memory(_) | LinkPlan::Direct => return Ok(None),
        LinkPlan::Tcp { address } => Box::new(TcpTransport::connect(address).map_err(refuse)?),
        LinkPlan::Serial { device, baud } => {
            Box::new(SerialTransport::open(device, *baud).map_err(refuse)?)
        }
    };
    let near = near(LineTiming::default())?;
    Ok(Some(Pipe::Elsewhere(Box::new(Elsewhere::new(transport, near)))))
}

/// A pipe of bytes in virtual time; its faults are drawn from `stream`.
pub(super) fn wired(
    config: &LinkConfig,
    (robot, stream, seed): (&str, &str, RunSeed),
    near: Box<dyn Driver>,
    far: Box<dyn Far>,
) -> Result<Pipe, RunError> {
    let rng = seed.stream(stream);
    let refuse = |problem: String| RunError::Settings { robot: robot.to_owned(), problem };
    let link = Link::new(config, rng).map_err(|e| refuse(e.to_string()))?;
    Ok(Pipe::Memory(Box::new(Wired::new(link, near, far, config.baud))))
}

/// What the bytes' way takes.
pub(super) fn timing(config: &LinkConfig) -> LineTiming {
    LineTiming { baud: config.baud, latency: config.latency }
}

/// A radio modem, over which a ground station speaks where the mission says nothing else.
pub(super) fn modem() -> LinkPlan {
    LinkPlan::Memory(LinkConfig {
        baud: Some(9600),
        latency: Duration::from_millis(5),
        ..LinkConfig::default()
    })
}
