//! The smart environment: buttons and motion detectors in, latches and lamps out.

use run_context::{Stamp, StateHash};
use simulator::World;

use crate::{
    intervention::InterventionError,
    mission::plan::{DevicePlan, DeviceWiring},
};

/// Every device, with its state.
#[derive(Debug)]
pub(crate) struct Devices {
    devices: Vec<Device>,
}

#[derive(Debug)]
struct Device {
    plan: DevicePlan,
    is_on: bool,
    /// A button pressed by a person is released before this step.
    released_at_step: Option<u64>,
    /// First time it was on.
    first_on: Option<Stamp>,
}

impl Devices {
    pub(crate) fn new(plans: &[DevicePlan]) -> Self {
        let device = |plan: &DevicePlan| Device {
            plan: plan.clone(),
            is_on: false,
            released_at_step: None,
            first_on: None,
        };
        Self { devices: plans.iter().map(device).collect() }
    }

    /// Reads the detectors, releases buttons whose time is up.
    pub(crate) fn sense(&mut self, now: Stamp, step: u64, world: &World) {
        for device in &mut self.devices {
            match &device.plan.wiring {
                DeviceWiring::Button { .. } => {
                    if device.released_at_step.is_some_and(|end| step >= end) {
                        device.is_on = false;
                        device.released_at_step = None;
                    }
                }
                // A passive infrared detector sees warm things that move: people, not robots.
                DeviceWiring::Motion { zone, .. } => device.is_on = world.motion_in(zone),
                DeviceWiring::Latch { .. } | DeviceWiring::Lamp { .. } => {}
            }
            if device.is_on && device.first_on.is_none() {
                device.first_on = Some(now);
            }
        }
    }

    /// Digital inputs as the wiring has them: (number, value).
    pub(crate) fn inputs(&self) -> impl Iterator<Item = (u8, bool)> + '_ {
        self.devices.iter().filter_map(|d| match d.plan.wiring {
            DeviceWiring::Button { input } | DeviceWiring::Motion { input, .. } => {
                input.map(|n| (n, d.is_on))
            }
            DeviceWiring::Latch { .. } | DeviceWiring::Lamp { .. } => None,
        })
    }

    /// Drives the actuators from the decision node's outputs; `changed` hears the index of each that
    /// was switched.
    pub(crate) fn drive(&mut self, outputs: u16, now: Stamp, mut changed: impl FnMut(usize)) {
        for (index, device) in self.devices.iter_mut().enumerate() {
            let (DeviceWiring::Latch { output, .. } | DeviceWiring::Lamp { output, .. }) =
                device.plan.wiring
            else {
                continue;
            };
            let is_on = outputs >> output & 1 == 1;
            if is_on != device.is_on {
                device.is_on = is_on;
                changed(index);
            }
            if is_on && device.first_on.is_none() {
                device.first_on = Some(now);
            }
        }
    }

    /// Presses or releases a button until told otherwise.
    pub(crate) fn hold(&mut self, index: usize, pressed: bool) {
        self.devices[index].is_on = pressed;
        self.devices[index].released_at_step = None;
    }

    /// Presses a button; it is released before the step `until_step`.
    pub(crate) fn press(&mut self, index: usize, until_step: u64) {
        self.devices[index].is_on = true;
        self.devices[index].released_at_step = Some(until_step);
    }

    /// The index of a button by its name.
    pub(crate) fn button(&self, name: &str) -> Result<usize, InterventionError> {
        let is_button = |d: &Device| matches!(d.plan.wiring, DeviceWiring::Button { .. });
        let found = self.devices.iter().position(|d| is_button(d) && d.plan.name == name);
        found.ok_or_else(|| {
            let buttons: Vec<&str> = self
                .devices
                .iter()
                .filter(|d| is_button(d))
                .map(|d| d.plan.name.as_str())
                .collect();
            InterventionError::NoSuchButton { device: name.to_owned(), buttons: buttons.join(", ") }
        })
    }

    pub(crate) fn label(&self, index: usize) -> &str {
        &self.devices[index].plan.label
    }

    /// What an actuator does now, in words.
    pub(crate) fn describe(&self, index: usize) -> String {
        let device = &self.devices[index];
        let text = match (&device.plan.wiring, device.is_on) {
            (DeviceWiring::Latch { .. }, true) => "opens",
            (DeviceWiring::Latch { .. }, false) => "closes",
            (_, true) => "is switched on",
            (_, false) => "is switched off",
        };
        format!("{} {text}", device.plan.label)
    }

    /// When a device was on for the first time.
    pub(crate) fn first_on(&self, index: usize) -> Option<Stamp> {
        self.devices[index].first_on
    }

    pub(crate) fn is_on(&self) -> impl Iterator<Item = bool> + '_ {
        self.devices.iter().map(|d| d.is_on)
    }

    pub(crate) fn absorb_state(&self, hash: &mut StateHash) {
        for device in &self.devices {
            hash.absorb_u64(u64::from(device.is_on));
        }
    }
}
