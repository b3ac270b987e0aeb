//! What a field in the place of an operand means.

use crate::{
    Code, Mnemonic, NameError, Operand, OperandKind, Parameter, ResourceId, Role, ValueKind,
    diagnostics::Problems,
    flaws::{report_flaw, shortened},
    instruction_set::Word,
    lexer::Field,
    names::{Definition, Names, Symbol, nearest_name},
};

/// Why a constant is none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum NumberError {
    /// Not written as a number of its notation.
    Malformed(&'static str),
    /// A number, but not one of 16 bits.
    TooLarge,
}

/// Reads `12`, `-12`, `$1F`, `%101`, `'A'`, `'AB'`: anything from −32768 to 65535.
pub(crate) fn parse_number(field: &Field<'_>) -> Result<i32, NumberError> {
    let text = field.text;
    if field.is_quoted() {
        let inside = text.trim_matches(['\'', '"']);
        return match inside.as_bytes() {
            [a] if a.is_ascii() => Ok(i32::from(*a)),
            [a, b] if inside.is_ascii() => Ok(i32::from(u16::from_be_bytes([*a, *b]))),
            _ => Err(NumberError::Malformed("a quoted constant is one or two ASCII characters")),
        };
    }
    let (digits, radix, negative, rule) = if let Some(digits) = text.strip_prefix('$') {
        (digits, 16, false, "after `$` come hexadecimal digits")
    } else if let Some(digits) = text.strip_prefix('%') {
        (digits, 2, false, "after `%` come the digits 0 and 1")
    } else {
        let digits = text.strip_prefix(['+', '-']).unwrap_or(text);
        (digits, 10, text.starts_with('-'), "a number has decimal digits only")
    };
    if digits.is_empty() || !digits.chars().all(|c| c.is_digit(radix)) {
        return Err(NumberError::Malformed(rule));
    }
    // Only overflow is left to go wrong.
    let value = i64::from_str_radix(digits, radix).or(Err(NumberError::TooLarge))?;
    let signed = if negative { value.saturating_neg() } else { value };
    let in_16_bits = -32768..=65535;
    let value = i32::try_from(signed).ok().filter(|value| in_16_bits.contains(value));
    value.ok_or(NumberError::TooLarge)
}

/// Resolves one operand, or reports why it cannot be.
pub(crate) fn resolve(
    field: &Field<'_>,
    mnemonic: Mnemonic,
    parameter: Parameter,
    names: &Names,
    problems: &mut Problems,
) -> Option<Operand> {
    if let Some(flaw) = field.flaw {
        report_flaw(flaw, field, problems);
        return None;
    }
    let mut resolver = Resolver { field, mnemonic, parameter, names, problems };
    let kind = if parameter.role.is_resource() {
        OperandKind::Resource(resolver.resource()?)
    } else {
        OperandKind::Immediate(resolver.immediate()?)
    };
    let place = field.place;
    Some(Operand {
        text: field.text.to_owned(),
        span: place.span,
        line: place.line,
        column: place.column,
        length: field.length,
        name: parameter.name,
        role: parameter.role,
        kind,
    })
}

struct Resolver<'a> {
    field: &'a Field<'a>,
    mnemonic: Mnemonic,
    parameter: Parameter,
    names: &'a Names,
    problems: &'a mut Problems,
}

impl Resolver<'_> {
    fn report(&mut self, code: Code, message: String, hint: Option<String>) {
        self.problems.report(code, self.field.place, message, || hint);
    }

    /// "DEST of AND".
    fn operand(&self) -> String {
        format!("{} of {}", self.parameter.name, self.mnemonic)
    }

    fn resource(&mut self) -> Option<ResourceId> {
        let id = self.find_resource()?;
        self.check_kind(id);
        Some(id)
    }

    fn find_resource(&mut self) -> Option<ResourceId> {
        let word = Word::by_name(self.field.text);
        if let (Role::Direction, Some(word)) = (self.parameter.role, word)
            && word.role == Role::Direction
        {
            return Some(if word.value == 1 { ResourceId::ONE } else { ResourceId::ZERO });
        }
        let name_error = match ResourceId::by_name(self.field.text) {
            Ok(id) => return self.checked_destination(id),
            Err(error) => error,
        };
        match self.definition().map(|definition| definition.symbol) {
            Some(Some(Symbol::Resource(id))) => return self.checked_destination(id),
            Some(Some(Symbol::Value(value))) => {
                self.report_constant(Some(value));
                return None;
            }
            // Its definition was wrong, and reported there.
            Some(None) => return None,
            None => {}
        }
        if let NameError::NumberTooLarge { .. } = name_error {
            let message = format!("there is no resource `{}`", self.field.folded());
            self.report(Code::NumberTooLarge, message, Some(name_error.to_string()));
        } else if word.is_some() || parse_number(self.field).is_ok() {
            self.report_constant(parse_number(self.field).ok());
        } else {
            self.report_unknown();
        }
        None
    }

    fn definition(&self) -> Option<Definition> {
        self.names.get(&self.field.folded()).copied()
    }

    fn report_constant(&mut self, value: Option<i32>) {
        let what = shortened(self.field.text);
        let message = format!("{} must be a resource, `{what}` is a constant", self.operand());
        let hint = match (self.parameter.role, value) {
            (Role::Direction, _) => Some("use UP or DOWN, or a resource".to_owned()),
            (_, Some(0)) => Some("did you mean `0L`?".to_owned()),
            (_, Some(1)) => Some("did you mean `1L`?".to_owned()),
            (Role::Number, _) => {
                Some("put it into a memory with STIC and compare with that".to_owned())
            }
            _ => None,
        };
        self.report(Code::ConstantForResource, message, hint);
    }

    fn report_unknown(&mut self) {
        let (field, names) = (self.field, self.names);
        let (code, message, rule) = match parse_number(field) {
            Err(NumberError::Malformed(rule)) if field.looks_like_number() => {
                let message = format!("`{}` is not a number", shortened(field.text));
                (Code::MalformedNumber, message, Some(rule))
            }
            _ => {
                let message = format!("nothing is called `{}`", shortened(&field.folded()));
                (Code::UnknownName, message, None)
            }
        };
        self.problems.report(code, field.place, message, || {
            let guess =
                nearest_name(field.text, names).map(|name| format!("did you mean `{name}`?"));
            guess.or_else(|| rule.map(str::to_owned))
        });
    }

    fn checked_destination(&mut self, id: ResourceId) -> Option<ResourceId> {
        use crate::Family;
        if !self.parameter.role.is_destination() || id.is_writable() {
            return Some(id);
        }
        let (why, hint) = match id.family() {
            Family::Input | Family::NegatedInput | Family::Analog => {
                ("the field writes it", "use an output, or a memory such as Y0")
            }
            Family::TimerOutput => ("its TIMER writes it", "start the timer with TIMER"),
            Family::State => ("it is decoded from STATUS", "write STATUS, for example with STIC"),
            family if family.is_clock() => ("the clock writes it", "use a memory such as M0"),
            _ => ("it is constant", "use a memory such as Y0"),
        };
        let message = format!("{} cannot be {id}: {why}", self.operand());
        self.report(Code::ReadOnlyDestination, message, Some(hint.to_owned()));
        None
    }

    fn check_kind(&mut self, id: ResourceId) {
        use Role::{Boolean, BooleanDestination, Condition, Number, NumberDestination};
        match (self.parameter.role, id.value_kind()) {
            (Boolean | BooleanDestination | Condition, ValueKind::Number) => {
                let message = format!(
                    "{} is one bit with a history, {id} is a number from 0 to 255",
                    self.operand()
                );
                let hint = if self.parameter.role == BooleanDestination {
                    "use a boolean such as Y0"
                } else {
                    "compare it first, with ACOMP or DCOMP"
                };
                self.report(Code::NumberAsBoolean, message, Some(hint.to_owned()));
            }
            (Number | NumberDestination, ValueKind::Boolean) => {
                let message =
                    format!("{} is a number, {id} is one bit with a history", self.operand());
                let hint =
                    "numbers live in A0–A7, M0–M7, STATUS, Y0–Y95 and in the clock (HOUR, …)"
                        .to_owned();
                self.report(Code::BooleanAsNumber, message, Some(hint));
            }
            _ => {}
        }
    }

    fn immediate(&mut self) -> Option<i32> {
        let value = self.find_immediate()?;
        let (min, max) = self.parameter.role.range()?;
        if (min..=max).contains(&value) {
            return Some(value);
        }
        let message = format!("{} is {value}, it must be {min} to {max}", self.operand());
        let hint = match (self.parameter.role, value) {
            (Role::Quanta, 256..) => Some("use a timer with a longer quantum".to_owned()),
            _ => None,
        };
        self.report(Code::ValueOutOfRange, message, hint);
        None
    }

    fn find_immediate(&mut self) -> Option<i32> {
        if let Some(word) = Word::by_name(self.field.text) {
            self.check_word(word);
            return Some(word.value);
        }
        if let Ok(id) = ResourceId::by_name(self.field.text) {
            self.report_resource(id);
            return None;
        }
        match self.definition().map(|definition| definition.symbol) {
            Some(Some(Symbol::Value(value))) => return Some(value),
            Some(Some(Symbol::Resource(id))) => {
                self.report_resource(id);
                return None;
            }
            Some(None) => return None,
            None => {}
        }
        match parse_number(self.field) {
            Ok(value) => return Some(value),
            Err(NumberError::TooLarge) => {
                let text = shortened(self.field.text);
                let message = format!("`{text}` does not fit into 16 bits");
                let hint = self.parameter.role.range();
                let hint = hint.map(|(min, max)| format!("it must be {min} to {max}"));
                self.report(Code::ValueOutOfRange, message, hint);
            }
            Err(NumberError::Malformed(_)) => self.report_unknown(),
        }
        None
    }

    fn report_resource(&mut self, id: ResourceId) {
        let message = format!("{} must be a constant, {id} is a resource", self.operand());
        let hint = match (self.parameter.role, id.family()) {
            (Role::TimerNumber, crate::Family::TimerOutput) => {
                Some(format!("write {}", id.number()))
            }
            (_, crate::Family::Zero) => Some("write 0".to_owned()),
            (_, crate::Family::One) => Some("write 1".to_owned()),
            _ => None,
        };
        self.report(Code::ResourceForConstant, message, hint);
    }

    fn check_word(&mut self, word: Word) {
        if word.role == self.parameter.role {
            return;
        }
        let message =
            format!("{} is {}, which stands for {}", self.operand(), word.name, word.value);
        let hint = match self.parameter.role {
            Role::Edge => "use RISE or FALL, or 0 or 3 for a level".to_owned(),
            Role::TimerType => "use MONO or OSC".to_owned(),
            _ => format!("write {}, or check the order of the operands", word.value),
        };
        self.report(Code::WordOutOfPlace, message, Some(hint));
    }
}
