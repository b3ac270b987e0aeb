//! The code of a file without what is no code of the program: comments, texts, tests.

/// The text with comments and literals blanked, and without what is compiled for tests only.
pub(super) fn of(text: &str) -> String {
    without_tests(&blanked(text))
}

/// Comments, strings and characters become blanks.
fn blanked(text: &str) -> String {
    let chars: Vec<char> = text.chars().collect();
    let at = |i: usize| chars.get(i).copied().unwrap_or('\0');
    let mut out = String::with_capacity(text.len());
    let mut i = 0;
    while i < chars.len() {
        let end = match at(i) {
            '/' if at(i + 1) == '/' => end_of_line(&chars, i),
            '/' if at(i + 1) == '*' => end_of_block(&chars, i),
            '"' => end_of_text(&chars, i + 1),
            'r' if !is_name(at(i.wrapping_sub(1))) && starts_raw(&chars, i + 1) => {
                end_of_raw(&chars, i + 1)
            }
            // A lifetime has no second quote.
            '\'' if at(i + 1) == '\\' => end_of_character(&chars, i + 2),
            '\'' if at(i + 2) == '\'' => i + 3,
            other => {
                out.push(other);
                i += 1;
                continue;
            }
        };
        out.extend(chars[i..end.min(chars.len())].iter().map(|&c| if c == '\n' { c } else { ' ' }));
        i = end;
    }
    out
}

fn end_of_line(chars: &[char], from: usize) -> usize {
    from + chars[from..].iter().take_while(|&&c| c != '\n').count()
}

fn end_of_block(chars: &[char], from: usize) -> usize {
    let (mut depth, mut i) = (0, from);
    while i < chars.len() {
        match (chars[i], chars.get(i + 1)) {
            ('/', Some('*')) => (depth, i) = (depth + 1, i + 2),
            ('*', Some('/')) => {
                (depth, i) = (depth - 1, i + 2);
                if depth == 0 {
                    return i;
                }
            }
            _ => i += 1,
        }
    }
    i
}

fn end_of_text(chars: &[char], from: usize) -> usize {
    let mut i = from;
    while i < chars.len() {
        match chars[i] {
            '"' => return i + 1,
            '\\' => i += 2,
            _ => i += 1,
        }
    }
    i
}

fn end_of_character(chars: &[char], from: usize) -> usize {
    let rest = chars.iter().skip(from + 1);
    from + 2 + rest.take_while(|&&c| c != '\'').count()
}

fn starts_raw(chars: &[char], from: usize) -> bool {
    let n_hashes = chars[from..].iter().take_while(|&&c| c == '#').count();
    chars.get(from + n_hashes) == Some(&'"')
}

fn end_of_raw(chars: &[char], from: usize) -> usize {
    let n_hashes = chars[from..].iter().take_while(|&&c| c == '#').count();
    let mut i = from + n_hashes + 1;
    while i < chars.len() {
        let n_closing = chars[i + 1..].iter().take_while(|&&c| c == '#').count();
        if chars[i] == '"' && n_closing >= n_hashes {
            return i + 1 + n_hashes;
        }
        i += 1;
    }
    i
}

fn is_name(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// Leaves out each item behind `#[cfg(test)]`.
fn without_tests(code: &str) -> String {
    const MARK: &str = "#[cfg(test)]";
    let mut out = String::with_capacity(code.len());
    let mut rest = code;
    while let Some(at) = rest.find(MARK) {
        out.push_str(&rest[..at]);
        rest = &rest[at + MARK.len()..];
        rest = &rest[end_of_item(rest)..];
    }
    out.push_str(rest);
    out
}

/// Behind the item that comes next: its semicolon or its last brace.
fn end_of_item(code: &str) -> usize {
    let mut depth = 0_usize;
    for (i, c) in code.char_indices() {
        match c {
            ';' if depth == 0 => return i + 1,
            '{' => depth += 1,
            '}' => {
                depth = depth.saturating_sub(1);
                if depth == 0 {
                    return i + 1;
                }
            }
            _ => {}
        }
    }
    code.len()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_texts_and_tests_are_gone_and_lifetimes_stay() {
        let text = "a /* b /* c */ d */ e // f\n\"g\\\"h\" r#\"i\"j\"# 'k' '\\n' &'l str\n#[cfg(test)]\nmod m { n { } }\nq";
        let left: Vec<String> = of(text).split_whitespace().map(str::to_owned).collect();
        assert_eq!(left, ["a", "e", "&'l", "str", "q"]);
    }
}
