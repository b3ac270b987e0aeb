//! What touched a robot lately, as a coarse ring of sectors: near where it was touched, free elsewhere.

use std::{f64::consts::FRAC_PI_2, time::Duration};

use geometry::wrap_to_pi;
use messages::{Contacts, N_RING_MAX, Ring};
use obstacle_avoidance::RangeSensor;
use run_context::Stamp;

use crate::settings::ContactMounts;

/// A touch is remembered for so long: backing off releases what was pressed, and the rebound comes after.
const REMEMBERED: Duration = Duration::from_secs(6);

/// What a sector reads where it was touched, metres.
const TOUCHED_M: f64 = 0.01;

/// A cliff counts for so much to either side of its sensor, radians.
const CLIFF_RAD: f64 = 0.35;

/// The part of the surroundings that is felt.
#[derive(Clone, Debug)]
pub(crate) struct Touch {
    mounts: ContactMounts,
    sectors: Vec<RangeSensor>,
    range_max_m: f64,
    touched_at: [Option<Stamp>; N_RING_MAX],
    heard: Ring,
}

impl Touch {
    /// For a ring of these sectors.
    pub(crate) fn new(mounts: &ContactMounts, sectors: &[RangeSensor], range_max_m: f64) -> Self {
        let n_sensors = sectors.len().min(N_RING_MAX);
        let ranges_m = [range_max_m; N_RING_MAX];
        Self {
            mounts: mounts.clone(),
            sectors: sectors[..n_sensors].to_vec(),
            range_max_m,
            touched_at: [None; N_RING_MAX],
            heard: Ring { ranges_m, ages_ms: [0; N_RING_MAX], n_sensors, fresh: 0 },
        }
    }

    /// What the sectors read.
    pub(crate) fn heard(&self) -> &Ring {
        &self.heard
    }

    /// Takes what touches the robot now.
    pub(crate) fn take(&mut self, now: Stamp, contacts: Contacts) {
        for (k, sector) in self.sectors.iter().enumerate() {
            if self.mounts.is_touched_at(contacts, sector.bearing_rad) {
                self.touched_at[k] = Some(now);
            }
            let is_near = self.touched_at[k].is_some_and(|at| now.since(at) <= REMEMBERED);
            self.heard.ranges_m[k] = if is_near { TOUCHED_M } else { self.range_max_m };
        }
    }
}

impl ContactMounts {
    /// Whether something of `contacts` is in that direction, radians from straight ahead.
    fn is_touched_at(&self, contacts: Contacts, bearing_rad: f64) -> bool {
        let pressed = self.bumpers_rad.iter().enumerate().any(|(bit, [right, left])| {
            contacts.bumpers >> bit & 1 != 0 && (*right..=*left).contains(&bearing_rad)
        });
        let cliff = self.cliffs_in_base.iter().enumerate().any(|(bit, place)| {
            let off_rad = wrap_to_pi(place.y.atan2(place.x) - bearing_rad).abs();
            contacts.cliffs >> bit & 1 != 0 && off_rad <= CLIFF_RAD
        });
        let wheel = |k: usize| contacts.stalled[k] || contacts.dropped[k];
        let wheels = wheel(0) && (0.0..=FRAC_PI_2).contains(&bearing_rad)
            || wheel(1) && (-FRAC_PI_2..=0.0).contains(&bearing_rad);
        pressed || cliff || wheels
    }
}

#[cfg(test)]
mod tests {
    use geometry::Vec2;

    use super::*;

    fn touch() -> Touch {
        let sector = |k: u32| RangeSensor {
            in_base: Vec2::zeros(),
            bearing_rad: (84.375 - 11.25 * f64::from(k)).to_radians(),
        };
        let mounts = ContactMounts {
            bumpers_rad: vec![[-FRAC_PI_2, 0.26], [-0.26, FRAC_PI_2]],
            cliffs_in_base: vec![Vec2::new(0.07, 0.14)],
        };
        Touch::new(&mounts, &(0..16).map(sector).collect::<Vec<_>>(), 2.0)
    }

    fn near(touch: &Touch) -> String {
        let sign = |m: &f64| if *m < 1.0 { '#' } else { '.' };
        touch.heard().ranges_m().iter().map(sign).collect()
    }

    #[test]
    fn sectors_read_near_where_the_robot_is_touched_and_for_a_while_after() {
        let none = Contacts::default();
        let at = Stamp::from_millis;
        // The middles of the sectors are 84.4°, 73.1°, … −84.4°; the bumpers overlap by 15° to either side, the cliff sensor
        // looks at 63°.
        for (contacts, sectors) in [
            (Contacts { bumpers: 0b01, ..none }, ".......#########"),
            (Contacts { bumpers: 0b10, ..none }, "#########......."),
            (Contacts { bumpers: 0b11, ..none }, "################"),
            (Contacts { cliffs: 1, ..none }, ".###............"),
            (Contacts { stalled: [true, false], ..none }, "########........"),
            (Contacts { dropped: [false, true], ..none }, "........########"),
        ] {
            let mut touch = touch();
            touch.take(at(0), none);
            assert_eq!(near(&touch), "................");
            touch.take(at(100), contacts);
            assert_eq!(near(&touch), sectors);
            touch.take(at(6_100), none);
            assert_eq!(near(&touch), sectors);
            touch.take(at(6_101), none);
            assert_eq!(near(&touch), "................");
        }
    }
}
