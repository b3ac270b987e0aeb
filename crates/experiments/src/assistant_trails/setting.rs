//! The conditions on the straight trail.

/// The part of the straight trail on which the error has settled, m along it.
pub(super) const SETTLED_M: std::ops::Range<f64> = 3.0..6.6;
/// Distance from the trail from which on a robot counts as having lost it, m.
pub(super) const LOST_M: f64 = 0.6;

/// One row of the settings on the straight trail.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Setting {
    pub(super) acceleration_mps2: f64,
    pub(super) speed_mps: f64,
    pub(super) period_ms: u32,
    pub(super) sigma_m: f64,
    pub(super) five_sets: bool,
    /// Cairn's default way of driving: sets as wide and a speed as great as the trail allows. The thesis's
    /// robot keeps its speed, and its law is the same at every speed.
    pub(super) fit_to_speed: bool,
}

impl Setting {
    /// The thesis's own conditions.
    pub(super) const THESIS: Self = Self {
        acceleration_mps2: 0.3,
        speed_mps: 0.3,
        period_ms: 200,
        sigma_m: 0.6,
        five_sets: false,
        fit_to_speed: false,
    };

    pub(super) fn overrides(self) -> Vec<String> {
        let Self { acceleration_mps2, speed_mps, period_ms, sigma_m, five_sets, fit_to_speed } =
            self;
        let controller = if five_sets { "fuzzy_fine" } else { "fuzzy" };
        vec![
            // The thesis's robot drives off at once; its law turns it.
            "robots.mind.follow.turn_first=false".to_owned(),
            // And its antennas alone lead it: no scout helps when they smell nothing.
            "robots.mind.how.preview_m=0".to_owned(),
            format!("robots.mind.follow.fit_to_speed={fit_to_speed}"),
            format!("robots.mind.follow.acceleration_mps2={acceleration_mps2}"),
            format!("robots.mind.follow.speed_mps={speed_mps}"),
            format!("robots.mind.control_period_ms={period_ms}"),
            format!("robots.mind.follow.trail_law={controller}"),
            format!("pheromones.sigma_m={sigma_m}"),
        ]
    }
}

impl Setting {
    /// Five sets, a larger radius and a shorter period.
    pub(super) fn with_all_remedies(self) -> Self {
        Self { five_sets: true, sigma_m: 0.9, period_ms: 100, ..self }
    }
}
