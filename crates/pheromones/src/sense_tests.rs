//! Tests of perception: the thesis's golden values, plain sums over all cells, and laws.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

use expect_test::expect;
use proptest::prelude::*;

use super::*;
use crate::exo_synapses;

/// N = 21, a horizontal trail one cell wide through the origin, unit sources.
fn horizontal_trail() -> Field {
    trail(1, false)
}

fn trail(width_cells: usize, vertical: bool) -> Field {
    let mut field = Field::new(21, 21, 0.2).unwrap();
    let across = 10 - width_cells / 2..=10 + width_cells / 2;
    for i in 0..21 {
        for j in across.clone() {
            let (col, row) = if vertical { (j, i) } else { (i, j) };
            field.set(col, row, 1).unwrap();
        }
    }
    field
}

fn strict(perception: Perception, sigma_m: f64) -> SenseConfig {
    SenseConfig { perception, sigma_m, antenna_spacing_m: 0.38, strict: true }
}

fn exact(perception: Perception) -> SenseConfig {
    SenseConfig { perception, ..SenseConfig::default() }
}

fn pose_mm_deg(x_mm: f64, y_mm: f64, heading_deg: f64) -> Se2 {
    Se2::new(x_mm / 1000.0, y_mm / 1000.0, heading_deg.to_radians())
}

/// Derived from the printed program; values before they are cut to bytes.
#[test]
fn golden_values_of_the_listing() {
    let golden_600 = [
        ((0.0, 0.0, 0.0), (132.14, 132.14)),
        ((0.0, 50.0, 0.0), (118.05, 141.39)),
        ((0.0, 100.0, 0.0), (101.71, 146.74)),
        ((0.0, -50.0, 0.0), (141.39, 118.05)),
        ((0.0, 0.0, 45.0), (112.45, 150.34)),
        ((0.0, 0.0, -45.0), (150.94, 112.44)),
        ((50.0, 0.0, 0.0), (93.01, 93.01)),
        ((0.0, 190.0, 0.0), (68.91, 99.00)),
        ((0.0, 300.0, 0.0), (28.49, 144.20)),
    ];
    let golden_680 = [
        ((0.0, 0.0, 0.0), (152.16, 152.16)),
        ((0.0, 50.0, 0.0), (138.98, 161.65)),
        ((0.0, 0.0, 45.0), (132.63, 164.70)),
        ((0.0, 300.0, 0.0), (53.41, 164.10)),
    ];
    let field = horizontal_trail();
    let check = |sigma_m, ((x, y, deg), (left, right)): ((f64, f64, f64), (f64, f64))| {
        let smell = field.sense(pose_mm_deg(x, y, deg), &strict(Perception::Listing, sigma_m));
        let off = (smell.left - left).abs().max((smell.right - right).abs());
        assert!(off < 0.005_001, "σ {sigma_m} at ({x}, {y}, {deg}): {smell:?}");
    };
    for golden in golden_600 {
        check(0.6, golden);
    }
    for golden in golden_680 {
        check(0.68, golden);
    }
}

#[test]
fn a_single_source_is_26_in_front_and_nothing_behind() {
    let mut field = Field::new(21, 21, 0.2).unwrap();
    field.set(12, 10, 1).unwrap();
    let config = strict(Perception::Listing, 0.6);
    // d = √(400² + 190²) = 442.83 mm, u = ⌊100 (1 − d/600)⌋ = 26; the folded angle keeps its length.
    let ahead = field.sense(Se2::IDENTITY, &config);
    assert!((ahead.left - 26.0).abs() < 1e-9 && (ahead.right - 26.0).abs() < 1e-9, "{ahead:?}");
    let behind = field.sense(pose_mm_deg(0.0, 0.0, 180.0), &config);
    assert_eq!(behind, Intensities { left: 0.0, right: 0.0 });
    assert!(behind.is_lost() && !ahead.is_lost());
    for perception in [Perception::Listing, Perception::VectorAtan2, Perception::ScalarSum] {
        let ahead = field.sense(Se2::IDENTITY, &exact(perception));
        let u = 100.0 * (1.0 - 442.831_796_509_689_6 / 600.0);
        assert!((ahead.left - u).abs() < 1e-9 && (ahead.right - u).abs() < 1e-9, "{ahead:?}");
        assert!(field.sense(Se2::new(0.0, 0.0, PI), &exact(perception)).is_lost());
    }
}

/// A robot displaced to the left of a trail must perceive more on the right. Swept over 40 places within a cell;
/// what is printed are least and greatest difference and how many of the 40 have the wrong sign.
#[test]
fn only_the_scalar_sum_is_right_on_wide_trails() {
    let mut table = String::new();
    for (width_cells, offset_m) in [(1, 0.06), (1, 0.12), (3, 0.06), (3, 0.12)] {
        for perception in [Perception::Listing, Perception::VectorAtan2, Perception::ScalarSum] {
            for vertical in [false, true] {
                let field = trail(width_cells, vertical);
                let differences: Vec<f64> = (0..40)
                    .map(|i| {
                        let along_m = 0.2 * f64::from(i) / 40.0;
                        let pose = if vertical {
                            Se2::new(-offset_m, along_m, FRAC_PI_2)
                        } else {
                            Se2::new(along_m, offset_m, 0.0)
                        };
                        field.sense(pose, &exact(perception)).difference()
                    })
                    .collect();
                let least = differences.iter().copied().fold(f64::INFINITY, f64::min);
                let greatest = differences.iter().copied().fold(f64::NEG_INFINITY, f64::max);
                let n_wrong = differences.iter().filter(|&&d| d >= 0.0).count();
                let direction = if vertical { "vertical" } else { "horizontal" };
                let line = format!(
                    "{width_cells} cells, {:.0} mm, {perception:?} {direction}: {least:.0} to \
                     {greatest:.0}, {n_wrong} wrong\n",
                    offset_m * 1000.0
                );
                table.push_str(&line);
            }
        }
    }
    expect![[r#"
        1 cells, 60 mm, Listing horizontal: -34 to -23, 0 wrong
        1 cells, 60 mm, Listing vertical: -34 to -23, 0 wrong
        1 cells, 60 mm, VectorAtan2 horizontal: -34 to -23, 0 wrong
        1 cells, 60 mm, VectorAtan2 vertical: -34 to -23, 0 wrong
        1 cells, 60 mm, ScalarSum horizontal: -42 to -22, 0 wrong
        1 cells, 60 mm, ScalarSum vertical: -42 to -22, 0 wrong
        1 cells, 120 mm, Listing horizontal: -70 to -44, 0 wrong
        1 cells, 120 mm, Listing vertical: -70 to -44, 0 wrong
        1 cells, 120 mm, VectorAtan2 horizontal: -70 to -44, 0 wrong
        1 cells, 120 mm, VectorAtan2 vertical: -70 to -44, 0 wrong
        1 cells, 120 mm, ScalarSum horizontal: -83 to -43, 0 wrong
        1 cells, 120 mm, ScalarSum vertical: -83 to -43, 0 wrong
        3 cells, 60 mm, Listing horizontal: -78 to -56, 0 wrong
        3 cells, 60 mm, Listing vertical: -35 to 80, 15 wrong
        3 cells, 60 mm, VectorAtan2 horizontal: -35 to 80, 15 wrong
        3 cells, 60 mm, VectorAtan2 vertical: -35 to 80, 15 wrong
        3 cells, 60 mm, ScalarSum horizontal: -89 to -52, 0 wrong
        3 cells, 60 mm, ScalarSum vertical: -89 to -52, 0 wrong
        3 cells, 120 mm, Listing horizontal: -145 to -95, 0 wrong
        3 cells, 120 mm, Listing vertical: -72 to 28, 4 wrong
        3 cells, 120 mm, VectorAtan2 horizontal: -72 to 28, 4 wrong
        3 cells, 120 mm, VectorAtan2 vertical: -72 to 28, 4 wrong
        3 cells, 120 mm, ScalarSum horizontal: -172 to -97, 0 wrong
        3 cells, 120 mm, ScalarSum vertical: -172 to -97, 0 wrong
    "#]]
    .assert_eq(&table);
}

/// The listing's arcsine makes turned maps smell differently; true directions do not.
#[test]
fn only_the_listing_notices_that_the_map_was_turned() {
    let turned = |config: &SenseConfig| {
        let flat = horizontal_trail().sense(pose_mm_deg(0.0, 0.0, 45.0), config);
        let upright = trail(1, true).sense(pose_mm_deg(0.0, 0.0, 135.0), config);
        [flat.left, flat.right, upright.left, upright.right].map(f64::round)
    };
    assert_eq!(turned(&strict(Perception::Listing, 0.6)), [112.0, 150.0, 112.0, 203.0]);
    assert_eq!(turned(&exact(Perception::VectorAtan2)), [114.0, 152.0, 114.0, 152.0]);
    assert_eq!(turned(&exact(Perception::ScalarSum)), [116.0, 213.0, 116.0, 213.0]);
}

/// Pose (0, 0, 90) on a vertical trail three cells wide: π = 3.14 decides which half of the row on the antennas'
/// line is in front.
#[test]
fn strict_arithmetic_is_lopsided_and_the_exact_one_is_not() {
    let (field, pose) = (trail(3, true), pose_mm_deg(0.0, 0.0, 90.0));
    let listing = field.sense(pose, &strict(Perception::Listing, 0.6));
    assert_eq!([listing.left.floor(), listing.right.floor()], [249.0, 192.0]);
    for perception in [Perception::Listing, Perception::VectorAtan2, Perception::ScalarSum] {
        let smell = field.sense(pose, &exact(perception));
        assert!((smell.left - smell.right).abs() < 1e-9, "{perception:?} {smell:?}");
    }
}

#[test]
fn reserved_cells_smell_of_nothing_and_strong_ones_of_more() {
    let mut field = Field::new(5, 5, 0.2).unwrap();
    let smell_of = |field: &Field| field.sense(Se2::new(-0.2, 0.0, 0.0), &SenseConfig::default());
    field.set(2, 2, 1).unwrap();
    let one = smell_of(&field);
    field.set(2, 2, 127).unwrap();
    assert!((smell_of(&field).left - 127.0 * one.left).abs() < 1e-9);
    field.set(2, 2, 128).unwrap();
    assert!(smell_of(&field).is_lost());
}

#[test]
fn the_scalar_sum_smells_a_source_it_stands_on_and_the_vectors_do_not() {
    let mut field = Field::new(5, 5, 0.2).unwrap();
    field.set(2, 2, 1).unwrap();
    let left_antenna_on_it = Se2::new(0.0, -0.19, 0.0);
    let left = |perception| field.sense(left_antenna_on_it, &exact(perception)).left;
    assert_eq!(left(Perception::ScalarSum), 100.0);
    assert_eq!([left(Perception::VectorAtan2), left(Perception::Listing)], [0.0, 0.0]);
    // Two millimetres, a hundredth of a cell, and a little more.
    let near = Se2::new(-0.002_01, -0.19, 0.0);
    assert!(field.sense(near, &exact(Perception::VectorAtan2)).left > 99.0);
}

#[test]
fn nonsense_perceives_nothing() {
    let field = horizontal_trail();
    let sense = |x_m, y_m, yaw_rad, sigma_m, antenna_spacing_m| {
        let config = SenseConfig { sigma_m, antenna_spacing_m, ..SenseConfig::default() };
        field.sense(Se2 { x_m, y_m, yaw_rad }, &config)
    };
    let (nan, inf) = (f64::NAN, f64::INFINITY);
    assert!(!sense(0.0, 0.0, 0.0, 0.6, 0.38).is_lost());
    for smell in [
        sense(nan, 0.0, 0.0, 0.6, 0.38),
        sense(0.0, inf, 0.0, 0.6, 0.38),
        sense(0.0, 0.0, nan, 0.6, 0.38),
        sense(0.0, 0.0, 0.0, 0.0, 0.38),
        sense(0.0, 0.0, 0.0, -1.0, 0.38),
        sense(0.0, 0.0, 0.0, inf, 0.38),
        sense(0.0, 0.0, 0.0, 0.6, nan),
        sense(1e300, 0.0, 0.0, 0.6, 0.38),
    ] {
        assert_eq!(smell, Intensities::default());
    }
    let bad = Se2 { x_m: nan, y_m: 0.0, yaw_rad: 0.0 };
    assert!(field.equivalent_source(bad, &SenseConfig::default()).is_none());
    assert!(exo_synapses(&field, bad, &SenseConfig::default()).is_empty());
}

/// One source at (400, 300) mm: perceived with 1 − 500/600 of itself, in its direction, at its distance.
#[test]
fn one_source_is_its_own_equivalent() {
    let mut field = Field::new(21, 21, 0.1).unwrap();
    field.set(14, 7, 2).unwrap();
    for yaw_rad in [0.0, 0.5, -0.7, FRAC_PI_4] {
        let seen =
            field.equivalent_source(Se2::new(0.0, 0.0, yaw_rad), &SenseConfig::default()).unwrap();
        assert!((seen.intensity - 200.0 / 6.0).abs() < 1e-9, "{seen:?}");
        assert!((seen.total_intensity - 200.0).abs() < 1e-9);
        assert!((seen.bearing_rad - (0.3_f64.atan2(0.4) - yaw_rad)).abs() < 1e-12);
        assert!((seen.distance_m - 0.5).abs() < 1e-12);
    }
    assert!(field.equivalent_source(Se2::new(0.0, 0.0, PI), &SenseConfig::default()).is_none());
}

/// By (5.38)–(5.43) and Annex B1, cell by cell over the whole field, angles by arcsine and arctangent.
fn by_definition(field: &Field, pose: Se2, config: &SenseConfig) -> Intensities {
    let (sin, cos) = pose.yaw_rad.sin_cos();
    let antenna = |side: f64| {
        let half = side * config.antenna_spacing_m / 2.0;
        let (ax, ay) = (pose.x_m - half * sin, pose.y_m + half * cos);
        let (mut s1, mut s2, mut scalar) = (0.0, 0.0, 0.0);
        for row in 0..field.height() {
            for col in 0..field.width() {
                let value = field.value(col, row);
                let x = (col as f64 - (field.width() / 2) as f64) * field.cell_size_m();
                let y = ((field.height() / 2) as f64 - row as f64) * field.cell_size_m();
                let front = (x - pose.x_m) * cos + (y - pose.y_m) * sin;
                let d = ((x - ax).powi(2) + (y - ay).powi(2)).sqrt();
                if value == 0 || value > 127 || front < -1e-9 || d >= config.sigma_m {
                    continue;
                }
                let p = 100.0 * f64::from(value) * (1.0 - d / config.sigma_m);
                scalar += p;
                if d < field.cell_size_m() / 100.0 {
                    continue;
                }
                let phi = match config.perception {
                    Perception::Listing => ((x - ax) / d).asin(),
                    _ => (x - ax).atan2(y - ay),
                };
                s1 += p * phi.sin();
                s2 += p * phi.cos();
            }
        }
        if config.perception == Perception::ScalarSum { scalar } else { f64::hypot(s1, s2) }
    };
    Intensities { left: antenna(1.0), right: antenna(-1.0) }
}

fn perceptions() -> impl Strategy<Value = Perception> {
    prop_oneof![
        Just(Perception::Listing),
        Just(Perception::VectorAtan2),
        Just(Perception::ScalarSum)
    ]
}

fn field_of(width: usize, height: usize, cell_size_m: f64, cells: &[(usize, usize, u8)]) -> Field {
    let mut field = Field::new(width, height, cell_size_m).unwrap();
    for &(col, row, value) in cells {
        field.set(col % width, row % height, value).unwrap();
    }
    field
}

proptest! {
    /// Narrow windows and wide ones (150 cells of 2 cm), in the middle, at the border and outside.
    #[test]
    fn the_window_matches_the_definition(
        perception in perceptions(),
        cells in proptest::collection::vec((0_usize..200, 0_usize..200, any::<u8>()), 0..60),
        (x, y, yaw) in (-2.5..2.5, -2.5..2.5, prop_oneof![-PI..PI, Just(0.0), Just(FRAC_PI_2), Just(-PI)]),
        (sigma_m, spacing) in (0.05..1.5, 0.0..0.6),
        fine in any::<bool>(),
    ) {
        let (n, size) = if fine { (150, 0.02) } else { (15, 0.2) };
        let field = field_of(n, n + 3, size, &cells);
        let config = SenseConfig { perception, sigma_m, antenna_spacing_m: spacing, strict: false };
        let pose = Se2::new(x, y, yaw);
        let (fast, slow) = (field.sense(pose, &config), by_definition(&field, pose, &config));
        let scale = 1e-9 * (1.0 + slow.left + slow.right);
        prop_assert!((fast.left - slow.left).abs() < scale, "{:?} {:?}", fast, slow);
        prop_assert!((fast.right - slow.right).abs() < scale, "{:?} {:?}", fast, slow);
    }

    /// Mirrored about the x axis, left is right.
    #[test]
    fn a_mirrored_world_swaps_the_antennas(
        perception in perceptions(),
        cells in proptest::collection::vec((0_usize..15, 0_usize..15, 0_u8..128), 1..40),
        (x, y, yaw) in (-1.0..1.0, -1.0..1.0, -PI..PI),
    ) {
        let mirrored: Vec<_> = cells.iter().map(|&(col, row, value)| (col, 14 - row, value)).collect();
        let (here, there) = (field_of(15, 15, 0.2, &cells), field_of(15, 15, 0.2, &mirrored));
        let smell = here.sense(Se2::new(x, y, yaw), &exact(perception));
        let mirror = there.sense(Se2::new(x, -y, -yaw), &exact(perception));
        // Where two of the drawn cells are the same cell, the mirror image has the same one on top.
        prop_assert!((smell.left - mirror.right).abs() < 1e-9);
        prop_assert!((smell.right - mirror.left).abs() < 1e-9);
    }

    #[test]
    fn true_directions_do_not_notice_a_quarter_turn(
        scalar in any::<bool>(),
        cells in proptest::collection::vec((0_usize..15, 0_usize..15, 0_u8..128), 1..40),
        (x, y, yaw) in (-1.0..1.0, -1.0..1.0, -PI..PI),
    ) {
        let perception = if scalar { Perception::ScalarSum } else { Perception::VectorAtan2 };
        // Counter-clockwise: (x, y) to (−y, x), so column 7 + i to row 7 − i.
        let turned: Vec<_> = cells.iter().map(|&(col, row, value)| (row, 14 - col, value)).collect();
        let (here, there) = (field_of(15, 15, 0.2, &cells), field_of(15, 15, 0.2, &turned));
        let smell = here.sense(Se2::new(x, y, yaw), &exact(perception));
        let same = there.sense(Se2::new(-y, x, yaw + FRAC_PI_2), &exact(perception));
        prop_assert!((smell.left - same.left).abs() < 1e-8, "{:?} {:?}", smell, same);
        prop_assert!((smell.right - same.right).abs() < 1e-8, "{:?} {:?}", smell, same);
    }

    /// What lies outside the reach of both antennas cannot matter, bit for bit.
    #[test]
    fn sources_out_of_reach_change_nothing(
        cells in proptest::collection::vec((0_usize..60, 0_usize..60, 1_u8..128), 0..300),
        perception in perceptions(),
    ) {
        let all = field_of(60, 60, 0.2, &cells);
        let mut near = Field::new(60, 60, 0.2).unwrap();
        for source in all.sources().filter(|s| s.in_map.norm() < 1.0) {
            near.set(source.col, source.row, source.value).unwrap();
        }
        let pose = Se2::new(0.03, -0.05, 0.4);
        prop_assert_eq!(all.sense(pose, &exact(perception)), near.sense(pose, &exact(perception)));
    }

    #[test]
    fn the_synapses_compute_the_scalar_sum(
        cells in proptest::collection::vec((0_usize..15, 0_usize..15, any::<u8>()), 0..60),
        (x, y, yaw) in (-1.6..1.6, -1.6..1.6, -PI..PI),
    ) {
        let field = field_of(15, 15, 0.2, &cells);
        let (pose, config) = (Se2::new(x, y, yaw), SenseConfig::default());
        let (mut left, mut right) = (0.0, 0.0);
        for synapse in exo_synapses(&field, pose, &config) {
            left += 100.0 * f64::from(synapse.value) * synapse.to_left_ratio;
            right += 100.0 * f64::from(synapse.value) * synapse.to_right_ratio;
        }
        let smell = field.sense(pose, &config);
        prop_assert!((smell.left - left).abs() < 1e-8 && (smell.right - right).abs() < 1e-8);
    }
}
