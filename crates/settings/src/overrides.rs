//! Single keys set from the command line: `table.key=value`.

/// A `--set` that cannot be applied.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("--set {given}: {problem}")]
pub struct OverrideError {
    /// What was given.
    pub given: String,
    /// What is wrong with it.
    pub problem: String,
}

/// Applies `table.key=value`, with indices for arrays of tables (`robots[0].start=[0,0,0]`; without
/// an index the first is meant).
///
/// The value is read as TOML; what is not TOML is taken as a string, so that quotes may be left
/// out: `robots.line.kind=direct`.
///
/// # Errors
///
/// [`OverrideError`] when there is no equals sign, or the key leads to nothing that holds keys; `root` may
/// then have empty tables more than before.
pub fn apply(root: &mut toml::Table, given: &str) -> Result<(), OverrideError> {
    let wrong = |problem: String| OverrideError { given: given.to_owned(), problem };
    let (key, value) = given
        .split_once('=')
        .ok_or_else(|| wrong("must look like table.key=value, with an equals sign".into()))?;
    let value = parse_value(value.trim());
    let mut parts: Vec<&str> = key.trim().split('.').collect();
    let last = parts.pop().filter(|l| !l.is_empty());
    let last = last.ok_or_else(|| wrong("the key is empty".into()))?;
    let mut table = root;
    for part in parts {
        table = descend(table, part).map_err(wrong)?;
    }
    let (name, index) = split_index(last).map_err(wrong)?;
    match index {
        None => {
            table.insert(name.to_owned(), value);
        }
        Some(index) => {
            let slot = table
                .get_mut(name)
                .and_then(toml::Value::as_array_mut)
                .and_then(|array| array.get_mut(index))
                .ok_or_else(|| wrong(format!("`{name}` has no element {index}")))?;
            *slot = value;
        }
    }
    Ok(())
}

/// The override that set `key`, if one did, as it was given; a missing index means the first.
pub fn setter<'o>(overrides: &'o [String], key: &str) -> Option<&'o str> {
    let plain = |key: &str| key.trim().replace("[0]", "");
    let sets =
        |given: &&String| given.split_once('=').is_some_and(|(set, _)| plain(set) == plain(key));
    overrides.iter().rev().find(sets).map(String::as_str)
}

fn parse_value(text: &str) -> toml::Value {
    let parsed = toml::from_str::<toml::Table>(&format!("v = {text}"));
    parsed
        .ok()
        .and_then(|mut table| table.remove("v"))
        .unwrap_or_else(|| toml::Value::String(text.to_owned()))
}

fn descend<'t>(table: &'t mut toml::Table, part: &str) -> Result<&'t mut toml::Table, String> {
    let (name, index) = split_index(part)?;
    if name.is_empty() {
        return Err("the key has an empty part".into());
    }
    let entry = table.entry(name).or_insert_with(|| toml::Value::Table(toml::Table::new()));
    match entry {
        toml::Value::Table(inner) if index.is_none() => Ok(inner),
        toml::Value::Array(array) => {
            let (n, index) = (array.len(), index.unwrap_or(0));
            array
                .get_mut(index)
                .and_then(toml::Value::as_table_mut)
                .ok_or_else(|| format!("`{name}` has {n} elements, no table at index {index}"))
        }
        _ => Err(format!("`{part}` is not a table")),
    }
}

fn split_index(part: &str) -> Result<(&str, Option<usize>), String> {
    let Some((name, rest)) = part.split_once('[') else { return Ok((part, None)) };
    let index = rest.strip_suffix(']').and_then(|digits| digits.parse().ok());
    index.map(|i| (name, Some(i))).ok_or_else(|| format!("`{part}` has a bad index"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn applied(text: &str, given: &str) -> String {
        let mut root: toml::Table = toml::from_str(text).unwrap();
        match apply(&mut root, given) {
            Ok(()) => toml::to_string(&root).unwrap(),
            Err(error) => error.to_string(),
        }
    }

    #[test]
    fn a_key_is_replaced_or_added() {
        assert_eq!(applied("[a]\nb = 1", "a.b=2.5"), "[a]\nb = 2.5\n");
        assert_eq!(applied("", "a.c.d=[1, 2]"), "[a.c]\nd = [1, 2]\n");
        assert_eq!(
            applied("[[r]]\nk = 1\n[[r]]\nk = 2", "r[1].k=direct"),
            "[[r]]\nk = 1\n\n[[r]]\nk = \"direct\"\n"
        );
        assert_eq!(applied("[[r]]\nk = 1", "r.k=7"), "[[r]]\nk = 7\n");
    }

    #[test]
    fn what_cannot_be_applied_is_explained() {
        let text = "[[r]]\nk = 1";
        assert_eq!(
            applied(text, "r.k"),
            "--set r.k: must look like table.key=value, with an equals sign"
        );
        assert_eq!(
            applied(text, "r[3].k=1"),
            "--set r[3].k=1: `r` has 1 elements, no table at index 3"
        );
        assert_eq!(applied(text, "r.k.z=1"), "--set r.k.z=1: `k` is not a table");
        assert_eq!(applied(text, "=1"), "--set =1: the key is empty");
    }
}
