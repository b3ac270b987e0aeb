//! Which sonars fire when, and what they heard since the last information packet.

use robot_models::RingTiming;
use run_context::Stamp;
use sensor_models::FiringSchedule;
use wire::arcos::SonarReading;

/// The information packet has flags for so many arrays.
const N_FLAGS: usize = 4;

#[derive(Clone, Debug)]
pub(super) struct SonarRing {
    schedule: FiringSchedule,
    timing: RingTiming,
    /// What each array fires, in its order.
    orders: Vec<Vec<usize>>,
    enabled: Vec<bool>,
    n_sensors: usize,
    fresh: Vec<SonarReading>,
}

impl SonarRing {
    /// Arrays as long as `timing` says; each fires one sensor at a time.
    pub(super) fn new(n_sensors: usize, timing: RingTiming, on: bool) -> Self {
        let sensors: Vec<usize> = (0..n_sensors).collect();
        let timing = RingTiming { chain_len: timing.chain_len.max(1), ..timing };
        let orders: Vec<Vec<usize>> =
            sensors.chunks(timing.chain_len).map(<[usize]>::to_vec).collect();
        Self {
            schedule: FiringSchedule::new(orders.clone(), timing.ping_period),
            timing,
            enabled: vec![on; orders.len()],
            orders,
            n_sensors,
            fresh: Vec::with_capacity(n_sensors),
        }
    }

    /// SONAR: bit 0 on or off, the bits above it one array's number, or 0 for all.
    pub(super) fn switch(&mut self, argument: i16) {
        let on = argument & 1 != 0;
        match usize::try_from(argument >> 1) {
            Ok(0) => self.enabled.fill(on),
            Ok(array) => {
                if let Some(enabled) = self.enabled.get_mut(array - 1) {
                    *enabled = on;
                }
            }
            Err(_) => {}
        }
    }

    /// POLLING: sensors fire in this order, numbered from 1. Arrays of which no sensor is named go
    /// on as they were; sensors not named in an array that is do not fire; numbers the robot does
    /// not have are passed over. An empty order switches all sonars off, until SONAR.
    pub(super) fn set_order(&mut self, numbers: &[u8]) {
        if numbers.is_empty() {
            self.enabled.fill(false);
            return;
        }
        let sensors = || {
            let known = |&number: &u8| usize::from(number).checked_sub(1);
            numbers.iter().filter_map(known).filter(|&sensor| sensor < self.n_sensors)
        };
        let array = |sensor: usize| sensor / self.timing.chain_len;
        let mut orders = self.orders.clone();
        sensors().for_each(|sensor| orders[array(sensor)].clear());
        sensors().for_each(|sensor| orders[array(sensor)].push(sensor));
        self.schedule = FiringSchedule::new(orders.clone(), self.timing.ping_period);
        self.orders = orders;
    }

    /// Fires the sensors that are due after `before`, up to `now`.
    pub(super) fn fire(&mut self, before: Stamp, now: Stamp, ping: &mut dyn FnMut(usize) -> f64) {
        for firing in self.schedule.due(before, now) {
            let sensor_index = firing.sensor_index;
            let array = sensor_index / self.timing.chain_len;
            let enabled = self.enabled.get(array).copied().unwrap_or(false);
            let Ok(sensor) = u8::try_from(sensor_index) else { continue };
            if !enabled {
                continue;
            }
            // A cast from a float saturates.
            let range_mm = (1000.0 * ping(sensor_index)).round() as u16;
            let reading = SonarReading { sensor, range_mm };
            match self.fresh.iter_mut().find(|known| known.sensor == sensor) {
                Some(known) => *known = reading,
                None => self.fresh.push(reading),
            }
        }
    }

    /// Readings not yet sent, at most one of each sensor, the oldest first.
    pub(super) fn fresh(&self) -> &[SonarReading] {
        &self.fresh
    }

    /// The first `n_sent` readings were sent.
    pub(super) fn forget_fresh(&mut self, n_sent: usize) {
        self.fresh.drain(..n_sent.min(self.fresh.len()));
    }

    pub(super) fn forget_all(&mut self) {
        self.fresh.clear();
    }

    /// Bit i: array i is on and exists.
    pub(super) fn enabled_bits(&self) -> u16 {
        let arrays = self.enabled.iter().take(N_FLAGS).enumerate();
        arrays.fold(0, |bits, (index, &on)| bits | (u16::from(on) << index))
    }
}
