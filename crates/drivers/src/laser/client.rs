//! A laser's driver as every driver is: scans are observations, troubles are told by name.

use std::collections::VecDeque;

use messages::{DeviceId, Observations};
use run_context::Stamp;
use sensor_models::LaserKind;

use super::{LaserDriver, LaserDriverConfig, LaserNews, laser_driver};
use crate::{Driver, Trouble};

/// Troubles that wait to be fetched; older ones are dropped first.
const N_TROUBLES_MAX: usize = 8;

/// A laser as one device of a robot.
///
/// A scan becomes an observation of the time at which its first beam was fired; one that cannot be believed, of a laser
/// that repeats itself for ever, becomes none: what is not seen is not free.
#[derive(Debug)]
pub struct LaserClient {
    driver: Box<dyn LaserDriver>,
    device: DeviceId,
    name: String,
    title: &'static str,
    is_heard: bool,
    troubles: VecDeque<Trouble>,
    n_scans: u64,
}

impl LaserClient {
    /// The driver of a laser of that kind, which is the robot's `device`.
    pub fn new(kind: LaserKind, device: DeviceId, config: LaserDriverConfig) -> Self {
        Self {
            name: config.name.clone(),
            driver: laser_driver(kind, config),
            device,
            title: kind.title(),
            is_heard: false,
            troubles: VecDeque::new(),
            n_scans: 0,
        }
    }

    /// Scans that were handed on so far.
    pub fn n_scans(&self) -> u64 {
        self.n_scans
    }
}

impl Driver for LaserClient {
    /// Does not allocate while nothing is wrong, once it has had its longest scan.
    fn step(
        &mut self,
        now: Stamp,
        received: &[u8],
        observations: &mut Observations,
        out: &mut Vec<u8>,
    ) {
        let Self { driver, device, name, title, is_heard, troubles, n_scans } = self;
        let mut tell = |is_over, text| {
            if troubles.len() >= N_TROUBLES_MAX {
                troubles.pop_front();
            }
            troubles.push_back(Trouble { is_over, text });
        };
        let mut take = |news: LaserNews<'_>| match news {
            LaserNews::Scan(scan) => {
                *n_scans = n_scans.saturating_add(1);
                observations.push_scan(*device, scan);
            }
            LaserNews::Trouble(trouble) => tell(false, trouble.to_string()),
            LaserNews::Well => tell(true, format!("laser `{name}` ({title}) sends scans again")),
        };
        driver.step(now, received, &mut take, out);
        *is_heard = driver.latest(now).is_some();
    }

    fn disconnect(&mut self, _now: Stamp, out: &mut Vec<u8>) {
        self.driver.disconnect(out);
    }

    fn is_connected(&self) -> bool {
        self.is_heard
    }

    fn wanted_baud(&self) -> Option<u32> {
        self.driver.wanted_baud()
    }

    fn take_trouble(&mut self) -> Option<Trouble> {
        self.troubles.pop_front()
    }
}
