//! The battery: how fast it empties and fills.

use std::time::Duration;

use robot_models::BatteryModel;

use crate::BatteryConfig;

/// Voltage and capacity where the catalogue knows no battery.
const BATTERY: BatteryModel = BatteryModel {
    capacity_mah: 3000.0,
    full_v: 16.5,
    empty_v: 12.0,
    idle_w: 4.5,
    driving_w: 10.0,
    charging_w: 20.0,
};

/// Its battery.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Power {
    pub(super) model: BatteryModel,
    pub(super) drain_ratio: f64,
    pub(super) charge_mah: f64,
    /// Into the battery.
    pub(super) current_ma: f64,
}

impl Power {
    pub(super) fn new(model: Option<BatteryModel>, config: BatteryConfig) -> Self {
        let model = model.unwrap_or(BATTERY);
        let share = (0.01 * config.charge_percent).clamp(0.0, 1.0);
        // Nonsense is an empty battery.
        let share = if share.is_nan() { 0.0 } else { share };
        let drain_ratio = config.drain_ratio.max(0.0);
        Self { model, drain_ratio, charge_mah: share * model.capacity_mah, current_ma: 0.0 }
    }

    /// Time passes; `effort` is the share of the wheels' full speed, 0 to 1.
    pub(super) fn pass(&mut self, dt: Duration, effort: f64, charges: bool) {
        let model = &self.model;
        let power_w = if charges && self.charge_mah < model.capacity_mah {
            model.charging_w
        } else if charges {
            0.0
        } else {
            -(model.idle_w + effort * model.driving_w)
        };
        self.current_ma = 1000.0 * power_w / self.voltage_v();
        let ratio = if charges { 1.0 } else { self.drain_ratio };
        let change_mah = ratio * self.current_ma * dt.as_secs_f64() / 3600.0;
        self.charge_mah = (self.charge_mah + change_mah).clamp(0.0, self.model.capacity_mah);
    }

    pub(super) fn charge_percent(&self) -> f64 {
        100.0 * self.charge_mah / self.model.capacity_mah
    }

    pub(super) fn voltage_v(&self) -> f64 {
        let BatteryModel { full_v, empty_v, .. } = self.model;
        empty_v + (full_v - empty_v) * self.charge_mah / self.model.capacity_mah
    }

    pub(super) fn is_empty(&self) -> bool {
        self.charge_mah <= 0.0
    }

    pub(super) fn is_full(&self) -> bool {
        self.charge_mah >= self.model.capacity_mah
    }
}
