//! The missions that come with the library, embedded in it.

/// A mission and the files it names.
pub(crate) struct ShippedMission {
    pub(crate) name: &'static str,
    pub(crate) text: &'static str,
}

/// A file that shipped missions name.
pub(crate) struct ShippedFile {
    pub(crate) path: &'static str,
    pub(crate) bytes: &'static [u8],
}

impl ShippedFile {
    /// Its text, if it is one.
    pub(crate) fn text(&self) -> Option<&'static str> {
        str::from_utf8(self.bytes).ok()
    }
}

macro_rules! shipped {
    ($($name:literal),* $(,)?) => {
        &[$(ShippedMission {
            name: $name,
            text: include_str!(concat!("../../../../missions/", $name, ".toml")),
        }),*]
    };
}

macro_rules! shipped_files {
    ($($path:literal),* $(,)?) => {
        &[$(ShippedFile {
            path: $path,
            bytes: include_bytes!(concat!("../../../../missions/", $path)),
        }),*]
    };
}

/// In the order in which they are offered: the first is what `cairn` runs without arguments.
pub(crate) const MISSIONS: &[ShippedMission] = shipped![
    "doorbell",
    "doorbell-answered",
    "trail-45deg",
    "trail-corner",
    "trail-junctions",
    "tag-trail",
    "path-slalom",
    "one-obstacle",
    "intermediate-goals",
    "decision-rig",
    "errands",
    "night-watch",
    "swarm",
    "link-cut",
    "server-lost",
    "ward-call",
    "ward-rounds",
    "go-anywhere",
    "workshop",
    "laser-ward",
    "create-errand",
    "create-scan",
    "artemic-e1",
    "artemic-e2",
    "artemic-e3",
    "artemic-e4",
];

/// Programs and maps that the shipped missions name.
pub(crate) const FILES: &[ShippedFile] = shipped_files![
    "doorbell.rdpl",
    "errands.rdpl",
    "night-watch.rdpl",
    "ward-call.rdpl",
    "ward.yaml",
    "ward.png",
    "workshop.map",
];

/// The expected verdicts: name, seed, `pass` or `fail`, tab-separated, one line each below a head.
pub(crate) const EXPECTED: &str = include_str!("../../../../missions/expected.tsv");
