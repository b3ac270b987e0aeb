//! What subcommands read: within limits, and long reading says how far it is.

use std::path::Path;

use files::{InputError, Limit, Sort};
use indicatif::{ProgressBar, ProgressStyle};

/// From this size on a file's reading is shown, bytes.
const SHOWN_FROM_BYTES: u64 = 32 << 20;

/// Reads a log, a recording or a graph of at most [`Limit::LOG`]; `what` is what it should be, with its article.
pub(crate) fn read(path: &Path, what: &str) -> Result<Vec<u8>, InputError> {
    let bar = ProgressBar::hidden();
    let bytes = files::read(path, what, Limit::LOG, &mut |read, size| {
        if size.is_none_or(|size| size < SHOWN_FROM_BYTES) {
            return;
        }
        if bar.is_hidden() {
            bar.set_draw_target(indicatif::ProgressDrawTarget::stderr());
            bar.set_length(size.unwrap_or(0));
            if let Ok(style) =
                ProgressStyle::with_template("reading {wide_bar} {bytes}/{total_bytes}")
            {
                bar.set_style(style);
            }
        }
        bar.set_position(read);
    });
    bar.finish_and_clear();
    bytes
}

/// Why a file that was read is not what it should be: what else it is, when that shows; `error` otherwise.
pub(crate) fn another(
    path: &Path,
    bytes: &[u8],
    wanted: &str,
    error: impl std::error::Error + Send + Sync + 'static,
) -> anyhow::Error {
    let name = path.display();
    match Sort::of(path, bytes) {
        Some(sort) if !sort.is_measured() => anyhow::anyhow!("{name} is no {wanted}: it is {sort}"),
        _ if error.to_string().contains(&*name.to_string()) => error.into(),
        _ => anyhow::Error::new(error).context(name.to_string()),
    }
}
