//! Cuts a line into fields.
//!
//! Blanks and commas, in any number, separate fields; `;` starts a comment; a field that begins
//! with a quote ends with the same quote and may contain anything else. Case means nothing outside
//! quotes; the listing's reader (Annex A1) folds a line only up to its first quote.

use crate::{Mode, Span, diagnostics::Place};

/// A word of a line, with its place.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Field<'s> {
    pub(crate) text: &'s str,
    pub(crate) place: Place,
    /// Characters.
    pub(crate) length: usize,
    /// Whether a comma stands between it and the field before.
    pub(crate) after_comma: bool,
    pub(crate) flaw: Option<Flaw>,
}

/// What disqualifies a field before anyone asks what it means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Flaw {
    UnclosedQuote,
    UnexpectedCharacter(char),
    /// In listing mode: small letters after a quote, which nothing folds.
    NotFolded,
}

impl Field<'_> {
    /// The text in upper case, except when it is quoted.
    pub(crate) fn folded(&self) -> String {
        if self.is_quoted() { self.text.to_owned() } else { self.text.to_ascii_uppercase() }
    }

    pub(crate) fn is_quoted(&self) -> bool {
        self.text.starts_with(is_quote)
    }

    /// Whether it begins as only constants begin.
    pub(crate) fn looks_like_number(&self) -> bool {
        let number = |c: char| c.is_ascii_digit() || matches!(c, '$' | '%' | '+' | '-');
        self.is_quoted() || self.text.starts_with(number)
    }
}

/// The fields of one line, from left to right.
#[derive(Clone, Debug)]
pub(crate) struct Fields<'s> {
    rest: &'s str,
    place: Place,
    /// Whether small letters are as good as capitals from here on.
    folds: bool,
    mode: Mode,
}

impl<'s> Fields<'s> {
    /// `start` is the offset of the line in the source, `number` counts lines from 1.
    pub(crate) fn new(line: &'s str, start: usize, number: usize, mode: Mode) -> Self {
        let span = Span { start, end: start };
        let place = Place { span, line: number, column: 1 };
        Self { rest: line, place, folds: true, mode }
    }

    /// Drops everything up to the first character that `keep`s, and returns it.
    fn take_until(&mut self, keep: impl Fn(char) -> bool) -> &'s str {
        let len = self.rest.find(keep).unwrap_or(self.rest.len());
        self.take(len)
    }

    fn take(&mut self, len: usize) -> &'s str {
        let (taken, rest) = self.rest.split_at_checked(len).unwrap_or((self.rest, ""));
        self.rest = rest;
        self.place.span.start = self.place.span.start.saturating_add(taken.len());
        self.place.column = self.place.column.saturating_add(taken.chars().count());
        taken
    }

    /// A quoted field: up to the same quote, or to the end of the line.
    fn take_quoted(&mut self, quote: char) -> (&'s str, Option<Flaw>) {
        let inside = self.rest.get(1..).unwrap_or("");
        let Some(len) = inside.find(quote) else {
            return (self.take(self.rest.len()), Some(Flaw::UnclosedQuote));
        };
        (self.take(len.saturating_add(2)), None)
    }
}

impl<'s> Iterator for Fields<'s> {
    type Item = Field<'s>;

    fn next(&mut self) -> Option<Field<'s>> {
        let gap = self.take_until(|c| !is_delimiter(c));
        let first = self.rest.chars().next().filter(|&c| c != ';')?;
        let mut place = self.place;
        let (text, flaw) = if is_quote(first) {
            // The listing stops folding at the first quote of a line.
            self.folds = self.mode == Mode::Corrected;
            self.take_quoted(first)
        } else {
            let text = self.take_until(|c| is_delimiter(c) || c == ';');
            let bad = text.chars().find(|&c| !is_field_character(c));
            let small = !self.folds && text.contains(|c: char| c.is_ascii_lowercase());
            let flaw = bad.map(Flaw::UnexpectedCharacter);
            (text, flaw.or(small.then_some(Flaw::NotFolded)))
        };
        place.span.end = self.place.span.start;
        let length = text.chars().count();
        Some(Field { text, place, length, after_comma: gap.contains(','), flaw })
    }
}

fn is_delimiter(c: char) -> bool {
    // The vertical tab is no whitespace to Rust's ASCII, and one to every printer.
    c == ',' || c == '\u{0B}' || c.is_ascii_whitespace()
}

fn is_quote(c: char) -> bool {
    matches!(c, '\'' | '"')
}

fn is_field_character(c: char) -> bool {
    c.is_ascii_alphanumeric() || matches!(c, '_' | '$' | '%' | '+' | '-' | ':')
}

#[cfg(test)]
mod tests {
    use super::*;
    use expect_test::{Expect, expect};

    fn check(line: &str, expected: &Expect) {
        let show = |f: Field<'_>| {
            let comma = if f.after_comma { "," } else { "" };
            let flaw = f.flaw.map(|flaw| format!(" {flaw:?}")).unwrap_or_default();
            let Place { span, column, .. } = f.place;
            assert_eq!(&line[span.start..span.end], f.text, "the span shows the text");
            format!("{comma}{}@{column}{flaw}\n", f.folded())
        };
        expected.assert_eq(&Fields::new(line, 0, 1, Mode::Corrected).map(show).collect::<String>());
    }

    #[test]
    fn blanks_and_commas_are_one_delimiter() {
        check(
            "  and o1, I1 ,\t,I2;AND Y1",
            &expect![[r"
                AND@3
                O1@7
                ,I1@11
                ,I2@17
            "]],
        );
    }

    #[test]
    fn quotes_keep_case_blanks_and_semicolons() {
        check(
            "a equ 'x;' \"b, \" 'open",
            &expect![[r#"
                A@1
                EQU@3
                'x;'@7
                "b, "@12
                'open@18 UnclosedQuote
            "#]],
        );
    }

    #[test]
    fn blanks_of_every_kind_separate() {
        let fields = Fields::new("a\u{0B}b\u{0C}c\td", 0, 1, Mode::Corrected);
        assert_eq!(fields.map(|f| f.folded()).collect::<Vec<_>>(), ["A", "B", "C", "D"]);
    }

    #[test]
    fn the_listing_folds_up_to_the_first_quote_only() {
        let flaws = |mode| {
            let fields = Fields::new("stic m0,'a',i0,I1 ; i0", 0, 1, mode);
            fields.map(|f| f.flaw).collect::<Vec<_>>()
        };
        assert_eq!(flaws(Mode::Corrected), [None; 5]);
        assert_eq!(flaws(Mode::Listing), [None, None, None, Some(Flaw::NotFolded), None]);
    }

    #[test]
    fn columns_count_characters_and_not_bytes() {
        check(
            "é o1",
            &expect![[r"
                é@1 UnexpectedCharacter('é')
                O1@3
            "]],
        );
    }

    #[test]
    fn comments_and_empty_lines_have_no_fields() {
        check("; all of it, 'really", &expect![""]);
        check(" \t,, ", &expect![""]);
        check("", &expect![""]);
    }
}
