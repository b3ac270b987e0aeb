//! Source text in, program and problems out.
//!
//! One pass over the lines, as in the thesis (Annex A1): a name is known from the line that
//! defines it. A line that is wrong is reported and left out, and the next one is read, so that
//! one run shows every problem. The work is linear in the length of the text; a problem beyond
//! the two hundredth is only counted.

use std::sync::Arc;

use crate::{
    Code, Diagnostic, Function, Mnemonic, Mode, Program, ResourceId, Span,
    diagnostics::{Place, Problems},
    flaws::{report_flaw, shortened},
    flow, image,
    instruction_set::Word,
    lexer::{Field, Fields},
    names::{Definition, Names, Symbol, nearest_name},
    operands::{NumberError, parse_number, resolve},
    parser::{Statement, parse_line},
    source_text::{Encoding, SOURCE_BYTES_MAX, SourceText, end_of_text, lines, read_source},
};

/// What compiling gave: a program unless there were errors, and every problem found.
#[derive(Clone, Debug)]
pub struct Compilation {
    /// The program; `None` when there was an error.
    pub program: Option<Program>,
    /// Every problem: those of the program as a whole, then the others in order of place.
    pub diagnostics: Vec<Diagnostic>,
    /// Lines read.
    pub n_lines: usize,
    /// Errors among the problems, also those beyond the ones listed.
    pub n_errors: usize,
    /// What the program's `EQU` lines name, in alphabetical order: name, line, meaning.
    pub symbols: Vec<(String, usize, Symbol)>,
    pub(crate) source: Arc<str>,
}

impl Compilation {
    /// The text that was compiled; every span points into it.
    pub fn source(&self) -> &str {
        &self.source
    }
}

/// Compiles a program. Cannot fail: whatever is wrong with the text is in the diagnostics.
///
/// ```
/// let compilation = decision::compile("AND O0,I0,I1,1L,1L");
/// let program = compilation.program.expect("no errors");
/// assert_eq!(program.image(), [0x00, 0x04, 0x20, 0x00, 0x01, 0xD2, 0xD2, 0x0F]);
/// ```
pub fn compile(source: &str) -> Compilation {
    compile_as(source, Mode::Corrected)
}

/// Compiles a program as the compiler of that mode reads it. The two differ in one thing: the
/// listing folds the case of a line only up to its first quote.
pub fn compile_as(source: &str, mode: Mode) -> Compilation {
    let text = SourceText { text: source.to_owned(), ..SourceText::default() };
    compile_text(&text, mode)
}

/// Compiles the bytes of a file, in whatever encoding they are; [`Code::OtherEncoding`] says when
/// that is not UTF-8.
pub fn compile_bytes(bytes: &[u8], mode: Mode) -> Compilation {
    if bytes.len() > SOURCE_BYTES_MAX {
        return Run::default().too_large(bytes.len());
    }
    compile_text(&read_source(bytes), mode)
}

fn compile_text(read: &SourceText, mode: Mode) -> Compilation {
    let mut run = Run::default();
    if read.text.len() > SOURCE_BYTES_MAX {
        return run.too_large(read.text.len());
    }
    let source: Arc<str> = read.text.as_str().into();
    let (end, beyond) = end_of_text(&source);
    let text = source.get(..end).unwrap_or(&source);
    let mut n_lines: usize = 0;
    let mut last = Place { line: 1, column: 1, ..Place::default() };
    for (start, line) in lines(text) {
        n_lines = n_lines.saturating_add(1);
        last = Place { span: Span { start, end: start }, line: n_lines, column: 1 };
        if read.first_odd_line == n_lines {
            run.report_encoding(read, last);
        }
        run.line(Fields::new(line, start, n_lines, mode));
    }
    if let Some(beyond) = beyond {
        let place = Place { span: Span { start: end, end: beyond }, ..last };
        let n_bytes = source.len().saturating_sub(beyond);
        let message = format!("{n_bytes} bytes after the end-of-file character are left out");
        let hint = || Some("remove the character 1A (Ctrl-Z) in this line".to_owned());
        run.problems.report(Code::TextAfterEnd, place, message, hint);
    }
    if run.functions.is_empty() && run.names.is_empty() && run.problems.is_empty() {
        let message = "the program has no functions: it does nothing".to_owned();
        let hint = || Some("a line such as `AND O0,I0,1L,1L,1L` is one".to_owned());
        run.problems.report(Code::NoFunctions, last, message, hint);
    }
    run.finish(source, n_lines)
}

#[derive(Default)]
struct Run {
    names: Names,
    functions: Vec<Function>,
    problems: Problems,
    /// Length of the image so far, its first byte not counted.
    n_bytes: usize,
}

impl Run {
    fn report_encoding(&mut self, read: &SourceText, place: Place) {
        let (message, hint) = match read.encoding {
            Encoding::Utf8 => return,
            Encoding::Utf16 => ("the text was read as UTF-16".to_owned(), "save it as UTF-8"),
            Encoding::Latin1 => {
                let n = read.n_odd_lines;
                let lines = if n == 1 { "this line is" } else { "this line and others are" };
                let message = format!("{lines} not UTF-8 and was read as Latin-1 ({n} in all)");
                (message, "save the text as UTF-8")
            }
        };
        self.problems.report(Code::OtherEncoding, place, message, || Some(hint.to_owned()));
    }

    /// Nothing is compiled of a text beyond all bounds.
    fn too_large(mut self, n_bytes: usize) -> Compilation {
        let place = Place { line: 1, column: 1, ..Place::default() };
        let message = format!("the text has {n_bytes} bytes; at most {SOURCE_BYTES_MAX} are read");
        let hint =
            || Some("the target holds 4096 bytes of program: is this the right file?".into());
        self.problems.report(Code::SourceTooLarge, place, message, hint);
        self.finish("".into(), 0)
    }

    fn line(&mut self, fields: Fields<'_>) {
        let line = parse_line(fields, &self.names, &mut self.problems);
        if let Some(label) = line.label {
            let text = label.text.strip_suffix(':').unwrap_or(label.text);
            self.define(text, label.place, None);
        }
        match line.statement {
            Some(Statement::Equ { name, value }) => self.equ(&name, &value),
            Some(Statement::Function { mnemonic, place, operands }) => {
                self.function(mnemonic, place, &operands);
            }
            None => {}
        }
    }

    fn equ(&mut self, name: &Field<'_>, value: &Field<'_>) {
        let symbol = self.equ_value(value);
        self.define(name.text, name.place, symbol);
    }

    /// A number, a resource, a word, or a name defined before.
    fn equ_value(&mut self, field: &Field<'_>) -> Option<Symbol> {
        if let Some(flaw) = field.flaw {
            report_flaw(flaw, field, &mut self.problems);
            return None;
        }
        if let Ok(id) = ResourceId::by_name(field.text) {
            return Some(Symbol::Resource(id));
        }
        if let Some(word) = Word::by_name(field.text) {
            return Some(Symbol::Value(word.value));
        }
        if let Some(definition) = self.names.get(&field.folded()) {
            return definition.symbol;
        }
        let text = shortened(field.text);
        match parse_number(field) {
            Ok(value) => return Some(Symbol::Value(value)),
            Err(NumberError::TooLarge) => {
                let message = format!("`{text}` does not fit into 16 bits");
                let hint = || Some("a constant is -32768 to 65535".to_owned());
                self.problems.report(Code::ValueOutOfRange, field.place, message, hint);
            }
            Err(NumberError::Malformed(rule)) if field.looks_like_number() => {
                let message = format!("`{text}` is not a number");
                let hint = || Some(rule.to_owned());
                self.problems.report(Code::MalformedNumber, field.place, message, hint);
            }
            Err(NumberError::Malformed(_)) => {
                let message = format!("nothing is called `{text}`");
                let names = &self.names;
                let hint =
                    || nearest_name(field.text, names).map(|n| format!("did you mean `{n}`?"));
                self.problems.report(Code::UnknownName, field.place, message, hint);
            }
        }
        None
    }

    /// Enters a name. A label has no `symbol`.
    fn define(&mut self, text: &str, place: Place, symbol: Option<Symbol>) {
        let name = text.to_ascii_uppercase();
        let is_name = name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
            && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
        let is_reserved = ResourceId::by_name(&name).is_ok()
            || Word::by_name(&name).is_some()
            || Mnemonic::by_name(&name).is_some()
            || name == "EQU";
        if is_reserved {
            let message = format!("`{name}` belongs to the language");
            let hint = || Some(format!("choose another name, such as `MY_{name}`"));
            self.problems.report(Code::NameReserved, place, message, hint);
        } else if !is_name {
            let message = format!("`{}` is not a name", shortened(text));
            let hint = || Some("a name has letters, digits and `_`, and no digit first".to_owned());
            self.problems.report(Code::MalformedName, place, message, hint);
        } else if let Some(first) = self.names.get(&name) {
            let message =
                format!("`{}` is already defined in line {}", shortened(&name), first.line);
            self.problems.report(Code::NameTaken, place, message, || None);
        } else {
            self.names.insert(name, Definition { line: place.line, symbol });
        }
    }

    fn function(&mut self, mnemonic: Mnemonic, place: Place, fields: &[Field<'_>]) {
        let mut operands = Vec::with_capacity(fields.len());
        for (field, &parameter) in fields.iter().zip(mnemonic.parameters()) {
            operands.extend(resolve(field, mnemonic, parameter, &self.names, &mut self.problems));
        }
        if operands.len() < fields.len() {
            return;
        }
        let end = operands.last().map_or(place.span.end, |operand| operand.span.end);
        let function = Function {
            line: place.line,
            span: Span { start: place.span.start, end },
            address: self.n_bytes.saturating_add(1),
            mnemonic,
            operands,
        };
        flow::check_oscillator(&function, &mut self.problems);
        self.n_bytes = self.n_bytes.saturating_add(mnemonic.size_bytes());
        self.functions.push(function);
    }

    fn finish(mut self, source: Arc<str>, n_lines: usize) -> Compilation {
        flow::check(&self.functions, &mut self.problems);
        if self.problems.n_errors() == 0 {
            flow::check_whole(&self.functions, &mut self.problems);
        }
        let bytes = image::encode(&self.functions);
        self.check_image(&bytes);
        let symbols = self.names.into_iter();
        let symbols = symbols.filter_map(|(name, d)| Some((name, d.line, d.symbol?))).collect();
        let (diagnostics, n_errors) = self.problems.into_sorted();
        let functions = self.functions;
        let program = (n_errors == 0).then(|| Program {
            source: Arc::clone(&source),
            functions,
            image: bytes.into(),
        });
        Compilation { program, diagnostics, n_lines, n_errors, symbols, source }
    }

    /// Guards our own work: what was encoded must decode to the same functions.
    fn check_image(&mut self, bytes: &[u8]) {
        if !image::decodes_to(bytes, &self.functions) {
            let place = Place { line: 1, column: 1, ..Place::default() };
            let message = "the image of this program does not decode to the program".to_owned();
            let hint = || Some("please send us the program".to_owned());
            self.problems.report(Code::ImageMismatch, place, message, hint);
        }
    }
}
