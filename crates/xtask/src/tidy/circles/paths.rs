//! The paths in a piece of code: those of `use`, spread out, and those that stand in the code.

/// A path, name by name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Path {
    pub(super) names: Vec<String>,
    /// The name that it has here, if it is one of `use`.
    pub(super) alias: Option<String>,
    /// It is one of `pub use`: handed on to others.
    pub(super) is_handed_on: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Token<'a> {
    Name(&'a str),
    Sign(char),
    /// `::`
    Colons,
}

/// All paths of at least two names, and every name that `use` brings.
pub(super) fn of(code: &str) -> Vec<Path> {
    let tokens = tokens(code);
    let mut found = Vec::new();
    let mut i = 0;
    let mut is_public = false;
    while let Some(&token) = tokens.get(i) {
        match token {
            Token::Name("use") => {
                let mut reader = Reader { tokens: &tokens, at: i + 1, found: &mut found };
                reader.tree(&[], Some(is_public));
                i = reader.at;
            }
            Token::Name(_) if tokens.get(i + 1) == Some(&Token::Colons) => {
                let mut reader = Reader { tokens: &tokens, at: i, found: &mut found };
                reader.tree(&[], None);
                i = reader.at.max(i + 1);
            }
            _ => i += 1,
        }
        // `pub use`, `pub(crate) use`, `pub(in path) use`.
        is_public = match token {
            Token::Name("pub") => true,
            Token::Name("crate" | "super" | "in" | "self") | Token::Sign('(' | ')') => is_public,
            _ => false,
        };
    }
    found
}

fn tokens(code: &str) -> Vec<Token<'_>> {
    let mut found = Vec::new();
    let mut rest = code;
    while let Some(first) = rest.chars().next() {
        let n = rest.find(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(rest.len());
        let taken = if n > 0 {
            found.push(Token::Name(&rest[..n]));
            n
        } else if rest.starts_with("::") {
            found.push(Token::Colons);
            2
        } else {
            if !first.is_whitespace() {
                found.push(Token::Sign(first));
            }
            first.len_utf8()
        };
        rest = &rest[taken..];
    }
    found
}

struct Reader<'t, 'f> {
    tokens: &'t [Token<'t>],
    at: usize,
    found: &'f mut Vec<Path>,
}

impl Reader<'_, '_> {
    fn peek(&self) -> Option<Token<'_>> {
        self.tokens.get(self.at).copied()
    }

    /// A path behind `before`, with all its branches. `used`: of a `use`, and whether that is public.
    fn tree(&mut self, before: &[String], used: Option<bool>) {
        let mut names = before.to_vec();
        loop {
            match self.peek() {
                Some(Token::Name(name)) => {
                    names.push(name.to_owned());
                    self.at += 1;
                }
                Some(Token::Sign('{')) if used.is_some() => {
                    self.at += 1;
                    return self.branches(&names, used);
                }
                Some(Token::Sign('*')) => {
                    self.at += 1;
                    break;
                }
                // A leading `::`, or a turbofish.
                Some(Token::Colons) if names.is_empty() => self.at += 1,
                _ => break,
            }
            match self.peek() {
                Some(Token::Colons) => self.at += 1,
                _ => break,
            }
        }
        if names.last().is_some_and(|last| last == "self") && names.len() > 1 {
            names.pop();
        }
        let mut alias = names.last().cloned();
        if self.peek() == Some(Token::Name("as")) && used.is_some() {
            self.at += 1;
            if let Some(Token::Name(name)) = self.peek() {
                alias = Some(name.to_owned());
                self.at += 1;
            }
        }
        if !names.is_empty() {
            let (alias, is_handed_on) = (alias.filter(|_| used.is_some()), used == Some(true));
            self.found.push(Path { names, alias, is_handed_on });
        }
    }

    fn branches(&mut self, before: &[String], used: Option<bool>) {
        while let Some(token) = self.peek() {
            match token {
                Token::Sign('}') => {
                    self.at += 1;
                    return;
                }
                Token::Sign(',') => self.at += 1,
                _ => {
                    let at = self.at;
                    self.tree(before, used);
                    self.at = self.at.max(at + 1);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn said(code: &str) -> Vec<String> {
        let word = |path: Path| {
            let alias = path.alias.map(|alias| format!(" as {alias}")).unwrap_or_default();
            format!(
                "{}{}{alias}",
                if path.is_handed_on { "pub " } else { "" },
                path.names.join("::")
            )
        };
        of(code).into_iter().map(word).collect()
    }

    #[test]
    fn trees_are_spread_out_and_paths_in_code_are_found() {
        assert_eq!(
            said(
                "use crate::{a::{B, self}, c::D as E};\npub(crate) use super::f::G;\nfn h() { i::j::<K>(l::M) }"
            ),
            [
                "crate::a::B as B",
                "crate::a as a",
                "crate::c::D as E",
                "pub super::f::G as G",
                "i::j",
                "l::M"
            ]
        );
    }
}
