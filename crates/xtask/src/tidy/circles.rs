//! Files of a crate do not import each other in a circle: whoever opens one need not open all the others.
//!
//! An import is a path in the code, tests left out, that leads to a name of another file: by `use` or where it stands,
//! through re-exports to the file that defines the name. A module that only declares another imports nothing of it.

mod code;
mod paths;

use std::collections::{BTreeMap, BTreeSet};

use crate::repository::Repository;
use paths::Path;

/// A module by the names on the way to it from the crate's root.
type Module = Vec<String>;
/// What each file takes from each other one.
type Imports = BTreeMap<Module, BTreeMap<Module, BTreeSet<String>>>;

/// Re-exports that are followed until the file that defines a name.
const N_DOORS_MAX: usize = 8;

/// Crates with circles that are there still, and how many of their files are in one. They may only become fewer:
/// whoever opens one lowers the number.
const N_FILES_IN_CIRCLES: &[(&str, usize)] = &[];

pub(super) fn findings(repository: &Repository) -> Vec<String> {
    let mut crates: BTreeMap<&str, House<'_>> = BTreeMap::new();
    for (path, text) in repository.rust_files("crates/") {
        let Some((name, file)) =
            path.strip_prefix("crates/").and_then(|rest| rest.split_once("/src/"))
        else {
            continue;
        };
        if let Some(module) = module_of(file) {
            crates.entry(name).or_default().add(module, path, text);
        }
    }
    let mut found = Vec::new();
    for (&name, house) in &crates {
        let circles = house.circles();
        let n_files: usize = circles.iter().map(|circle| circle.n_files).sum();
        let listed = N_FILES_IN_CIRCLES.iter().find(|(listed, _)| *listed == name);
        let n_allowed = listed.map_or(0, |(_, n)| *n);
        if n_files > n_allowed {
            found.extend(circles.into_iter().map(|circle| circle.text));
        }
        if n_files != n_allowed {
            found.push(format!(
                "{name}: {n_files} files are in circles, and {n_allowed} are listed"
            ));
        }
    }
    found
}

/// Files of which each leads to each.
#[derive(Debug)]
struct Circle {
    n_files: usize,
    text: String,
}

/// The module in a file below `src`; `None` for tests.
fn module_of(file: &str) -> Option<Module> {
    let stem = file.strip_suffix(".rs")?;
    let mut names: Module = stem.split('/').map(str::to_owned).collect();
    if names.iter().any(|name| name == "tests" || name.ends_with("_tests")) {
        return None;
    }
    if names.last().is_some_and(|last| last == "mod") || matches!(stem, "lib" | "main") {
        names.pop();
    }
    Some(names)
}

/// The modules of a crate.
#[derive(Debug, Default)]
struct House<'a> {
    rooms: BTreeMap<Module, Room<'a>>,
}

/// One file: its paths, and the names that it has from elsewhere.
#[derive(Debug)]
struct Room<'a> {
    file: &'a str,
    paths: Vec<Path>,
    imported: BTreeMap<String, Path>,
}

impl<'a> House<'a> {
    fn add(&mut self, module: Module, file: &'a str, text: &str) {
        let paths = paths::of(&code::of(text));
        let named = |path: &Path| Some((path.alias.clone()?, path.clone()));
        let imported = paths.iter().filter_map(named).collect();
        self.rooms.insert(module, Room { file, paths, imported });
    }

    /// The module that `path`, said in `module`, begins at, and what follows.
    fn begin<'p>(&self, module: &Module, path: &'p [String]) -> Option<(Module, &'p [String])> {
        let (head, mut rest) = path.split_first()?;
        let mut at = match head.as_str() {
            "crate" => Module::new(),
            "self" => module.clone(),
            "super" => parent(module)?,
            child => {
                let at = inside(module, child);
                return self.rooms.contains_key(&at).then_some((at, rest));
            }
        };
        while let Some((name, behind)) = rest.split_first().filter(|(name, _)| *name == "super") {
            let _ = name;
            (at, rest) = (parent(&at)?, behind);
        }
        Some((at, rest))
    }

    /// The module that defines what `path`, said in `module`, names; and that name.
    fn definition(
        &self,
        module: &Module,
        path: &[String],
        n_doors: usize,
    ) -> Option<(Module, String)> {
        let (mut at, mut rest) = self.begin(module, path)?;
        while let Some((name, behind)) = rest.split_first() {
            let next = inside(&at, name);
            if !self.rooms.contains_key(&next) {
                break;
            }
            (at, rest) = (next, behind);
        }
        let Some(name) = rest.first() else {
            let name = at.last().cloned().unwrap_or_default();
            return Some((at, name));
        };
        let elsewhere = self.rooms.get(&at).and_then(|room| room.imported.get(name));
        match elsewhere.filter(|_| n_doors > 0) {
            // A name of another crate is nobody's here.
            Some(path) => self.definition(&at, &path.names, n_doors - 1),
            None => Some((at, name.clone())),
        }
    }

    fn imports(&self) -> Imports {
        let mut imports = Imports::new();
        for (module, room) in &self.rooms {
            for path in &room.paths {
                let Some((from, name)) = self.definition(module, &path.names, N_DOORS_MAX) else {
                    continue;
                };
                // What is only handed on is not used here.
                if from != *module && !path.is_handed_on {
                    let of = imports.entry(module.clone()).or_default();
                    of.entry(from).or_default().insert(name);
                }
            }
        }
        imports
    }

    /// A line for each set of files of which each leads to each.
    fn circles(&self) -> Vec<Circle> {
        let imports = self.imports();
        let reach: BTreeMap<&Module, BTreeSet<&Module>> =
            self.rooms.keys().map(|module| (module, reached(&imports, module))).collect();
        let mut told: BTreeSet<&Module> = BTreeSet::new();
        let mut found = Vec::new();
        for (module, reached) in &reach {
            let circle: Vec<&Module> = reached
                .iter()
                .copied()
                .filter(|other| reach.get(other).is_some_and(|back| back.contains(module)))
                .collect();
            if circle.len() > 1 && !told.contains(module) {
                told.extend(&circle);
                let text = self.told(&circle, &imports);
                found.push(Circle { n_files: circle.len(), text });
            }
        }
        found
    }

    fn told(&self, circle: &[&Module], imports: &Imports) -> String {
        let file = |module: &Module| self.rooms.get(module).map_or("", |room| room.file);
        let short = |module: &Module| file(module).rsplit("/src/").next().unwrap_or_default();
        let mut arrows = Vec::new();
        for &module in circle {
            for (from, names) in imports.get(module).into_iter().flatten() {
                if circle.contains(&from) {
                    let names: Vec<&str> = names.iter().map(String::as_str).collect();
                    arrows.push(format!(
                        "{} takes {} from {}",
                        short(module),
                        names.join(", "),
                        short(from)
                    ));
                }
            }
        }
        let first = circle.first().map_or("", |module| file(module));
        format!("{first} is in a circle of {} files: {}", circle.len(), arrows.join("; "))
    }
}

fn parent(module: &Module) -> Option<Module> {
    module.split_last().map(|(_, above)| above.to_vec())
}

fn inside(module: &Module, child: &str) -> Module {
    module.iter().cloned().chain([child.to_owned()]).collect()
}

/// Every module that one leads to; itself only on the way round a circle.
fn reached<'a>(imports: &'a Imports, module: &Module) -> BTreeSet<&'a Module> {
    let mut found = BTreeSet::new();
    let mut open: Vec<&Module> = imports.get(module).into_iter().flat_map(BTreeMap::keys).collect();
    while let Some(next) = open.pop() {
        if found.insert(next) {
            open.extend(imports.get(next).into_iter().flat_map(BTreeMap::keys));
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use expect_test::expect;

    fn found(files: &[(&str, &str)]) -> String {
        findings(&Repository::of(files)).join("\n")
    }

    #[test]
    fn circles_of_two_and_of_three_are_reported_once() {
        expect!["crates/a/src/one.rs is in a circle of 3 files: one.rs takes B, two from two.rs; three.rs takes A from one.rs; two.rs takes C from three.rs\na: 3 files are in circles, and 0 are listed\ncrates/b/src/lib.rs is in a circle of 2 files: lib.rs takes go from part.rs; part.rs takes Whole from lib.rs\nb: 2 files are in circles, and 0 are listed"]
        .assert_eq(&found(&[
            ("crates/a/src/lib.rs", "mod one; mod two; mod three;\npub use one::A;"),
            ("crates/a/src/one.rs", "use crate::two::{B, self};\npub struct A;"),
            ("crates/a/src/two.rs", "use super::three::C as D;\npub struct B;"),
            // Through the crate's face, to the file that defines it.
            ("crates/a/src/three.rs", "use crate::A;\npub struct C;"),
            ("crates/b/src/lib.rs", "mod part;\npub struct Whole;\nfn f() { part::go() }"),
            ("crates/b/src/part.rs", "pub fn go() { super::Whole; }"),
        ]));
    }

    #[test]
    fn what_is_downhill_in_a_test_or_in_words_is_no_circle() {
        assert_eq!(
            found(&[
                ("crates/a/src/lib.rs", "mod one; mod two;\npub use two::B;\npub use one::A;"),
                ("crates/a/src/one.rs", "use crate::B;\npub struct A;"),
                (
                    "crates/a/src/two.rs",
                    "// use crate::A;\npub struct B(&'static str);\nconst T: &str = \"crate::A\";\n\
                     #[cfg(test)]\nmod tests { use crate::A; fn f() { crate::one::A } }"
                ),
                ("crates/a/src/two_tests.rs", "use super::*; use crate::A;"),
            ]),
            ""
        );
    }
}
