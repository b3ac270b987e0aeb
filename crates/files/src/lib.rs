//! Files of people: outputs written by one rule, inputs read within limits.
//!
//! The rule, for every command that writes:
//!
//! 1. Nothing that exists is replaced unless that was asked for (`--force`).
//! 2. What the command reads is never written, whatever it is called: files are told apart by what they are, not by
//!    how their path is spelt. Nor is a file of another sort than the one that is written (a mission where a
//!    recording would go), with or without `--force`.
//! 3. Folders, links (symbolic and hard), pipes, devices and sockets are never replaced.
//! 4. No folder is made that was not asked for: the folder of results itself is, those above it are not.
//! 5. Everything is written beside its name and takes it when it is whole; on an error nothing half-written is
//!    left.
//! 6. All of this is known before the work begins ([`Outputs::check`]), and looked at again when it ends.
//!
//! ```
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let place = tempfile::tempdir()?;
//! # let (source, drawing) = (place.path().join("a.src"), place.path().join("a.svg"));
//! # std::fs::write(&source, "OR O0,I0,I1,0L,0L\n")?;
//! use files::{Kind, Outputs};
//!
//! let outputs = Outputs::new(false).keeping([&source]);
//! outputs.check(&drawing, Kind::SVG)?; // before the work
//! outputs.write(&drawing, Kind::SVG, b"<svg></svg>")?;
//! assert!(outputs.check(&drawing, Kind::SVG).is_err(), "it exists now");
//! assert!(outputs.check(&source, Kind::SVG).is_err(), "it is read");
//! # Ok(())
//! # }
//! ```

mod batch;
mod holder;
mod identity;
mod input;
mod kind;
mod output;
mod refusal;
mod sort;

pub use batch::{Batch, make_folder};
pub use input::{InputError, Limit, read, read_text, text_of};
pub use kind::Kind;
pub use output::{Live, Outputs, lock, numbered};
pub use refusal::Refusal;
pub use sort::Sort;
