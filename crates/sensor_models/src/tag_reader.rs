//! Passive radio tags in the floor and the reader that passes over them.
//!
//! A reader feeds the tags in its recognition area and asks them for their memory. That takes milliseconds,
//! during which the tag must stay inside; some reads fail; and of several tags in the area at once either none
//! is understood, or they are read one after another by a reader that can tell them apart.
//!
//! Source: the thesis (Susnea, c. 2009, Univ. Galati), 3.3.3 (reading takes milliseconds, with or without
//! anti-collision), 3.5.2 and Fig. 3.10 (recognition area), 5.3.2 (what tags store for path following).
//! Differences: it gives no figures beyond "a few centimetres"; the recognition area is a disc with a sharp edge.

use std::time::Duration;

use geometry::Vec2;
use rand_core::Rng;
use run_context::{RandomStream, Stamp};

/// What a tag in the floor stores: some 20 bytes of the kilobyte that such tags have.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TagMemory {
    /// Where the tag was put down (m, map).
    pub in_map: Vec2,
    /// Pheromone intensity: 0 (white) is no trail, 255 (black) the most.
    pub strength: u8,
    /// For each of the two directions of its trail, where a robot that stands here should steer for.
    pub hints: [Option<TagHint>; 2],
}

/// Navigation information for one direction of a trail.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TagHint {
    /// The look-ahead point of pure pursuit for a robot over this tag (m, map).
    pub look_ahead_in_map: Vec2,
    /// Where the trail ends in that direction (m, map).
    pub end_in_map: Vec2,
}

/// How a reader reads.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TagReaderModel {
    /// Radius of the recognition area on the floor, metres.
    pub range_m: f64,
    /// What one read takes; the tag must stay in the area for so long.
    pub read_time: Duration,
    /// Probability that a read fails.
    pub miss_prob: f64,
    /// Whether several tags in the area are read in turn; otherwise none of them is understood.
    pub anti_collision: bool,
}

impl Default for TagReaderModel {
    /// A proximity reader: 6 cm, 20 ms, one read in twenty fails, anti-collision.
    fn default() -> Self {
        Self {
            range_m: 0.06,
            read_time: Duration::from_millis(20),
            miss_prob: 0.05,
            anti_collision: true,
        }
    }
}

/// One reader at work.
///
/// ```
/// use run_context::{RunSeed, Stamp};
/// use sensor_models::{TagReader, TagReaderModel};
///
/// let mut reader = TagReader::new(TagReaderModel { miss_prob: 0.0, ..TagReaderModel::default() });
/// let mut rng = RunSeed(1).stream("reader");
/// assert_eq!(reader.step(Stamp::from_millis(0), &[7], &mut rng), None, "it has only begun");
/// assert_eq!(reader.step(Stamp::from_millis(10), &[7], &mut rng), None);
/// assert_eq!(reader.step(Stamp::from_millis(20), &[7], &mut rng), Some(7));
/// ```
#[derive(Clone, Debug)]
pub struct TagReader {
    model: TagReaderModel,
    /// The tag that is being read, and since when.
    attempt: Option<(u32, Stamp)>,
    /// The tag whose turn was last.
    last: Option<u32>,
}

impl TagReader {
    /// A reader that has read nothing yet.
    pub fn new(model: TagReaderModel) -> Self {
        Self { model, attempt: None, last: None }
    }

    /// How it reads.
    pub fn model(&self) -> &TagReaderModel {
        &self.model
    }

    /// One step of time: `in_area` are the numbers of the tags in the recognition area now, ascending. The
    /// tag whose memory has been read by now, if any; at most one per call, so call at least once per read
    /// time. O(tags in the area), allocates nothing; draws one number per finished read.
    pub fn step(&mut self, now: Stamp, in_area: &[u32], rng: &mut RandomStream) -> Option<u32> {
        if in_area.len() > 1 && !self.model.anti_collision {
            // They answer at once, and nothing is understood.
            self.attempt = None;
            return None;
        }
        let begun = self.attempt.filter(|(tag, _)| in_area.contains(tag));
        let (done, under_way) = match begun {
            Some((tag, since)) if now.since(since) >= self.model.read_time => (Some(tag), None),
            other => (None, other),
        };
        self.last = done.or(self.last);
        self.attempt = under_way.or_else(|| self.next(in_area).map(|tag| (tag, now)));
        done.filter(|_| uniform(rng) >= self.model.miss_prob)
    }

    /// The next in turn: the first number after the last one, or the first of all.
    fn next(&self, in_area: &[u32]) -> Option<u32> {
        let after = |last: u32| in_area.iter().find(|tag| **tag > last);
        self.last.and_then(after).or(in_area.first()).copied()
    }
}

/// An even draw from [0, 1).
fn uniform(rng: &mut RandomStream) -> f64 {
    // 53 bits are what an f64 in [0, 1) can hold.
    (rng.next_u64() >> 11) as f64 * 2.0_f64.powi(-53)
}

#[cfg(test)]
mod tests {
    use run_context::RunSeed;

    use super::*;

    /// Reads in so many milliseconds, stepped every 10 ms, over tags that stay where they are.
    fn reads(model: TagReaderModel, in_area: &[u32], for_ms: u64) -> Vec<u32> {
        let mut reader = TagReader::new(model);
        let mut rng = RunSeed(3).stream("reader");
        (0..for_ms / 10)
            .filter_map(|k| reader.step(Stamp::from_millis(10 * k), in_area, &mut rng))
            .collect()
    }

    const SURE: TagReaderModel = TagReaderModel {
        range_m: 0.06,
        read_time: Duration::from_millis(50),
        miss_prob: 0.0,
        anti_collision: true,
    };

    /// Counted by hand: the first read begins at 0 and ends at 50 ms, the next at 100 ms, …
    #[test]
    fn one_read_after_another_takes_the_read_time() {
        assert_eq!(reads(SURE, &[4], 460), [4; 9]);
        assert!(reads(SURE, &[], 460).is_empty());
    }

    #[test]
    fn several_tags_are_read_in_turn_or_not_at_all() {
        assert_eq!(reads(SURE, &[2, 5, 9], 360), [2, 5, 9, 2, 5, 9, 2]);
        let plain = TagReaderModel { anti_collision: false, ..SURE };
        assert!(reads(plain, &[2, 5], 1000).is_empty());
        assert_eq!(reads(plain, &[2], 110), [2, 2]);
    }

    /// A tag that leaves the area before its read ends is not read, and the read does not count on.
    #[test]
    fn a_tag_that_leaves_is_not_read() {
        let mut reader = TagReader::new(SURE);
        let mut rng = RunSeed(3).stream("reader");
        let mut step = |ms, in_area: &[u32]| reader.step(Stamp::from_millis(ms), in_area, &mut rng);
        assert_eq!(step(0, &[1]), None);
        assert_eq!(step(40, &[1]), None);
        assert_eq!(step(50, &[]), None, "it left in time");
        assert_eq!(step(60, &[1]), None, "and came back");
        assert_eq!(step(100, &[1]), None, "40 ms of the new read");
        assert_eq!(step(110, &[1]), Some(1));
    }

    /// 2000 reads: the share that fails is p within 5·√(p(1−p)/n).
    #[test]
    fn reads_fail_as_often_as_the_model_says() {
        for miss_prob in [0.05, 0.3, 0.9] {
            let model = TagReaderModel { miss_prob, read_time: Duration::from_millis(10), ..SURE };
            let failed = 1.0 - reads(model, &[1], 20_000).len() as f64 / 2000.0;
            let within = 5.0 * (miss_prob * (1.0 - miss_prob) / 2000.0).sqrt();
            assert!((failed - miss_prob).abs() < within, "{miss_prob}: {failed}");
        }
        assert!(reads(TagReaderModel { miss_prob: 1.0, ..SURE }, &[1], 5000).is_empty());
    }
}
