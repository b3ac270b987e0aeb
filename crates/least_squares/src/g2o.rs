//! Pose graphs as text: the lines `VERTEX_SE2`, `EDGE_SE2` and `FIX` of the g2o format.
//!
//! `VERTEX_SE2 id x y yaw`, `EDGE_SE2 from to x y yaw I11 I12 I13 I22 I23 I33` (information, upper
//! triangle by rows, order x, y, yaw), `FIX id …`; metres and radians, one record a line, in any
//! order. Other lines are counted and left out. Kernels have no place in the format.

use std::{
    collections::BTreeMap,
    fmt::{self, Write as _},
};

use geometry::Se2;
use nalgebra::Matrix3;
use thiserror::Error;

use crate::{Edge, GraphError, PoseGraph, residual::wrapped, start};

/// So many different unknown tags are counted by name; the rest together.
const TAGS_MAX: usize = 16;
/// What they are counted under.
const OTHER_TAGS: &str = "(others)";
/// A tag is cut to so many bytes.
const TAG_LENGTH_MAX: usize = 32;
/// So many left-out lines are kept with their reasons; all are counted.
const NOTES_MAX: usize = 20;

/// The numbers that a file gives to its vertices, by our index; ascending.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Ids(Vec<u64>);

/// What was left out or guessed in reading; empty for a sound file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Damage {
    /// How many lines each tag had that is not known here (the first sixteen tags by name).
    pub unknown_tags: BTreeMap<String, usize>,
    /// Lines that were left out.
    pub n_skipped: usize,
    /// The first twenty of them, with what is wrong.
    pub skipped: Vec<(usize, Skipped)>,
    /// Vertices that edges name, but no line places: they were placed along the edges.
    pub n_unplaced: usize,
}

/// Why a line was left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Skipped {
    /// The file ends within this line.
    CutShort,
    /// A second, different line for a vertex; the first counts.
    SecondPose {
        /// Its number in the file.
        id: u64,
    },
    /// An edge from a vertex to itself.
    SelfLoop {
        /// Its number in the file.
        id: u64,
    },
    /// A vertex to be fixed that is nowhere else in the file.
    UnknownFixed {
        /// Its number in the file.
        id: u64,
    },
}

/// Why a file is refused; nothing of it is kept.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum G2oError {
    /// A line has too few or too many fields.
    #[error("line {line}: {tag} has {found} fields after the tag, needs {needed}")]
    FieldCount {
        /// Counted from 1.
        line: usize,
        /// First word of the line.
        tag: &'static str,
        /// How many there are.
        found: usize,
        /// How many there must be.
        needed: usize,
    },
    /// A field is not a number of the kind that belongs there.
    #[error("line {line}, field {field}: `{text}` is not {expected}")]
    NotANumber {
        /// Counted from 1.
        line: usize,
        /// Counted from 1 after the tag.
        field: usize,
        /// What stands there.
        text: String,
        /// What should.
        expected: &'static str,
    },
    /// An edge that no graph accepts.
    #[error("line {line}: {reason}")]
    BadEdge {
        /// Counted from 1.
        line: usize,
        /// What is wrong with it.
        reason: GraphError,
    },
    /// No known line at all.
    #[error("no VERTEX_SE2 or EDGE_SE2 line among {n_lines}: is this a planar pose graph?")]
    Empty {
        /// How many lines there are.
        n_lines: usize,
    },
}

/// Reads a graph. Vertices are ordered by their numbers in the file, edges as they come.
///
/// Vertices without a line of their own are placed along the edges (all of them, as by
/// [`odometry_start`](crate::odometry_start), when the file has no `VERTEX_SE2`). Yaws outside
/// [-π, π) are wrapped; all other numbers keep their bits. Cost: linear in the text, memory in
/// proportion to it.
///
/// # Errors
///
/// [`G2oError`] with the line, for known tags with wrong fields, numbers that are not finite,
/// matrices that are no information, and files without a single vertex or edge. A last line that is
/// cut short, a second pose of a vertex, self loops and unknown fixed vertices are left out and
/// told in [`Damage`].
pub fn read(text: &[u8]) -> Result<(PoseGraph, Ids, Damage), G2oError> {
    let records = Records::read(text)?;
    let ids = records.ids();
    let mut damage = records.damage;
    let mut graph = PoseGraph {
        poses: vec![Se2::IDENTITY; ids.len()],
        edges: Vec::with_capacity(records.edges.len()),
        is_fixed: vec![false; ids.len()],
    };
    let mut is_placed = vec![false; ids.len()];
    for (line, id, pose) in records.vertices {
        let Some(vertex) = ids.vertex(id) else { continue };
        if !is_placed[vertex] {
            is_placed[vertex] = true;
            graph.poses[vertex] = pose;
        } else if graph.poses[vertex] != pose {
            damage.skip(line, Skipped::SecondPose { id });
        }
    }
    for (line, [from_id, to_id], to_in_from, information) in records.edges {
        let (Some(from), Some(to)) = (ids.vertex(from_id), ids.vertex(to_id)) else { continue };
        if from == to {
            damage.skip(line, Skipped::SelfLoop { id: from_id });
            continue;
        }
        let edge = Edge::new(from, to, to_in_from, information);
        graph.add_edge(edge).map_err(|reason| G2oError::BadEdge { line, reason })?;
    }
    for (line, id) in records.fixed {
        match ids.vertex(id) {
            Some(vertex) => graph.is_fixed[vertex] = true,
            None => damage.skip(line, Skipped::UnknownFixed { id }),
        }
    }
    place_the_rest(&mut graph, is_placed, &mut damage);
    Ok((graph, ids, damage))
}

/// Writes a graph so that [`read`] gives it back bit for bit (but for kernels).
///
/// Vertices that `ids` has no number for are numbered on from the greatest.
pub fn write(graph: &PoseGraph, ids: &Ids) -> String {
    let next = ids.0.last().map_or(0, |last| last.saturating_add(1));
    let id_of = |vertex: usize| {
        let beyond = vertex.saturating_sub(ids.len()) as u64;
        ids.0.get(vertex).copied().unwrap_or(next.saturating_add(beyond))
    };
    let mut text = String::with_capacity(64 * graph.poses.len() + 128 * graph.edges.len());
    let mut line = |arguments: fmt::Arguments<'_>| {
        // Writing to a string cannot fail.
        let _written = text.write_fmt(arguments);
    };
    for (vertex, p) in graph.poses.iter().enumerate() {
        let id = id_of(vertex);
        line(format_args!("VERTEX_SE2 {id} {} {} {}\n", p.x_m, p.y_m, p.yaw_rad));
    }
    for vertex in (0..graph.poses.len()).filter(|v| graph.is_fixed[*v]) {
        line(format_args!("FIX {}\n", id_of(vertex)));
    }
    for edge in &graph.edges {
        let (from, to, z, i) =
            (id_of(edge.from), id_of(edge.to), edge.to_in_from, edge.information);
        line(format_args!("EDGE_SE2 {from} {to} {} {} {}", z.x_m, z.y_m, z.yaw_rad));
        for value in [i.m11, i.m12, i.m13, i.m22, i.m23, i.m33] {
            line(format_args!(" {value}"));
        }
        line(format_args!("\n"));
    }
    text
}

impl Ids {
    /// Vertices numbered as in the graph, from 0.
    pub fn consecutive(n_vertices: usize) -> Self {
        Self((0..n_vertices as u64).collect())
    }

    /// How many vertices have a number.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Whether none has.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The number of a vertex in the file.
    pub fn id(&self, vertex: usize) -> Option<u64> {
        self.0.get(vertex).copied()
    }

    /// The vertex of a number.
    pub fn vertex(&self, id: u64) -> Option<usize> {
        // Nearly every file counts without gaps: then the place is known.
        let first = *self.0.first()?;
        let guess = usize::try_from(id.checked_sub(first)?).ok();
        match guess {
            Some(guess) if self.0.get(guess) == Some(&id) => Some(guess),
            _ => self.0.binary_search(&id).ok(),
        }
    }
}

impl Damage {
    /// Whether nothing was left out or guessed. Graphs without any vertex line are whole.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    fn skip(&mut self, line: usize, reason: Skipped) {
        self.n_skipped += 1;
        if self.skipped.len() < NOTES_MAX {
            self.skipped.push((line, reason));
        }
    }

    fn count_tag(&mut self, tag: &[u8]) {
        let text = String::from_utf8_lossy(&tag[..tag.len().min(TAG_LENGTH_MAX)]).into_owned();
        let is_full = self.unknown_tags.len() >= TAGS_MAX && !self.unknown_tags.contains_key(&text);
        let name = if is_full { OTHER_TAGS.to_owned() } else { text };
        *self.unknown_tags.entry(name).or_default() += 1;
    }
}

impl fmt::Display for Damage {
    /// One line for each kind of damage, none for a sound file.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (line, reason) in &self.skipped {
            writeln!(f, "line {line}: {reason}; left out")?;
        }
        if self.n_skipped > self.skipped.len() {
            writeln!(f, "{} more lines were left out", self.n_skipped - self.skipped.len())?;
        }
        for (tag, n) in &self.unknown_tags {
            writeln!(f, "{n} lines with the unknown tag {tag} were left out")?;
        }
        if self.n_unplaced > 0 {
            let n = self.n_unplaced;
            writeln!(f, "{n} vertices have no VERTEX_SE2 line; placed along the edges")?;
        }
        Ok(())
    }
}

impl fmt::Display for Skipped {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::CutShort => write!(f, "the file ends within this line"),
            Self::SecondPose { id } => write!(f, "a second, different pose of vertex {id}"),
            Self::SelfLoop { id } => write!(f, "an edge from vertex {id} to itself"),
            Self::UnknownFixed { id } => {
                write!(f, "vertex {id} is to be fixed, but is nowhere else")
            }
        }
    }
}

/// The lines of a file, as numbers.
#[derive(Debug, Default)]
struct Records {
    vertices: Vec<(usize, u64, Se2)>,
    edges: Vec<(usize, [u64; 2], Se2, Matrix3<f64>)>,
    fixed: Vec<(usize, u64)>,
    damage: Damage,
}

/// The fields of one line behind its tag.
struct Fields<'a> {
    line: usize,
    rest: &'a [u8],
    n_taken: usize,
}

impl Records {
    fn read(text: &[u8]) -> Result<Self, G2oError> {
        let mut records = Self::default();
        let mut n_lines = 0;
        for (index, whole) in text.split_inclusive(|byte| *byte == b'\n').enumerate() {
            let line = index + 1;
            n_lines = line;
            let mut fields = Fields { line, rest: whole, n_taken: 0 };
            let Some(tag) = fields.word() else { continue };
            fields.n_taken = 0;
            let result = match tag {
                b"VERTEX_SE2" => records.vertex(fields),
                b"EDGE_SE2" => records.edge(fields),
                b"FIX" => records.fix(fields),
                _ => {
                    if !tag.starts_with(b"#") {
                        records.damage.count_tag(tag);
                    }
                    Ok(())
                }
            };
            // Only the last line can lack its end.
            match result {
                Err(_) if !whole.ends_with(b"\n") => records.damage.skip(line, Skipped::CutShort),
                other => other?,
            }
        }
        if records.vertices.is_empty() && records.edges.is_empty() {
            return Err(G2oError::Empty { n_lines });
        }
        Ok(records)
    }

    fn vertex(&mut self, mut fields: Fields<'_>) -> Result<(), G2oError> {
        fields.check_count("VERTEX_SE2", 4)?;
        let line = fields.line;
        self.vertices.push((line, fields.id()?, fields.pose()?));
        Ok(())
    }

    fn edge(&mut self, mut fields: Fields<'_>) -> Result<(), G2oError> {
        fields.check_count("EDGE_SE2", 11)?;
        let ends = [fields.id()?, fields.id()?];
        let pose = fields.pose()?;
        let mut information = Matrix3::zeros();
        for row in 0..3 {
            for column in row..3 {
                let value = fields.number()?;
                information[(row, column)] = value;
                information[(column, row)] = value;
            }
        }
        self.edges.push((fields.line, ends, pose, information));
        Ok(())
    }

    fn fix(&mut self, mut fields: Fields<'_>) -> Result<(), G2oError> {
        let n = fields.count();
        fields.check_count("FIX", n.max(1))?;
        for _ in 0..n {
            self.fixed.push((fields.line, fields.id()?));
        }
        Ok(())
    }

    /// All numbers of vertices, sorted.
    fn ids(&self) -> Ids {
        let mut ids: Vec<u64> = self.vertices.iter().map(|(_, id, _)| *id).collect();
        ids.extend(self.edges.iter().flat_map(|(_, ends, ..)| ends));
        ids.sort_unstable();
        ids.dedup();
        Ids(ids)
    }
}

impl<'a> Fields<'a> {
    fn word(&mut self) -> Option<&'a [u8]> {
        let begin = self.rest.iter().position(|byte| !byte.is_ascii_whitespace())?;
        let rest = &self.rest[begin..];
        let end = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        self.rest = &rest[end..];
        self.n_taken += 1;
        Some(&rest[..end])
    }

    fn count(&self) -> usize {
        let words = self.rest.split(u8::is_ascii_whitespace);
        words.filter(|word| !word.is_empty()).count()
    }

    fn check_count(&self, tag: &'static str, needed: usize) -> Result<(), G2oError> {
        let found = self.count();
        let line = self.line;
        let is_right = found == needed;
        is_right.then_some(()).ok_or(G2oError::FieldCount { line, tag, found, needed })
    }

    fn id(&mut self) -> Result<u64, G2oError> {
        let word = self.word().unwrap_or_default();
        let id = std::str::from_utf8(word).ok().and_then(|text| text.parse().ok());
        id.ok_or_else(|| self.not_a(word, "the number of a vertex, 0 or greater"))
    }

    fn number(&mut self) -> Result<f64, G2oError> {
        let word = self.word().unwrap_or_default();
        let number = std::str::from_utf8(word).ok().and_then(|text| text.parse().ok());
        let finite = number.filter(|value: &f64| value.is_finite());
        finite.ok_or_else(|| self.not_a(word, "a finite number"))
    }

    fn pose(&mut self) -> Result<Se2, G2oError> {
        let (x_m, y_m, yaw_rad) = (self.number()?, self.number()?, self.number()?);
        Ok(Se2 { x_m, y_m, yaw_rad: wrapped(yaw_rad) })
    }

    fn not_a(&self, word: &[u8], expected: &'static str) -> G2oError {
        let text = String::from_utf8_lossy(&word[..word.len().min(TAG_LENGTH_MAX)]).into_owned();
        G2oError::NotANumber { line: self.line, field: self.n_taken, text, expected }
    }
}

/// Places the vertices that have no line of their own.
fn place_the_rest(graph: &mut PoseGraph, mut is_placed: Vec<bool>, damage: &mut Damage) {
    let n_placed = is_placed.iter().filter(|placed| **placed).count();
    if n_placed == graph.poses.len() {
        return;
    }
    if n_placed > 0 {
        damage.n_unplaced = graph.poses.len() - n_placed;
    }
    // A part of the graph without any placed vertex begins at the origin.
    let part = start::parts(graph);
    let mut has_placed = vec![false; part.len()];
    for vertex in (0..part.len()).filter(|v| is_placed[*v]) {
        has_placed[part[vertex]] = true;
    }
    for vertex in 0..part.len() {
        is_placed[vertex] |= part[vertex] == vertex && !has_placed[vertex];
    }
    start::place_along_edges(graph, &is_placed);
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const SOUND: &str = "VERTEX_SE2 10 0 0 0\nVERTEX_SE2 20 1 0 0.5\nFIX 20\n\
                         EDGE_SE2 10 20 1 0.25 -0.5 4 0.5 0 4 0 9\n";

    fn damaged(text: &str) -> Damage {
        read(text.as_bytes()).unwrap().2
    }

    #[test]
    fn a_sound_file_is_read_as_it_stands() {
        let (graph, ids, damage) = read(SOUND.as_bytes()).unwrap();
        assert_eq!(graph.poses(), [Se2::IDENTITY, Se2::new(1.0, 0.0, 0.5)]);
        assert_eq!(graph.fixed(), [false, true]);
        let information = Matrix3::new(4.0, 0.5, 0.0, 0.5, 4.0, 0.0, 0.0, 0.0, 9.0);
        assert_eq!(graph.edges(), [Edge::new(0, 1, Se2::new(1.0, 0.25, -0.5), information)]);
        assert_eq!((ids.id(1), ids.vertex(20), ids.vertex(15)), (Some(20), Some(1), None));
        assert!(damage.is_empty() && damage.to_string().is_empty());
        let windows = SOUND.replace('\n', "\r\n").replace(' ', "\t ");
        assert_eq!(read(windows.as_bytes()).unwrap().0, graph);
    }

    #[test]
    fn refusals_say_where_and_what() {
        let edge = |fields: &str| format!("VERTEX_SE2 0 0 0 0\n\nEDGE_SE2 {fields}\n");
        for (text, expected) in [
            (String::new(), "no VERTEX_SE2 or EDGE_SE2 line among 0"),
            ("hello\nEDGE_SE3 1\n".into(), "no VERTEX_SE2 or EDGE_SE2 line among 2"),
            ("VERTEX_SE2 0 0 0\n".into(), "line 1: VERTEX_SE2 has 3 fields after the tag, needs 4"),
            (edge("0 1 0 0 0 1 0 0 1 0"), "line 3: EDGE_SE2 has 10 fields after the tag, needs 11"),
            (edge("0 1 0 0 0 1 0 0 1 0 1 7"), "has 12 fields"),
            (edge("0 1 0 nan 0 1 0 0 1 0 1"), "line 3, field 4: `nan` is not a finite number"),
            (edge("0 1 0 0 0 inf 0 0 1 0 1"), "line 3, field 6: `inf` is not a finite number"),
            (edge("0 1 0 0 0 1e999 0 0 1 0 1"), "`1e999` is not a finite"),
            (edge("0 -1 0 0 0 1 0 0 1 0 1"), "line 3, field 2: `-1` is not the number of a vertex"),
            (edge("0 1 0 0 0 1 0 0 -1 0 1"), "line 3: the information matrix is not symmetric"),
            ("VERTEX_SE2 0 0 0 0\nFIX\n".into(), "line 2: FIX has 0 fields after the tag, needs 1"),
            ("VERTEX_SE2 0 0 0 \u{fffd}\n".into(), "field 4"),
        ] {
            let message = read(text.as_bytes()).unwrap_err().to_string();
            assert!(message.contains(expected), "{message}");
        }
    }

    #[test]
    fn what_can_be_left_out_is_counted_with_its_line() {
        let with = |text: &str| damaged(&format!("{SOUND}{text}"));
        for (text, line, reason) in [
            ("VERTEX_SE2 20 1 1 0.5\n", 5, Skipped::SecondPose { id: 20 }),
            ("EDGE_SE2 20 20 0 0 0 1 0 0 1 0 1\n", 5, Skipped::SelfLoop { id: 20 }),
            ("FIX 10 11\n", 5, Skipped::UnknownFixed { id: 11 }),
            ("\nEDGE_SE2 20 10 0 0 0 1 0", 6, Skipped::CutShort),
            ("VERTEX_SE2 21 1 1 -", 5, Skipped::CutShort),
        ] {
            let damage = with(text);
            assert_eq!((damage.n_skipped, &damage.skipped[..]), (1, &[(line, reason)][..]));
            assert!(damage.to_string().starts_with(&format!("line {line}: ")));
        }
        assert!(with("VERTEX_SE2 20 1 0 0.5\n# a remark\n\n").is_empty());
        let many = with(&"EDGE_SE2 20 20 0 0 0 1 0 0 1 0 1\n".repeat(50));
        assert_eq!((many.n_skipped, many.skipped.len()), (50, NOTES_MAX));
        assert!(many.to_string().contains("30 more lines"));
        let tags: Vec<String> = (0..80).map(|i| format!("TAG{:02} 1", i / 2)).collect();
        let tags = with(&(tags.join("\n") + "\n")).unknown_tags;
        assert_eq!((tags.len(), tags["TAG03"], tags[OTHER_TAGS]), (TAGS_MAX + 1, 2, 48));
    }

    #[test]
    fn vertices_without_a_line_are_placed_along_the_edges() {
        let edge = |a: u64, b: u64| format!("EDGE_SE2 {a} {b} 1 0 0 1 0 0 1 0 1\n");
        let chain = edge(5, 6) + &edge(7, 6);
        let (graph, ids, damage) = read(chain.as_bytes()).unwrap();
        let x = |graph: &PoseGraph| graph.poses().iter().map(|p| p.x_m).collect::<Vec<_>>();
        assert_eq!((x(&graph), ids.id(0)), (vec![0.0, 1.0, 0.0], Some(5)));
        assert!(damage.is_empty());
        let (graph, _, damage) = read(format!("{chain}VERTEX_SE2 7 4 0 0\n").as_bytes()).unwrap();
        assert_eq!((x(&graph), damage.n_unplaced), (vec![4.0, 5.0, 4.0], 2));
        assert!(damage.to_string().contains("2 vertices have no VERTEX_SE2 line"));
    }

    fn bits(graph: &PoseGraph) -> Vec<u64> {
        let pose = |p: Se2| [p.x_m, p.y_m, p.yaw_rad];
        let mut numbers: Vec<f64> = graph.poses().iter().flat_map(|p| pose(*p)).collect();
        for edge in graph.edges() {
            numbers.extend(pose(edge.to_in_from));
            numbers.extend(edge.information.iter());
        }
        numbers.iter().map(|v| v.to_bits()).collect()
    }

    proptest! {
        #[test]
        fn what_was_written_reads_back_bit_for_bit(
            numbers in proptest::collection::vec(-1e6_f64..1e6, 12),
            exponent in -300_i32..100,
            yaw in -std::f64::consts::PI..std::f64::consts::PI,
            first in 0..u64::MAX / 2,
        ) {
            let mut graph = PoseGraph::new();
            let scale = 10_f64.powi(exponent);
            let n = &numbers;
            graph.add_vertex(Se2 { x_m: n[0] * scale, y_m: -0.0, yaw_rad: yaw });
            graph.add_vertex(Se2 { x_m: n[1], y_m: n[2] / 3.0, yaw_rad: -std::f64::consts::PI });
            graph.add_vertex(Se2 { x_m: n[3], y_m: n[4], yaw_rad: -yaw });
            graph.fix(1).unwrap();
            let l = Matrix3::new(n[5], 0.0, 0.0, n[6], n[7], 0.0, n[8], n[9], n[10]);
            let mut information = l * l.transpose() + Matrix3::identity();
            information.fill_lower_triangle_with_upper_triangle();
            let z = Se2 { x_m: n[11] * scale, y_m: n[0], yaw_rad: yaw / 3.0 };
            graph.add_edge(Edge::new(2, 0, z, information)).unwrap();
            graph.add_edge(Edge::new(0, 1, z, Matrix3::identity() * 0.1)).unwrap();
            // The third vertex has no number yet.
            let ids = Ids(vec![first, first + 7]);
            let (again, ids_again, damage) = read(write(&graph, &ids).as_bytes()).unwrap();
            prop_assert_eq!(bits(&again), bits(&graph));
            prop_assert_eq!(again, graph);
            prop_assert_eq!(ids_again.0, vec![first, first + 7, first + 8]);
            prop_assert!(damage.is_empty());
        }

        #[test]
        fn no_text_makes_it_panic(text in "(VERTEX_SE2|EDGE_SE2|FIX|[a-z ]|[0-9. -]{1,9}|\n){0,60}") {
            if let Ok((graph, ids, _)) = read(text.as_bytes()) {
                prop_assert_eq!(graph.poses().len(), ids.len());
            }
        }

        #[test]
        fn a_file_cut_anywhere_is_read_or_refused(end in 0..SOUND.len()) {
            if let Ok((graph, ..)) = read(&SOUND.as_bytes()[..end]) {
                prop_assert!(graph.poses().len() <= 2 && graph.edges().len() <= 1);
            }
        }
    }

    #[test]
    fn numbers_for_a_new_graph_count_from_zero() {
        let ids = Ids::consecutive(3);
        assert_eq!(
            (ids.len(), ids.id(2), ids.vertex(2), ids.is_empty()),
            (3, Some(2), Some(2), false)
        );
        assert!(Ids::default().is_empty() && Ids::default().vertex(0).is_none());
    }
}
