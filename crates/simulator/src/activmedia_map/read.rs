//! The reader.

#![warn(clippy::indexing_slicing, clippy::arithmetic_side_effects)]

use std::str::FromStr;

use geometry::{Se2, Segment, Vec2};

use super::{CairnObject, MapFile, MapWarning};

/// No coordinate may be larger, millimetres: 1000 km.
const COORDINATE_MAX_MM: f64 = 1e9;
/// What the first line may be. The later ones have more kinds of objects and of header lines, and may have several sources.
const CATEGORIES: [&str; 5] = ["2D-Map", "2D-Map-Ex", "2D-Map-Ex2", "2D-Map-Ex3", "2D-Map-Ex4"];
/// Keys of the header that each source has for itself, with its name before them.
const KEYS_OF_SOURCES: [&str; 7] =
    ["MinPos", "MaxPos", "NumPoints", "LineMinPos", "LineMaxPos", "NumLines", "Resolution"];
/// Scanners that a map may come from.
const N_SOURCES_MAX: usize = 32;
/// Characters of an unexpected text that an error repeats.
const EXCERPT_CHARS: usize = 40;

/// A map that cannot be read, with the line (counted from 1) where.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MapFileError {
    /// Not a map at all.
    #[error(
        "line 1: found `{found}`, expected `2D-Map` or one of `2D-Map-Ex` to `2D-Map-Ex4`: this is \
         no ActivMedia 2-D map"
    )]
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
        what: String,
    },
    /// A section with fewer entries than its header states.
    #[error("{key} states {stated}, but the file has {found}: it was probably cut short")]
    CutShort {
        /// `NumLines` or `NumPoints`, with the source before it if there are several.
        key: String,
        /// What the header states.
        stated: usize,
        /// What the section has.
        found: usize,
    },
}

impl MapFileError {
    /// The line that is wrong, counted from 1, where it is one.
    pub const fn line(&self) -> Option<usize> {
        match self {
            Self::NotAMap { .. } => Some(1),
            Self::Unexpected { line, .. }
            | Self::Number { line, .. }
            | Self::Missing { line, .. }
            | Self::OpenQuote { line, .. }
            | Self::Repeated { line, .. } => Some(*line),
            Self::CutShort { .. } => None,
        }
    }
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
    if !CATEGORIES.contains(&first) {
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

/// What the header and the sections say about one scanner.
#[derive(Debug, Default)]
struct Source {
    /// What its keys and sections begin with: nothing for the usual one.
    prefix: String,
    n_lines_stated: Option<usize>,
    n_points_stated: Option<usize>,
    n_lines: usize,
    n_points: usize,
    has_lines: bool,
    has_data: bool,
}

#[derive(Debug)]
struct Reader {
    map: MapFile,
    section: Section,
    /// Those that `Sources` names; without it the usual one.
    sources: Vec<Source>,
    /// The one whose section is read.
    source: usize,
    names_sources: bool,
}

impl Default for Reader {
    fn default() -> Self {
        Self {
            map: MapFile::default(),
            section: Section::Header,
            sources: vec![Source::default()],
            source: 0,
            names_sources: false,
        }
    }
}

impl Reader {
    fn read_line(&mut self, number: usize, line: &str) -> Result<(), MapFileError> {
        if let Some((source, section)) = self.section_of(line) {
            return self.open(number, source, section, line);
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
                if let Some(source) = self.sources.get_mut(self.source) {
                    source.n_lines = source.n_lines.saturating_add(1);
                }
                Ok(())
            }
            Section::Data => {
                let [x, y] = fields.only(["x", "y"], "`x y` in mm, `LINES` or the end")?;
                self.map.points.push(metres(x, y));
                if let Some(source) = self.sources.get_mut(self.source) {
                    source.n_points = source.n_points.saturating_add(1);
                }
                Ok(())
            }
        }
    }

    /// The source and the section that a line begins, if it is one: `LINES`, or `Front_LINES` for the source `Front`.
    fn section_of(&self, line: &str) -> Option<(usize, Section)> {
        let (prefix, section) = if let Some(prefix) = line.strip_suffix("LINES") {
            (prefix, Section::Lines)
        } else {
            (line.strip_suffix("DATA")?, Section::Data)
        };
        let prefix = if prefix.is_empty() { prefix } else { prefix.strip_suffix('_')? };
        self.sources.iter().position(|s| s.prefix == prefix).map(|source| (source, section))
    }

    fn open(
        &mut self,
        line: usize,
        source: usize,
        section: Section,
        what: &str,
    ) -> Result<(), MapFileError> {
        let seen = self.sources.get_mut(source).map(|it| match section {
            Section::Data => &mut it.has_data,
            Section::Lines | Section::Header => &mut it.has_lines,
        });
        if seen.is_some_and(|seen| std::mem::replace(seen, true)) {
            return Err(MapFileError::Repeated { line, what: what.to_owned() });
        }
        (self.source, self.section) = (source, section);
        Ok(())
    }

    /// `Sources: name name …`, which the keys of these names follow.
    fn read_sources(&mut self, line: usize, names: &str) -> Result<(), MapFileError> {
        if std::mem::replace(&mut self.names_sources, true) {
            return Err(MapFileError::Repeated { line, what: "Sources".to_owned() });
        }
        let names: Vec<&str> = names.split_whitespace().collect();
        if names.is_empty() || names.len() > N_SOURCES_MAX {
            return Err(MapFileError::Number {
                line,
                what: "the number of sources",
                found: names.len().to_string(),
                expected: "from 1 to 32 names",
            });
        }
        // The first laser of these tools has no prefix: maps from before there were several stay as they are.
        let prefix = |name: &str| {
            if name.eq_ignore_ascii_case("SickLaser") { String::new() } else { name.to_owned() }
        };
        let known = |prefix: String| {
            let before = self.sources.iter().find(|s| s.prefix == prefix);
            let stated = before.map(|s| (s.n_lines_stated, s.n_points_stated)).unwrap_or_default();
            let (n_lines_stated, n_points_stated) = stated;
            Source { prefix, n_lines_stated, n_points_stated, ..Source::default() }
        };
        let mut sources: Vec<Source> = names.iter().map(|name| known(prefix(name))).collect();
        if sources.iter().all(|source| !source.prefix.is_empty()) {
            // Sections without a name may be there all the same.
            sources.push(known(String::new()));
        }
        if names.len() > 1 {
            let names = names.join(", ");
            self.map.warnings.push(MapWarning::Sources { names });
        }
        self.sources = sources;
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
        let (source, bare) = self.source_of(key.trim());
        match bare {
            "Sources" => self.read_sources(line, value)?,
            "NumLines" => {
                if let Some(source) = self.sources.get_mut(source) {
                    count(&mut source.n_lines_stated, "NumLines", line, value.trim())?;
                }
            }
            "NumPoints" => {
                if let Some(source) = self.sources.get_mut(source) {
                    count(&mut source.n_points_stated, "NumPoints", line, value.trim())?;
                }
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
                // Of several scanners the coarsest leaves no gaps.
                let resolution_m = resolution_mm / 1000.0;
                let before = self.map.resolution_m.unwrap_or(resolution_m);
                self.map.resolution_m = Some(resolution_m.max(before));
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
            _ => self.map.info.push((key.trim().to_owned(), value.trim().to_owned())),
        }
        Ok(())
    }

    /// The source that a key is about, and the key without its name.
    fn source_of<'k>(&self, key: &'k str) -> (usize, &'k str) {
        let of = |source: &Source| {
            key.strip_prefix(source.prefix.as_str()).filter(|bare| KEYS_OF_SOURCES.contains(bare))
        };
        let found = (0..).zip(&self.sources).find_map(|(i, source)| Some((i, of(source)?)));
        found.unwrap_or((0, key))
    }

    fn finish(mut self) -> Result<MapFile, MapFileError> {
        for source in &self.sources {
            let sections = [
                ("NumLines", source.n_lines_stated, source.n_lines),
                ("NumPoints", source.n_points_stated, source.n_points),
            ];
            for (key, stated, found) in sections {
                let Some(stated) = stated else { continue };
                let key = format!("{}{key}", source.prefix);
                if found < stated {
                    return Err(MapFileError::CutShort { key, stated, found });
                }
                if found > stated {
                    self.map.warnings.push(MapWarning::MoreThanStated { key, stated, found });
                }
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
        return Err(MapFileError::Repeated { line, what: key.to_owned() });
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
