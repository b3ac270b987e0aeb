//! The sensitivity bubble: how near a thing may come before the robot reacts.

/// A boundary around the robot that grows with its speed, one radius per range sensor.
#[derive(Clone, Debug, PartialEq)]
pub struct Bubble {
    gains: Vec<f64>,
    floors_m: Vec<f64>,
    range_cap_m: f64,
}

/// What [`Bubble::check`] found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Intrusion {
    /// The first sensor whose reading lies inside its boundary.
    pub first: Option<usize>,
    /// How many sensors read something inside.
    pub n_sensors: usize,
}

/// A bubble that cannot be.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BubbleError {
    /// Gains and floors speak of different sensors.
    #[error("bubble has {n_gains} gains but {n_floors} floors: give one of each per sensor")]
    Lengths {
        /// Number of gains.
        n_gains: usize,
        /// Number of floors.
        n_floors: usize,
    },
    /// A value outside its range.
    #[error("bubble.{key}[{index}] = {value}: must be {requirement}")]
    Value {
        /// Which list.
        key: &'static str,
        /// Which sensor.
        index: usize,
        /// What was given.
        value: f64,
        /// What is allowed.
        requirement: &'static str,
    },
}

impl Bubble {
    /// Makes a bubble from one gain Kᵢ (dimensionless) and one floor (m) per sensor.
    ///
    /// A sensor with gain and floor zero takes no part. No boundary exceeds `range_cap_m`, which
    /// must not exceed what the sensors can measure, else "nothing heard" would look like a thing.
    ///
    /// # Errors
    ///
    /// [`BubbleError`] when the lists differ in length, or a value is negative or not finite.
    pub fn new(gains: &[f64], floors_m: &[f64], range_cap_m: f64) -> Result<Self, BubbleError> {
        if gains.len() != floors_m.len() {
            let (n_gains, n_floors) = (gains.len(), floors_m.len());
            return Err(BubbleError::Lengths { n_gains, n_floors });
        }
        check_list("gains", gains)?;
        check_list("floors_m", floors_m)?;
        if !(range_cap_m.is_finite() && range_cap_m > 0.0) {
            return Err(BubbleError::Value {
                key: "range_cap_m",
                index: 0,
                value: range_cap_m,
                requirement: "a finite distance above 0 m",
            });
        }
        Ok(Self { gains: gains.to_vec(), floors_m: floors_m.to_vec(), range_cap_m })
    }

    /// Number of sensors it speaks of.
    pub fn len(&self) -> usize {
        self.gains.len()
    }

    /// Whether it speaks of no sensor at all.
    pub fn is_empty(&self) -> bool {
        self.gains.is_empty()
    }

    /// The boundary of sensor `index` at `speed_mps`, metres; 0 for sensors it does not know.
    ///
    /// `interval_s` is the time between evaluations. Backward speed counts like forward speed.
    ///
    /// Source: the thesis, 6.3.1: `bubble_boundary[i] = K_i · V · Δt`, capped by the sensor's range.
    /// Differences: a floor, because a bubble of radius zero lets a slow robot touch things.
    pub fn limit_m(&self, index: usize, speed_mps: f64, interval_s: f64) -> f64 {
        let (Some(gain), Some(floor)) = (self.gains.get(index), self.floors_m.get(index)) else {
            return 0.0;
        };
        (gain * speed_mps.abs() * interval_s).max(*floor).min(self.range_cap_m)
    }

    /// Writes all boundaries (m) into `limits_m`; entries beyond the known sensors become 0.
    pub fn limits(&self, speed_mps: f64, interval_s: f64, limits_m: &mut [f64]) {
        for (index, limit_m) in limits_m.iter_mut().enumerate() {
            *limit_m = self.limit_m(index, speed_mps, interval_s);
        }
    }

    /// Which readings (m) lie on or inside the boundaries at that speed.
    ///
    /// Source: the thesis, 6.3.1, `check_for_obstacles`. Differences: the printed sample returns
    /// after the first sensor whatever it reads; here, as its text and Annex C say, any sensor
    /// inside counts. A reading that is not a number counts as inside: a broken sensor stops us.
    pub fn check(&self, ranges_m: &[f64], speed_mps: f64, interval_s: f64) -> Intrusion {
        let mut found = Intrusion::default();
        for (index, &range_m) in ranges_m.iter().enumerate().take(self.len()) {
            if self.is_inside(index, range_m, speed_mps, interval_s) {
                found.first = found.first.or(Some(index));
                found.n_sensors += 1;
            }
        }
        found
    }

    /// Whether one reading (m) lies on or inside its boundary. A reading at the cap says that nothing was
    /// heard and is outside, however far the boundary reaches.
    pub fn is_inside(&self, index: usize, range_m: f64, speed_mps: f64, interval_s: f64) -> bool {
        let limit_m = self.limit_m(index, speed_mps, interval_s);
        let clear = limit_m <= 0.0 || range_m > limit_m || range_m >= self.range_cap_m;
        !clear
    }

    /// The greatest speed (m/s) at which no reading lies inside its boundary; 0 when one lies
    /// inside a floor. Infinite when no sensor limits it.
    ///
    /// This turns (6.3.1) round: V = Dᵢ / (Kᵢ · Δt). An extension: with it a robot slows down
    /// beside a door post instead of rebounding from it.
    pub fn speed_allowed_mps(&self, ranges_m: &[f64], interval_s: f64) -> f64 {
        let mut allowed_mps = f64::INFINITY;
        for (index, &range_m) in ranges_m.iter().enumerate().take(self.len()) {
            let (gain, floor_m) = (self.gains[index], self.floors_m[index]);
            if floor_m > 0.0 && (range_m.is_nan() || range_m <= floor_m) {
                return 0.0;
            }
            if gain > 0.0 && range_m < self.range_cap_m {
                allowed_mps = allowed_mps.min(range_m / (gain * interval_s));
            }
        }
        allowed_mps
    }
}

fn check_list(key: &'static str, values: &[f64]) -> Result<(), BubbleError> {
    let bad = values.iter().position(|v| !(v.is_finite() && *v >= 0.0));
    bad.map_or(Ok(()), |index| {
        let requirement = "finite and not negative";
        Err(BubbleError::Value { key, index, value: values[index], requirement })
    })
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "these values are exact")]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn eight() -> Bubble {
        let gains = [0.0, 4.0, 6.0, 10.0, 10.0, 6.0, 4.0, 0.0];
        Bubble::new(&gains, &[0.0, 0.1, 0.1, 0.2, 0.2, 0.1, 0.1, 0.0], 5.0).unwrap()
    }

    #[test]
    fn the_thesis_speeds_give_its_distances() {
        // V·Δt is 60 mm at 0.3 m/s and 100 mm at 0.5 m/s (Δt 200 ms).
        let unit = Bubble::new(&[1.0], &[0.0], 5.0).unwrap();
        assert!((unit.limit_m(0, 0.3, 0.2) - 0.060).abs() < 1e-12);
        assert!((unit.limit_m(0, 0.5, 0.2) - 0.100).abs() < 1e-12);
        assert!((unit.limit_m(0, -0.5, 0.2) - 0.100).abs() < 1e-12);
    }

    #[test]
    fn silence_is_no_obstacle_however_far_the_boundary_reaches() {
        let bubble = eight();
        // 10 · 1 m/s · 0.5 s reaches the cap of 5 m exactly.
        assert_eq!(bubble.limit_m(3, 1.0, 0.5), 5.0);
        assert!(!bubble.is_inside(3, 5.0, 1.0, 0.5), "nothing was heard");
        assert!(bubble.is_inside(3, 4.999, 1.0, 0.5));
        assert!(bubble.is_inside(3, f64::NAN, 1.0, 0.5), "a broken sensor stops the robot");
        assert_eq!(bubble.check(&[5.0; 8], 1.0, 0.5).first, None);
    }

    #[test]
    fn cap_and_floor_hold() {
        let bubble = eight();
        assert_eq!(bubble.limit_m(3, 0.0, 0.2), 0.2);
        assert_eq!(bubble.limit_m(3, 100.0, 0.2), 5.0);
        assert_eq!(bubble.limit_m(8, 0.3, 0.2), 0.0);
        let mut limits_m = [9.0; 10];
        bubble.limits(0.3, 0.2, &mut limits_m);
        assert_eq!(limits_m[0], 0.0);
        assert!((limits_m[4] - 0.6).abs() < 1e-12);
        assert_eq!(limits_m[9], 0.0);
    }

    #[test]
    fn any_sensor_inside_counts_and_not_only_the_first() {
        let bubble = eight();
        let mut ranges_m = [5.0; 8];
        assert_eq!(bubble.check(&ranges_m, 0.3, 0.2), Intrusion::default());
        ranges_m[5] = 0.36; // exactly on the boundary
        ranges_m[4] = 0.59;
        assert_eq!(bubble.check(&ranges_m, 0.3, 0.2), Intrusion { first: Some(4), n_sensors: 2 });
        ranges_m[4] = 0.61;
        assert_eq!(bubble.check(&ranges_m, 0.3, 0.2), Intrusion { first: Some(5), n_sensors: 1 });
        ranges_m[5] = 0.361;
        assert_eq!(bubble.check(&ranges_m, 0.3, 0.2), Intrusion::default());
        ranges_m[2] = f64::NAN;
        assert_eq!(bubble.check(&ranges_m, 0.3, 0.2).first, Some(2));
        // The outer sensors take no part, whatever they read.
        assert_eq!(bubble.check(&[0.0, 5.0, 5.0], 0.3, 0.2).first, None);
    }

    #[test]
    fn bad_values_are_named() {
        let error = Bubble::new(&[1.0, -2.0], &[0.0, 0.0], 5.0).unwrap_err();
        assert_eq!(error.to_string(), "bubble.gains[1] = -2: must be finite and not negative");
        assert!(Bubble::new(&[1.0], &[], 5.0).is_err());
        assert!(Bubble::new(&[1.0], &[f64::NAN], 5.0).is_err());
        assert!(Bubble::new(&[1.0], &[0.0], 0.0).is_err());
    }

    proptest! {
        #[test]
        fn just_below_the_allowed_speed_nothing_is_inside(ranges in proptest::collection::vec(0.21..4.9_f64, 8)) {
            let bubble = eight();
            let allowed = bubble.speed_allowed_mps(&ranges, 0.2);
            prop_assert_eq!(bubble.check(&ranges, 0.999 * allowed, 0.2).first, None);
            prop_assert!(bubble.check(&ranges, 1.001 * allowed, 0.2).first.is_some());
        }

        #[test]
        fn a_reading_inside_a_floor_allows_no_speed(index in 1_usize..7, range in 0.0..0.099_f64) {
            let mut ranges = [4.0; 8];
            ranges[index] = range;
            prop_assert_eq!(eight().speed_allowed_mps(&ranges, 0.2), 0.0);
        }
    }
}
