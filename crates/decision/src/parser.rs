//! From the fields of a line to a statement: which field is label, function, operand, comment.
//!
//! Source: the thesis, Annex A1 (`[label] mnemonic op1,…,op5 [comment]`). Differences: a mnemonic
//! may stand flush left; what follows the fifth operand is a comment only if no comma precedes
//! it, so that a sixth input of an `AND` is an error and not silently lost; a comment without its
//! sign that looks like an operand or another function is pointed at.

use crate::{
    Code, Mnemonic, ResourceId,
    diagnostics::{Place, Problems},
    flaws::{comment_hint, report_flaw, shortened},
    instruction_set::Word,
    lexer::{Field, Fields},
    names::{Names, nearest_mnemonic},
    operands::parse_number,
};

/// Operand fields of a line; the field after them is a comment.
const N_OPERANDS_MAX: usize = 5;

/// What a line says.
#[derive(Debug)]
pub(crate) enum Statement<'s> {
    /// `NAME EQU value`.
    Equ { name: Field<'s>, value: Field<'s> },
    /// A function with as many operand fields as it has parameters.
    Function { mnemonic: Mnemonic, place: Place, operands: Vec<Field<'s>> },
}

/// A label and a statement; either may be missing, and problems are already reported.
#[derive(Debug, Default)]
pub(crate) struct Line<'s> {
    pub(crate) label: Option<Field<'s>>,
    pub(crate) statement: Option<Statement<'s>>,
}

/// What a field in the place of a mnemonic is.
enum Head {
    Equ,
    Function(Mnemonic),
}

fn head(field: &Field<'_>) -> Option<Head> {
    if field.text.eq_ignore_ascii_case("EQU") {
        return Some(Head::Equ);
    }
    Mnemonic::by_name(field.text).map(Head::Function)
}

/// Parses one line. Reports what is wrong with it and keeps what is not. `names` are those defined
/// above it.
pub(crate) fn parse_line<'s>(
    mut fields: Fields<'s>,
    names: &Names,
    problems: &mut Problems,
) -> Line<'s> {
    let Some(first) = fields.next() else {
        return Line::default();
    };
    match head(&first) {
        Some(Head::Function(mnemonic)) => {
            let statement = parse_function((mnemonic, first.place), fields, names, problems);
            Line { label: None, statement }
        }
        Some(Head::Equ) => {
            let message = "EQU has no name before it".to_owned();
            problems.report(Code::IncompleteEqu, first.place, message, || Some(equ_hint("NAME")));
            Line::default()
        }
        None => parse_labelled(first, fields, names, problems),
    }
}

/// The first field is no function: a label, the name of an EQU, or a slip.
fn parse_labelled<'s>(
    first: Field<'s>,
    mut fields: Fields<'s>,
    names: &Names,
    problems: &mut Problems,
) -> Line<'s> {
    if let Some(flaw) = first.flaw {
        report_flaw(flaw, &first, problems);
        return Line::default();
    }
    let Some(second) = fields.next() else {
        let message = format!("nothing follows the label `{}`", shortened(&first.folded()));
        let hint = || nearest_mnemonic(first.text).map(|m| format!("did you mean `{m}`?"));
        problems.report(Code::LoneLabel, first.place, message, hint);
        return Line::default();
    };
    match head(&second) {
        Some(Head::Equ) => {
            let statement = parse_equ((first, &second), fields, names, problems);
            Line { label: None, statement }
        }
        Some(Head::Function(mnemonic)) => {
            let statement = parse_function((mnemonic, second.place), fields, names, problems);
            Line { label: Some(first), statement }
        }
        None => {
            // Which of the two was meant to be the function? The one that is nearly one.
            let guess = nearest_mnemonic(first.text);
            let second_guess = if guess.is_none() { nearest_mnemonic(second.text) } else { None };
            let culprit = if second_guess.is_some() { second } else { first };
            let message = format!("there is no function `{}`", shortened(&culprit.folded()));
            let hint = || guess.or(second_guess).map(|m| format!("did you mean `{m}`?"));
            problems.report(Code::UnknownMnemonic, culprit.place, message, hint);
            Line::default()
        }
    }
}

fn equ_hint(name: &str) -> String {
    format!("write `{name} EQU value`")
}

fn parse_equ<'s>(
    (name, equ): (Field<'s>, &Field<'s>),
    mut fields: Fields<'s>,
    names: &Names,
    problems: &mut Problems,
) -> Option<Statement<'s>> {
    let Some(value) = fields.next() else {
        let message = format!("`{}` is given no value", shortened(&name.folded()));
        let hint = || Some(equ_hint(name.text));
        problems.report(Code::IncompleteEqu, equ.place, message, hint);
        return None;
    };
    match fields.next() {
        Some(extra) if extra.after_comma => {
            let message = format!("EQU takes one value, `{}` is too many", shortened(extra.text));
            problems.report(Code::TooManyOperands, extra.place, message, || Some(comment_hint()));
        }
        Some(extra) => check_comment("EQU", extra, fields, names, problems),
        None => {}
    }
    Some(Statement::Equ { name, value })
}

fn parse_function<'s>(
    (mnemonic, place): (Mnemonic, Place),
    mut fields: Fields<'s>,
    names: &Names,
    problems: &mut Problems,
) -> Option<Statement<'s>> {
    let parameters = mnemonic.parameters();
    let operands: Vec<Field<'s>> = fields.by_ref().take(parameters.len()).collect();
    if let Some(missing) = parameters.get(operands.len()) {
        for field in &operands {
            if let Some(flaw) = field.flaw {
                report_flaw(flaw, field, problems);
            }
        }
        let (needed, given) = (parameters.len(), operands.len());
        let message = format!(
            "{mnemonic} needs {needed} operands and has {given}: {} is missing",
            missing.name
        );
        let hint = || match mnemonic.neutral().filter(|_| given >= 2) {
            Some(neutral) => Some(format!("tie unused inputs to {neutral}")),
            None => Some(syntax(mnemonic)),
        };
        problems.report(Code::TooFewOperands, place, message, hint);
        return None;
    }
    let comment_allowed = operands.len() == N_OPERANDS_MAX;
    match fields.next() {
        Some(extra) if extra.after_comma || !comment_allowed => {
            let (needed, text) = (parameters.len(), shortened(extra.text));
            let message = format!("{mnemonic} takes {needed} operands, `{text}` is too many");
            problems.report(Code::TooManyOperands, extra.place, message, || {
                if extra.after_comma {
                    Some(syntax(mnemonic))
                } else if head(&extra).is_some() {
                    Some("write one function a line".to_owned())
                } else {
                    Some(comment_hint())
                }
            });
        }
        Some(extra) => check_comment(mnemonic.name(), extra, fields, names, problems),
        None => {}
    }
    Some(Statement::Function { mnemonic, place, operands })
}

/// Looks at a comment without its sign, which begins with `first`: is it really one?
fn check_comment<'s>(
    function: &str,
    first: Field<'s>,
    rest: Fields<'s>,
    names: &Names,
    problems: &mut Problems,
) {
    if is_like_operand(&first, names) {
        let text = shortened(first.text);
        let message = format!("`{text}` after the last operand of {function} is left out");
        let hint = || Some(format!("if it is a comment, {}", comment_hint()));
        return problems.report(Code::OperandBeyondLast, first.place, message, hint);
    }
    let mut before = first;
    for field in rest {
        if head(&before).is_some() && is_like_operand(&field, names) {
            let text = before.folded();
            let message = format!("`{text}` is the second function on this line: it is left out");
            let hint = || Some("write one function a line".to_owned());
            return problems.report(Code::SecondFunction, before.place, message, hint);
        }
        before = field;
    }
}

/// Whether a field could stand in the place of an operand.
fn is_like_operand(field: &Field<'_>, names: &Names) -> bool {
    ResourceId::by_name(field.text).is_ok()
        || Word::by_name(field.text).is_some()
        || (field.looks_like_number() && parse_number(field).is_ok())
        || names.contains_key(&field.folded())
}

fn syntax(mnemonic: Mnemonic) -> String {
    format!("write `{}`", mnemonic.syntax())
}
