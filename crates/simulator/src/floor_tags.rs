//! Passive tags in the floor: a grid of memories that readers above them can read and write.

use geometry::Vec2;
use run_context::StateHash;
use sensor_models::TagMemory;

/// The most places for tags that a floor may have.
const N_PLACES_MAX: usize = 4_000_000;

/// A rectangular grid of places, most of them with a tag.
///
/// Place `n` is in column `n % n_columns` and row `n / n_columns`, counted from the lower left.
/// Memory: some 100 bytes per place.
#[derive(Clone, Debug)]
pub struct FloorTags {
    first: Vec2,
    pitch_m: f64,
    n_columns: usize,
    tags: Vec<Option<TagMemory>>,
    /// Everything that was written so far, in order.
    written: StateHash,
}

/// A grid that cannot be made.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "tags every {pitch_m} m from ({x0}, {y0}) to ({x1}, {y1}) m: must be at least 0.01 m apart, in an area that is not \
     empty, and at most {N_PLACES_MAX}"
)]
pub struct FloorTagsError {
    pitch_m: f64,
    x0: f64,
    y0: f64,
    x1: f64,
    y1: f64,
}

impl FloorTags {
    /// Lays tags over an area (x0, y0, x1, y1, m) on whole multiples of `pitch_m` from the origin. `memory`
    /// is asked row by row from below for what the tag at a place (m, map) stores; `None`: no tag answers there.
    ///
    /// # Errors
    ///
    /// [`FloorTagsError`] when there would be no tags, or too many.
    pub fn new(
        area_m: [f64; 4],
        pitch_m: f64,
        mut memory: impl FnMut(Vec2) -> Option<TagMemory>,
    ) -> Result<Self, FloorTagsError> {
        let [x0, y0, x1, y1] = area_m;
        let refuse = FloorTagsError { pitch_m, x0, y0, x1, y1 };
        let n = |from: f64, to: f64| (to / pitch_m).floor() - (from / pitch_m).ceil() + 1.0;
        let (columns, rows) = (n(x0, x1), n(y0, y1));
        let few = columns * rows <= N_PLACES_MAX as f64;
        if !(pitch_m >= 0.01 && columns >= 1.0 && rows >= 1.0 && few) {
            return Err(refuse);
        }
        let first = Vec2::new((x0 / pitch_m).ceil(), (y0 / pitch_m).ceil()) * pitch_m;
        let (n_columns, n_rows) = (columns as usize, rows as usize);
        let places = (0..n_rows).flat_map(|row| (0..n_columns).map(move |column| (column, row)));
        let at =
            |(column, row): (usize, usize)| first + Vec2::new(column as f64, row as f64) * pitch_m;
        let tags = places.map(|place| memory(at(place))).collect();
        Ok(Self { first, pitch_m, n_columns, tags, written: StateHash::new() })
    }

    /// Between neighbouring tags, metres.
    pub fn pitch_m(&self) -> f64 {
        self.pitch_m
    }

    /// Columns.
    pub fn n_columns(&self) -> usize {
        self.n_columns
    }

    /// Rows.
    pub fn n_rows(&self) -> usize {
        self.tags.len() / self.n_columns
    }

    /// Where place 0 is (m, map).
    pub fn first_in_map(&self) -> Vec2 {
        self.first
    }

    /// What the tag at that place stores; `None` where no tag answers.
    pub fn tag(&self, place: u32) -> Option<&TagMemory> {
        self.tags.get(place as usize)?.as_ref()
    }

    /// All tags that answer, with their places, ascending.
    pub fn tags(&self) -> impl Iterator<Item = (u32, &TagMemory)> {
        (0..).zip(&self.tags).filter_map(|(place, tag)| Some((place, tag.as_ref()?)))
    }

    /// Replaces `places` by the tags that answer within `range_m` of a point (m, map), ascending. O(range² / pitch²);
    /// allocates only while `places` grows.
    pub fn in_area(&self, centre: Vec2, range_m: f64, places: &mut Vec<u32>) {
        places.clear();
        let index = |m: f64, n: usize| (m.clamp(0.0, n as f64)) as usize;
        let from = (centre - self.first).add_scalar(-range_m) / self.pitch_m;
        let to = (centre - self.first).add_scalar(range_m) / self.pitch_m;
        let rows = index(from.y.ceil(), self.n_rows())..index(to.y.floor() + 1.0, self.n_rows());
        for row in rows {
            let columns =
                index(from.x.ceil(), self.n_columns)..index(to.x.floor() + 1.0, self.n_columns);
            for column in columns {
                let at = self.first + Vec2::new(column as f64, row as f64) * self.pitch_m;
                let place = row * self.n_columns + column;
                if (at - centre).norm() <= range_m && self.tags[place].is_some() {
                    places.push(place as u32);
                }
            }
        }
    }

    /// Writes a tag's intensity; nothing happens where no tag answers.
    pub fn write_strength(&mut self, place: u32, strength: u8) {
        if let Some(Some(tag)) = self.tags.get_mut(place as usize)
            && tag.strength != strength
        {
            tag.strength = strength;
            self.written.absorb_u64(u64::from(place) << 8 | u64::from(strength));
        }
    }

    pub(crate) fn absorb(&self, hash: &mut StateHash) {
        hash.absorb_u64(self.written.value());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn floor(area_m: [f64; 4]) -> FloorTags {
        let memory = |in_map: Vec2| Some(TagMemory { in_map, ..TagMemory::default() });
        FloorTags::new(area_m, 0.1, memory).unwrap()
    }

    #[test]
    fn places_are_multiples_of_the_pitch_inside_the_area() {
        let floor = floor([-0.25, 0.05, 0.31, 0.2]);
        let expected: Vec<(i32, i32)> =
            [1, 2].iter().flat_map(|y| (-2..=3).map(move |x| (x, *y))).collect();
        let found: Vec<(i32, i32)> = floor
            .tags()
            .map(|(_, tag)| tag.in_map * 10.0)
            .map(|p| (p.x.round() as i32, p.y.round() as i32))
            .collect();
        assert_eq!(found, expected);
        assert_eq!((floor.n_columns(), floor.n_rows()), (6, 2));
    }

    /// Against all tags, looked at one by one, also beyond the borders and on a tag and its edge.
    #[test]
    fn the_recognition_area_holds_what_a_search_of_all_tags_finds() {
        let floor = floor([-1.0, -0.5, 1.0, 0.5]);
        let mut found = vec![99];
        for k in 0..4000 {
            let turn = f64::from(k);
            let centre = Vec2::new(1.4 * (0.37 * turn).sin(), 0.8 * (0.61 * turn).cos());
            let range_m = [0.03, 0.06, 0.1, 0.25][k as usize % 4];
            floor.in_area(centre, range_m, &mut found);
            let near = |tag: &TagMemory| (tag.in_map - centre).norm() <= range_m;
            let all: Vec<u32> =
                floor.tags().filter(|(_, tag)| near(tag)).map(|(place, _)| place).collect();
            assert_eq!(found, all, "{centre:?} {range_m}");
        }
    }

    #[test]
    fn a_floor_that_makes_no_sense_is_refused() {
        let none = |_| None;
        for (area_m, pitch_m) in [
            ([0.0, 0.0, 1.0, 1.0], 0.0),
            ([0.0, 0.0, 1.0, 1.0], f64::NAN),
            ([0.0, 0.0, -1.0, 1.0], 0.1),
            ([0.01, 0.0, 0.09, 1.0], 0.1),
            ([0.0, 0.0, 1000.0, 1000.0], 0.1),
        ] {
            let error = FloorTags::new(area_m, pitch_m, none).unwrap_err();
            assert!(error.to_string().contains("apart"), "{error}");
        }
    }

    #[test]
    fn what_is_written_is_read_and_where_no_tag_is_nothing_happens() {
        let memory =
            |in_map: Vec2| (in_map.x > 0.05).then(|| TagMemory { in_map, ..TagMemory::default() });
        let mut floor = FloorTags::new([0.0, 0.0, 0.1, 0.0], 0.1, memory).unwrap();
        let hash = |floor: &FloorTags| {
            let mut hash = StateHash::new();
            floor.absorb(&mut hash);
            hash.value()
        };
        let before = hash(&floor);
        floor.write_strength(0, 7);
        floor.write_strength(99, 7);
        assert_eq!(hash(&floor), before);
        floor.write_strength(1, 7);
        assert_eq!(floor.tag(1).map(|tag| tag.strength), Some(7));
        assert_eq!(floor.tag(0), None);
        assert_ne!(hash(&floor), before);
    }
}
