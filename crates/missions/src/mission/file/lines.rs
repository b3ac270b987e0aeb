//! Lines between nodes: `[robots.line]`, `[robots.lasers.line]`, `[pheromones.line]`, `[decision.line]`.

use serde::{Deserialize, Deserializer, Serialize};

/// A line between two nodes.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct LineFile {
    /// `memory`, `direct`, `tcp` or `serial`.
    pub kind: String,
    /// Bits per second, 10 bits a byte; 0: no limit.
    pub baud: u32,
    /// Delay of each byte, ms.
    pub latency_ms: f64,
    /// Up to this much is added to the delay at random, ms.
    pub jitter_ms: f64,
    /// Probability that a byte is lost.
    pub loss_prob: f64,
    /// Probability that a byte is corrupted.
    pub corruption_prob: f64,
    /// `tcp`: host and port.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub address: String,
    /// `serial`: the device.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub device: String,
}

impl Default for LineFile {
    fn default() -> Self {
        Self {
            kind: "memory".into(),
            baud: 9600,
            latency_ms: 2.0,
            jitter_ms: 0.0,
            loss_prob: 0.0,
            corruption_prob: 0.0,
            address: String::new(),
            device: String::new(),
        }
    }
}

impl LineFile {
    /// A radio modem: a line that takes longer than a cable.
    pub(super) fn radio() -> Self {
        Self { latency_ms: 5.0, ..Self::default() }
    }

    /// A laser's cable: as fast as the device speaks.
    pub(crate) fn laser() -> Self {
        Self { baud: 0, ..Self::default() }
    }
}

/// A line whose other keys are those of a laser's cable.
pub(super) fn laser_line<'de, D: Deserializer<'de>>(from: D) -> Result<LineFile, D::Error> {
    LineKeys::deserialize(from).map(|keys| keys.over(LineFile::laser()))
}

/// The keys of a line as far as they are written.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct LineKeys {
    kind: Option<String>,
    baud: Option<u32>,
    latency_ms: Option<f64>,
    jitter_ms: Option<f64>,
    loss_prob: Option<f64>,
    corruption_prob: Option<f64>,
    address: Option<String>,
    device: Option<String>,
}

/// A line whose other keys are those of a radio modem, and not those of a cable.
pub(super) fn radio_line<'de, D: Deserializer<'de>>(from: D) -> Result<LineFile, D::Error> {
    LineKeys::deserialize(from).map(|keys| keys.over(LineFile::radio()))
}

impl LineKeys {
    /// What is not written is as in `usual`.
    fn over(self, usual: LineFile) -> LineFile {
        LineFile {
            kind: self.kind.unwrap_or(usual.kind),
            baud: self.baud.unwrap_or(usual.baud),
            latency_ms: self.latency_ms.unwrap_or(usual.latency_ms),
            jitter_ms: self.jitter_ms.unwrap_or(usual.jitter_ms),
            loss_prob: self.loss_prob.unwrap_or(usual.loss_prob),
            corruption_prob: self.corruption_prob.unwrap_or(usual.corruption_prob),
            address: self.address.unwrap_or(usual.address),
            device: self.device.unwrap_or(usual.device),
        }
    }
}
