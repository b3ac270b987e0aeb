//! The reader.

#![warn(clippy::indexing_slicing, clippy::arithmetic_side_effects)]

use std::str::FromStr;

use geometry::{Se2, Segment, Vec2};

use super::{CairnObject, MapFile, MapWarning};

/// No coordinate may be larger, millimetres: 1000 km.
const COORDINATE_MAX_MM: f64 = 1e9;
/// Characters of an unexpected text that an error repeats.
const EXCERPT_CHARS: usize = 40;

/// A map that cannot be read, with the line (counted from 1) where.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MapFileError {
    /// Not a map at all.
    #[error("line 1: found `{found}`, expected `2D-Map`: this is no ActivMedia 2-D map")]
    NotAMap {
        /// The first line, cut.
        found: String,
    },
    /// A line that is neither a header, nor a section's name, nor of the section's shape.
    #[error("line {line}: found `{found}`, expected {expected}")]
    Unexpected {
        /// Where.
        line: usize,
        /// What, cut.
        found: String,
        /// What is allowed there, as prose.
        expected: &'static str,
    },
    /// A number that is none, not finite, or too large.
    #[error("line {line}: {what} is `{found}`, expected {expected}")]
    Number {
        /// Where.
        line: usize,
        /// Which number.
        what: &'static str,
        /// What, cut.
        found: String,
        /// What is allowed there, as prose.
        expected: &'static str,
    },
    /// Too few numbers on a line.
    #[error("line {line}: {what} is missing: expected {expected}")]
    Missing {
        /// Where.
        line: usize,
        /// Which number.
        what: &'static str,
        /// What the line should hold, as prose.
        expected: &'static str,
    },
    /// A quotation that does not end on its line.
    #[error("line {line}: a quotation mark at column {column} is not closed")]
    OpenQuote {
        /// Where.
        line: usize,
        /// Character of the line, counted from 1.
        column: usize,
    },
    /// A section or count that was given before.
    #[error("line {line}: `{what}` was already given: keep one")]
    Repeated {
        /// Where.
        line: usize,
        /// Which.
        what: &'static str,
    },
    /// A section with fewer entries than its header states.
    #[error("{key} states {stated}, but the file has {found}: it was probably cut short")]
    CutShort {
        /// `NumLines` or `NumPoints`.
        key: &'static str,
        /// What the header states.
        stated: usize,
        /// What the section has.
        found: usize,
    },
}

/// Reads a map.
///
/// O(n) time and memory for n bytes; never panics, whatever the bytes.
///
/// ```
/// let map = simulator::activmedia_map::parse("2D-Map\nLINES\n0 0 2500 0\n")?;
/// assert_eq!(map.lines[0].b.x, 2.5);
/// # Ok::<(), simulator::activmedia_map::MapFileError>(())
/// ```
///
/// # Errors
///
/// [`MapFileError`] for the first line that is wrong, or for a section that was cut short.
pub fn parse(text: &str) -> Result<MapFile, MapFileError> {
    let mut reader = Reader::default();
    // A byte order mark is what some editors leave at the start.
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut lines = (1..).zip(text.lines());
    let first = lines.next().map_or("", |(_, line)| line.trim());
    if first != "2D-Map" {
        return Err(MapFileError::NotAMap { found: excerpt(first) });
    }
    for (number, line) in lines {
        let line = line.trim();
        if !line.is_empty() {
            reader.read_line(number, line)?;
        }
    }
    reader.finish()
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Section {
    #[default]
    Header,
    Lines,
    Data,
}

#[derive(Debug, Default)]
struct Reader {
    map: MapFile,
    section: Section,
    n_lines_stated: Option<usize>,
    n_points_stated: Option<usize>,
    has_lines: bool,
    has_data: bool,
}

impl Reader {
    fn read_line(&mut self, number: usize, line: &str) -> Result<(), MapFileError> {
        match line {
            "LINES" => return self.open(number, Section::Lines),
            "DATA" => return self.open(number, Section::Data),
            _ => {}
        }
        let fields = Fields { line: number, rest: line };
        match self.section {
            Section::Header => self.read_header(number, line),
            Section::Lines => {
                let [x1, y1, x2, y2] = fields
                    .only(["x1", "y1", "x2", "y2"], "`x1 y1 x2 y2` in mm, `DATA` or the end")?;
                let segment = Segment { a: metres(x1, y1), b: metres(x2, y2) };
                if segment.a == segment.b {
                    self.map.warnings.push(MapWarning::EmptyLine { line: number });
                }
                self.map.lines.push(segment);
                Ok(())
            }
            Section::Data => {
                let [x, y] = fields.only(["x", "y"], "`x y` in mm, `LINES` or the end")?;
                self.map.points.push(metres(x, y));
                Ok(())
            }
        }
    }

    fn open(&mut self, line: usize, section: Section) -> Result<(), MapFileError> {
        let (seen, what) = match section {
            Section::Data => (&mut self.has_data, "DATA"),
            Section::Lines | Section::Header => (&mut self.has_lines, "LINES"),
        };
        if std::mem::replace(seen, true) {
            return Err(MapFileError::Repeated { line, what });
        }
        self.section = section;
        Ok(())
    }

    fn read_header(&mut self, line: usize, text: &str) -> Result<(), MapFileError> {
        let Some((key, value)) = text.split_once(':') else {
            return Err(MapFileError::Unexpected {
                line,
                found: excerpt(text),
                expected: "`Key: values`, `LINES` or `DATA`",
            });
        };
        let fields = Fields { line, rest: value.trim() };
        match key.trim() {
            "NumLines" => {
                count(&mut self.n_lines_stated, "NumLines", line, value.trim())?;
            }
            "NumPoints" => {
                count(&mut self.n_points_stated, "NumPoints", line, value.trim())?;
            }
            "Resolution" => {
                let [resolution_mm] = fields.only(["the resolution"], "one length in mm")?;
                if resolution_mm <= 0.0 {
                    return Err(MapFileError::Number {
                        line,
                        what: "the resolution",
                        found: excerpt(value.trim()),
                        expected: "a length above 0 mm",
                    });
                }
                self.map.resolution_m = Some(resolution_mm / 1000.0);
            }
            "Cairn" => {
                let thing = read_cairn(line, text, value.trim())?;
                if thing.kind == "RobotHome" && self.map.home.is_none() {
                    self.map.home = Some(thing.pose);
                }
                self.map.things.push(thing);
            }
            // The extent is worked out anew, and is checked only for being numbers.
            "MinPos" | "MaxPos" | "LineMinPos" | "LineMaxPos" => {
                fields.only(["x", "y"], "`x y` in mm")?;
            }
            other => self.map.info.push((other.to_owned(), value.trim().to_owned())),
        }
        Ok(())
    }

    fn finish(mut self) -> Result<MapFile, MapFileError> {
        let sections = [
            ("NumLines", self.n_lines_stated, self.map.lines.len()),
            ("NumPoints", self.n_points_stated, self.map.points.len()),
        ];
        for (key, stated, found) in sections {
            let Some(stated) = stated else { continue };
            if found < stated {
                return Err(MapFileError::CutShort { key, stated, found });
            }
            if found > stated {
                self.map.warnings.push(MapWarning::MoreThanStated { key, stated, found });
            }
        }
        Ok(self.map)
    }
}

/// `TYPE x y th "description" ICON "name" [x1 y1 x2 y2]`
///
/// `whole` is the line that ends in `text`, for the columns of errors.
fn read_cairn(line: usize, whole: &str, text: &str) -> Result<CairnObject, MapFileError> {
    const SHAPE: &str = "`TYPE x y th \"description\" ICON \"name\" [x1 y1 x2 y2]`";
    let mut fields = Fields { line, rest: text };
    let kind = fields.word("the type", SHAPE)?.to_owned();
    let x = fields.coordinate("x", SHAPE)?;
    let y = fields.coordinate("y", SHAPE)?;
    let th_deg = fields.coordinate("th", SHAPE)?;
    let description = fields.quoted(whole, "the description", SHAPE)?;
    let icon = fields.word("the icon", SHAPE)?.to_owned();
    let name = fields.quoted(whole, "the name", SHAPE)?;
    let area = if fields.rest.is_empty() {
        None
    } else {
        let [x1, y1, x2, y2] = fields.only(["x1", "y1", "x2", "y2"], SHAPE)?;
        Some([metres(x1, y1), metres(x2, y2)])
    };
    let place = metres(x, y);
    let pose = Se2::new(place.x, place.y, th_deg.to_radians());
    Ok(CairnObject { kind, pose, name, description, icon, area })
}

/// What is left of a line.
#[derive(Clone, Copy)]
struct Fields<'a> {
    line: usize,
    rest: &'a str,
}

impl<'a> Fields<'a> {
    /// The next word; `what` and `shape` are for the error.
    fn word(&mut self, what: &'static str, shape: &'static str) -> Result<&'a str, MapFileError> {
        let rest = self.rest.trim_start();
        let end = rest.find(char::is_whitespace).unwrap_or(rest.len());
        let (word, rest) = rest.split_at(end);
        self.rest = rest.trim_start();
        if word.is_empty() {
            return Err(MapFileError::Missing { line: self.line, what, expected: shape });
        }
        Ok(word)
    }

    fn coordinate(&mut self, what: &'static str, shape: &'static str) -> Result<f64, MapFileError> {
        let word = self.word(what, shape)?;
        match f64::from_str(word) {
            Ok(number) if number.abs() <= COORDINATE_MAX_MM => Ok(number),
            _ => Err(MapFileError::Number {
                line: self.line,
                what,
                found: excerpt(word),
                expected: "a number from -1e9 to 1e9",
            }),
        }
    }

    /// Exactly these numbers and nothing more.
    fn only<const N: usize>(
        mut self,
        names: [&'static str; N],
        shape: &'static str,
    ) -> Result<[f64; N], MapFileError> {
        let mut numbers = [0.0; N];
        for (number, name) in numbers.iter_mut().zip(names) {
            *number = self.coordinate(name, shape)?;
        }
        if self.rest.is_empty() {
            return Ok(numbers);
        }
        Err(MapFileError::Unexpected {
            line: self.line,
            found: excerpt(self.rest),
            expected: shape,
        })
    }

    /// A text in quotation marks, which may hold blanks but no quotation mark.
    fn quoted(
        &mut self,
        whole: &str,
        what: &'static str,
        shape: &'static str,
    ) -> Result<String, MapFileError> {
        let Some(inside) = self.rest.strip_prefix('"') else {
            let found = self.word(what, shape)?;
            return Err(MapFileError::Unexpected {
                line: self.line,
                found: excerpt(found),
                expected: shape,
            });
        };
        let Some((text, rest)) = inside.split_once('"') else {
            let before = whole.len().saturating_sub(self.rest.len());
            let column = whole.get(..before).map_or(0, |t| t.chars().count()).saturating_add(1);
            return Err(MapFileError::OpenQuote { line: self.line, column });
        };
        self.rest = rest.trim_start();
        Ok(text.to_owned())
    }
}

fn count(
    slot: &mut Option<usize>,
    key: &'static str,
    line: usize,
    text: &str,
) -> Result<(), MapFileError> {
    let Ok(number) = usize::from_str(text) else {
        return Err(MapFileError::Number {
            line,
            what: key,
            found: excerpt(text),
            expected: "a whole number, 0 or more",
        });
    };
    if slot.replace(number).is_some() {
        return Err(MapFileError::Repeated { line, what: key });
    }
    Ok(())
}

fn metres(x_mm: f64, y_mm: f64) -> Vec2 {
    Vec2::new(x_mm / 1000.0, y_mm / 1000.0)
}

fn excerpt(text: &str) -> String {
    let cut: String = text.chars().take(EXCERPT_CHARS).collect();
    if cut.len() < text.len() { format!("{cut}…") } else { cut }
}
