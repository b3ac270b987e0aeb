//! What somebody probably meant who wrote a name that does not exist.

/// The candidate most like `word`, if one is like enough: a slip of the finger, two letters exchanged, another separator,
/// another case. Ties go to the first. Cost: length of the word times length of all candidates.
///
/// ```
/// let modes = ["memory", "direct", "tcp", "serial"];
/// assert_eq!(settings::did_you_mean("memroy", modes), Some("memory"));
/// assert_eq!(settings::did_you_mean("carrier pigeon", modes), None);
/// ```
pub fn did_you_mean<'c>(
    word: &str,
    candidates: impl IntoIterator<Item = &'c str>,
) -> Option<&'c str> {
    let plain = |text: &str| text.to_lowercase().replace(['-', ' '], "_");
    let word = plain(word.get(..80).unwrap_or(word));
    let mut best: Option<(f64, &str)> = None;
    for candidate in candidates {
        let likeness = strsim::jaro_winkler(&word, &plain(candidate));
        if likeness > best.map_or(0.84, |(most, _)| most) {
            best = Some((likeness, candidate));
        }
    }
    best.map(|(_, candidate)| candidate)
}

/// A reader's message about an unknown key, with a suggestion instead of a list of everything that exists.
///
/// The list stays when nothing in it is like what was written. Other messages come back as they are.
pub fn clarified(message: &str) -> String {
    for what in ["field", "variant"] {
        let Some((before, rest)) = message.split_once(&format!("unknown {what} `")) else {
            continue;
        };
        let Some((word, rest)) = rest.split_once('`') else { continue };
        let (list, after) = rest.split_once('\n').map_or((rest, None), |(l, a)| (l, Some(a)));
        let candidates = list.split('`').skip(1).step_by(2);
        let Some(meant) = did_you_mean(word, candidates) else { continue };
        let after = after.map(|text| format!("\n{text}")).unwrap_or_default();
        return format!("{before}unknown {what} `{word}`: did you mean `{meant}`?{after}");
    }
    message.to_owned()
}

/// The key of `template`, a file with every key, that somebody probably meant who wrote the unknown key `written`
/// (`table.key`): one of the same last name elsewhere, or one below the same table whose last name is like it.
///
/// ```
/// let template = "[mission]\nseed = 1\n[[robots]]\n[robots.mind.follow]\nspeed_mps = 0.3\n";
/// assert_eq!(settings::meant_key("seed", template).as_deref(), Some("mission.seed"));
/// assert_eq!(settings::meant_key("robots.speed", template).as_deref(), Some("robots.mind.follow.speed_mps"));
/// assert_eq!(settings::meant_key("robots.colour", template), None);
/// ```
pub fn meant_key(written: &str, template: &str) -> Option<String> {
    let table: toml::Table = toml::from_str(template).ok()?;
    let mut keys = Vec::new();
    collect(&table, "", &mut keys);
    let plain: Vec<&str> =
        written.split('.').map(|part| part.split('[').next().unwrap_or(part)).collect();
    let (&last, before) = plain.split_last()?;
    let name = |key: &str| key.rsplit('.').next().unwrap_or(key).to_owned();
    let n_shared = |key: &str| key.split('.').zip(before).take_while(|(a, b)| a == *b).count();
    let mut same: Vec<&String> = keys.iter().filter(|key| name(key) == last).collect();
    same.sort_by_key(|key| std::cmp::Reverse(n_shared(key)));
    if let Some(&key) = same.first() {
        return (*key != plain.join(".")).then(|| key.clone());
    }
    let near: Vec<&String> =
        keys.iter().filter(|key| before.is_empty() || n_shared(key) > 0).collect();
    let names: Vec<String> = near.iter().map(|key| name(key)).collect();
    let meant = did_you_mean(last, names.iter().map(String::as_str))?;
    let at = names.iter().position(|name| name == meant)?;
    near.get(at).map(|key| (*key).clone())
}

/// The keys of a table and of all that is in it, with dots; of an array of tables those of its first.
fn collect(table: &toml::Table, before: &str, keys: &mut Vec<String>) {
    for (name, value) in table {
        let key = if before.is_empty() { name.clone() } else { format!("{before}.{name}") };
        let inner = match value {
            toml::Value::Table(inner) => Some(inner),
            toml::Value::Array(array) => array.first().and_then(toml::Value::as_table),
            _ => None,
        };
        match inner {
            Some(inner) => collect(inner, &key, keys),
            None => keys.push(key),
        }
    }
}

/// Letters of a line that a message shows at most.
const SHOWN_LETTERS: usize = 160;

/// What a TOML reader found wrong with `text`, for the person who wrote it: line ends that TOML does not know are named
/// as such, a name that nearly exists is offered, and a long line is shown up to its 160th letter.
pub fn told(error: &toml::de::Error, text: &str) -> String {
    if let Some(line) = lone_return(text) {
        return format!(
            "line {line} ends with a carriage return alone (CR), as old Macintosh editors wrote it; TOML's lines end \
             with LF or CR LF: save it so"
        );
    }
    let said = clarified(error.to_string().trim_end());
    said.lines().map(shortened).collect::<Vec<String>>().join("\n")
}

/// The first line, from 1, that ends with a carriage return and no line feed behind it.
fn lone_return(text: &str) -> Option<usize> {
    let mut letters = text.bytes().peekable();
    let mut line = 1;
    while let Some(letter) = letters.next() {
        match letter {
            b'\r' if letters.peek() != Some(&b'\n') => return Some(line),
            b'\n' => line += 1,
            _ => {}
        }
    }
    None
}

/// A line of a message, of at most [`SHOWN_LETTERS`].
fn shortened(line: &str) -> String {
    match line.char_indices().nth(SHOWN_LETTERS) {
        Some((end, _)) => format!("{} …", &line[..end]),
        None => line.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reader_s_message_fits_on_a_screen_and_names_foreign_line_ends() {
        let told =
            |text: &str| super::told(&toml::from_str::<toml::Table>(text).unwrap_err(), text);
        let said = told("a = 1\r\nb = 2\rc = 3\r");
        assert!(said.contains("line 2") && said.contains("CR LF"), "{said}");
        let said = told(&format!("a = [{}\n", "é, ".repeat(50_000)));
        assert!(said.lines().all(|line| line.chars().count() <= SHOWN_LETTERS + 2), "{said}");
        assert!(said.contains("line 1, column"), "{said}");
        let said = told("a = 1\nb = = 2\n");
        assert!(said.contains("b = = 2") && said.contains("line 2"), "{said}");
    }

    #[test]
    fn slips_are_understood_and_other_words_are_not() {
        let keys =
            ["speed_mps", "path_controller", "trail_controller", "route", "acceleration_mps2"];
        for (written, meant) in [
            ("sped_mps", Some("speed_mps")),
            ("speed", Some("speed_mps")),
            ("trail-controller", Some("trail_controller")),
            ("ROUTE", Some("route")),
            ("acceleration", Some("acceleration_mps2")),
            ("colour", None),
            ("", None),
        ] {
            assert_eq!(did_you_mean(written, keys), meant, "{written}");
        }
        assert_eq!(did_you_mean("x", []), None);
    }

    #[test]
    fn a_list_of_keys_becomes_a_suggestion_where_one_fits() {
        let said = "TOML parse error at line 3, column 1\n3 | fo = 1\nunknown field `sed`, expected one of `name`, `seed`\n";
        assert!(
            clarified(said).ends_with("unknown field `sed`: did you mean `seed`?\n"),
            "{}",
            clarified(said)
        );
        let said = "unknown field `zz`, expected one of `name`, `seed`";
        assert_eq!(clarified(said), said);
        assert_eq!(clarified("no such thing"), "no such thing");
    }
}
