//! The Robot Decision Programming Language: source text in, a scanning machine out.
//!
//! RDPL programs say what a robotic assistant does about what the sensors of a house report: the
//! doorbell rings, nobody moves for fifteen seconds, the robot goes to the door. A program is a
//! list of functions, evaluated in order, over and over, as in a programmable controller.
//!
//! [`compile`] turns text into a [`Program`] and every problem it finds; a [`Machine`] executes
//! it and keeps the time it is given; [`decode`] reads an image back. Inputs, outputs and goals
//! are plain numbers: this crate knows nothing of robots, links or files.
//!
//! The language is described for users in `docs/guide/rdpl.md`, every problem in
//! `docs/problems/`.
//!
//! Source: Susnea (c. 2009), doctoral thesis, University of Galati, chapter 4 and Annex A. The thesis
//! prints neither addresses nor the back end of its compiler; both are ours. Where its text and
//! its listing disagree, [`Mode`] offers both.

#![cfg_attr(not(test), warn(clippy::indexing_slicing, clippy::arithmetic_side_effects))]

mod clock;
mod codes;
mod compiler;
mod diagnostics;
mod estimate;
mod execute;
mod flaws;
mod flow;
mod gate_view;
mod image;
mod instruction_set;
mod lexer;
mod listing;
mod machine;
mod mode;
mod moves;
mod names;
mod operands;
mod parser;
mod program;
mod rehearsal;
mod resources;
mod ring;
mod source_text;
mod state;
mod timers;

pub use clock::DateTime;
pub use codes::{Code, Severity};
pub use compiler::{Compilation, compile, compile_as, compile_bytes};
pub use diagnostics::Diagnostic;
pub use estimate::{Estimate, FUNCTION_BYTES, FUNCTION_MS, N_FUNCTIONS_MAX, SCAN_MS_MAX};
pub use gate_view::gate_view;
pub use image::{IMAGE_BYTES_MAX, ImageError, decode};
pub use instruction_set::{Mnemonic, OPCODE_END_OF_CYCLE, OPCODE_READ_INPUTS, Parameter, Role};
pub use machine::{Machine, ScanReport, TimerView, WATCHDOG};
pub use mode::Mode;
pub use moves::{MovePoints, MoveReport, MoveSignal, MoveState};
pub use names::Symbol;
pub use program::{Function, Operand, OperandKind, Program, Span};
pub use rehearsal::{
    Rehearsal, Row, Script, ScriptError, rehearse, watched_all, watched_by_default,
};
pub use resources::{EdgeCode, Family, N_RESOURCES, NameError, ResourceId, ValueKind};
pub use source_text::{Encoding, SOURCE_BYTES_MAX, SourceText, read_source};
pub use state::{Event, Failsafe, Fault, MoveCommand, Step};
