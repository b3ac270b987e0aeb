//! The fuzzy trail controller in the whole-number arithmetic of the thesis's program.
//!
//! For comparison with the thesis and with controllers too small for floats; [`crate::fuzzy`] is the
//! one to use otherwise. Truths are per cent, speeds mm/s, and every division rounds towards zero.
//!
//! Source: the thesis, Annex B2: `compute_error`, `compute_error_dot`, `compute_dom`, `antecedent`,
//! `crisp`. Differences: constants and the left table are not legible in print and are settings here.

use crate::{
    SettingError, WheelReference,
    fuzzy::{Speed, Table},
    wheels::check_range,
};

/// The constants of the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ListingConfig {
    /// ME: errors from here on are fully N or P; intensity units, > 0.
    pub error_full: i32,
    /// MED: the same for the change of the error.
    pub change_full: i32,
    /// L, millimetres per second.
    pub slow_mmps: i32,
    /// M, millimetres per second.
    pub mean_mmps: i32,
    /// H, millimetres per second.
    pub fast_mmps: i32,
    /// The rules.
    pub table: Table,
    /// What the program does at its first call.
    pub first_change: FirstChange,
}

/// How the first change of the error is found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FirstChange {
    /// As the program: the first call answers 0 without remembering the error, so the second call's
    /// change is counted from 0.
    #[default]
    Listing,
    /// The first call answers 0 and remembers.
    Corrected,
}

impl Default for ListingConfig {
    /// ME = 50, MED = 25, L/M/H = 150/300/450, antisymmetric.
    fn default() -> Self {
        Self {
            error_full: 50,
            change_full: 25,
            slow_mmps: 150,
            mean_mmps: 300,
            fast_mmps: 450,
            table: Table::default(),
            first_change: FirstChange::default(),
        }
    }
}

/// What one cycle computes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ListingOutput {
    /// `VLEFT`, millimetres per second.
    pub left_mmps: i32,
    /// `VRIGHT`, millimetres per second.
    pub right_mmps: i32,
    /// `VL`: the byte sent for the left wheel, in units of 20 mm/s.
    pub left_byte: u8,
    /// `VR`: the byte sent for the right wheel, in units of 20 mm/s.
    pub right_byte: u8,
    /// `gnil`: neither antenna perceived anything.
    pub lost: bool,
}

impl ListingOutput {
    /// What the robot does with the two bytes: signed, 20 mm/s each.
    pub fn wheels(self) -> WheelReference {
        let speed_mps = |byte: u8| f64::from(byte as i8) * 0.02; // two's complement on the wire
        WheelReference {
            left_mps: speed_mps(self.left_byte),
            right_mps: speed_mps(self.right_byte),
        }
    }
}

/// The controller with the program's memory.
#[derive(Clone, Debug)]
pub struct ListingFuzzy {
    config: ListingConfig,
    previous_error: i32,
    called_before: bool,
}

impl ListingFuzzy {
    /// Checks the constants.
    ///
    /// # Errors
    ///
    /// [`SettingError`] for a value outside its range.
    pub fn new(config: ListingConfig) -> Result<Self, SettingError> {
        let positive = "from 1 to 100000";
        check_range("error_full", f64::from(config.error_full), 1.0..=1e5, positive)?;
        check_range("change_full", f64::from(config.change_full), 1.0..=1e5, positive)?;
        for (key, value) in [
            ("slow_mmps", config.slow_mmps),
            ("mean_mmps", config.mean_mmps),
            ("fast_mmps", config.fast_mmps),
        ] {
            check_range(
                key,
                f64::from(value),
                -2540.0..=2540.0,
                "from -2540 to 2540, 127 units of 20",
            )?;
        }
        Ok(Self { config, previous_error: 0, called_before: false })
    }

    /// One cycle: from the two intensities the server sent to wheel speeds.
    ///
    /// When both are 0 the robot goes straight on at 80 mm/s (`VL` = `VR` = 4), while `VLEFT` says 60 as
    /// printed.
    pub fn step(&mut self, left: u8, right: u8) -> ListingOutput {
        let error = i32::from(left) - i32::from(right);
        let change = self.error_dot(error);
        if left == 0 && right == 0 {
            return ListingOutput {
                left_mmps: 60,
                right_mmps: 60,
                left_byte: 4,
                right_byte: 4,
                lost: true,
            };
        }
        self.infer(error, change)
    }

    /// The inference alone: any error and change to wheel speeds.
    pub fn infer(&self, error: i32, change: i32) -> ListingOutput {
        let antecedents = antecedents(
            degrees_of_membership(error, self.config.error_full),
            degrees_of_membership(change, self.config.change_full),
        );
        let (left_rules, right_rules) = self.config.table.rules();
        let crisp = |rules: [Speed; 9]| {
            let weighted = antecedents.iter().zip(rules).map(|(z, s)| z * self.speed_mmps(s));
            // Σ z is never 0: each input has a set with a truth of at least 50.
            weighted.sum::<i32>() / antecedents.iter().sum::<i32>()
        };
        let (left_mmps, right_mmps) = (crisp(left_rules), crisp(right_rules));
        let byte = |speed_mmps: i32| ((speed_mmps / 20) & 0xFF) as u8;
        ListingOutput {
            left_mmps,
            right_mmps,
            left_byte: byte(left_mmps),
            right_byte: byte(right_mmps),
            lost: false,
        }
    }

    fn error_dot(&mut self, error: i32) -> i32 {
        if !self.called_before {
            self.called_before = true;
            if self.config.first_change == FirstChange::Corrected {
                self.previous_error = error;
            }
            return 0;
        }
        error - std::mem::replace(&mut self.previous_error, error)
    }

    fn speed_mmps(&self, speed: Speed) -> i32 {
        match speed {
            Speed::Slow => self.config.slow_mmps,
            Speed::Mean => self.config.mean_mmps,
            Speed::Fast => self.config.fast_mmps,
        }
    }
}

/// `compute_dom()`: the truths of N, Z and P in per cent; they sum to 100. `full` > 0.
pub fn degrees_of_membership(input: i32, full: i32) -> [i32; 3] {
    // At the outermost inputs the quotient would be 100 anyway; cutting first keeps it from overflowing.
    let outer =
        (100 * i64::from(input.unsigned_abs()).min(i64::from(full)) / i64::from(full)) as i32;
    if input < 0 { [outer, 100 - outer, 0] } else { [0, 100 - outer, outer] }
}

/// `antecedent()`: the truth of each rule, at 3 × (set of e) + (set of e′).
pub fn antecedents(error: [i32; 3], change: [i32; 3]) -> [i32; 9] {
    std::array::from_fn(|rule| error[rule / 3].min(change[rule % 3]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const GOLDEN: ListingConfig = ListingConfig {
        error_full: 50,
        change_full: 25,
        slow_mmps: 200,
        mean_mmps: 300,
        fast_mmps: 400,
        table: Table::Antisymmetric,
        first_change: FirstChange::Listing,
    };

    fn controller(config: ListingConfig) -> ListingFuzzy {
        ListingFuzzy::new(config).unwrap()
    }

    /// Derived from the printed program by hand and by script; ME = 50, MED = 25, L/M/H = 200/300/400.
    #[test]
    fn golden_values() {
        let golden = [
            ((0, 0), (300, 300), (15, 15)),
            ((-38, 0), (376, 224), (18, 11)),
            ((-38, 10), (324, 275), (16, 13)),
            ((25, -5), (278, 321), (13, 16)),
            ((60, 30), (200, 400), (10, 20)),
            ((10, -40), (380, 220), (19, 11)),
        ];
        for ((error, change), speeds, bytes) in golden {
            let out = controller(GOLDEN).infer(error, change);
            assert_eq!(
                ((out.left_mmps, out.right_mmps), (out.left_byte, out.right_byte)),
                (speeds, bytes)
            );
            assert!(!out.lost);
        }
    }

    #[test]
    fn memberships_at_and_around_the_ends() {
        let cases = [(-51, [100, 0, 0]), (-50, [100, 0, 0]), (-49, [98, 2, 0]), (-1, [2, 98, 0])];
        for (input, truths) in cases {
            assert_eq!(degrees_of_membership(input, 50), truths);
            let mirrored = [truths[2], truths[1], truths[0]];
            assert_eq!(degrees_of_membership(-input, 50), mirrored);
        }
        assert_eq!(degrees_of_membership(0, 50), [0, 100, 0]);
        assert_eq!(degrees_of_membership(7, 30), [0, 77, 23]);
        assert_eq!(degrees_of_membership(i32::MIN, 1), [100, 0, 0]);
    }

    #[test]
    fn a_lost_trail_means_slowly_straight_on() {
        let out = controller(GOLDEN).step(0, 0);
        assert_eq!((out.left_mmps, out.right_mmps), (60, 60));
        assert_eq!((out.left_byte, out.right_byte, out.lost), (4, 4, true));
        assert_eq!(out.wheels(), WheelReference::straight(0.08));
        assert!(!controller(GOLDEN).step(0, 1).lost);
        assert!(!controller(GOLDEN).step(1, 0).lost);
    }

    /// First call: change 0, nothing remembered. Second: counted from 0. Third: from the second.
    #[test]
    fn the_first_change_is_forgotten_as_in_the_program() {
        let mut listing = controller(GOLDEN);
        let mut corrected =
            controller(ListingConfig { first_change: FirstChange::Corrected, ..GOLDEN });
        let reference = controller(GOLDEN);
        assert_eq!(listing.step(40, 20), reference.infer(20, 0));
        assert_eq!(corrected.step(40, 20), reference.infer(20, 0));
        assert_eq!(listing.step(40, 30), reference.infer(10, 10));
        assert_eq!(corrected.step(40, 30), reference.infer(10, -10));
        assert_eq!(listing.step(40, 35), reference.infer(5, -5));
        assert_eq!(corrected.step(40, 35), reference.infer(5, -5));
    }

    #[test]
    fn the_three_tables_differ_where_they_are_printed_differently() {
        let out = |table, error, change| {
            let out = controller(ListingConfig { table, ..GOLDEN }).infer(error, change);
            (out.left_mmps, out.right_mmps)
        };
        // Fully N with e′ fully P, and e zero with e′ fully N.
        assert_eq!(out(Table::Antisymmetric, -50, 25), (300, 300));
        assert_eq!(out(Table::LiteralMirror, -50, 25), (300, 300));
        assert_eq!(out(Table::Table51, -50, 25), (300, 300));
        assert_eq!(out(Table::Antisymmetric, 0, -25), (400, 200));
        assert_eq!(out(Table::LiteralMirror, 0, -25), (300, 300));
        assert_eq!(out(Table::Table51, 0, -25), (200, 400));
        assert_eq!(out(Table::Antisymmetric, 50, -25), (300, 300));
        assert_eq!(out(Table::LiteralMirror, 50, -25), (400, 200));
        assert_eq!(out(Table::Table51, 50, -25), (200, 400));
    }

    #[test]
    fn a_backward_speed_is_sent_in_twos_complement() {
        let config = ListingConfig { slow_mmps: -100, ..GOLDEN };
        let out = controller(config).infer(60, 30);
        assert_eq!((out.left_mmps, out.left_byte), (-100, 0xFB));
        assert_eq!(out.wheels(), WheelReference { left_mps: -0.1, right_mps: 0.4 });
    }

    #[test]
    fn constants_out_of_range_are_named() {
        let refused = |config| ListingFuzzy::new(config).unwrap_err().to_string();
        assert_eq!(
            refused(ListingConfig { error_full: 0, ..GOLDEN }),
            "error_full = 0: must be from 1 to 100000"
        );
        assert_eq!(
            refused(ListingConfig { fast_mmps: 2541, ..GOLDEN }),
            "fast_mmps = 2541: must be from -2540 to 2540, 127 units of 20"
        );
    }

    proptest! {
        #[test]
        fn truths_always_sum_to_a_hundred(input in any::<i32>(), full in 1..=100_000) {
            let truths = degrees_of_membership(input, full);
            prop_assert_eq!(truths.iter().sum::<i32>(), 100);
            prop_assert!(truths.iter().all(|t| (0..=100).contains(t)));
        }

        #[test]
        fn mirrored_errors_swap_the_wheels(error in -300..300, change in -300..300) {
            let (here, there) =
                (controller(GOLDEN).infer(error, change), controller(GOLDEN).infer(-error, -change));
            prop_assert_eq!((here.left_mmps, here.right_mmps), (there.right_mmps, there.left_mmps));
        }
    }
}
