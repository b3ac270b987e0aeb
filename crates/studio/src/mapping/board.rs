//! The picture of one run as its pages see it, and what each page has not been sent yet.
//!
//! Every part carries the number of its last change. A page remembers up to which change it was sent each part, so
//! that any number of pages, fast and slow, share one picture, and none needs a queue.

use std::collections::BTreeMap;

use super::{
    pack::Bytes,
    protocol::{Pose, Registration},
};

/// Cells on a side of a tile.
pub(crate) const TILE_SIDE: usize = grid_maps::TILE_SIDE_CELLS;
/// Tiles that are kept for the page: 33 million cells. The page needs four bytes for each.
pub(crate) const TILES_MAX: usize = 8192;
/// Tiles in one message: at most 130 kB, since every page that does not read holds one.
const TILES_PER_MESSAGE: usize = 32;
/// Poses in one message: at most 100 kB.
const POSES_PER_MESSAGE: usize = 8192;

const KIND_TILES: u8 = 1;
const KIND_TRACK: u8 = 2;
const KIND_GRAPH: u8 = 3;
const KIND_SCAN: u8 = 4;
const KIND_PATCH: u8 = 5;

/// Which track.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TrackKind {
    /// Dead reckoning.
    Odometry,
    /// What the survey made of it.
    Corrected,
    /// Where the robot really was.
    Truth,
}

/// Vertices and edges of a pose graph.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Graph {
    pub vertices_m: Vec<[f64; 2]>,
    /// From, to, and whether it closes a loop.
    pub edges: Vec<(usize, usize, bool)>,
}

/// What the newest scan saw.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Sight {
    /// Points in the map.
    Points(Vec<[f64; 2]>),
    /// Sonar cones: pose in the map, range, whether it is an echo.
    Cones { half_angle_rad: f64, cones: Vec<(Pose, f64, bool)> },
}

/// A small map in a frame of its own, such as the short-term map.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Patch {
    /// Of its frame in the map.
    pub pose: Pose,
    pub origin_m: [f64; 2],
    pub cell_m: f64,
    pub columns: usize,
    pub cells: Vec<u8>,
}

/// A value with the number of its last change.
#[derive(Debug, Default)]
struct Part<T> {
    value: T,
    changed: u64,
}

/// A list that mostly grows; a new epoch when its beginning changed.
#[derive(Debug, Default)]
struct Track {
    poses: Vec<Pose>,
    epoch: u64,
}

/// The picture of one run.
#[derive(Debug)]
pub(crate) struct Board {
    run: u32,
    origin_m: [f64; 2],
    cell_m: f64,
    /// By row and column of the lower left cell.
    tiles: BTreeMap<(i32, i32), Part<Box<[u8]>>>,
    is_cut: bool,
    tracks: [Track; 3],
    graph: Part<Graph>,
    sight: Part<Option<Sight>>,
    patch: Part<Option<Patch>>,
    registration: Part<Registration>,
    n_changes: u64,
}

/// What one page was sent of a board.
#[derive(Clone, Debug, Default)]
pub(crate) struct Seen {
    run: Option<u32>,
    tiles: u64,
    /// Epoch and number of poses.
    tracks: [(u64, usize); 3],
    graph: u64,
    sight: u64,
    patch: u64,
    registration: u64,
}

/// A message to a page.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Message {
    Text(String),
    Binary(Vec<u8>),
}

impl Board {
    /// The picture of a run that has not begun.
    pub(crate) fn new(run: u32) -> Self {
        Self {
            run,
            origin_m: [0.0; 2],
            cell_m: 1.0,
            tiles: BTreeMap::new(),
            is_cut: false,
            tracks: Default::default(),
            graph: Part::default(),
            sight: Part::default(),
            patch: Part::default(),
            registration: Part::default(),
            n_changes: 0,
        }
    }

    /// Whether the map has more tiles than pages are sent.
    pub(crate) fn is_cut(&self) -> bool {
        self.is_cut
    }

    /// Where cells lie: the corner of cell (0, 0), and the side of a cell. A map of other cells is sent anew.
    pub(crate) fn set_lattice(&mut self, origin_m: [f64; 2], cell_m: f64) {
        let bits = |[x, y]: [f64; 2], cell: f64| [x, y, cell].map(f64::to_bits);
        if bits(self.origin_m, self.cell_m) != bits(origin_m, cell_m) {
            (self.origin_m, self.cell_m) = (origin_m, cell_m);
            let columns_and_rows: Vec<_> = self.tiles.keys().copied().collect();
            for key in columns_and_rows {
                let changed = self.next_change();
                if let Some(tile) = self.tiles.get_mut(&key) {
                    tile.changed = changed;
                }
            }
        }
    }

    /// The cells of the tile whose lower left cell is in `row` and `column`, as they are now.
    pub(crate) fn set_tile(&mut self, row: i32, column: i32, cells: &[u8]) {
        let changed = self.n_changes + 1;
        let is_full = self.tiles.len() >= TILES_MAX;
        match self.tiles.get_mut(&(row, column)) {
            Some(tile) if *tile.value == *cells => return,
            Some(tile) => {
                tile.value.copy_from_slice(cells);
                tile.changed = changed;
            }
            None if is_full => {
                self.is_cut = true;
                return;
            }
            None => {
                self.tiles.insert((row, column), Part { value: cells.into(), changed });
            }
        }
        self.n_changes = changed;
    }

    /// Makes tiles unknown of which `exists` says that the map has them no more.
    pub(crate) fn clear_tiles_but(&mut self, exists: impl Fn(i32, i32) -> bool) {
        let gone = |&&(row, column): &&(i32, i32)| !exists(row, column);
        let gone: Vec<_> = self.tiles.keys().filter(gone).copied().collect();
        for (row, column) in gone {
            self.set_tile(row, column, &[0; TILE_SIDE * TILE_SIDE]);
        }
    }

    /// Adds to a track.
    pub(crate) fn extend_track(&mut self, kind: TrackKind, poses: impl IntoIterator<Item = Pose>) {
        self.tracks[kind as usize].poses.extend(poses);
    }

    /// Replaces a track.
    pub(crate) fn set_track(&mut self, kind: TrackKind, poses: impl IntoIterator<Item = Pose>) {
        let track = &mut self.tracks[kind as usize];
        track.poses.clear();
        track.poses.extend(poses);
        track.epoch += 1;
    }

    /// How many poses a track has.
    pub(crate) fn track_length(&self, kind: TrackKind) -> usize {
        self.tracks[kind as usize].poses.len()
    }

    pub(crate) fn set_graph(&mut self, graph: Graph) {
        if self.graph.value != graph {
            self.graph = Part { value: graph, changed: self.next_change() };
        }
    }

    pub(crate) fn set_sight(&mut self, sight: Option<Sight>) {
        self.sight = Part { value: sight, changed: self.next_change() };
    }

    pub(crate) fn set_patch(&mut self, patch: Option<Patch>) {
        if self.patch.value != patch {
            self.patch = Part { value: patch, changed: self.next_change() };
        }
    }

    pub(crate) fn set_registration(&mut self, registration: Registration) {
        if self.registration.value != registration {
            self.registration = Part { value: registration, changed: self.next_change() };
        }
    }

    /// What a page in `slot` has not been sent; `seen` is brought up to date. A large picture takes several calls:
    /// the second value says that there is more.
    pub(crate) fn news(&self, slot: usize, seen: &mut Seen) -> (Vec<Message>, bool) {
        if seen.run != Some(self.run) {
            *seen = Seen { run: Some(self.run), ..Seen::default() };
        }
        let mut messages = Vec::new();
        if self.tell_tiles(slot, seen, &mut messages) || self.tell_tracks(slot, seen, &mut messages)
        {
            return (messages, true);
        }
        if self.graph.changed > seen.graph {
            seen.graph = self.graph.changed;
            messages.push(Message::Binary(self.graph_bytes(slot)));
        }
        if self.sight.changed > seen.sight {
            seen.sight = self.sight.changed;
            messages.push(Message::Binary(self.sight_bytes(slot)));
        }
        if self.patch.changed > seen.patch {
            seen.patch = self.patch.changed;
            messages.push(Message::Binary(self.patch_bytes(slot)));
        }
        if self.registration.changed > seen.registration {
            seen.registration = self.registration.changed;
            let registration =
                Registration { slot, run: self.run, ..self.registration.value.clone() };
            messages.push(Message::Text(serde_json::to_string(&registration).unwrap_or_default()));
        }
        (messages, false)
    }

    fn next_change(&mut self) -> u64 {
        self.n_changes += 1;
        self.n_changes
    }

    fn tell_tiles(&self, slot: usize, seen: &mut Seen, messages: &mut Vec<Message>) -> bool {
        let mut fresh: Vec<_> =
            self.tiles.iter().filter(|(_, tile)| tile.changed > seen.tiles).collect();
        if fresh.is_empty() {
            return false;
        }
        fresh.sort_by_key(|(_, tile)| tile.changed);
        let more = fresh.len() > TILES_PER_MESSAGE;
        fresh.truncate(TILES_PER_MESSAGE);
        let mut bytes = Bytes::begin(KIND_TILES, slot, self.run);
        bytes.f64(self.origin_m[0]);
        bytes.f64(self.origin_m[1]);
        bytes.f64(self.cell_m);
        bytes.count(fresh.len());
        for (&(row, column), tile) in fresh {
            bytes.i32(column);
            bytes.i32(row);
            bytes.tile(&tile.value);
            seen.tiles = tile.changed;
        }
        messages.push(Message::Binary(bytes.finish()));
        more
    }

    fn tell_tracks(&self, slot: usize, seen: &mut Seen, messages: &mut Vec<Message>) -> bool {
        for (which, (track, (epoch, n))) in self.tracks.iter().zip(&mut seen.tracks).enumerate() {
            let is_new = *epoch != track.epoch;
            let first = if is_new { 0 } else { *n };
            if !is_new && first == track.poses.len() {
                continue;
            }
            let end = track.poses.len().min(first + POSES_PER_MESSAGE);
            let mut bytes = Bytes::begin(KIND_TRACK, slot, self.run);
            bytes.count(which);
            bytes.count(first);
            bytes.count(end - first);
            track.poses[first..end].iter().flatten().for_each(|&value| bytes.f32(value));
            (*epoch, *n) = (track.epoch, end);
            messages.push(Message::Binary(bytes.finish()));
            if end < track.poses.len() {
                return true;
            }
        }
        false
    }

    fn graph_bytes(&self, slot: usize) -> Vec<u8> {
        let Graph { vertices_m, edges } = &self.graph.value;
        let mut bytes = Bytes::begin(KIND_GRAPH, slot, self.run);
        bytes.count(vertices_m.len());
        vertices_m.iter().flatten().for_each(|&value| bytes.f32(value));
        bytes.count(edges.len());
        for &(from, to, closes) in edges {
            bytes.count(from);
            bytes.count(to);
            bytes.u32(u32::from(closes));
        }
        bytes.finish()
    }

    fn sight_bytes(&self, slot: usize) -> Vec<u8> {
        let mut bytes = Bytes::begin(KIND_SCAN, slot, self.run);
        match &self.sight.value {
            None => {
                bytes.f32(0.0);
                bytes.count(0);
            }
            Some(Sight::Points(points)) => {
                bytes.f32(0.0);
                bytes.count(points.len());
                points.iter().flatten().for_each(|&value| bytes.f32(value));
            }
            Some(Sight::Cones { half_angle_rad, cones }) => {
                bytes.f32(*half_angle_rad);
                bytes.count(cones.len());
                for (pose, range_m, is_echo) in cones {
                    let [x_m, y_m, yaw_rad] = *pose;
                    let echo = f64::from(u8::from(*is_echo));
                    for value in [x_m, y_m, yaw_rad, *range_m, echo] {
                        bytes.f32(value);
                    }
                }
            }
        }
        bytes.finish()
    }

    fn patch_bytes(&self, slot: usize) -> Vec<u8> {
        let nothing = Patch {
            pose: [0.0; 3],
            origin_m: [0.0; 2],
            cell_m: 1.0,
            columns: 0,
            cells: Vec::new(),
        };
        let patch = self.patch.value.as_ref().unwrap_or(&nothing);
        let mut bytes = Bytes::begin(KIND_PATCH, slot, self.run);
        patch.pose.iter().chain(&patch.origin_m).for_each(|&value| bytes.f64(value));
        bytes.f64(patch.cell_m);
        bytes.count(patch.columns);
        bytes.count(patch.cells.len().checked_div(patch.columns).unwrap_or(0));
        bytes.cells(&patch.cells);
        bytes.finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CELLS: usize = TILE_SIDE * TILE_SIDE;

    fn kinds(messages: &[Message]) -> Vec<u8> {
        messages.iter().map(|m| if let Message::Binary(bytes) = m { bytes[0] } else { 0 }).collect()
    }

    /// The number of tiles in the first message.
    fn n_tiles(messages: &[Message]) -> u32 {
        let Message::Binary(bytes) = &messages[0] else { panic!("no tiles") };
        assert_eq!(bytes[0], KIND_TILES);
        u32::from_le_bytes(bytes[32..36].try_into().unwrap())
    }

    #[test]
    fn a_page_is_sent_only_what_changed_since_the_last_time() {
        let mut board = Board::new(3);
        let (mut fast, mut slow) = (Seen::default(), Seen::default());
        assert!(board.news(0, &mut fast).0.is_empty());
        board.set_tile(0, 0, &[1; CELLS]);
        board.set_tile(0, 64, &[2; CELLS]);
        assert_eq!(n_tiles(&board.news(0, &mut fast).0), 2);
        assert!(board.news(0, &mut fast).0.is_empty());
        board.set_tile(0, 64, &[2; CELLS]);
        assert!(board.news(0, &mut fast).0.is_empty(), "the same cells are no change");
        board.set_tile(0, 64, &[3; CELLS]);
        assert_eq!(n_tiles(&board.news(0, &mut fast).0), 1);
        let (all, more) = board.news(0, &mut slow);
        assert_eq!((n_tiles(&all), more), (2, false), "each tile once, as it is now");
    }

    #[test]
    fn a_large_map_comes_in_pieces_and_a_larger_one_is_cut() {
        let mut board = Board::new(0);
        for i in 0..TILES_MAX as i32 {
            board.set_tile(0, 64 * i, &[1; CELLS]);
        }
        assert!(!board.is_cut());
        board.set_tile(64, 0, &[1; CELLS]);
        assert!(board.is_cut());
        let mut seen = Seen::default();
        let mut n = 0;
        loop {
            let (messages, more) = board.news(1, &mut seen);
            n += n_tiles(&messages) as usize;
            if !more {
                break;
            }
        }
        assert_eq!(n, TILES_MAX);
    }

    #[test]
    fn tracks_grow_at_their_end_and_are_sent_anew_when_they_moved() {
        let mut board = Board::new(0);
        let mut seen = Seen::default();
        let range = |messages: &[Message]| {
            let Message::Binary(bytes) = &messages[0] else { panic!("no track") };
            let at = |i: usize| u32::from_le_bytes(bytes[i..i + 4].try_into().unwrap());
            (bytes[0], at(8), at(12), at(16))
        };
        board.extend_track(TrackKind::Corrected, [[0.0; 3], [1.0; 3]]);
        assert_eq!(range(&board.news(0, &mut seen).0), (KIND_TRACK, 1, 0, 2));
        board.extend_track(TrackKind::Corrected, [[2.0; 3]]);
        assert_eq!(range(&board.news(0, &mut seen).0), (KIND_TRACK, 1, 2, 1));
        board.set_track(TrackKind::Corrected, [[5.0; 3]; 4]);
        assert_eq!(range(&board.news(0, &mut seen).0), (KIND_TRACK, 1, 0, 4));
        assert!(board.news(0, &mut seen).0.is_empty());
    }

    #[test]
    fn a_new_run_is_sent_from_its_beginning() {
        let mut seen = Seen::default();
        let mut old = Board::new(1);
        old.set_graph(Graph { vertices_m: vec![[0.0; 2]], edges: Vec::new() });
        old.set_sight(Some(Sight::Points(vec![[1.0, 2.0]])));
        assert_eq!(kinds(&old.news(0, &mut seen).0), [KIND_GRAPH, KIND_SCAN]);
        let mut new = Board::new(2);
        new.set_patch(Some(Patch {
            pose: [0.0; 3],
            origin_m: [0.0; 2],
            cell_m: 0.1,
            columns: 2,
            cells: vec![0, 1, 2, 3],
        }));
        new.set_registration(Registration { number: 1, ..Registration::default() });
        let (messages, _) = new.news(1, &mut seen);
        assert_eq!(kinds(&messages), [KIND_PATCH, 0]);
        let Message::Text(text) = &messages[1] else { panic!("no text") };
        assert!(
            text.starts_with(r#"{"type":"registration","slot":1,"run":2,"number":1"#),
            "{text}"
        );
    }

    #[test]
    fn cells_that_the_map_has_no_more_become_unknown() {
        let mut board = Board::new(0);
        let mut seen = Seen::default();
        board.set_tile(0, 0, &[9; CELLS]);
        board.set_tile(64, 0, &[9; CELLS]);
        board.news(0, &mut seen);
        board.clear_tiles_but(|row, _| row == 0);
        assert_eq!(n_tiles(&board.news(0, &mut seen).0), 1);
        assert_eq!(*board.tiles[&(64, 0)].value, [0; CELLS]);
        board.clear_tiles_but(|row, _| row == 0);
        assert!(board.news(0, &mut seen).0.is_empty());
    }
}
