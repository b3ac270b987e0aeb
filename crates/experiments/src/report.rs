//! What every report of an experiment ends with.

use figures::{Section, Table};

/// The last section: what the document says, what is found, why they differ.
pub(crate) fn comparison<const N: usize>(rows: [[String; 3]; N]) -> Section {
    let mut table = Table::new(
        "Reported and measured",
        &["reported by the document", "measured here", "why they differ"],
    );
    table.rows = rows.into_iter().map(Vec::from).collect();
    Section {
        heading: "What the document reports, and what is found".to_owned(),
        tables: vec![table],
        ..Section::default()
    }
}
