//! What people give instead of a file: a shipped mission's name, or `-` for standard input.

use std::{io::Read as _, path::Path};

use anyhow::{Context, bail};
use missions::Mission;

use crate::output::complain;

/// The name that stands for standard input.
const STDIN: &str = "-";
/// What errors call it.
pub(crate) const STDIN_NAME: &str = "standard input";

/// Whether a path stands for standard input.
pub(crate) fn is_stdin(path: &Path) -> bool {
    path.as_os_str() == STDIN
}

/// Standard input to its end, at most `bytes_max`.
pub(crate) fn stdin(bytes_max: u64) -> anyhow::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let n = std::io::stdin()
        .lock()
        .take(bytes_max + 1)
        .read_to_end(&mut bytes)
        .context("standard input cannot be read")?;
    if n as u64 > bytes_max {
        bail!("standard input has more than {bytes_max} bytes, the most that is read here");
    }
    Ok(bytes)
}

/// A mission: a shipped one by its name, a file by its path, or `-` for standard input. What is odd about it is said on
/// standard error.
pub(crate) fn mission(name: &str, overrides: &[String]) -> anyhow::Result<Mission> {
    let mission = mission_without_warnings(name, overrides)?;
    for warning in mission.warnings() {
        complain!("cairn: warning: {}: {warning}", shown(name));
    }
    Ok(mission)
}

/// The same, for callers who tell the warnings themselves.
pub(crate) fn mission_without_warnings(
    name: &str,
    overrides: &[String],
) -> anyhow::Result<Mission> {
    if name != STDIN {
        return Ok(Mission::load(name, overrides)?);
    }
    let bytes = stdin(MISSION_BYTES_MAX)?;
    let text = files::text_of(Path::new(STDIN_NAME), "the mission from", bytes)?;
    Ok(Mission::parse_in(Path::new(""), STDIN_NAME, &text, overrides)?)
}

/// A mission with its programs and maps inlined stays far below this.
const MISSION_BYTES_MAX: u64 = 64 * 1024 * 1024;

/// A name as errors say it.
pub(crate) fn shown(name: &str) -> &str {
    if name == STDIN { STDIN_NAME } else { name }
}
