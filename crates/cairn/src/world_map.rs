//! A world out of whatever file people name: a map of any format, a mission, a shipped mission.

use std::path::Path;

use missions::Mission;

use crate::output::complain;

/// Whether a name is that of a map, by its ending, and not of a mission.
fn is_map(path: &Path) -> bool {
    let ends = ["map", "yaml", "yml"];
    path.extension().is_some_and(|found| ends.iter().any(|end| found.eq_ignore_ascii_case(end)))
}

/// The mission of that name, or one whose world is the map of that name and nothing else. What was guessed about the
/// map is told.
///
/// # Errors
///
/// A mission or map that cannot be read.
pub(crate) fn mission(name: &str) -> anyhow::Result<Mission> {
    if name.to_ascii_lowercase().ends_with(".map.gz") {
        anyhow::bail!(
            "{name} is packed: unpack it first (gunzip --keep {name}) and give the .map file"
        );
    }
    let path = Path::new(name);
    if !is_map(path) {
        return Ok(Mission::load(name, &[])?);
    }
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    let file_name =
        toml::Value::from(path.file_name().unwrap_or_default().to_string_lossy().as_ref());
    let text = format!("[mission]\nname = \"map\"\n[world]\nmap = {file_name}\n");
    let mission = Mission::parse_in(folder.unwrap_or(Path::new(".")), name, &text, &[])?;
    let warnings = mission.warnings();
    let notes = warnings.iter().filter_map(|warning| warning.strip_prefix("world.map: "));
    notes.for_each(|note| complain!("{name}: {note}"));
    Ok(mission)
}
