//! Maps for path planners: the Moving AI laboratory's `.map` text.
//!
//! | character | meaning there | state here |
//! | --- | --- | --- |
//! | `.` `G` | passable | free |
//! | `S` | swamp, passable from regular terrain | free |
//! | `@` | out of bounds | occupied |
//! | `T` | trees, not passable | occupied |
//! | `W` | water, not passable from terrain | occupied |
//! | `O` | out of bounds | unknown |
//!
//! Source: Sturtevant, "Pathfinding Benchmarks: File Formats", movingai.com/benchmarks. There the
//! first line of the map is row 0; here it is the last row, as everywhere in this crate.

use crate::{Cell, CellBox, MapError, State, Window};

const FORMAT: &str = "Moving AI map";

/// Writes `.` for free, `@` for occupied and `O` for unknown cells.
///
/// # Errors
///
/// [`MapError::Empty`] for a window without cells.
pub fn write(states: &Window<State>) -> Result<String, MapError> {
    let CellBox { width, height, .. } = states.area();
    if states.area().is_empty() {
        return Err(MapError::Empty);
    }
    let mut text = format!("type octile\nheight {height}\nwidth {width}\nmap\n");
    for row in states.values().chunks_exact(width).rev() {
        text.extend(row.iter().map(|state| match state {
            State::Free => '.',
            State::Occupied => '@',
            State::Unknown => 'O',
        }));
        text.push('\n');
    }
    Ok(text)
}

/// Reads a map; cell (0, 0) is the lower left one.
///
/// # Errors
///
/// [`MapError::Text`] with the line, and [`MapError::TooLarge`].
pub fn read(text: &str) -> Result<Window<State>, MapError> {
    let mut lines = (1..).zip(text.lines().map(str::trim_end));
    let kinds = ["tile", "octile", "octile_unicost"];
    head(&mut lines, "type", |word| kinds.contains(&word).then_some(0), "type octile")?;
    let number = |word: &str| word.parse().ok().filter(|n: &usize| *n > 0);
    let height = head(&mut lines, "height", number, "height with a number above 0")?;
    let width = head(&mut lines, "width", number, "width with a number above 0")?;
    head(&mut lines, "map", |word| word.is_empty().then_some(0), "map")?;
    let area = CellBox { min: Cell::new(0, 0), width, height };
    // Each cell is a character, so the text itself is the limit of the memory.
    if area.n_cells() > text.len() {
        let (found, expected) = (lines.count(), height);
        return Err(MapError::Length { format: FORMAT, found, expected, unit: "lines of cells" });
    }
    let mut states = Window::filled(area, State::Unknown)?;
    for (n_lines, row) in (0..height).rev().enumerate() {
        let Some((line, content)) = lines.next() else {
            let (found, expected) = (n_lines, height);
            return Err(MapError::Length {
                format: FORMAT,
                found,
                expected,
                unit: "lines of cells",
            });
        };
        read_row(content, line, states.row_mut(row as i32))?;
    }
    match lines.find(|(_, content)| !content.is_empty()) {
        Some((line, content)) => {
            let expected = format!("nothing after {height} lines of cells");
            Err(refused(line, &format!("`{}`", shortened(content)), expected))
        }
        None => Ok(states),
    }
}

fn read_row(content: &str, line: usize, row: &mut [State]) -> Result<(), MapError> {
    let n = content.chars().count();
    if n != row.len() {
        return Err(refused(line, &format!("{n} cells"), format!("{} cells", row.len())));
    }
    for (to, c) in row.iter_mut().zip(content.chars()) {
        *to = match c {
            '.' | 'G' | 'S' => State::Free,
            '@' | 'T' | 'W' => State::Occupied,
            'O' => State::Unknown,
            _ => return Err(refused(line, &format!("`{c}`"), "one of . G S @ T W O")),
        };
    }
    Ok(())
}

/// The value behind `key` on the next line.
fn head<'a>(
    lines: &mut impl Iterator<Item = (usize, &'a str)>,
    key: &str,
    value_of: impl Fn(&str) -> Option<usize>,
    expected: &str,
) -> Result<usize, MapError> {
    let Some((line, content)) = lines.next() else {
        return Err(refused(1, "the end of the text", format!("`{expected}`")));
    };
    let mut words = content.split_whitespace();
    let (name, value) = (words.next(), words.next().unwrap_or(""));
    let fits = name == Some(key) && words.next().is_none();
    let value = value_of(value).filter(|_| fits);
    value
        .ok_or_else(|| refused(line, &format!("`{}`", shortened(content)), format!("`{expected}`")))
}

fn shortened(content: &str) -> String {
    content.chars().take(24).collect()
}

fn refused(line: usize, found: &str, expected: impl Into<String>) -> MapError {
    MapError::Text { format: FORMAT, line, found: found.to_owned(), expected: expected.into() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use State::{Free, Occupied, Unknown};
    use expect_test::expect;
    use proptest::{collection::vec, prelude::*};

    #[test]
    fn every_character_has_its_state_and_the_first_line_is_the_top() {
        let states = read("type octile\nheight 2\nwidth 4\nmap\n.GS@\r\nTWO.\n").unwrap();
        assert_eq!(states.row(1), &[Free, Free, Free, Occupied]);
        assert_eq!(states.row(0), &[Occupied, Occupied, Unknown, Free]);
        expect!["type octile\nheight 2\nwidth 4\nmap\n...@\n@@O.\n"]
            .assert_eq(&write(&states).unwrap());
        let nothing = Window::filled(CellBox { width: 0, ..states.area() }, Free).unwrap();
        assert_eq!(write(&nothing), Err(MapError::Empty));
    }

    #[test]
    fn what_does_not_fit_is_refused_with_its_line() {
        let cases: [&str; 10] = [
            "",
            "type hex\n",
            "type octile\nwidth 3\n",
            "type octile\nheight 0\n",
            "type octile\nheight 1\nwidth 1 1\n",
            "type octile\nheight 1\nwidth 2\nmap\n.x",
            "type octile\nheight 1\nwidth 2\nmap\n.",
            "type octile\nheight 3\nwidth 2\nmap\n..\n..",
            "type octile\nheight 1\nwidth 2\nmap\n..\n\n..",
            "type octile\nheight 99999999\nwidth 99999999999\nmap\n..",
        ];
        let messages = cases.map(|case| read(case).unwrap_err().to_string());
        expect![[r##"
            Moving AI map, line 1: found the end of the text, expected `type octile`
            Moving AI map, line 1: found `type hex`, expected `type octile`
            Moving AI map, line 2: found `width 3`, expected `height with a number above 0`
            Moving AI map, line 2: found `height 0`, expected `height with a number above 0`
            Moving AI map, line 3: found `width 1 1`, expected `width with a number above 0`
            Moving AI map, line 5: found `x`, expected one of . G S @ T W O
            Moving AI map, line 5: found 1 cells, expected 2 cells
            Moving AI map: 2 lines of cells, expected 3: the file is damaged or cut short
            Moving AI map, line 7: found `..`, expected nothing after 1 lines of cells
            Moving AI map: 1 lines of cells, expected 99999999: the file is damaged or cut short
        "##]]
        .assert_eq(&(messages.join("\n") + "\n"));
    }

    proptest! {
        #[test]
        fn what_is_written_is_read(
            width in 1..9_usize,
            states in vec(prop_oneof![Just(State::Free), Just(State::Occupied), Just(State::Unknown)], 40),
        ) {
            let area = CellBox { min: Cell::new(0, 0), width, height: 40 / width };
            let states = Window::from_values(area, states[..area.n_cells()].to_vec()).unwrap();
            prop_assert_eq!(read(&write(&states).unwrap()).unwrap(), states);
        }

        #[test]
        fn no_text_makes_it_panic(text in "(type octile\n|height |width |map\n|[0-9]|\n|[.@TO]|é){0,20}") {
            let _result = read(&text);
        }
    }
}
