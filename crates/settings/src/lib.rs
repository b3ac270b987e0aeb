//! Settings as people write them: words to choose from, single keys from the command line, values located in their file.
//!
//! A settings file is TOML whose keys a crate of its own declares; here is only what all of them share.
//!
//! ```
//! let text = "[map]\nresolution_m = 0.05\n";
//! let mut table: toml::Table = toml::from_str(text).unwrap();
//! settings::apply(&mut table, "map.resolution_m=9")?;
//! let found = table["map"]["resolution_m"].as_integer();
//! assert_eq!(found, Some(9));
//! # Ok::<(), settings::OverrideError>(())
//! ```

mod choice;
mod overrides;
mod suggest;
mod values;

pub use choice::{Choice, chosen, chosen_of, listed, picked, words};
pub use overrides::{OverrideError, apply, setter};
pub use suggest::{clarified, did_you_mean, meant_key, told};
pub use values::{SettingError, Wrong, range};
