//! Where a robot is by the coordinates that tags in the floor store.
//!
//! Every read says that a place of the robot's dead reckoning is a place of the map. The last of these pairs are laid over
//! each other by a turn and a shift, in closed form.
//!
//! Source: the thesis, 3.5.2: every tag re-initialises the position. Differences: it takes the heading from a compass; here it
//! follows from several tags, as soon as they lie far enough apart. The least squares are those of a rigid motion in the
//! plane: tan θ = Σ pᵢ × qᵢ / Σ pᵢ · qᵢ about the two centres.

use geometry::{Se2, Vec2, wrap_to_pi};

/// Tags that are remembered.
const N_PAIRS: usize = 24;

/// Tags from which on the heading follows, and how far they must spread around their centre (r.m.s.), metres.
const N_FOR_HEADING: usize = 8;
const SPREAD_MIN_M: f64 = 0.25;

/// The part of what is found that one more tag corrects.
const GAIN: f64 = 0.25;

/// A tag, and where its reader was while it was read (m, dead reckoning).
#[derive(Clone, Copy, Debug, Default)]
struct Pair {
    tag: u32,
    in_map: Vec2,
    in_odom_sum: Vec2,
    n_reads: f64,
}

impl Pair {
    fn in_odom(&self) -> Vec2 {
        self.in_odom_sum / self.n_reads.max(1.0)
    }
}

/// The last pairs.
#[derive(Clone, Debug)]
pub(crate) struct TagFixes {
    pairs: [Pair; N_PAIRS],
    n_pairs: usize,
    next: usize,
}

impl TagFixes {
    pub(crate) fn new() -> Self {
        Self { pairs: [Pair::default(); N_PAIRS], n_pairs: 0, next: 0 }
    }

    /// A tag was read while its reader was there. While a tag stays under its reader its place is the mean, which
    /// is the middle of the chord that the reader cut out of the tag's surroundings.
    pub(crate) fn note(&mut self, tag: u32, in_map: Vec2, in_odom: Vec2) {
        let recent = (1..=4.min(self.n_pairs)).map(|k| (self.next + N_PAIRS - k) % N_PAIRS);
        if let Some(index) = recent.into_iter().find(|index| self.pairs[*index].tag == tag) {
            self.pairs[index].in_odom_sum += in_odom;
            self.pairs[index].n_reads += 1.0;
            return;
        }
        self.pairs[self.next] = Pair { tag, in_map, in_odom_sum: in_odom, n_reads: 1.0 };
        self.next = (self.next + 1) % N_PAIRS;
        self.n_pairs = (self.n_pairs + 1).min(N_PAIRS);
    }

    /// The place of the dead reckoning in the map, corrected by a part of what the tags say, and whether they say
    /// anything about the heading.
    pub(crate) fn corrected(&self, map_from_odom: Se2) -> (Se2, bool) {
        if self.n_pairs == 0 {
            return (map_from_odom, false);
        }
        let pairs = &self.pairs[..self.n_pairs];
        let n = self.n_pairs as f64;
        let odom_centre = pairs.iter().map(Pair::in_odom).sum::<Vec2>() / n;
        let map_centre = pairs.iter().map(|pair| pair.in_map).sum::<Vec2>() / n;
        let (mut dot, mut cross, mut square_m2) = (0.0, 0.0, 0.0);
        for pair in pairs {
            let (p, q) = (pair.in_odom() - odom_centre, pair.in_map - map_centre);
            dot += p.dot(&q);
            cross += p.perp(&q);
            square_m2 += p.norm_squared();
        }
        let turns = self.n_pairs >= N_FOR_HEADING && (square_m2 / n).sqrt() >= SPREAD_MIN_M;
        let yaw_rad = if turns { cross.atan2(dot) } else { map_from_odom.yaw_rad };
        let turn_rad = GAIN * wrap_to_pi(yaw_rad - map_from_odom.yaw_rad);
        let corrected_rad = wrap_to_pi(map_from_odom.yaw_rad + turn_rad);
        // Turned about the centre of the tags, then shifted there.
        let centre_before = map_from_odom.transform_point(odom_centre);
        let centre = centre_before + (map_centre - centre_before) * GAIN;
        let turned = Se2::new(0.0, 0.0, corrected_rad).transform_point(odom_centre);
        let shift = centre - turned;
        (Se2::new(shift.x, shift.y, corrected_rad), turns)
    }

    /// Forgets all pairs: the robot was lifted.
    pub(crate) fn clear(&mut self) {
        self.n_pairs = 0;
        self.next = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tags along a bent way, seen from a dead reckoning that is turned and shifted; each a little off.
    fn fixed(truth: Se2, believed: Se2, n_tags: u32, spacing_m: f64) -> (Se2, bool) {
        let mut fix = TagFixes::new();
        let (mut found, mut turns) = (believed, false);
        for k in 0..n_tags {
            let along = spacing_m * f64::from(k);
            let tag = Vec2::new(along, 0.3 * along.sin());
            let off = Vec2::new(0.03 * f64::from(k).sin(), 0.03 * (2.0 * f64::from(k)).cos());
            for _ in 0..3 {
                fix.note(k, tag, truth.inverse().transform_point(tag + off));
                (found, turns) = fix.corrected(found);
            }
        }
        (found, turns)
    }

    #[test]
    fn a_wrong_place_and_heading_are_put_right() {
        let truth = Se2::new(0.4, -0.7, 2.0);
        for off in [Se2::new(0.3, 0.2, 0.0), Se2::new(-0.2, 0.1, 0.4), Se2::new(0.0, 0.0, -0.4)] {
            let believed = off.compose(truth);
            let (found, turns) = fixed(truth, believed, 60, 0.1);
            assert!(turns);
            let yaw_off_rad = wrap_to_pi(found.yaw_rad - truth.yaw_rad);
            assert!(yaw_off_rad.abs() < 0.02, "{off:?}: {yaw_off_rad}");
            // Where it matters: at the last tags.
            let last = truth.inverse().transform_point(Vec2::new(5.9, 0.3 * 5.9_f64.sin()));
            let place_off_m = (found.transform_point(last) - truth.transform_point(last)).norm();
            assert!(place_off_m < 0.03, "{off:?}: {place_off_m}");
        }
    }

    /// Too few tags, or all at one place, say where but not which way.
    #[test]
    fn the_heading_waits_until_tags_lie_apart() {
        let truth = Se2::new(0.0, 0.0, 0.5);
        let believed = Se2::new(0.0, 0.0, 0.3);
        for (n_tags, spacing_m) in [(7, 0.3), (24, 0.01)] {
            let (found, turns) = fixed(truth, believed, n_tags, spacing_m);
            assert!(!turns && (found.yaw_rad - 0.3).abs() < 1e-12, "{n_tags}: {found:?}");
        }
        let mut fix = TagFixes::new();
        assert_eq!(fix.corrected(believed), (believed, false));
        fix.note(1, Vec2::zeros(), Vec2::zeros());
        fix.clear();
        assert_eq!(fix.corrected(believed), (believed, false));
    }
}
