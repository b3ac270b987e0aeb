//! Queries with known answers: the Moving AI laboratory's `.scen` text.
//!
//! A line for each query: bucket, map, width and height of the map, column and row of start and goal, counted from
//! the **upper** left cell, and the length of a shortest way with eight directions that cuts no corner, in cells.
//!
//! Source: Sturtevant, "Pathfinding Benchmarks: File Formats", movingai.com/benchmarks. Lengths are printed there with 5
//! to 8 decimals, or with six digits in all, so each is compared within [`Query::tolerance_cells`].

/// Printed lengths with many decimals were summed in single precision, cells.
const TOLERANCE_MIN_CELLS: f64 = 1e-4;

/// One query.
#[derive(Clone, Debug, PartialEq)]
pub struct Query {
    /// The line of the text that it stands in, counted from 1.
    pub line: usize,
    /// The map's name, as written.
    pub map: String,
    /// Columns and rows of the map that it is for.
    pub size: [usize; 2],
    /// Column and row of the start, from the upper left cell.
    pub start: [usize; 2],
    /// Column and row of the goal, from the upper left cell.
    pub goal: [usize; 2],
    /// Length of a shortest way, cells.
    pub optimal_cells: f64,
    /// By how much a length may differ from the printed one and still be the same: its sixth digit, or 1e-4, cells.
    pub tolerance_cells: f64,
}

/// A line that is no query.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("line {line}: found `{found}`, expected {expected}")]
pub struct ScenarioError {
    /// Which line, counted from 1.
    pub line: usize,
    /// What stands there.
    pub found: String,
    /// What should.
    pub expected: &'static str,
}

/// Reads the queries of a text.
///
/// # Errors
///
/// [`ScenarioError`] for the first line that is wrong.
pub fn parse(text: &str) -> Result<Vec<Query>, ScenarioError> {
    let mut lines = (1..).zip(text.trim_start_matches('\u{feff}').lines());
    let wrong = |line: usize, found: &str, expected| {
        let found = found.chars().take(60).collect();
        Err(ScenarioError { line, found, expected })
    };
    match lines.next() {
        Some((_, first)) if first.split_whitespace().next() == Some("version") => {}
        Some((line, first)) => return wrong(line, first, "`version 1`"),
        None => return wrong(1, "", "`version 1`"),
    }
    let mut queries = Vec::new();
    for (line, content) in lines {
        if content.trim().is_empty() {
            continue;
        }
        let Some(query) = query(line, content) else {
            return wrong(
                line,
                content,
                "bucket, map, width, height, start x, start y, goal x, goal y, length",
            );
        };
        queries.push(query);
    }
    Ok(queries)
}

fn query(line: usize, content: &str) -> Option<Query> {
    // Names of maps may have blanks: the eight numbers are taken from the end.
    let mut fields = content.split_whitespace().rev();
    let length = fields.next()?;
    let optimal_cells: f64 = length.parse().ok().filter(|length: &f64| *length >= 0.0)?;
    // Six digits in all, trailing zeros left out: the sixth is worth this.
    let n_digits = length.chars().filter(char::is_ascii_digit).count();
    let sixth = 10.0_f64.powf(f64::max(optimal_cells, 1.0).log10().floor() - 5.0);
    let tolerance_cells =
        if n_digits <= 6 { sixth.max(TOLERANCE_MIN_CELLS) } else { TOLERANCE_MIN_CELLS };
    let mut whole = || fields.next()?.parse().ok();
    let [goal_y, goal_x, start_y, start_x, height, width] =
        [whole()?, whole()?, whole()?, whole()?, whole()?, whole()?];
    let map: Vec<&str> = fields.collect();
    let (_bucket, map) = map.split_last()?;
    let map: Vec<&str> = map.iter().rev().copied().collect();
    Some(Query {
        line,
        map: map.join(" "),
        size: [width, height],
        start: [start_x, start_y],
        goal: [goal_x, goal_y],
        optimal_cells,
        tolerance_cells,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn queries_are_read_and_wrong_lines_named() {
        let text =
            "version 1\n0\tmaps/a b.map\t8\t9\t1\t2\t3\t4\t2.82842712\n\n3 c.map 8 9 0 0 7 8 12\n";
        let queries = parse(text).unwrap();
        assert_eq!(queries.len(), 2);
        assert_eq!((queries[0].map.as_str(), queries[0].line), ("maps/a b.map", 2));
        assert_eq!((queries[0].size, queries[0].start, queries[0].goal), ([8, 9], [1, 2], [3, 4]));
        assert!((queries[1].optimal_cells - 12.0).abs() < 1e-12 && queries[1].line == 4);
        assert!((queries[0].tolerance_cells - 1e-4).abs() < 1e-12);
        assert!((queries[1].tolerance_cells - 1e-4).abs() < 1e-12);
        let rounded = parse("version 1\n26 c.map 512 512 63 411 130 382 286.765").unwrap();
        assert!((rounded[0].tolerance_cells - 1e-3).abs() < 1e-12);
        for (text, line) in [
            ("", 1),
            ("0 a 8 9 1 2 3 4 5", 1),
            ("version 1\n0 a 8 9 1 2 3 4", 2),
            ("version 1\n0 a 8 9 1 2 3 4 x", 2),
            ("version 1\n0 a 8 9 1 -2 3 4 5", 2),
            ("version 1\n0 a 8 9 1 2 3 4 NaN", 2),
        ] {
            assert_eq!(parse(text).unwrap_err().line, line, "{text:?}");
        }
    }
}
