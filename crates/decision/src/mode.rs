//! Two behaviours of the machine: that of the text and that of the listing.

/// Which of two behaviours, where the thesis's listing and its text disagree.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mode {
    /// As the text means it.
    #[default]
    Corrected,
    /// As the printed listing does it, mistakes included.
    Listing,
}

settings::choices!(Mode {
    Corrected = "corrected": "as the thesis's text means it",
    Listing = "listing": "as the printed program does it, mistakes included",
});
