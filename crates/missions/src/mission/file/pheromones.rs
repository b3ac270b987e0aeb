//! `[pheromones]`: trails and the server that knows of them.

use serde::{Deserialize, Serialize};

use super::lines::{LineFile, radio_line};

/// `[pheromones]`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct PheromonesFile {
    /// Trails as lines of corners, x and y (m).
    pub trails_m: Vec<Vec<[f64; 2]>>,
    /// Cells marked across the trail: 1, 3 or 5.
    pub width_cells: usize,
    /// Value of a marked cell, 1 to 127.
    pub value: u8,
    /// Matrix file, relative to the mission file, instead of trails.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub map_file: Option<String>,
    /// The text of such a matrix.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub map: Option<String>,
    /// Side of a cell, m.
    pub cell_m: f64,
    /// Columns; the grid is centred on the origin.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Perception radius, m.
    pub sigma_m: f64,
    /// Distance between the two antennas, m.
    pub antenna_spacing_m: f64,
    /// What the server multiplies intensities with before it sends them as bytes, 0.001 to 1; 0.5 or
    /// less for trails three cells wide, whose sum exceeds a byte.
    pub scale_ratio: f64,
    /// `scalar_sum`, `vector_atan2` or `listing`.
    pub perception: String,
    /// `[pheromones.line]`: the radio modem to the server.
    #[serde(deserialize_with = "radio_line")]
    pub line: LineFile,
}

impl Default for PheromonesFile {
    fn default() -> Self {
        Self {
            trails_m: Vec::new(),
            width_cells: 1,
            value: 1,
            map_file: None,
            map: None,
            cell_m: 0.2,
            width: 61,
            height: 61,
            sigma_m: 0.6,
            antenna_spacing_m: 0.38,
            scale_ratio: 1.0,
            perception: "scalar_sum".into(),
            line: LineFile::radio(),
        }
    }
}
