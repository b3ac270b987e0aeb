//! A compiled program: functions in order, each operand tied to its place in the source.

use std::{sync::Arc, time::Duration};

use crate::{
    Mnemonic, ResourceId, Role,
    timers::{TICK, quantum_ticks},
};

/// Byte range in the source text.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Span {
    /// First byte.
    pub start: usize,
    /// One past the last byte.
    pub end: usize,
}

/// What an operand turned out to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OperandKind {
    /// A variable.
    Resource(ResourceId),
    /// A constant, encoded in the instruction.
    Immediate(i32),
}

/// One operand, with what a screen needs to light it up in place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Operand {
    /// As written.
    pub text: String,
    /// Where it stands in the source.
    pub span: Span,
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// Length in characters.
    pub length: usize,
    /// Name of the operand in the documents, such as `DEST`.
    pub name: &'static str,
    /// What it is for.
    pub role: Role,
    /// What it is.
    pub kind: OperandKind,
}

impl Operand {
    /// The resource it names, if it names one.
    pub fn resource(&self) -> Option<ResourceId> {
        match self.kind {
            OperandKind::Resource(id) => Some(id),
            OperandKind::Immediate(_) => None,
        }
    }

    /// The constant it is, if it is one.
    pub fn immediate(&self) -> Option<i32> {
        match self.kind {
            OperandKind::Resource(_) => None,
            OperandKind::Immediate(value) => Some(value),
        }
    }
}

/// One function of a program.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Function {
    /// Line, from 1.
    pub line: usize,
    /// From its mnemonic to its last operand.
    pub span: Span,
    /// Offset of its opcode in the image.
    pub address: usize,
    /// Which function.
    pub mnemonic: Mnemonic,
    /// As many as the mnemonic has parameters, in that order.
    pub operands: Vec<Operand>,
}

impl Function {
    /// The timer that it sets, if it sets one: 0 to 31.
    pub fn timer(&self) -> Option<u8> {
        u8::try_from(self.constant(Role::TimerNumber)?).ok()
    }

    /// How long that timer runs: K quanta of its group.
    pub fn timer_time(&self) -> Option<Duration> {
        let ticks = quantum_ticks(self.timer()?);
        let quanta = u32::try_from(self.constant(Role::Quanta)?).ok()?;
        Some(TICK.saturating_mul(ticks.saturating_mul(quanta)))
    }

    /// Its first constant of that role, if it has one.
    pub fn constant(&self, role: Role) -> Option<i32> {
        self.operands.iter().find(|operand| operand.role == role)?.immediate()
    }
}

/// A program without errors.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Program {
    pub(crate) source: Arc<str>,
    pub(crate) functions: Vec<Function>,
    pub(crate) image: Arc<[u8]>,
}

impl Program {
    /// The text it came from; every span points into it.
    pub fn source(&self) -> &str {
        &self.source
    }

    /// Its functions, in order of evaluation.
    pub fn functions(&self) -> &[Function] {
        &self.functions
    }

    /// Its encoding: 0x00, the functions, 0x0F.
    pub fn image(&self) -> &[u8] {
        &self.image
    }
}
