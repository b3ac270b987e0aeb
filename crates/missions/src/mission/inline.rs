//! The files that a mission names, read into it, so that it stands alone.
//!
//! A decision program and a matrix of pheromones become their text. So does a map of the world,
//! whatever its format: the picture of a ROS map stands within the text of its YAML.

use std::{
    cell::RefCell,
    path::{Path, PathBuf},
};

use grid_maps::files::{MapYaml, read_picture};
use settings::{SettingError, Wrong};
use simulator::floor_plan::MapFormat;

use super::{error::MissionError, file::MissionFile, shipped};

/// Where the files that a mission names are.
pub(super) enum Shelf<'s> {
    /// Among those that are shipped, and nowhere else.
    Shipped,
    /// In a folder; what was read is noted, and what was guessed about it.
    Folder {
        folder: &'s Path,
        read_from: &'s RefCell<Vec<PathBuf>>,
        guesses: &'s RefCell<Vec<String>>,
    },
}

/// Why a file could not be read in.
pub(super) enum Fault {
    /// The key that names it has no value that could be used.
    Named(Box<Wrong>),
    /// Something is wrong within it.
    Within(Box<SettingError>),
}

/// Which key became the text of a file, and the file's name.
pub(super) type Read = (&'static str, String);

impl Shelf<'_> {
    /// The text of a file; `what` is what it should be, with its article.
    fn text(&self, name: &str, what: &str) -> Result<String, MissionError> {
        match self {
            Self::Shipped => {
                let file = shipped(name)?;
                Ok(String::from_utf8_lossy(file.bytes).into_owned())
            }
            Self::Folder { folder, read_from, guesses } => {
                let path = folder.join(name);
                read_from.borrow_mut().push(path.clone());
                if path.extension().is_some_and(|end| end.eq_ignore_ascii_case("rdpl")) {
                    return read_program(&path, &mut guesses.borrow_mut());
                }
                Ok(files::read_text(&path, what)?)
            }
        }
    }

    fn picture(&self, name: &str) -> Result<Vec<u8>, MissionError> {
        match self {
            Self::Shipped => Ok(shipped(name)?.bytes.to_vec()),
            Self::Folder { folder, read_from, .. } => {
                read_from.borrow_mut().push(folder.join(name));
                let (path, limit) = (folder.join(name), files::Limit::PICTURE);
                Ok(files::read(&path, "the picture of the map", limit, &mut |_, _| ())?)
            }
        }
    }
}

fn shipped(name: &str) -> Result<&'static shipped::ShippedFile, MissionError> {
    shipped::FILES.iter().find(|f| f.path == name).ok_or_else(|| MissionError::Read {
        path: PathBuf::from(name),
        source: std::io::Error::new(std::io::ErrorKind::NotFound, "not among the shipped files"),
    })
}

/// A decision program in whatever encoding its editor saved it, as `cairn rdpl` reads it.
fn read_program(path: &Path, guesses: &mut Vec<String>) -> Result<String, MissionError> {
    let limit = files::Limit::bytes(decision::SOURCE_BYTES_MAX as u64);
    let bytes = files::read(path, "the decision program", limit, &mut |_, _| {})?;
    let read = decision::read_source(&bytes);
    let read_as = match read.encoding {
        decision::Encoding::Utf8 => return Ok(read.text),
        decision::Encoding::Utf16 => "UTF-16",
        decision::Encoding::Latin1 => "Latin-1",
    };
    guesses.push(format!(
        "{}, line {}: this is not UTF-8 and was read as {read_as} ({} such lines); save it as UTF-8",
        path.display(),
        read.first_odd_line,
        read.n_odd_lines
    ));
    Ok(read.text)
}

/// Reads the files that a mission names into it.
pub(super) fn inline(file: &mut MissionFile, shelf: &Shelf<'_>) -> Result<Vec<Read>, Fault> {
    let mut read = Vec::new();
    if let Some(name) = file.world.map.take_if(|map| !is_text(map)) {
        file.world.map = Some(map(&name, shelf)?);
        read.push(("world.map", name));
    }
    let mut take =
        |key: &'static str, what: &str, name: &mut Option<String>, into: &mut Option<String>| {
            if let Some(name) = name.take() {
                let refused = |e| unreadable(&format!("{key}_file"), &name, &e);
                *into = Some(shelf.text(&name, what).map_err(refused)?);
                read.push((key, name));
            }
            Ok(())
        };
    if let Some(pheromones) = &mut file.pheromones {
        take("pheromones.map", "the pheromone map", &mut pheromones.map_file, &mut pheromones.map)?;
    }
    if let Some(decision) = &mut file.decision {
        take(
            "decision.program",
            "the decision program",
            &mut decision.program_file,
            &mut decision.program,
        )?;
    }
    Ok(read)
}

/// Whether `world.map` is the map itself and not the name of its file: it has lines.
fn is_text(map: &str) -> bool {
    map.contains('\n') || map.trim() == "2D-Map"
}

fn unreadable(key: &str, name: &str, error: &MissionError) -> Fault {
    let allowed = format!("a file that can be read ({error})");
    Fault::Named(Box::new(Wrong::new(key, name, allowed)))
}

/// The text of a map, with its picture if it has one.
fn map(name: &str, shelf: &Shelf<'_>) -> Result<String, Fault> {
    const KEY: &str = "world.map";
    let picture = ["pgm", "png", "jpg", "jpeg", "bmp"];
    let extension = Path::new(name).extension().unwrap_or_default().to_ascii_lowercase();
    if picture.iter().any(|known| extension == *known) {
        let allowed =
            "the YAML beside the picture, which says how large a pixel is and where it lies";
        return Err(Fault::Named(Box::new(Wrong::new(KEY, name, allowed))));
    }
    if extension == "gz" {
        let allowed = format!("a file that is not packed: unpack it first (gunzip --keep {name})");
        return Err(Fault::Named(Box::new(Wrong::new(KEY, name, allowed))));
    }
    let text = shelf.text(name, "the map").map_err(|e| unreadable(KEY, name, &e))?;
    if MapFormat::of(&text) != Some(MapFormat::MapServer) {
        // Of one line it would look like a name.
        return Ok(text + "\n");
    }
    let within = |origin: &str, line: usize, found: String, allowed: String| {
        let (origin, key) = (origin.to_owned(), KEY.to_owned());
        Fault::Within(Box::new(SettingError {
            origin,
            position: Some((line, 1)),
            key,
            found,
            allowed,
        }))
    };
    let yaml = MapYaml::parse(&text).map_err(|e| {
        let wrong = super::check::wrong_map(KEY, &e.into());
        within(name, wrong.within.map_or(1, |(line, _)| line), wrong.found, wrong.allowed)
    })?;
    if yaml.picture().is_some() {
        return Ok(text);
    }
    let line = text.lines().position(|line| line.starts_with("image")).map_or(1, |i| i + 1);
    let image = Path::new(name).with_file_name(&yaml.image);
    let image = image.to_string_lossy();
    let allowed = |e: &dyn std::fmt::Display| format!("a picture that can be read ({e})");
    let bytes = shelf
        .picture(&image)
        .map_err(|e| within(name, line, format!("{:?}", yaml.image), allowed(&e)))?;
    let unfit = |e: grid_maps::MapError| {
        let allowed = format!("a whole PGM or PNG picture: {e}");
        within(name, line, format!("{:?}", yaml.image), allowed)
    };
    let picture = read_picture(&bytes).map_err(unfit)?;
    Ok(yaml.with_picture(&picture).map_err(unfit)?.to_text())
}
