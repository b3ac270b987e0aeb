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
    pub const CSV: Self = Self { name: "a table (CSV)", example: "out.csv", recognises: is_table };
    /// One JSON object, or one a line.
    pub const JSON: Self = Self {
        name: "JSON",
        example: "out.json",
        recognises: |b| {
            let inside = b.trim_ascii_start().strip_prefix(b"{").map(<[u8]>::trim_ascii_start);
            inside.is_some_and(|rest| rest.starts_with(b"\"") || rest.starts_with(b"}"))
        },
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
    /// A trajectory: lines of eight numbers.
    pub const TRAJECTORY: Self = Self {
        name: "a trajectory (TUM)",
        example: "trajectory.tum",
        recognises: |b| {
            let is_pose = |line: &str| {
                let is_number = |word: &str| word.parse::<f64>().is_ok();
                line.split_whitespace().filter(|word| is_number(word)).count() == 8
                    && line.split_whitespace().count() == 8
            };
            text(b).is_some_and(|t| t.lines().find(|l| !l.starts_with('#')).is_some_and(is_pose))
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
        recognises: |b| {
            let mut lines = text(b).unwrap_or_default().lines();
            lines.next().is_some_and(|line| line.starts_with("# "))
                && lines.all(|line| !line.starts_with(['[', ';']))
        },
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

/// Whether bytes begin with two lines or more of the same number of cells, at least two. Neither a key with a list
/// (`a = [1, 2]`) nor a head of a section (`[a]`) is a line of cells.
fn is_table(bytes: &[u8]) -> bool {
    let Some(text) = text(bytes) else { return false };
    let mut lines = text.split_inclusive('\n');
    let Some(head) = lines.next() else { return false };
    let n = n_cells(head);
    let is_setting = head.starts_with('[') || head.contains("= [") || head.contains("=[");
    // The second line may be cut off, or hold a line's end in a cell.
    let second = lines.next().filter(|line| line.ends_with('\n') && !line.contains('"'));
    n >= 2 && !is_setting && second.is_none_or(|line| n_cells(line) == n)
}

/// Cells of a line, with commas between quotation marks not counted.
fn n_cells(line: &str) -> usize {
    let mut is_quoted = false;
    let mut n = 1;
    for letter in line.chars() {
        match letter {
            '"' => is_quoted = !is_quoted,
            ',' if !is_quoted => n += 1,
            _ => {}
        }
    }
    n
}
