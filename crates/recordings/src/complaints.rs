//! What was wrong in a file that could be read all the same: where, what, and what was done about it.

use std::{collections::BTreeMap, fmt};

/// Complaints that are kept in full when nothing else is asked for; all are counted.
pub(crate) const KEPT_DEFAULT: usize = 100;

/// Where in a file something was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Place {
    /// The file as a whole.
    File,
    /// A line, from 1, as an editor counts them (comments and empty lines count).
    Line(usize),
    /// A line of the second file: poses or truth.
    SecondFileLine(usize),
    /// A byte of the (unpacked) file, from 0.
    Byte(usize),
    /// A row of a matrix, from 1.
    Row(usize),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File => write!(f, "the file"),
            Self::Line(line) => write!(f, "line {line}"),
            Self::SecondFileLine(line) => write!(f, "second file, line {line}"),
            Self::Byte(byte) => write!(f, "byte {byte}"),
            Self::Row(row) => write!(f, "row {row}"),
        }
    }
}

/// What was done about it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Action {
    /// Left out.
    Skipped,
    /// Put right; the text says how.
    Repaired,
    /// Taken as it is.
    Kept,
}

impl fmt::Display for Action {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Skipped => "skipped",
            Self::Repaired => "repaired",
            Self::Kept => "kept",
        })
    }
}

/// Kinds of trouble, for counting.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Trouble {
    /// Something that the file does not say was assumed.
    Assumed,
    /// A scan has another number of readings than the rest of the file.
    BeamCount,
    /// A damaged part: a checksum differs, or bytes make no sense.
    Damaged,
    /// The same scan again: equal stamp, ranges and odometry.
    Duplicate,
    /// The file (or its gzip) ends before its end.
    EndsEarly,
    /// A part that this version does not read.
    NotSupported,
    /// NaN or infinity where a number is needed.
    NotFinite,
    /// Odometry that no robot can have: too far from that of the scans around it.
    OdometryJump,
    /// Odometry without a usable stamp, or a scan at whose time there is none.
    OdometryUnusable,
    /// The rig is described again, and differently.
    RigChanges,
    /// A stamp before that of an earlier line, where sorting puts things right.
    OutOfOrder,
    /// A stamp that jumps back (the clock was set, or one stamp is wrong), where sorting would not help.
    StampJumpsBack,
    /// So many equal stamps that they order nothing.
    StampsUseless,
    /// A line with fewer fields than it needs.
    Truncated,
    /// A scan outside the time that the truth covers.
    TruthMissing,
    /// A field that is no number, or no text.
    Unreadable,
}

impl fmt::Display for Trouble {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Assumed => "assumption",
            Self::BeamCount => "wrong number of readings",
            Self::Damaged => "damaged part",
            Self::Duplicate => "duplicated scan",
            Self::EndsEarly => "early end of the file",
            Self::NotSupported => "part that is not read",
            Self::NotFinite => "NaN or infinity",
            Self::OdometryJump => "odometry out of reach",
            Self::OdometryUnusable => "unusable odometry",
            Self::RigChanges => "change of the rig",
            Self::OutOfOrder => "line out of order",
            Self::StampJumpsBack => "stamp that jumps back",
            Self::StampsUseless => "stamps without order",
            Self::Truncated => "truncated line",
            Self::TruthMissing => "missing truth",
            Self::Unreadable => "unreadable field",
        })
    }
}

/// One complaint.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Complaint {
    /// Where.
    pub place: Place,
    /// What kind of trouble.
    pub trouble: Trouble,
    /// What was found there and what is expected, in words.
    pub found: String,
    /// What was done.
    pub action: Action,
}

impl fmt::Display for Complaint {
    /// Such as `line 17: 12 fields where 372 are needed: skipped`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}: {}", self.place, self.found, self.action)
    }
}

/// All complaints about one file: the first ones in full, all of them counted.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Complaints {
    kept: Vec<Complaint>,
    counts: BTreeMap<(Trouble, Action), usize>,
    n_kept_max: usize,
}

impl Default for Complaints {
    fn default() -> Self {
        Self::keeping(KEPT_DEFAULT)
    }
}

impl Complaints {
    /// No complaints yet; the first `n_kept_max` will be kept in full.
    pub fn keeping(n_kept_max: usize) -> Self {
        Self { kept: Vec::new(), counts: BTreeMap::new(), n_kept_max }
    }

    /// The first complaints, in the order in which the reader met them.
    pub fn kept(&self) -> &[Complaint] {
        &self.kept
    }

    /// How many there were of each kind, with what was done; kinds without any are absent.
    pub fn counts(&self) -> impl Iterator<Item = (Trouble, Action, usize)> + '_ {
        self.counts.iter().map(|(&(trouble, action), &n)| (trouble, action, n))
    }

    /// How many there were of one kind.
    pub fn count(&self, trouble: Trouble) -> usize {
        self.counts().filter(|&(t, ..)| t == trouble).map(|(.., n)| n).sum()
    }

    /// How many there were.
    pub fn total(&self) -> usize {
        self.counts.values().sum()
    }

    /// Whether there is nothing to complain about.
    pub fn is_empty(&self) -> bool {
        self.counts.is_empty()
    }

    /// Adds one; `found` is called only if it is kept in full.
    pub fn add(
        &mut self,
        place: Place,
        trouble: Trouble,
        action: Action,
        found: impl FnOnce() -> String,
    ) {
        *self.counts.entry((trouble, action)).or_insert(0) += 1;
        if self.kept.len() < self.n_kept_max {
            self.kept.push(Complaint { place, trouble, found: found(), action });
        }
    }
}

impl fmt::Display for Complaints {
    /// One line for each kind, such as `3 × truncated line: skipped`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, (trouble, action, n)) in self.counts().enumerate() {
            let end = if index == 0 { "" } else { "\n" };
            write!(f, "{end}{n} × {trouble}: {action}")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_are_counted_and_the_first_ones_kept() {
        let mut complaints = Complaints::keeping(2);
        let mut n_made = 0;
        for line in 1..=5 {
            complaints.add(Place::Line(line), Trouble::Truncated, Action::Skipped, || {
                n_made += 1;
                format!("{line} fields")
            });
        }
        complaints.add(Place::File, Trouble::Assumed, Action::Kept, String::new);
        assert_eq!(n_made, 2, "texts are made only for those that are kept");
        assert_eq!(complaints.kept().len(), 2);
        assert_eq!(complaints.kept()[1].to_string(), "line 2: 2 fields: skipped");
        assert_eq!(complaints.count(Trouble::Truncated), 5);
        assert_eq!(complaints.count(Trouble::Duplicate), 0);
        assert_eq!(complaints.total(), 6);
        assert_eq!(complaints.to_string(), "1 × assumption: kept\n5 × truncated line: skipped");
    }
}
