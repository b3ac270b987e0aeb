//! What is said of a field that cannot mean anything.

use crate::{
    Code,
    diagnostics::Problems,
    lexer::{Field, Flaw},
};

/// Reports a field that cannot mean anything.
pub(crate) fn report_flaw(flaw: Flaw, field: &Field<'_>, problems: &mut Problems) {
    match flaw {
        Flaw::UnclosedQuote => {
            let message = format!("the quote in {} is not closed", shortened(field.text));
            let quote = field.text.chars().next().unwrap_or('\'');
            let hint = || Some(format!("end the text with {quote}"));
            problems.report(Code::UnclosedQuote, field.place, message, hint);
        }
        Flaw::UnexpectedCharacter(c) => {
            let message = format!("`{}` cannot stand in a field", c.escape_debug());
            problems.report(Code::UnexpectedCharacter, field.place, message, || match c {
                '#' | '/' | '*' | '!' | '(' => Some(comment_hint()),
                '\0' => Some("is this a text at all?".to_owned()),
                c if c.is_whitespace() || c == '\u{FEFF}' || c == '\u{200B}' => {
                    Some("it looks like a blank and is none: put a plain blank there".to_owned())
                }
                _ => Some("separate operands with commas or blanks".to_owned()),
            });
        }
        Flaw::NotFolded => {
            let text = shortened(field.text);
            let message = format!("nothing is called `{text}` in listing mode");
            let hint = || {
                let capitals = text.to_ascii_uppercase();
                Some(format!("after a quote the listing folds no case: write `{capitals}`"))
            };
            problems.report(Code::UnknownName, field.place, message, hint);
        }
    }
}

/// The beginning of a text that may be very long.
pub(crate) fn shortened(text: &str) -> String {
    const SHOWN_MAX: usize = 32;
    if text.chars().count() <= SHOWN_MAX {
        return text.to_owned();
    }
    text.chars().take(SHOWN_MAX).chain(['…']).collect()
}

/// How comments begin.
pub(crate) fn comment_hint() -> String {
    "start a comment with `;`".to_owned()
}
