//! Problems in a program: what, where, and how to mend it.

use std::fmt;

use crate::{
    Span,
    codes::{Code, Severity},
};

/// One problem at one place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnostic {
    /// Which problem.
    pub code: Code,
    /// Whether it stops the program from being built.
    pub severity: Severity,
    /// Where.
    pub span: Span,
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// What is wrong, with the names and values involved; no full stop.
    pub message: String,
    /// What to do about it, if we can guess.
    pub hint: Option<String>,
}

impl fmt::Display for Diagnostic {
    /// `line:column code severity: message (hint)`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { code, severity, line, column, message, .. } = self;
        write!(f, "{line}:{column} {code} {severity}: {message}")?;
        self.hint.as_ref().map_or(Ok(()), |hint| write!(f, " ({hint})"))
    }
}

/// Where something stands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Place {
    pub(crate) span: Span,
    pub(crate) line: usize,
    pub(crate) column: usize,
}

/// Problems listed before the rest is only counted; keeps the work on garbage bounded.
pub(crate) const N_DIAGNOSTICS_MAX: usize = 200;

/// Whether a problem is one of the program as a whole: it is told first, whatever else there is.
fn is_about_the_whole(code: Code) -> bool {
    matches!(
        code,
        Code::NoFunctions | Code::ScanTooLong | Code::ImageTooLarge | Code::SourceTooLarge
    )
}

/// Collects problems and forgets those beyond [`N_DIAGNOSTICS_MAX`].
#[derive(Debug, Default)]
pub(crate) struct Problems {
    list: Vec<Diagnostic>,
    n_errors: usize,
    n_forgotten: usize,
    last: Place,
}

impl Problems {
    /// Reports one problem. `hint` may be slow: it is only asked when the problem is kept.
    pub(crate) fn report(
        &mut self,
        code: Code,
        place: Place,
        message: String,
        hint: impl FnOnce() -> Option<String>,
    ) {
        if code.severity() == Severity::Error {
            self.n_errors = self.n_errors.saturating_add(1);
        }
        if self.list.len() >= N_DIAGNOSTICS_MAX && !is_about_the_whole(code) {
            self.n_forgotten = self.n_forgotten.saturating_add(1);
            self.last = place;
            return;
        }
        let Place { span, line, column } = place;
        let (severity, hint) = (code.severity(), hint());
        self.list.push(Diagnostic { code, severity, span, line, column, message, hint });
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    pub(crate) fn n_errors(&self) -> usize {
        self.n_errors
    }

    /// The problems of the program as a whole, then the others by place, and the number of errors, the forgotten ones included.
    pub(crate) fn into_sorted(mut self) -> (Vec<Diagnostic>, usize) {
        self.list.sort_by_key(|d| (!is_about_the_whole(d.code), d.span.start, d.code));
        if self.n_forgotten > 0 {
            let code = Code::TooManyProblems;
            let Place { span, line, column } = self.last;
            let message = format!("{} further problems are not listed", self.n_forgotten);
            let hint = Some("mend the first ones and compile again".to_owned());
            let severity = code.severity();
            self.list.push(Diagnostic { code, severity, span, line, column, message, hint });
        }
        (self.list, self.n_errors)
    }
}
