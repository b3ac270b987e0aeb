//! The small text beside a map's picture: where it lies and what its greys mean.
//!
//! It is YAML, but flat: names with a value each, and one list of three numbers. This reads that
//! much of YAML: comments, quotes, a list in brackets or below with dashes. Anything deeper is
//! refused with its line.
//!
//! Source: documentation of ROS's packages `map_server` and `nav2_map_server`, "Map format".

use std::fmt::Write;

use geometry::Se2;

use crate::MapError;

const FORMAT: &str = "map YAML";
/// Sides of pixels that a map may have, metres: more than the first, at most the second. Finer maps cost minutes before
/// anything is seen of them; coarser ones show no building.
const RESOLUTION_M: (f64, f64) = (1e-4, 10.0);
/// How far from zero the corner of a map may lie, metres, and how often it may be turned round, radians.
const ORIGIN_MAX: f64 = 1e6;

/// How greys become occupancy.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// Free, occupied or unknown, by the thresholds.
    Trinary,
    /// Free and occupied by the thresholds, everything between in proportion.
    Scale,
    /// The grey itself is the occupancy in percent; above 100 it is unknown.
    Raw,
}

/// What the text says.
#[derive(Clone, Debug, PartialEq)]
pub struct MapYaml {
    /// File name of the picture, relative to the text's own folder.
    pub image: String,
    /// Side of a pixel, metres.
    pub resolution_m: f64,
    /// The lower left corner of the lower left pixel, and how the picture is turned about it.
    pub origin: Se2,
    /// How greys become occupancy; trinary where the text does not say.
    pub mode: Mode,
    /// Whether white is occupied; has no effect on [`Mode::Raw`].
    pub negate: bool,
    /// Above it a pixel is occupied; to 1.
    pub occupied_prob: f64,
    /// Below it a pixel is free; from 0, less than `occupied_prob`.
    pub free_prob: f64,
}

impl Mode {
    /// The word for it in the text.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Trinary => "trinary",
            Self::Scale => "scale",
            Self::Raw => "raw",
        }
    }
}

impl MapYaml {
    /// A description with everything usual: trinary, black is occupied, thresholds 0.65 and 0.196.
    ///
    /// The lower threshold is not the 0.25 that newer tools write: the usual grey of unknown, 205,
    /// means 0.19608, and would be read back as free.
    pub fn new(image: &str, resolution_m: f64, origin: Se2) -> Self {
        Self {
            image: image.to_owned(),
            resolution_m,
            origin,
            mode: Mode::Trinary,
            negate: false,
            occupied_prob: 0.65,
            free_prob: 0.196,
        }
    }

    /// The text. Numbers are written so that reading gives the same bits.
    pub fn to_text(&self) -> String {
        let mut text = String::new();
        let Se2 { x_m, y_m, yaw_rad } = self.origin;
        let mut line = |key: &str, value: &dyn std::fmt::Display| {
            // Writing into a string cannot fail.
            let _result = writeln!(text, "{key}: {value}");
        };
        let plain = |c: char| c.is_ascii_alphanumeric() || "._-/".contains(c);
        let is_plain = self.image.starts_with(|c: char| c.is_ascii_alphabetic() || c == '/')
            && self.image.chars().all(plain);
        let image = if is_plain { self.image.clone() } else { quoted(&self.image) };
        line("image", &image);
        line("mode", &self.mode.name());
        line("resolution", &number(self.resolution_m));
        line("origin", &format!("[{}, {}, {}]", number(x_m), number(y_m), number(yaw_rad)));
        line("negate", &u8::from(self.negate));
        line("occupied_thresh", &number(self.occupied_prob));
        line("free_thresh", &number(self.free_prob));
        text
    }

    /// Reads the text.
    ///
    /// `mode` may be absent (then it is trinary); names that are not known are left out, as the
    /// map server does.
    ///
    /// # Errors
    ///
    /// [`MapError::Text`] with the line: a name that is missing or comes twice, a value that does
    /// not fit, and YAML that is deeper than this format needs.
    pub fn parse(text: &str) -> Result<Self, MapError> {
        let entries = Entries::read(text)?;
        let sensible = |value: f64| value > RESOLUTION_M.0 && value <= RESOLUTION_M.1;
        let fraction = |value: f64| (0.0..=1.0).contains(&value);
        let allowed = "metres for a pixel, more than 0.0001 and at most 10";
        let resolution_m = entries.number("resolution", sensible, allowed)?;
        let occupied = "a number from 0 to 1, above free_thresh";
        let free_prob = entries.number("free_thresh", fraction, "a number from 0 to 1")?;
        let above_free = |value| fraction(value) && value > free_prob;
        let occupied_prob = entries.number("occupied_thresh", above_free, occupied)?;
        let image = entries.scalar("image")?;
        if image.text.is_empty() {
            return Err(image.refused("the file name of the picture"));
        }
        Ok(Self {
            image: image.text.clone(),
            resolution_m,
            origin: entries.origin()?,
            mode: entries.mode()?,
            negate: entries.negate()?,
            occupied_prob,
            free_prob,
        })
    }
}

/// The shortest text that reads as the same number, always with a point.
fn number(value: f64) -> String {
    format!("{value:?}")
}

/// A YAML text in double quotes.
fn quoted(text: &str) -> String {
    let mut quoted = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => quoted.extend(['\\', c]),
            '\n' => quoted.push_str("\\n"),
            '\t' => quoted.push_str("\\t"),
            _ => quoted.push(c),
        }
    }
    quoted + "\""
}

/// A value with its line.
#[derive(Clone, Debug)]
struct Value {
    line: usize,
    text: String,
}

/// One name with its values: one, or several of a list.
#[derive(Clone, Debug)]
struct Entry {
    key: String,
    line: usize,
    is_list: bool,
    values: Vec<Value>,
}

struct Entries {
    entries: Vec<Entry>,
    n_lines: usize,
}

fn refused(line: usize, found: impl Into<String>, expected: impl Into<String>) -> MapError {
    MapError::Text { format: FORMAT, line, found: found.into(), expected: expected.into() }
}

impl Value {
    fn refused(&self, expected: &str) -> MapError {
        refused(self.line, format!("`{}`", self.text), expected)
    }

    fn number(&self, expected: &str) -> Result<f64, MapError> {
        let value: f64 = self
            .text
            .parse()
            .ok()
            .filter(|v: &f64| v.is_finite())
            .ok_or_else(|| self.refused(expected))?;
        Ok(value)
    }
}

impl Entries {
    fn read(text: &str) -> Result<Self, MapError> {
        let mut entries: Vec<Entry> = Vec::new();
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let mut n_lines = 0;
        for (line, whole) in (1..).zip(text.lines()) {
            n_lines = line;
            let content = without_comment(whole).trim_end();
            let bare = content.trim_start();
            if bare.is_empty() || bare == "---" || bare == "..." || bare.starts_with('%') {
                continue;
            }
            if let Some(item) = list_item(bare) {
                let owner = entries.last_mut().filter(|e| e.is_list || e.values.is_empty());
                let Some(owner) = owner else {
                    return Err(refused(line, format!("`{bare}`"), "`name: value`"));
                };
                owner.is_list = true;
                owner.values.push(Value { line, text: unquoted(item, line)? });
                continue;
            }
            if content.len() != bare.len() {
                let expected = "`name: value` at the beginning of the line: nothing is nested";
                return Err(refused(line, format!("`{bare}`, indented"), expected));
            }
            let entry = Entry::read(bare, line)?;
            if let Some(first) = entries.iter().find(|e| e.key == entry.key) {
                let found = format!("`{}` again", entry.key);
                return Err(refused(
                    line,
                    found,
                    format!("it once; it is on line {} too", first.line),
                ));
            }
            entries.push(entry);
        }
        Ok(Self { entries, n_lines })
    }

    fn find(&self, key: &str) -> Option<&Entry> {
        self.entries.iter().find(|entry| entry.key == key)
    }

    fn required(&self, key: &str) -> Result<&Entry, MapError> {
        let missing = || refused(self.n_lines, format!("no `{key}`"), format!("a line `{key}: …`"));
        self.find(key).ok_or_else(missing)
    }

    fn scalar(&self, key: &str) -> Result<&Value, MapError> {
        let entry = self.required(key)?;
        match (&entry.values[..], entry.is_list) {
            ([value], false) => Ok(value),
            _ => Err(refused(
                entry.line,
                format!("no single value for `{key}`"),
                format!("`{key}: value`"),
            )),
        }
    }

    fn number(
        &self,
        key: &str,
        fits: impl Fn(f64) -> bool,
        expected: &str,
    ) -> Result<f64, MapError> {
        let value = self.scalar(key)?;
        let number = value.number(expected)?;
        if fits(number) { Ok(number) } else { Err(value.refused(expected)) }
    }

    fn origin(&self) -> Result<Se2, MapError> {
        let entry = self.required("origin")?;
        let expected = "`origin: [x, y, yaw]`, metres and radians, each within ±1000000";
        if let ([x, y, yaw], true) = (&entry.values[..], entry.is_list) {
            let near = |value: &Value| match value.number(expected)? {
                number if number.abs() <= ORIGIN_MAX => Ok(number),
                _ => Err(value.refused(expected)),
            };
            return Ok(Se2::new(near(x)?, near(y)?, near(yaw)?));
        }
        let n = entry.values.len();
        let found = if entry.is_list { format!("a list of {n}") } else { "no list".to_owned() };
        Err(refused(entry.line, found, expected))
    }

    fn mode(&self) -> Result<Mode, MapError> {
        if self.find("mode").is_none() {
            return Ok(Mode::Trinary);
        }
        let value = self.scalar("mode")?;
        let modes = [Mode::Trinary, Mode::Scale, Mode::Raw];
        let named = modes.into_iter().find(|mode| mode.name() == value.text);
        named.ok_or_else(|| value.refused("trinary, scale or raw"))
    }

    fn negate(&self) -> Result<bool, MapError> {
        let value = self.scalar("negate")?;
        match value.text.as_str() {
            "0" | "false" | "False" | "FALSE" | "no" => Ok(false),
            "1" | "true" | "True" | "TRUE" | "yes" => Ok(true),
            _ => Err(value.refused("0 or 1")),
        }
    }
}

impl Entry {
    fn read(bare: &str, line: usize) -> Result<Self, MapError> {
        let split = bare.split_once(": ").or_else(|| Some((bare.strip_suffix(':')?, "")));
        let Some((key, value)) = split else {
            return Err(refused(line, format!("`{bare}`"), "`name: value`"));
        };
        let (key, value) = (unquoted(key.trim(), line)?, value.trim());
        let mut entry = Self { key, line, is_list: false, values: Vec::new() };
        if let Some(inside) = value.strip_prefix('[') {
            let Some(inside) = inside.strip_suffix(']') else {
                return Err(refused(
                    line,
                    format!("`{value}`"),
                    "the list to end with `]` on its line",
                ));
            };
            entry.is_list = true;
            for item in inside.split(',').filter(|item| !item.trim().is_empty()) {
                entry.values.push(Value { line, text: unquoted(item.trim(), line)? });
            }
        } else if !value.is_empty() {
            entry.values.push(Value { line, text: unquoted(value, line)? });
        }
        Ok(entry)
    }
}

/// What follows a dash.
fn list_item(bare: &str) -> Option<&str> {
    bare.strip_prefix("- ").map(str::trim)
}

/// The line up to a `#` that begins a comment: at the start or after a blank, outside quotes.
fn without_comment(line: &str) -> &str {
    let mut quote = None;
    let mut before = ' ';
    let mut escaped = false;
    for (i, c) in line.char_indices() {
        match quote {
            Some('"') if escaped => escaped = false,
            Some('"') if c == '\\' => escaped = true,
            Some(q) if c == q => quote = None,
            None if c == '#' && before.is_whitespace() => return &line[..i],
            None if (c == '"' || c == '\'') && " ,[".contains(before) => quote = Some(c),
            _ => {}
        }
        before = c;
    }
    line
}

/// A value without its quotes.
fn unquoted(value: &str, line: usize) -> Result<String, MapError> {
    let Some(quote) = value.chars().next().filter(|c| "\"'".contains(*c)) else {
        return Ok(value.to_owned());
    };
    let inside = value[1..].strip_suffix(quote).filter(|_| value.len() > 1);
    let Some(inside) = inside else {
        return Err(refused(line, format!("`{value}`"), format!("{quote} at the end too")));
    };
    if quote == '\'' {
        return Ok(inside.replace("''", "'"));
    }
    let mut text = String::new();
    let mut chars = inside.chars();
    while let Some(c) = chars.next() {
        if c != '\\' {
            text.push(c);
            continue;
        }
        // A slash at the end has nothing to stand before, and stands for itself.
        match chars.next().unwrap_or('\\') {
            'n' => text.push('\n'),
            't' => text.push('\t'),
            other if "\\\"/".contains(other) => text.push(other),
            other => {
                return Err(refused(line, format!("`\\{other}`"), "one of \\\\, \\\", \\n, \\t"));
            }
        }
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;
    use expect_test::expect;
    use proptest::prelude::*;

    const USUAL: &str = "\
image: testmap.png
resolution: 0.1
origin: [0.0, 0.0, 0.0]
occupied_thresh: 0.65
free_thresh: 0.196
negate: 0
";

    #[test]
    fn the_example_of_the_documentation_is_read() {
        let usual = MapYaml::new("testmap.png", 0.1, Se2::IDENTITY);
        assert_eq!(MapYaml::parse(USUAL).unwrap(), usual);
        assert_eq!(MapYaml::parse(&USUAL.replace('\n', "\r\n")).unwrap(), usual);
    }

    #[test]
    fn other_ways_to_write_the_same_are_read() {
        let text = "\
---
# saved by hand
free_thresh: 25e-2   # of 1
occupied_thresh: .7
\"mode\": 'scale'
negate: true
image: \"a \\\"b\\\" #1.pgm\"
origin:
- -10
  - +2.5
- 1.5
resolution: 5e-2
cost_translation_table:
...
";
        let read = MapYaml::parse(text).unwrap();
        let expected = MapYaml {
            image: "a \"b\" #1.pgm".to_owned(),
            resolution_m: 0.05,
            origin: Se2::new(-10.0, 2.5, 1.5),
            mode: Mode::Scale,
            negate: true,
            occupied_prob: 0.7,
            free_prob: 0.25,
        };
        assert_eq!(read, expected);
    }

    #[test]
    fn what_does_not_fit_is_refused_with_its_line() {
        let cases = [
            ("0.1", "0"),
            ("0.1", ".nan"),
            ("0.1", "inf"),
            ("0.1", "-0.05"),
            ("0.1", "1e-4"),
            ("0.1", "10.1"),
            ("[0.0, 0.0, 0.0]", "[.nan, 0, 0]"),
            ("[0.0, 0.0, 0.0]", "[0, -inf, 0]"),
            ("[0.0, 0.0, 0.0]", "[0, 1e7, 0]"),
            ("[0.0, 0.0, 0.0]", "[0, 0, 1e300]"),
            ("resolution: 0.1\n", ""),
            ("0.0]", "0.0"),
            (", 0.0]", "]"),
            ("[0.0, 0.0, 0.0]", "5"),
            ("0.65", "0.1"),
            ("0.196", "-0.1"),
            ("negate: 0", "negate: 2"),
            ("negate: 0", "negate:"),
            ("negate: 0", "negate: 0\nmode: Scale"),
            ("negate: 0", "negate: 0\nnegate: 1"),
            ("negate: 0", " negate: 0"),
            ("negate: 0", "negate 0"),
            ("negate: 0", "negate: 0\n- 4"),
            ("testmap.png", "\"a"),
            ("testmap.png", "\"a\\x\""),
            ("testmap.png", "''"),
        ];
        let messages = cases.map(|(from, to)| {
            assert!(USUAL.contains(from));
            MapYaml::parse(&USUAL.replace(from, to)).unwrap_err().to_string()
        });
        expect![[r##"
            map YAML, line 2: found `0`, expected metres for a pixel, more than 0.0001 and at most 10
            map YAML, line 2: found `.nan`, expected metres for a pixel, more than 0.0001 and at most 10
            map YAML, line 2: found `inf`, expected metres for a pixel, more than 0.0001 and at most 10
            map YAML, line 2: found `-0.05`, expected metres for a pixel, more than 0.0001 and at most 10
            map YAML, line 2: found `1e-4`, expected metres for a pixel, more than 0.0001 and at most 10
            map YAML, line 2: found `10.1`, expected metres for a pixel, more than 0.0001 and at most 10
            map YAML, line 3: found `.nan`, expected `origin: [x, y, yaw]`, metres and radians, each within ±1000000
            map YAML, line 3: found `-inf`, expected `origin: [x, y, yaw]`, metres and radians, each within ±1000000
            map YAML, line 3: found `1e7`, expected `origin: [x, y, yaw]`, metres and radians, each within ±1000000
            map YAML, line 3: found `1e300`, expected `origin: [x, y, yaw]`, metres and radians, each within ±1000000
            map YAML, line 5: found no `resolution`, expected a line `resolution: …`
            map YAML, line 3: found `[0.0, 0.0, 0.0`, expected the list to end with `]` on its line
            map YAML, line 3: found a list of 2, expected `origin: [x, y, yaw]`, metres and radians, each within ±1000000
            map YAML, line 3: found no list, expected `origin: [x, y, yaw]`, metres and radians, each within ±1000000
            map YAML, line 4: found `0.1`, expected a number from 0 to 1, above free_thresh
            map YAML, line 5: found `-0.1`, expected a number from 0 to 1
            map YAML, line 6: found `2`, expected 0 or 1
            map YAML, line 6: found no single value for `negate`, expected `negate: value`
            map YAML, line 7: found `Scale`, expected trinary, scale or raw
            map YAML, line 7: found `negate` again, expected it once; it is on line 6 too
            map YAML, line 6: found `negate: 0`, indented, expected `name: value` at the beginning of the line: nothing is nested
            map YAML, line 6: found `negate 0`, expected `name: value`
            map YAML, line 7: found `- 4`, expected `name: value`
            map YAML, line 1: found `"a`, expected " at the end too
            map YAML, line 1: found `\x`, expected one of \\, \", \n, \t
            map YAML, line 1: found ``, expected the file name of the picture
        "##]]
        .assert_eq(&(messages.join("\n") + "\n"));
    }

    #[test]
    fn the_text_is_what_people_know() {
        let mut yaml = MapYaml::new("office.pgm", 0.05, Se2::new(-12.5, 3.0, 0.0));
        expect![[r#"
            image: office.pgm
            mode: trinary
            resolution: 0.05
            origin: [-12.5, 3.0, 0.0]
            negate: 0
            occupied_thresh: 0.65
            free_thresh: 0.196
        "#]]
        .assert_eq(&yaml.to_text());
        yaml.image = "two words: \"#1\"\\.pgm".to_owned();
        assert_eq!(MapYaml::parse(&yaml.to_text()).unwrap(), yaml);
    }

    proptest! {
        #[test]
        fn what_is_written_is_read_to_the_last_bit(
            image in "[ -~]{1,12}",
            resolution_m in 1.01e-4..10.0_f64,
            origin in (any::<i32>(), -1e6..1e6_f64, -3.0..3.0_f64),
            mode in prop_oneof![Just(Mode::Trinary), Just(Mode::Scale), Just(Mode::Raw)],
            negate: bool,
            (free_prob, occupied_prob) in (0.0..0.5_f64, 0.5..=1.0_f64),
        ) {
            let origin = Se2::new(f64::from(origin.0) / 7e3, origin.1, origin.2);
            let yaml = MapYaml { image, resolution_m, origin, mode, negate, occupied_prob, free_prob };
            prop_assert_eq!(MapYaml::parse(&yaml.to_text()).unwrap(), yaml);
        }

        #[test]
        fn no_text_makes_it_panic(text in "(image|origin|mode|negate|:|-| |\\[|\\]|\"|'|#|\\\\|,|\n|é|0|\\.){0,40}") {
            let _result = MapYaml::parse(&text);
            let _result = MapYaml::parse(&format!("{USUAL}{text}"));
        }
    }
}
