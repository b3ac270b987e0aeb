//! Which sonars fire when, and what they heard since the last information packet.

use run_context::Stamp;
use sensor_models::FiringSchedule;
use wire::arcos::SonarReading;

/// Sensors of one array; each array fires one at a time.
const ARRAY_LEN: usize = 8;

/// The information packet has flags for so many arrays.
const N_ARRAYS_MAX: usize = 4;

#[derive(Clone, Debug)]
pub(super) struct SonarRing {
    schedule: FiringSchedule,
    n_sensors: usize,
    enabled: [bool; N_ARRAYS_MAX],
    fresh: Vec<SonarReading>,
}

impl SonarRing {
    pub(super) fn new(n_sensors: usize, on: bool) -> Self {
        Self {
            schedule: FiringSchedule::pioneer(n_sensors),
            n_sensors,
            enabled: [on; N_ARRAYS_MAX],
            fresh: Vec::with_capacity(ARRAY_LEN * N_ARRAYS_MAX),
        }
    }

    /// SONAR: bit 0 on or off, the bits above it one array's number, or 0 for all.
    pub(super) fn switch(&mut self, argument: i16) {
        let on = argument & 1 != 0;
        match usize::try_from(argument >> 1) {
            Ok(0) => self.enabled = [on; N_ARRAYS_MAX],
            Ok(array) => {
                if let Some(enabled) = self.enabled.get_mut(array - 1) {
                    *enabled = on;
                }
            }
            Err(_) => {}
        }
    }

    /// POLLING: sensors fire in this order, numbered from 1; those not named do not fire, and
    /// numbers the robot does not have are passed over. An empty order restores the usual one.
    pub(super) fn set_order(&mut self, numbers: &[u8]) {
        if numbers.is_empty() {
            self.schedule = FiringSchedule::pioneer(self.n_sensors);
            return;
        }
        let mut arrays = vec![Vec::new(); N_ARRAYS_MAX];
        for &number in numbers {
            let sensor = usize::from(number).checked_sub(1).filter(|&s| s < self.n_sensors);
            if let Some(sensor) = sensor
                && let Some(array) = arrays.get_mut(sensor / ARRAY_LEN)
            {
                array.push(sensor);
            }
        }
        self.schedule = FiringSchedule::new(arrays, self.schedule.period());
    }

    /// Fires the sensors that are due after `before`, up to `now`.
    pub(super) fn fire(&mut self, before: Stamp, now: Stamp, ping: &mut dyn FnMut(usize) -> f64) {
        for firing in self.schedule.due(before, now) {
            let sensor_index = firing.sensor_index;
            let enabled = self.enabled.get(sensor_index / ARRAY_LEN).copied().unwrap_or(false);
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

    /// Readings since [`forget_fresh`](Self::forget_fresh), at most one of each sensor.
    pub(super) fn fresh(&self) -> &[SonarReading] {
        &self.fresh
    }

    pub(super) fn forget_fresh(&mut self) {
        self.fresh.clear();
    }

    /// Bit i: array i is on and exists.
    pub(super) fn enabled_bits(&self) -> u16 {
        let n_arrays = self.n_sensors.div_ceil(ARRAY_LEN);
        let arrays = self.enabled.iter().take(n_arrays).enumerate();
        arrays.fold(0, |bits, (index, &on)| bits | (u16::from(on) << index))
    }
}
