//! Sorts of files: what they are called and how one is known, so that no file of another sort is replaced.

/// Bytes of a file that are looked at to know its sort.
pub(crate) const HEAD_BYTES: usize = 4096;

/// A sort of file that is written.
#[derive(Clone, Copy, Debug)]
pub struct Kind {
    /// What it is called, with its article.
    name: &'static str,
    example: &'static str,
    recognises: fn(&[u8]) -> bool,
}

impl Kind {
    /// A recording (MCAP).
    pub const RECORDING: Self = Self {
        name: "a recording (MCAP)",
        example: "out.mcap",
        recognises: |b| b.starts_with(b"\x89MCAP0\r\n"),
    };
    /// A picture (SVG).
    pub const SVG: Self =
        Self { name: "a drawing (SVG)", example: "out.svg", recognises: |b| has(b, "<svg") };
    /// The image of a decision program.
    pub const IMAGE: Self = Self {
        name: "the image of a decision program",
        example: "out.bin",
        recognises: |b| b.starts_with(&[0]),
    };
    /// The listing of a decision program.
    pub const LISTING: Self = Self {
        name: "the listing of a decision program",
        example: "out.lst",
        recognises: |b| b.starts_with(b"Cairn RDPL compiler list file."),
    };
    /// A pose graph.
    pub const GRAPH: Self = Self {
        name: "a pose graph (g2o)",
        example: "out.g2o",
        recognises: |b| text(b).is_some_and(|t| t.contains("VERTEX") || t.contains("EDGE")),
    };
    /// A page (HTML).
    pub const HTML: Self = Self {
        name: "a page (HTML)",
        example: "out.html",
        recognises: |b| {
            let head: Vec<u8> = b.iter().take(64).map(u8::to_ascii_lowercase).collect();
            has(&head, "<!doctype html") || has(&head, "<html")
        },
    };
    /// A table (CSV).
    pub const CSV: Self = Self {
        name: "a table (CSV)",
        example: "out.csv",
        recognises: |b| first_line(b).is_some_and(|line| line.contains(',') || !line.contains(' ')),
    };
    /// One JSON object, or one a line.
    pub const JSON: Self = Self {
        name: "JSON",
        example: "out.json",
        recognises: |b| b.trim_ascii().starts_with(b"{"),
    };
    /// A grey picture.
    pub const PGM: Self = Self {
        name: "a picture (PGM)",
        example: "map.pgm",
        recognises: |b| b.starts_with(b"P5") || b.starts_with(b"P2"),
    };
    /// A coloured picture.
    pub const PNG: Self = Self {
        name: "a picture (PNG)",
        example: "map.png",
        recognises: |b| b.starts_with(b"\x89PNG"),
    };
    /// A map's description, as ROS's map server reads it.
    pub const MAP_YAML: Self = Self {
        name: "the description of a map (YAML)",
        example: "map.yaml",
        recognises: |b| text(b).is_some_and(|t| t.contains("image:")),
    };
    /// A trajectory: lines of numbers.
    pub const TRAJECTORY: Self = Self {
        name: "a trajectory (TUM)",
        example: "trajectory.tum",
        recognises: |b| {
            first_line(b).is_some_and(|l| {
                l.starts_with(|c: char| c == '#' || c == '-' || c.is_ascii_digit())
            })
        },
    };
    /// Settings of a survey.
    pub const SETTINGS: Self = Self {
        name: "settings (TOML)",
        example: "settings.toml",
        recognises: |b| text(b).is_some_and(|t| t.contains("[map]") || t.contains("[survey]")),
    };
    /// A text for people.
    pub const MARKDOWN: Self = Self {
        name: "a report (Markdown)",
        example: "report.md",
        recognises: |b| first_line(b).is_some_and(|line| line.starts_with('#')),
    };

    /// What it is called, with its article.
    pub fn name(&self) -> &'static str {
        self.name
    }

    pub(crate) fn example(&self) -> &'static str {
        self.example
    }

    /// Whether a file that begins with `head` (its first 4096 bytes, or all of it) is of this sort. An empty file
    /// is of every sort.
    pub fn recognises(&self, head: &[u8]) -> bool {
        head.is_empty() || (self.recognises)(head)
    }
}

fn has(bytes: &[u8], word: &str) -> bool {
    bytes.windows(word.len()).any(|window| window == word.as_bytes())
}

/// The text that bytes begin with; a letter that is cut in two at their end does not matter.
fn text(bytes: &[u8]) -> Option<&str> {
    let whole = match std::str::from_utf8(bytes) {
        Ok(text) => text,
        Err(e) if e.error_len().is_none() => std::str::from_utf8(&bytes[..e.valid_up_to()]).ok()?,
        Err(_) => return None,
    };
    (!whole.contains('\0')).then_some(whole)
}

fn first_line(bytes: &[u8]) -> Option<&str> {
    text(bytes)?.lines().next()
}
