//! The table of formats: what each is called, how it is known, what it needs, which options it understands.
//!
//! Messages, `cairn map --help`, the guide's table and the page read it. A new format is a row here, a row of
//! `READERS` in `read.rs`, and a file that reads it.

use std::fmt;

/// The enum of formats and everything that is said of each, made of one row for each.
macro_rules! formats {
    ($(
        $(#[$doc:meta])*
        $variant:ident = $name:literal, $endings:expr, $known_by:literal,
            second: $second:expr, takes: $takes:expr;
    )+) => {
        /// What a file was read as.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[non_exhaustive]
        pub enum Format {
            $( $(#[$doc])* $variant, )+
        }

        impl Format {
            /// Every format that is read.
            pub const ALL: &'static [Self] = &[$( Self::$variant, )+];

            /// What people call a file of it.
            pub const fn name(self) -> &'static str {
                match self { $( Self::$variant => $name, )+ }
            }

            /// The endings that such files usually have; what a file is says its content, not its name.
            pub const fn endings(self) -> &'static [&'static str] {
                match self { $( Self::$variant => &$endings, )+ }
            }

            /// How it is known, in words for the guide (names in backticks).
            pub const fn known_by(self) -> &'static str {
                match self { $( Self::$variant => $known_by, )+ }
            }

            /// What comes in a second file; `None` if it has none.
            pub const fn second(self) -> Option<&'static str> {
                match self { $( Self::$variant => $second, )+ }
            }

            /// The options that it understands, and others do not.
            pub const fn takes(self) -> &'static [Takes] {
                match self { $( Self::$variant => &$takes, )+ }
            }
        }
    };
}

formats! {
    /// A log of the CARMEN toolkit.
    Carmen = "CARMEN log", [".clf", ".log"],
        "lines `FLASER …`, `RAWLASER1 …` or `ROBOTLASER1 …`, with `ODOM …`",
        second: None, takes: [];
    /// Laser scans as text, as MRPT's tools write them.
    MrptLaser = "MRPT laser text", [".txt"],
        "rows of time, ranges, valid flags; remarks after `%`",
        second: Some("true poses (or `--truth`), if there are any,"), takes: [];
    /// A MAT file of level 5 with `saved_readings` and `saved_pose`.
    Mat = "MAT file", [".mat"],
        "level 5, with `saved_readings` and `saved_pose`",
        second: None, takes: [Takes::Ring];
    /// ARTEMIC's `saved_readings` and `saved_pose` as two texts.
    ArtemicText = "ARTEMIC text", [".txt"],
        "rows of readings with bars between them",
        second: Some("the poses"), takes: [Takes::Ring];
    /// Rows of a stamp and readings in millimetres, and a file of poses.
    SonarText = "sonar text", [".txt"],
        "rows of a stamp and readings in millimetres",
        second: Some("the poses"), takes: [Takes::Ring];
    /// Cairn's CSV.
    Csv = "CSV file", [".csv"],
        "Cairn's own: `# rig:` or column names such as `stamp_s`",
        second: None, takes: [Takes::Ring];
    /// Cairn's MCAP.
    CairnMcap = "recording of cairn", [".mcap"],
        "MCAP with Cairn's channels",
        second: None, takes: [Takes::Robot];
}

/// An option that only some formats understand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Takes {
    /// Which robot of several.
    Robot,
    /// Which ring of sonars took the readings, if not the one that such files usually are of.
    Ring,
}

impl Format {
    /// Whether it understands an option.
    pub fn understands(self, option: Takes) -> bool {
        self.takes().contains(&option)
    }

    /// All names as prose: `CARMEN log, MRPT laser text, … or recording of cairn`.
    pub fn listed() -> String {
        let names: Vec<&str> = Self::ALL.iter().map(|format| format.name()).collect();
        match names.split_last() {
            Some((last, others)) => format!("{} or {last}", others.join(", ")),
            None => String::new(),
        }
    }

    /// What it needs besides the file, in words for the guide; `–` for nothing.
    pub fn needs(self) -> String {
        let second = self.second().map(|what| format!("{what} as second file"));
        let options = self.takes().iter().map(|option| match option {
            Takes::Robot => "`--robot NAME`, if several robots are in it".to_owned(),
            Takes::Ring => "`--ring`, if the sonars are not the usual ones".to_owned(),
        });
        let needs: Vec<String> = second.into_iter().chain(options).collect();
        if needs.is_empty() { "–".to_owned() } else { needs.join("; ") }
    }
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
