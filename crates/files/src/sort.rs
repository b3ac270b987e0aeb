//! What a file is that was given where another was meant: known by how it begins, told with who takes it.

use std::{fmt, path::Path};

use decision::Mnemonic;

/// Bytes of a file that are looked at.
const HEAD_BYTES: usize = 4096;

/// A sort of file that people give; its text says what it is and what to do with it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sort {
    name: &'static str,
    advice: &'static str,
}

impl Sort {
    /// A mission.
    pub const MISSION: Self = Self::new("a mission (TOML)", "`cairn run` takes it");
    /// A decision program.
    pub const PROGRAM: Self = Self::new("a decision program (RDPL)", "`cairn rdpl` takes it");
    /// A recording of a run.
    pub const RECORDING: Self = Self::new("a recording (MCAP)", "`cairn replay` shows it");
    /// The log of a robot.
    pub const LOG: Self = Self::new("the log of a robot", "`cairn map` takes it");
    /// A pose graph.
    pub const GRAPH: Self = Self::new("a pose graph (g2o)", "`cairn graph` takes it");
    /// Settings of a survey.
    pub const SETTINGS: Self =
        Self::new("settings of a survey", "`cairn map LOG --config` takes it");
    /// A map of walls.
    pub const MAP: Self = Self::new("a map", "a mission names it (`[world] map = …`)");
    /// Packed with gzip.
    pub const GZIP: Self = Self::new("packed (gzip)", "unpack it first (gunzip --keep)");
    /// Text in UTF-16.
    pub const UTF16: Self = Self::new("text in UTF-16", "save it as UTF-8");
    /// Text in UTF-32.
    pub const UTF32: Self = Self::new("text in UTF-32", "save it as UTF-8");
    const ZIP: Self = Self::new("an archive (ZIP)", "unpack it first");
    const PACKED: Self = Self::new("packed", "unpack it first");
    const PICTURE: Self = Self::new("a picture", NOTHING);
    const PAGE: Self = Self::new("a page (HTML)", NOTHING);
    const DRAWING: Self = Self::new("a drawing (SVG or XML)", NOTHING);
    const JSON: Self = Self::new("JSON", NOTHING);
    const PDF: Self = Self::new("a document (PDF)", NOTHING);
    const EXECUTABLE: Self = Self::new("a program of this computer", NOTHING);
    const LISTING: Self =
        Self::new("the listing of a decision program", "give its source (.rdpl, .src)");

    const fn new(name: &'static str, advice: &'static str) -> Self {
        Self { name, advice }
    }

    /// Whether it may hold what a robot measured: a log, a recording or a graph, packed or not.
    pub fn is_measured(self) -> bool {
        [Self::LOG, Self::RECORDING, Self::GRAPH, Self::GZIP].contains(&self)
    }

    /// Whether nobody would take it for the text of a decision program, however it is encoded.
    pub fn is_foreign_to_programs(self) -> bool {
        ![Self::PROGRAM, Self::UTF16, Self::LOG, Self::MAP].contains(&self)
    }

    /// What a file called `name` that begins with `head` is; `None` when neither tells. How it begins counts before
    /// what it is called.
    pub fn of(name: &Path, head: &[u8]) -> Option<Self> {
        let head = &head[..head.len().min(HEAD_BYTES)];
        by_mark(head).or_else(|| by_zeros(head)).or_else(|| by_text(head)).or_else(|| by_name(name))
    }
}

/// What nobody here takes.
const NOTHING: &str = "nothing here reads it";

impl fmt::Display for Sort {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}; {}", self.name, self.advice)
    }
}

/// By the bytes that files of a sort begin with.
fn by_mark(head: &[u8]) -> Option<Sort> {
    const MARKS: [(&[u8], Sort); 16] = [
        (b"\x89MCAP", Sort::RECORDING),
        (b"\x1f\x8b", Sort::GZIP),
        (b"PK\x03\x04", Sort::ZIP),
        (b"\x28\xb5\x2f\xfd", Sort::PACKED),
        (b"\xfd7zXZ\x00", Sort::PACKED),
        (b"BZh", Sort::PACKED),
        (b"\x89PNG", Sort::PICTURE),
        (b"\xff\xd8\xff", Sort::PICTURE),
        (b"P5", Sort::PICTURE),
        (b"P2", Sort::PICTURE),
        (b"%PDF-", Sort::PDF),
        (b"\x7fELF", Sort::EXECUTABLE),
        (b"MATLAB 5.0", Sort::LOG),
        (b"\xff\xfe\x00\x00", Sort::UTF32),
        (b"\xff\xfe", Sort::UTF16),
        (b"\xfe\xff", Sort::UTF16),
    ];
    MARKS.iter().find(|(mark, _)| head.starts_with(mark)).map(|&(_, sort)| sort)
}

/// Text of two bytes a letter without a mark has a zero in every second place.
fn by_zeros(head: &[u8]) -> Option<Sort> {
    let (pairs, _) = head.as_chunks::<2>();
    let is_wide = |zero: usize| {
        let n = pairs.iter().filter(|pair| pair[zero] == 0 && pair[1 - zero] != 0).count();
        pairs.len() >= 2 && 10 * n >= 9 * pairs.len()
    };
    (is_wide(0) || is_wide(1)).then_some(Sort::UTF16)
}

/// By the words that lines of a text begin with.
fn by_text(head: &[u8]) -> Option<Sort> {
    let text = match std::str::from_utf8(head) {
        Ok(text) => text,
        // Cut within a letter, or in another encoding from there on.
        Err(error) => std::str::from_utf8(&head[..error.valid_up_to()]).unwrap_or_default(),
    };
    let text = text.trim_start_matches('\u{feff}').trim_start();
    let lines = || text.split(['\n', '\r']).map(str::trim).filter(|line| !line.is_empty());
    let has = |tables: &[&str]| lines().any(|line| tables.iter().any(|t| line.starts_with(t)));
    if has(&[
        "[mission]",
        "[[robots]]",
        "[robots.",
        "[world]",
        "[[world.",
        "[[events]]",
        "[decision]",
    ]) {
        return Some(Sort::MISSION);
    }
    if has(&["[map]", "[survey]"]) {
        return Some(Sort::SETTINGS);
    }
    let start = text.get(..16).unwrap_or(text).to_ascii_lowercase();
    if start.starts_with("<!doctype html") || start.starts_with("<html") {
        return Some(Sort::PAGE);
    }
    if start.starts_with("<svg") || start.starts_with("<?xml") {
        return Some(Sort::DRAWING);
    }
    if text.strip_prefix('{').is_some_and(|rest| rest.trim_start().starts_with(['"', '}'])) {
        return Some(Sort::JSON);
    }
    if text.starts_with("Cairn RDPL compiler list file.") {
        return Some(Sort::LISTING);
    }
    // Remarks of programs begin with a semicolon, those of all other texts with a hash.
    let line = lines().find(|line| !line.starts_with(['#', ';']));
    let Some(line) = line else { return text.starts_with(';').then_some(Sort::PROGRAM) };
    let first = line.split_ascii_whitespace().next().unwrap_or_default();
    let second = line.split_ascii_whitespace().nth(1).unwrap_or_default();
    match first {
        _ if text.starts_with(';') => Some(Sort::PROGRAM),
        _ if Mnemonic::by_name(first).is_some() || second.eq_ignore_ascii_case("EQU") => {
            Some(Sort::PROGRAM)
        }
        "2D-Map" | "2D-Map-Ex" | "2D-Map-Ex2" | "2D-Map-Ex3" | "2D-Map-Ex4" | "image:" => {
            Some(Sort::MAP)
        }
        "FLASER" | "RLASER" | "ODOM" | "PARAM" | "ROBOTLASER1" | "RAWLASER1" | "TRUEPOS" => {
            Some(Sort::LOG)
        }
        _ if first.starts_with("VERTEX") || first.starts_with("EDGE_") => Some(Sort::GRAPH),
        _ => None,
    }
}

/// By what a file is called.
fn by_name(name: &Path) -> Option<Sort> {
    match name.extension()?.to_str()?.to_ascii_lowercase().as_str() {
        "rdpl" | "src" => Some(Sort::PROGRAM),
        "mcap" | "part" => Some(Sort::RECORDING),
        "g2o" => Some(Sort::GRAPH),
        "clf" | "log" => Some(Sort::LOG),
        "map" => Some(Sort::MAP),
        "gz" => Some(Sort::GZIP),
        "svg" => Some(Sort::DRAWING),
        "html" => Some(Sort::PAGE),
        "json" => Some(Sort::JSON),
        "lst" => Some(Sort::LISTING),
        "png" | "pgm" | "jpg" | "jpeg" => Some(Sort::PICTURE),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_file_is_shows_in_how_it_begins() {
        let of = |name: &str, head: &[u8]| Sort::of(Path::new(name), head);
        for (head, sort) in [
            (&b"\x89MCAP0\r\n.."[..], Sort::RECORDING),
            (b"\x1f\x8b\x08\x00", Sort::GZIP),
            (b"\xff\xfe[\0m\0", Sort::UTF16),
            (b"\xfe\xff\0[\0m", Sort::UTF16),
            (b"[\0m\0i\0s\0", Sort::UTF16),
            (b"\0[\0m\0i\0s", Sort::UTF16),
            (b"\xff\xfe\0\0[\0\0\0", Sort::UTF32),
            (b"# mine\n[mission]\nname = 1", Sort::MISSION),
            (b"ADN O0,I0\nAND O1,I0,1L,1L,1L\n", Sort::PROGRAM),
            (b"; a remark\nADN O0\n", Sort::PROGRAM),
            (b"BELL equ I3\r\n", Sort::PROGRAM),
            (b"VERTEX_SE2 0 0 0 0\n", Sort::GRAPH),
            (b"# CARMEN\nPARAM robot_x 1\n", Sort::LOG),
            (b"[map]\nresolution_m = 0.1\n", Sort::SETTINGS),
            (b"2D-Map\nDATA\n", Sort::MAP),
            (b"<!DOCTYPE html><p>", Sort::PAGE),
            (b"{ \"a\": 1}", Sort::JSON),
        ] {
            let found = of("whatever", head);
            // Of a program with a slip in its first line only the name or a remark tells.
            let wanted = (!head.starts_with(b"ADN")).then_some(sort);
            assert_eq!(found, wanted, "{}", String::from_utf8_lossy(head));
            assert_eq!(of("a.rdpl", head), Some(sort));
        }
        assert_eq!(of("a.toml", b"x = = 1\n"), None);
        assert_eq!(of("a.toml", b""), None);
        assert_eq!(of("a.rdpl", b""), Some(Sort::PROGRAM));
    }
}
