//! What a panel and a layer are.

/// A panel beside the map. `S` is what a session has.
pub(super) struct Panel<S> {
    /// Its name.
    pub key: &'static str,
    /// What its tab says.
    pub title: &'static str,
    /// The key that brings it to the front.
    pub digit: u8,
    /// The row of tabs, from above.
    pub row: usize,
    /// A sentence for the guide.
    #[cfg_attr(not(test), expect(dead_code, reason = "a test writes it into the guide"))]
    pub about: &'static str,
    pub is_offered: fn(&S) -> bool,
}

/// A part of the picture that can be switched off.
pub(super) struct Layer<S> {
    /// Its name.
    pub key: &'static str,
    /// What the list says.
    pub label: &'static str,
    /// The colour beside it, as style sheets write it.
    pub colour: &'static str,
    /// Whether it is shown until somebody switches it off.
    pub is_on: bool,
    /// How it looks, for the guide.
    #[cfg_attr(not(test), expect(dead_code, reason = "a test writes it into the guide"))]
    pub looks: &'static str,
    /// What it is, for the guide.
    #[cfg_attr(not(test), expect(dead_code, reason = "a test writes it into the guide"))]
    pub about: &'static str,
    pub is_offered: fn(&S) -> bool,
}

/// What a survey has.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct SurveyHas {
    /// Ranges of a ring of sonars; else of a laser.
    pub sonar: bool,
    /// True poses.
    pub truth: bool,
}
