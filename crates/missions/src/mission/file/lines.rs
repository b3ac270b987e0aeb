//! Lines between nodes: `[robots.line]`, `[pheromones.line]`, `[decision.line]`.

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
    let keys = LineKeys::deserialize(from)?;
    let radio = LineFile::radio();
    Ok(LineFile {
        kind: keys.kind.unwrap_or(radio.kind),
        baud: keys.baud.unwrap_or(radio.baud),
        latency_ms: keys.latency_ms.unwrap_or(radio.latency_ms),
        jitter_ms: keys.jitter_ms.unwrap_or(radio.jitter_ms),
        loss_prob: keys.loss_prob.unwrap_or(radio.loss_prob),
        corruption_prob: keys.corruption_prob.unwrap_or(radio.corruption_prob),
        address: keys.address.unwrap_or(radio.address),
        device: keys.device.unwrap_or(radio.device),
    })
}
