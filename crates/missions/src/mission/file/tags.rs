//! `[tags]` and `[robots.tag_readers]`: tags in the floor, and the readers over them.

use serde::{Deserialize, Serialize};

/// `[tags]`: passive radio tags in the floor, and the trail that is written into them.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct TagsFile {
    /// Trails as lines of corners, x and y (m).
    pub trails_m: Vec<Vec<[f64; 2]>>,
    /// Tags across the trail that store something, 1 to 9; even numbers suit a trail between two rows.
    pub width_cells: usize,
    /// What a tag in the middle of the trail stores, 1 to 255.
    pub peak: u8,
    /// Distance between neighbouring tags, m.
    pub pitch_m: f64,
    /// Where the floor has tags: x0, y0, x1, y1 (m); empty: within `world.bounds_m`.
    pub area_m: Vec<f64>,
    /// Part of the tags that do not answer, drawn by the seed.
    pub missing_ratio: f64,
    /// How far along the trail the look-ahead point lies that each tag of it stores, m; 0: none is stored.
    pub look_ahead_m: f64,
}

impl Default for TagsFile {
    fn default() -> Self {
        Self {
            trails_m: Vec::new(),
            width_cells: 3,
            peak: 200,
            pitch_m: 0.1,
            area_m: Vec::new(),
            missing_ratio: 0.0,
            look_ahead_m: 0.6,
        }
    }
}

/// `[robots.tag_readers]`: the readers under a robot.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct TagReadersFile {
    /// Places (x, y, m, robot's frame): left and right, or one for `look_ahead`; empty: under the front of a Pioneer,
    /// two or one as the law wants them.
    pub at_m: Vec<[f64; 2]>,
    /// Radius of the recognition area on the floor, m.
    pub range_m: f64,
    /// What one read takes, ms.
    pub read_ms: f64,
    /// Probability that a read fails.
    pub miss_prob: f64,
    /// Whether several tags in the area are read in turn; otherwise none of them is understood.
    pub anti_collision: bool,
    /// What the robot adds to a tag of the trail that it passes, 0 to 255.
    pub amplify: u8,
}

impl Default for TagReadersFile {
    fn default() -> Self {
        Self {
            at_m: Vec::new(),
            range_m: 0.06,
            read_ms: 20.0,
            miss_prob: 0.05,
            anti_collision: true,
            amplify: 0,
        }
    }
}
