//! Tests of the grid, the map text and deposits.

use expect_test::{Expect, expect};
use proptest::prelude::*;
use std::time::Duration;

use super::*;

const SECOND: Duration = Duration::from_secs(1);

fn check_text(text: &str, expected: &Expect) {
    expected.assert_eq(&match Field::from_text(text, 0.2) {
        Ok(field) => format!("{} x {}\n{}", field.width(), field.height(), field.to_text()),
        Err(error) => format!("{error}\n"),
    });
}

#[test]
fn rows_are_lines_whatever_separates_the_numbers() {
    check_text(
        "0;1,2\r\n\r\n [3] 127\t255",
        &expect![[r#"
        3 x 2
          0   1   2
          3 127 255
    "#]],
    );
}

#[test]
fn one_line_with_a_square_number_of_values_is_a_square() {
    check_text(
        "1 2 3 4 5 6 7 8 9",
        &expect![[r#"
        3 x 3
        1 2 3
        4 5 6
        7 8 9
    "#]],
    );
    check_text(
        "1 2 3",
        &expect![[r#"
        3 x 1
        1 2 3
    "#]],
    );
}

#[test]
fn ragged_lines_are_a_square_if_they_can_be() {
    check_text(
        "1 2 3\n4",
        &expect![[r#"
        2 x 2
        1 2
        3 4
    "#]],
    );
    check_text(
        "1 2 3\n\n4 55\n6",
        &expect![[r#"
        line 3, column 3: this row has 2 values, the first one has 3, and all 6 values do not fill a square; give every row the same number of values
    "#]],
    );
}

#[test]
fn what_cannot_be_read_is_located() {
    check_text(
        "0 1\n2 256",
        &expect![[r#"
        line 2, column 3: the value 256 is too large; cells hold 0 (empty), 1 to 127 (source) or 128 to 255 (reserved)
    "#]],
    );
    check_text(
        "99999999999999999999999",
        &expect![[r#"
        line 1, column 1: the value 18446744073709551615 is too large; cells hold 0 (empty), 1 to 127 (source) or 128 to 255 (reserved)
    "#]],
    );
    check_text(
        "",
        &expect![[r#"
        line 1, column 1: the text ends without a single number
    "#]],
    );
    check_text(
        "no\nnumber here",
        &expect![[r#"
        line 2, column 12: the text ends without a single number
    "#]],
    );
    check_text(
        "000000000000000000000000007",
        &expect![[r#"
        1 x 1
        7
    "#]],
    );
}

#[test]
fn cells_lie_where_the_listing_puts_them() {
    // N = 4: x = (−2 + i mod 4) a, y = (2 − i / 4) a.
    let field = Field::new(4, 4, 0.2).unwrap();
    for i in 0..16_usize {
        let (x, y) = ((i % 4) as f64 * 0.2 - 0.4, 0.4 - (i / 4) as f64 * 0.2);
        let centre = field.cell_centre(i % 4, i / 4);
        assert!((centre - Vec2::new(x, y)).norm() < 1e-12);
    }
    // N = 21: the middle cell's centre is the origin.
    let odd = Field::new(21, 21, 0.2).unwrap();
    assert_eq!(odd.cell_centre(10, 10), Vec2::zeros());
    assert_eq!(odd.cell_at(Vec2::zeros()), Some((10, 10)));
}

#[test]
fn a_point_on_an_edge_belongs_to_the_cell_further_right_and_up() {
    let field = Field::new(3, 3, 1.0).unwrap();
    assert_eq!(field.cell_at(Vec2::new(0.5, 0.5)), Some((2, 0)));
    assert_eq!(field.cell_at(Vec2::new(-0.5, -0.5)), Some((1, 1)));
    assert_eq!(field.cell_at(Vec2::new(-1.5, -1.5)), Some((0, 2)));
    assert_eq!(field.cell_at(Vec2::new(1.5, 0.0)), None);
    assert_eq!(field.cell_at(Vec2::new(0.0, 1.5)), None);
    assert_eq!(field.cell_at(Vec2::new(f64::NAN, 0.0)), None);
}

#[test]
fn impossible_fields_and_cells_are_refused_with_numbers() {
    let message = |result: Result<Field, FieldError>| result.unwrap_err().to_string();
    expect!["a pheromone field of 0 x 5 cells: each side must be at least 1 and the whole at most 67108864 cells; use larger cells"]
        .assert_eq(&message(Field::new(0, 5, 0.2)));
    assert!(Field::new(usize::MAX, 2, 0.2).is_err());
    assert!(Field::new(1 << 13, (1 << 13) + 1, 0.2).is_err());
    expect!["pheromone cell size NaN m: must be from 0.001 to 100 m"]
        .assert_eq(&message(Field::new(5, 5, f64::NAN)));
    let mut field = Field::new(5, 3, 0.2).unwrap();
    expect!["cell (column 5, row 0) is outside the field of 5 x 3 cells"]
        .assert_eq(&field.set(5, 0, 1).unwrap_err().to_string());
    assert!(field.set(0, 3, 1).is_err() && field.deposit(0, 3, 1).is_err());
    assert_eq!((field.value(5, 0), field.value(0, 3), field.revision()), (0, 0, 0));
}

#[test]
fn only_values_from_1_to_127_are_sources() {
    let mut field = Field::new(70, 2, 0.2).unwrap();
    for (col, value) in [(0, 1), (63, 127), (64, 128), (65, 255), (69, 9)] {
        field.set(col, 1, value).unwrap();
    }
    let sources: Vec<(usize, usize, u8)> =
        field.sources().map(|s| (s.col, s.row, s.value)).collect();
    assert_eq!(sources, [(0, 1, 1), (63, 1, 127), (69, 1, 9)]);
    assert_eq!(field.n_sources(), 3);
    field.set(63, 1, 200).unwrap();
    field.set(64, 1, 5).unwrap();
    field.set(0, 1, 0).unwrap();
    assert_eq!(field.sources().map(|s| s.col).collect::<Vec<_>>(), [64, 69]);
    assert_eq!(field.n_sources(), 2);
    field.clear();
    assert_eq!((field.n_sources(), field.sources().count()), (0, 0));
}

#[test]
fn a_revision_counts_changes_and_nothing_else() {
    let mut field = Field::new(3, 3, 0.2).unwrap();
    field.set(1, 1, 4).unwrap();
    let revision = field.revision();
    field.set(1, 1, 4).unwrap();
    field.evaporate(SECOND, SECOND);
    assert_eq!(field.revision(), revision);
    field.set(1, 1, 5).unwrap();
    assert!(field.revision() > revision);
}

#[test]
fn resizing_keeps_every_source_in_its_place() {
    let mut field = Field::new(5, 4, 0.2).unwrap();
    field.set(1, 1, 7).unwrap();
    field.set(4, 3, 9).unwrap();
    field.deposit(2, 2, 3).unwrap();
    let places = |field: &Field| -> Vec<(u8, i64, i64)> {
        let mm = |m: f64| (m * 1000.0).round() as i64;
        field.sources().map(|s| (s.value, mm(s.in_map.x), mm(s.in_map.y))).collect()
    };
    let larger = field.resized(8, 9).unwrap();
    assert_eq!(places(&larger), places(&field));
    assert_eq!(larger.n_deposits(), 1);
    assert_eq!(larger.resized(5, 4).unwrap(), field);
    // 3 x 3 keeps the block around the origin only.
    assert_eq!(places(&field.resized(3, 3).unwrap()), [(7, -200, 200), (3, 0, 0)]);
}

#[test]
fn a_deposit_fades_linearly_and_the_lasting_source_stays() {
    let mut field = Field::new(3, 3, 0.2).unwrap();
    field.set(1, 1, 10).unwrap();
    assert_eq!(field.deposit(1, 1, 20), Ok(30));
    let mut seen = Vec::new();
    for _ in 0..6 {
        seen.push(field.value(1, 1));
        field.evaporate(SECOND, 4 * SECOND);
    }
    assert_eq!(seen, [30, 25, 20, 15, 10, 10]);
    assert_eq!(field.n_deposits(), 0);
}

#[test]
fn passing_again_refreshes_what_is_left() {
    let mut field = Field::new(1, 1, 0.2).unwrap();
    field.deposit(0, 0, 40).unwrap();
    field.evaporate(2 * SECOND, 4 * SECOND);
    assert_eq!(field.deposit(0, 0, 60), Ok(80));
    field.evaporate(2 * SECOND, 4 * SECOND);
    assert_eq!(field.value(0, 0), 40);
    assert_eq!(field.deposit(0, 0, 255), Ok(127), "never more than the strongest source");
}

#[test]
fn reserved_cells_take_nothing() {
    let mut field = Field::new(2, 1, 0.2).unwrap();
    field.set(0, 0, 200).unwrap();
    assert_eq!(field.deposit(0, 0, 5), Ok(200));
    assert_eq!(field.deposit(1, 0, 0), Ok(0));
    assert_eq!(field.n_deposits(), 0);
}

#[test]
fn a_drawn_trail_can_be_made_to_evaporate() {
    let mut field = Field::from_text("4 0 200\n0 8 0", 0.2).unwrap();
    field.deposit(1, 1, 8).unwrap();
    field.make_volatile();
    field.evaporate(SECOND, 2 * SECOND);
    assert_eq!(field.values(), [2, 0, 200, 0, 8, 0]);
    field.evaporate(SECOND, 2 * SECOND);
    assert_eq!(field.values(), [0, 0, 200, 0, 0, 0]);
}

#[test]
fn a_lifetime_of_zero_ends_everything_at_once() {
    let mut field = Field::new(1, 1, 0.2).unwrap();
    field.deposit(0, 0, 40).unwrap();
    assert_eq!(field.evaporate(Duration::ZERO, Duration::ZERO), 1);
    assert_eq!(field.value(0, 0), 0);
}

proptest! {
    #[test]
    fn text_comes_back_as_it_went(
        width in 1_usize..80,
        height in 1_usize..5,
        values in proptest::collection::vec(any::<u8>(), 400),
    ) {
        // One row alone whose length is a square number is read as a square, as in the listing.
        prop_assume!(height > 1 || width.isqrt().pow(2) != width || width == 1);
        let mut field = Field::new(width, height, 0.2).unwrap();
        for (i, &value) in values.iter().take(width * height).enumerate() {
            field.set(i % width, i / width, value).unwrap();
        }
        prop_assert_eq!(Field::from_text(&field.to_text(), 0.2).unwrap(), field);
    }

    #[test]
    fn no_text_makes_the_reader_panic(text in "[0-9 ,\n\r\u{e4}-]{0,200}") {
        Field::from_text(&text, 0.2).ok();
    }

    #[test]
    fn a_cell_contains_its_centre_and_its_surroundings(
        (width, height) in (1_usize..20, 1_usize..20),
        (col, row) in (0_usize..20, 0_usize..20),
        (dx, dy) in (-0.4999..0.4999, -0.4999..0.4999),
    ) {
        prop_assume!(col < width && row < height);
        let field = Field::new(width, height, 0.2).unwrap();
        let point = field.cell_centre(col, row) + Vec2::new(0.2 * dx, 0.2 * dy);
        prop_assert_eq!(field.cell_at(point), Some((col, row)));
    }

    /// Exactly, not nearly: this is what makes runs repeat whatever the tick.
    #[test]
    fn time_may_be_cut_anyhow(
        amounts in proptest::collection::vec(any::<u8>(), 4),
        cuts in proptest::collection::vec(0_u64..4_000_000_000, 1..6),
    ) {
        let mut at_once = Field::new(2, 2, 0.2).unwrap();
        for (i, &amount) in amounts.iter().enumerate() {
            at_once.deposit(i % 2, i / 2, amount).unwrap();
        }
        let mut in_pieces = at_once.clone();
        let lifetime = Duration::from_secs(7);
        for &cut in &cuts {
            in_pieces.evaporate(Duration::from_nanos(cut), lifetime);
        }
        at_once.evaporate(Duration::from_nanos(cuts.iter().sum()), lifetime);
        prop_assert_eq!(at_once, in_pieces);
    }

    #[test]
    fn values_follow_the_model_rounded_up(peak in 1_u8..=127, age_ms in 0_u64..12_000) {
        let mut field = Field::new(1, 1, 0.2).unwrap();
        field.deposit(0, 0, peak).unwrap();
        let (age, lifetime) = (Duration::from_millis(age_ms), Duration::from_secs(10));
        field.evaporate(age, lifetime);
        let exact = crate::model::evaporated(f64::from(peak), age, lifetime);
        let value = f64::from(field.value(0, 0));
        prop_assert!(value >= exact - 1e-9 && value < exact + 1.0 + 1e-9);
    }
}
