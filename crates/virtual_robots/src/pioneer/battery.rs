//! The battery: how fast it empties, and the voltage that shows it.

use std::time::Duration;

use crate::BatteryConfig;

/// What three batteries of 12 V and 7 Ah hold, J; with the powers below they last eight hours of
/// steady driving at 0.4 m/s, the figures commonly quoted for the robot.
const CAPACITY_J: f64 = 252.0 * 3600.0;
/// What computers and sonars take, W.
const IDLE_W: f64 = 14.0;
/// What motors take that are on, W.
const MOTORS_W: f64 = 4.0;
/// What driving takes besides, J per metre of a wheel's way (both wheels count half).
const DRIVING_JPM: f64 = 34.0;

/// Voltage over charge, percent: straight lines between these points.
const CURVE: [(f64, f64); 3] = [(0.0, 10.0), (20.0, 11.0), (100.0, 12.6)];

/// A battery.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Battery {
    charge_j: f64,
    drain_ratio: f64,
}

impl Battery {
    /// Below this it is low, V: what the configuration packet says.
    pub(super) const LOW_V: f64 = CURVE[1].1;

    pub(super) fn new(config: BatteryConfig) -> Self {
        let mut battery = Self { charge_j: 0.0, drain_ratio: config.drain_ratio.max(0.0) };
        battery.set_charge_percent(config.charge_percent);
        battery
    }

    /// Time passes: wheels turned by `way_m` on average, whichever way.
    pub(super) fn drain(&mut self, dt: Duration, motors_on: bool, way_m: f64) {
        let power_w = if motors_on { IDLE_W + MOTORS_W } else { IDLE_W };
        let taken_j = power_w * dt.as_secs_f64() + DRIVING_JPM * way_m;
        self.charge_j = (self.charge_j - self.drain_ratio * taken_j).max(0.0);
    }

    pub(super) fn charge_percent(&self) -> f64 {
        100.0 * self.charge_j / CAPACITY_J
    }

    pub(super) fn voltage_v(&self) -> f64 {
        interpolate(CURVE, self.charge_percent())
    }

    /// BATTEST: as if it had that voltage.
    pub(super) fn pretend_v(&mut self, voltage_v: f64) {
        self.set_charge_percent(interpolate(
            CURVE.map(|(charge, volts)| (volts, charge)),
            voltage_v,
        ));
    }

    pub(super) fn is_low(&self) -> bool {
        self.voltage_v() < Self::LOW_V
    }

    /// Nothing is left for the motors.
    pub(super) fn is_empty(&self) -> bool {
        self.charge_j <= 0.0
    }

    fn set_charge_percent(&mut self, charge_percent: f64) {
        // Nonsense is an empty battery.
        let charge_percent = if charge_percent.is_nan() { 0.0 } else { charge_percent };
        self.charge_j = CAPACITY_J * charge_percent.clamp(0.0, 100.0) / 100.0;
    }
}

/// The value at `x` of straight lines between points; beyond the ends, the ends.
fn interpolate(points: [(f64, f64); 3], x: f64) -> f64 {
    let [(x0, y0), (x1, y1), (x2, y2)] = points;
    let between = |(xa, ya): (f64, f64), (xb, yb): (f64, f64)| {
        ya + (yb - ya) * ((x - xa) / (xb - xa)).clamp(0.0, 1.0)
    };
    if x < x1 { between((x0, y0), (x1, y1)) } else { between((x1, y1), (x2, y2)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn full() -> Battery {
        Battery::new(BatteryConfig::default())
    }

    #[test]
    fn it_lasts_eight_hours_of_driving_and_eighteen_of_waiting() {
        let hours = |motors_on: bool, speed_mps: f64| {
            let mut battery = full();
            (0..2000).position(|_minute| {
                battery.drain(Duration::from_mins(1), motors_on, 60.0 * speed_mps);
                battery.is_empty()
            })
        };
        // 252 Wh / (18 + 34 · 0.4) W = 7.97 h; 252 / 14 = 18 h.
        assert_eq!((hours(true, 0.4), hours(false, 0.0)), (Some(478), Some(1079)));
    }

    #[test]
    fn the_voltage_tells_the_charge_and_back() {
        let mut battery = full();
        for (volts, percent) in
            [(12.6, 100.0), (11.8, 60.0), (11.0, 20.0), (10.5, 10.0), (10.0, 0.0)]
        {
            battery.pretend_v(volts);
            assert!((battery.charge_percent() - percent).abs() < 1e-9, "{volts} V");
            assert!((battery.voltage_v() - volts).abs() < 1e-9);
            assert_eq!(battery.is_low(), volts < 11.0);
        }
        for (volts, kept) in [(99.0, 12.6), (-3.0, 10.0), (f64::NAN, 10.0)] {
            battery.pretend_v(volts);
            assert!((battery.voltage_v() - kept).abs() < 1e-9, "{volts}");
        }
    }

    #[test]
    fn it_drains_as_fast_as_it_is_told_to() {
        let left = |drain_ratio| {
            let mut battery = Battery::new(BatteryConfig { charge_percent: 50.0, drain_ratio });
            battery.drain(Duration::from_secs(252), false, 0.0);
            battery.charge_percent()
        };
        // 252 s of 14 W are 3528 J, 0.389 % of 907 200 J.
        assert!((left(0.0) - 50.0).abs() < 1e-12 && (left(-1.0) - 50.0).abs() < 1e-12);
        assert!((50.0 - left(1.0) - 0.388_89).abs() < 1e-4);
        assert!((50.0 - left(10.0) - 3.888_9).abs() < 1e-3);
    }
}
