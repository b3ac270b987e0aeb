//! A crate may depend on crates of lower layers only.
//!
//! The layers are in the root manifest, as `[workspace.metadata.layers]`. Dependencies for tests
//! are exempt: anything may use the test kit.

use std::collections::BTreeMap;

use toml::{Table, Value};

use crate::repository::Repository;

pub(super) fn findings(repository: &Repository) -> Vec<String> {
    let root = match toml::from_str::<Table>(repository.text("Cargo.toml")) {
        Ok(root) => root,
        Err(error) => return vec![format!("Cargo.toml: {error}")],
    };
    let mut found = Vec::new();
    let levels = levels(&root, &mut found);
    let mut members = Vec::new();
    for (path, text) in &repository.files {
        let parts: Vec<&str> = path.split('/').collect();
        if let ["crates", member, "Cargo.toml"] = parts[..] {
            members.push(member);
            match toml::from_str::<Table>(text) {
                Ok(manifest) => found.extend(upward(member, &manifest, &levels)),
                Err(error) => found.push(format!("{path}: {error}")),
            }
        }
    }
    let absent = levels.keys().filter(|name| !members.contains(name));
    found.extend(absent.map(|name| format!("{name} is in a layer, but there is no crates/{name}")));
    found
}

/// The level of each crate that a layer names.
fn levels<'a>(root: &'a Table, found: &mut Vec<String>) -> BTreeMap<&'a str, i64> {
    let layers = root.get("workspace").and_then(|w| w.get("metadata")?.get("layers")?.as_table());
    let mut levels = BTreeMap::new();
    for (layer, content) in layers.into_iter().flatten() {
        let Some(level) = content.get("level").and_then(Value::as_integer) else {
            found.push(format!("layer {layer} has no level"));
            continue;
        };
        let names = content.get("crates").and_then(Value::as_array).into_iter().flatten();
        for name in names.filter_map(Value::as_str) {
            if levels.insert(name, level).is_some() {
                found.push(format!("{name} is in two layers"));
            }
        }
    }
    levels
}

fn upward(member: &str, manifest: &Table, levels: &BTreeMap<&str, i64>) -> Vec<String> {
    let Some(level) = levels.get(member) else { return vec![format!("{member} is in no layer")] };
    let dependencies = manifest.get("dependencies").and_then(Value::as_table);
    let needs = dependencies.into_iter().flatten().filter_map(|(needed, _)| {
        let needed_level = levels.get(needed.as_str())?;
        (needed_level >= level)
            .then(|| format!("{member} (level {level}) needs {needed} (level {needed_level})"))
    });
    needs.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use expect_test::expect;

    #[test]
    fn upward_sideways_missing_and_stray_crates_are_reported() {
        let root = "
            [workspace.metadata.layers]
            ground = { level = 0, crates = ['stones'] }
            middle = { level = 2, crates = ['walls', 'doors'] }
            top = { level = 4, crates = ['roof', 'chimney'] }
            lost = { crates = ['cellar'] }";
        let repository = Repository::of(&[
            ("Cargo.toml", root),
            ("crates/stones/Cargo.toml", "dependencies.doors.path = '../doors'"),
            ("crates/walls/Cargo.toml", "dependencies.stones.path = '../stones'"),
            ("crates/doors/Cargo.toml", "[dependencies]\nwalls.workspace = true"),
            ("crates/roof/Cargo.toml", "dev-dependencies.roof.path = '.'"),
            ("crates/stray/Cargo.toml", ""),
        ]);
        expect![[r#"
            layer lost has no level
            doors (level 2) needs walls (level 2)
            stones (level 0) needs doors (level 2)
            stray is in no layer
            chimney is in a layer, but there is no crates/chimney"#]]
        .assert_eq(&findings(&repository).join("\n"));
    }
}
