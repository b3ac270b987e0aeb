//! What can be set about laser SLAM. The defaults are meant for every building; no log needs its own.

/// How ranges become points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointsConfig {
    /// Nearer readings are left out (the robot sees itself), metres.
    pub range_min_m: f64,
    /// Farther readings are left out, metres.
    pub range_max_m: f64,
    /// Spacing of the points that are kept along a surface, metres.
    pub spacing_m: f64,
    /// Neighbours up to this distance take part in a point's line, metres.
    pub normal_reach_m: f64,
    /// Neighbouring points farther apart than this are on different surfaces, metres.
    pub gap_m: f64,
    /// Points that a line needs, itself included.
    pub n_normal_points_min: usize,
    /// Greatest deviation from the line, root mean square, metres.
    pub normal_rms_max_m: f64,
}

/// How a scan is laid on surfels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RefineConfig {
    /// Greatest number of steps.
    pub iterations_max: usize,
    /// Greatest distance from a point to its surfel in the first step, metres.
    pub reach_start_m: f64,
    /// The same in the last steps, metres.
    pub reach_end_m: f64,
    /// Factor from step to step, 0 to 1.
    pub reach_shrink_ratio: f64,
    /// Errors beyond it count linearly, not quadratically, metres.
    pub robust_m: f64,
    /// Standard deviation of a point across its surface, metres.
    pub point_std_m: f64,
    /// Steps shorter than this and [`step_min_rad`](Self::step_min_rad) end the iteration, metres.
    pub step_min_m: f64,
    /// See [`step_min_m`](Self::step_min_m), radians.
    pub step_min_rad: f64,
}

/// How sure dead reckoning is: standard deviations grow with what was driven and turned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionConfig {
    /// Position, standing, metres.
    pub position_std_m: f64,
    /// Position per metre driven, a ratio.
    pub position_std_ratio: f64,
    /// Position per radian turned, metres.
    pub position_per_turn_std_m: f64,
    /// Yaw, standing, radians.
    pub yaw_std_rad: f64,
    /// Yaw per metre driven, radians.
    pub yaw_per_metre_std_rad: f64,
    /// Yaw per radian turned, a ratio.
    pub yaw_std_ratio: f64,
    /// Position, when the scan contradicts the odometry (slip, a push), metres.
    pub slip_position_std_m: f64,
    /// Yaw, when the scan contradicts the odometry, radians.
    pub slip_yaw_std_rad: f64,
    /// Without any odometry: position from scan to scan, metres.
    pub unknown_position_std_m: f64,
    /// Without any odometry: yaw from scan to scan, radians.
    pub unknown_yaw_std_rad: f64,
    /// Without any odometry: how much the speed changes in a second, metres per second.
    pub unknown_speed_std_mps: f64,
    /// Without any odometry: how much the rate of turning changes in a second, radians per second.
    pub unknown_turn_std_radps: f64,
}

/// How scans are tracked and keyframes chosen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrackingConfig {
    /// A new keyframe after this way, metres.
    pub keyframe_distance_m: f64,
    /// A new keyframe after this turn, radians.
    pub keyframe_turn_rad: f64,
    /// A new keyframe when fewer points than this share are explained by the map.
    pub keyframe_inlier_ratio: f64,
    /// Keyframes in the local map.
    pub local_keyframes: usize,
    /// Side of the cells in which surface points are merged, metres.
    pub surfel_cell_m: f64,
    /// Below this share of explained points a match is not believed.
    pub inlier_min_ratio: f64,
    /// Below this share wider windows are searched too.
    pub inlier_doubt_ratio: f64,
    /// What is found in a wider window needs this share.
    pub inlier_anywhere_ratio: f64,
    /// Cell of the likelihood grid, metres.
    pub grid_resolution_m: f64,
    /// Width of a surface in the likelihood grid, standard deviation, metres.
    pub grid_std_m: f64,
    /// A match counts as this many times less certain than independent points would make it.
    pub inflation_ratio: f64,
    /// Standard deviation that no match falls below, metres.
    pub floor_std_m: f64,
    /// The same for the yaw, radians.
    pub floor_std_rad: f64,
}

/// How loops are found, and when they are believed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoopConfig {
    /// Way between two visits that makes a loop, metres.
    pub way_min_m: f64,
    /// Places nearer than this, by the estimate and its uncertainty, are tried, metres.
    pub radius_m: f64,
    /// Candidates that are matched for each keyframe.
    pub candidates_max: usize,
    /// Keyframes on each side of the candidate that make up its map.
    pub side_keyframes: usize,
    /// Greatest shift that is searched, metres.
    pub window_max_m: f64,
    /// Greatest turn that is searched, radians.
    pub window_max_rad: f64,
    /// Mean likelihood that a match needs.
    pub score_min_ratio: f64,
    /// Share of explained points that a match needs.
    pub inlier_min_ratio: f64,
    /// Greatest share of the other map's points that the scan looks through.
    pub through_max_ratio: f64,
    /// Greatest difference between the match there and the match back, metres.
    pub both_ways_m: f64,
    /// The same, radians.
    pub both_ways_rad: f64,
    /// A match whose guess was less sure than this is kept until a second one agrees, metres.
    pub sure_std_m: f64,
    /// Keyframes within which the second one must come.
    pub agree_keyframes: usize,
}

/// Everything that can be set about laser SLAM.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct LaserConfig {
    /// From ranges to points.
    pub points: PointsConfig,
    /// Laying scans on surfels.
    pub refine: RefineConfig,
    /// Dead reckoning.
    pub motion: MotionConfig,
    /// Tracking and keyframes.
    pub tracking: TrackingConfig,
    /// Loops.
    pub loops: LoopConfig,
}

impl LaserConfig {
    /// The same with every length that has to do with noise stretched to ranges of this noise.
    ///
    /// Up to a few centimetres, which every common laser keeps, nothing changes. `range_std_m` is the
    /// standard deviation of one range, see [`range_std_m`](super::points::range_std_m).
    #[must_use]
    pub fn for_noise(&self, range_std_m: f64) -> Self {
        let mut config = *self;
        if range_std_m <= NOISE_USUAL_M {
            return config;
        }
        let at_least = |value: &mut f64, least: f64| *value = value.max(least);
        let std_m = range_std_m;
        at_least(&mut config.points.spacing_m, 0.3 * std_m);
        at_least(&mut config.points.normal_rms_max_m, 1.5 * std_m);
        // Six deviations on each side: the line's direction is then good to a few degrees.
        at_least(&mut config.points.normal_reach_m, 6.0 * std_m);
        at_least(&mut config.points.gap_m, 6.0 * std_m);
        at_least(&mut config.refine.robust_m, 0.7 * std_m);
        at_least(&mut config.refine.point_std_m, 0.4 * std_m);
        at_least(&mut config.refine.reach_start_m, 3.0 * std_m);
        at_least(&mut config.refine.reach_end_m, 2.0 * std_m);
        at_least(&mut config.tracking.surfel_cell_m, 3.0 * std_m);
        at_least(&mut config.tracking.grid_std_m, std_m);
        at_least(&mut config.tracking.grid_resolution_m, std_m / 3.0);
        config
    }
}

/// Ranges of less noise than this need no other settings, metres.
const NOISE_USUAL_M: f64 = 0.05;

impl Default for PointsConfig {
    fn default() -> Self {
        Self {
            range_min_m: 0.1,
            range_max_m: 60.0,
            spacing_m: 0.05,
            normal_reach_m: 0.15,
            gap_m: 0.15,
            n_normal_points_min: 4,
            normal_rms_max_m: 0.03,
        }
    }
}

impl Default for RefineConfig {
    fn default() -> Self {
        Self {
            iterations_max: 20,
            reach_start_m: 0.5,
            reach_end_m: 0.15,
            reach_shrink_ratio: 0.7,
            robust_m: 0.03,
            point_std_m: 0.02,
            step_min_m: 2e-4,
            step_min_rad: 5e-5,
        }
    }
}

impl Default for MotionConfig {
    fn default() -> Self {
        Self {
            position_std_m: 0.02,
            position_std_ratio: 0.1,
            position_per_turn_std_m: 0.05,
            yaw_std_rad: 0.01,
            yaw_per_metre_std_rad: 0.05,
            yaw_std_ratio: 0.1,
            slip_position_std_m: 0.3,
            slip_yaw_std_rad: 0.25,
            unknown_position_std_m: 0.05,
            unknown_yaw_std_rad: 0.03,
            unknown_speed_std_mps: 0.5,
            unknown_turn_std_radps: 0.5,
        }
    }
}

impl Default for TrackingConfig {
    fn default() -> Self {
        Self {
            keyframe_distance_m: 0.3,
            keyframe_turn_rad: 0.25,
            keyframe_inlier_ratio: 0.5,
            local_keyframes: 15,
            surfel_cell_m: 0.1,
            inlier_min_ratio: 0.3,
            inlier_doubt_ratio: 0.42,
            inlier_anywhere_ratio: 0.7,
            grid_resolution_m: 0.05,
            grid_std_m: 0.08,
            inflation_ratio: 30.0,
            floor_std_m: 0.01,
            floor_std_rad: 0.003,
        }
    }
}

impl Default for LoopConfig {
    fn default() -> Self {
        Self {
            way_min_m: 4.0,
            radius_m: 4.0,
            candidates_max: 2,
            side_keyframes: 5,
            window_max_m: 6.0,
            window_max_rad: 0.7,
            score_min_ratio: 0.4,
            inlier_min_ratio: 0.6,
            through_max_ratio: 0.2,
            both_ways_m: 0.1,
            both_ways_rad: 0.03,
            sure_std_m: 0.5,
            agree_keyframes: 12,
        }
    }
}
