//! `[robots.mind]`: a table for each question that a robot on its way must answer.

use serde::{Deserialize, Serialize};

/// `[robots.mind]`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct MindFile {
    /// Time between two control steps, ms.
    pub control_period_ms: u32,
    /// `[robots.mind.where_am_i]`.
    pub where_am_i: WhereAmIFile,
    /// `[robots.mind.where_to]`.
    pub where_to: WhereToFile,
    /// `[robots.mind.how]`.
    pub how: HowFile,
    /// `[robots.mind.follow]`.
    pub follow: FollowFile,
    /// `[robots.mind.guard]`.
    pub guard: GuardFile,
    /// `[robots.mind.health]`.
    pub health: HealthFile,
}

impl Default for MindFile {
    fn default() -> Self {
        Self {
            control_period_ms: 200,
            where_am_i: WhereAmIFile::default(),
            where_to: WhereToFile::default(),
            how: HowFile::default(),
            follow: FollowFile::default(),
            guard: GuardFile::default(),
            health: HealthFile::default(),
        }
    }
}

/// `[robots.mind.where_am_i]`: what tells it where it is.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct WhereAmIFile {
    /// A word of [`navigator::PoseMethod`].
    pub method: String,
}

impl Default for WhereAmIFile {
    fn default() -> Self {
        Self { method: "tag_fixes".into() }
    }
}

/// `[robots.mind.where_to]`: when it has arrived, and which places come before the goal.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct WhereToFile {
    /// How near to the goal it must stand, m.
    pub within_m: f64,
    /// How well it must look the goal's way, degrees.
    pub within_deg: f64,
    /// Places, x and y (m), that `how.method = "straight"` visits in this order before every goal.
    pub via_m: Vec<[f64; 2]>,
}

impl Default for WhereToFile {
    fn default() -> Self {
        Self { within_m: 0.06, within_deg: 4.0, via_m: Vec::new() }
    }
}

/// `[robots.mind.how]`: the route to the goal.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct HowFile {
    /// A word of [`navigator::Method`].
    pub method: String,
    /// Corners of the path that `method = "path"` follows to its goal, from start to goal.
    pub path_m: Vec<[f64; 2]>,
    /// How much of the way that its scout found it shows ahead, m; 0: it follows its antennas alone, also at junctions.
    pub preview_m: f64,
    /// Within this distance of the goal it leaves the trail for a straight line, m.
    pub approach_m: f64,
}

impl Default for HowFile {
    fn default() -> Self {
        Self { method: "trail".into(), path_m: Vec::new(), preview_m: 4.0, approach_m: 0.7 }
    }
}

/// `[robots.mind.follow]`: how it keeps to its route, and how fast.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct FollowFile {
    /// Cruising speed, m/s.
    pub speed_mps: f64,
    /// What the wheels are told to accelerate with, m/s².
    pub acceleration_mps2: f64,
    /// The steering law on a trail, a word of [`path_following::TrailController`].
    pub trail_law: String,
    /// The steering law on a path, a word of [`path_following::PathController`].
    pub path_law: String,
    /// Whether it turns in place towards the trail before it drives off, and at sharp corners.
    pub turn_first: bool,
    /// Whether on a trail it slows down for bends and the goal, and widens the sets of laws that have some above 0.3
    /// m/s; otherwise the law is as printed and the speed constant, as in the thesis.
    pub fit_to_speed: bool,
    /// `[robots.mind.follow.fuzzy]`: sets and rules of the fuzzy laws on the trail.
    pub fuzzy: FuzzyFile,
    /// `[robots.mind.follow.tags]`: how it follows tags in the floor.
    pub tags: TagFollowingFile,
}

impl Default for FollowFile {
    fn default() -> Self {
        Self {
            speed_mps: 0.3,
            acceleration_mps2: 0.3,
            trail_law: "fuzzy".into(),
            path_law: "fuzzy".into(),
            turn_first: true,
            fit_to_speed: true,
            fuzzy: FuzzyFile::default(),
            tags: TagFollowingFile::default(),
        }
    }
}

/// `[robots.mind.follow.fuzzy]`: sets and rules, for the trail laws that have some.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct FuzzyFile {
    /// ME: the error from which on the outermost set is fully true, in units of intensity.
    pub error_full: u32,
    /// MED: the same for the change of the error between two steps.
    pub change_full: u32,
    /// L as a ratio of M, the cruising speed.
    pub slow_ratio: f64,
    /// H as a ratio of M.
    pub fast_ratio: f64,
    /// M of `listing`, which has its own speeds, mm/s.
    pub listing_mean_mmps: u32,
    /// The rules: `antisymmetric`, `literal_mirror`, `table_5_1` or `own`.
    pub table: String,
    /// Rules of the left wheel for `table = "own"`: nine letters L, M, H.
    pub left_rules: String,
    /// Rules of the right wheel.
    pub right_rules: String,
}

impl Default for FuzzyFile {
    fn default() -> Self {
        Self {
            error_full: 50,
            change_full: 25,
            slow_ratio: 0.5,
            fast_ratio: 1.5,
            listing_mean_mmps: 300,
            table: "antisymmetric".into(),
            left_rules: String::new(),
            right_rules: String::new(),
        }
    }
}

/// `[robots.mind.follow.tags]`: how `how.method = "tags"` follows them.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct TagFollowingFile {
    /// `gradient` (two readers, fuzzy) or `look_ahead` (the point that each tag stores, pure pursuit).
    pub law: String,
    /// Difference of the two readers' intensities from which on the outermost fuzzy set is fully true.
    pub error_full: u32,
    /// The same for its change over 6 cm of way.
    pub change_full: u32,
    /// L as a ratio of M, the cruising speed.
    pub slow_ratio: f64,
    /// H as a ratio of M.
    pub fast_ratio: f64,
    /// Way over which what was read is smoothed, m.
    pub smooth_m: f64,
    /// Way without a read after which a reader smells nothing any more, m.
    pub hold_m: f64,
}

impl Default for TagFollowingFile {
    fn default() -> Self {
        Self {
            law: "gradient".into(),
            error_full: 150,
            change_full: 60,
            slow_ratio: 0.0,
            fast_ratio: 2.0,
            smooth_m: 0.05,
            hold_m: 0.3,
        }
    }
}

/// `[robots.mind.guard]`: what it does about obstacles.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct GuardFile {
    /// A word of [`navigator::Avoidance`].
    pub method: String,
    /// When it aims at its target again after a rebound, a word of [`obstacle_avoidance::Variant`].
    pub aims_again: String,
    /// How long it waits for an obstacle to go away, s; 0: not at all.
    pub wait_s: f64,
    /// Attempts on one obstacle before it gives up.
    pub attempts_max: u32,
}

impl Default for GuardFile {
    fn default() -> Self {
        Self {
            method: "checked".into(),
            aims_again: "visibility".into(),
            wait_s: 2.5,
            attempts_max: 10,
        }
    }
}

/// `[robots.mind.health]`: after how long it gives up.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct HealthFile {
    /// A whole task, from its order on, s.
    pub task_limit_s: f64,
    /// Without coming nearer to the goal along the way, s.
    pub progress_limit_s: f64,
    /// Without a word from its robot, s.
    pub link_limit_s: f64,
    /// Without an answer of the pheromone server, s.
    pub server_limit_s: f64,
}

impl Default for HealthFile {
    fn default() -> Self {
        Self { task_limit_s: 900.0, progress_limit_s: 90.0, link_limit_s: 2.0, server_limit_s: 5.0 }
    }
}
