//! The table of functions: names, opcodes, what each operand must be, when it acts, and a sentence on it.
//!
//! Everything else — parser, encoder, decoder, machine, rules about programs, gate view, `cairn rdpl --help`, the
//! guide's table, the editor of the studio — reads it and has no list of functions of its own. A new function is a row
//! here and what it does in `execute.rs`; its size follows from its operands.
//!
//! Source: the thesis, §4.2.3.4, Table 4.6 and Annex A. Differences: the thesis prints no length
//! for `MOVE`; ours is nine bytes, with coordinates as 16-bit big-endian numbers.

use std::fmt;

use crate::ResourceId;

/// The enum of functions and everything that is said of each, made of one row for each.
macro_rules! functions {
    ($( $variant:ident = $name:literal, $opcode:literal, $parameters:expr, $acts:ident, $about:literal; )+) => {
        /// A function of the language.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
        pub enum Mnemonic {
            $( #[doc = $about] #[doc = "."] $variant, )+
        }

        impl Mnemonic {
            /// Every function, by opcode.
            pub const ALL: &'static [Self] = &[$( Self::$variant, )+];

            /// As a program writes it.
            pub const fn name(self) -> &'static str {
                match self { $( Self::$variant => $name, )+ }
            }

            /// First byte of its encoding.
            pub const fn opcode(self) -> u8 {
                match self { $( Self::$variant => $opcode, )+ }
            }

            /// The function with that opcode.
            pub const fn by_opcode(opcode: u8) -> Option<Self> {
                match opcode {
                    $( $opcode => Some(Self::$variant), )+
                    _ => None,
                }
            }

            /// Its operands, in the order of both text and encoding.
            pub const fn parameters(self) -> &'static [Parameter] {
                match self { $( Self::$variant => $parameters, )+ }
            }

            /// Bytes of its encoding, the opcode included.
            pub const fn size_bytes(self) -> usize {
                match self { $( Self::$variant => const { size_bytes($parameters) }, )+ }
            }

            /// What it does, in one sentence without a full stop.
            pub const fn about(self) -> &'static str {
                match self { $( Self::$variant => $about, )+ }
            }

            /// When it acts.
            pub(crate) const fn acts(self) -> Acts {
                match self { $( Self::$variant => Acts::$acts, )+ }
            }
        }
    };
}

functions! {
    And = "AND", 0x04, LOGIC, EachScan, "1 when all four are 1";
    Nand = "NAND", 0x05, LOGIC, EachScan, "1 when not all four are 1";
    Or = "OR", 0x06, LOGIC, EachScan, "1 when at least one of four is 1";
    Nor = "NOR", 0x07, LOGIC, EachScan, "1 when none of four is 1";
    Xor = "XOR", 0x08, LOGIC, EachScan, "1 when an odd number of four are 1";
    Ff = "FF", 0x09, FF, EachScan, "a flip-flop that S sets and R resets";
    Timer = "TIMER", 0x0A, TIMER, EachScan, "one of 32 timers: a pulse of K quanta, or an oscillator";
    Counter = "COUNTER", 0x0B, COUNTER, OnEdges, "counts edges up or down, from 0 to 255";
    Dcomp = "DCOMP", 0x0C, DCOMP, EachScan, "1 when two bytes agree in the bits of a mask";
    Acomp = "ACOMP", 0x0D, ACOMP, EachScan, "1 when one number is at least another";
    Move = "MOVE", 0x0E, MOVE, Outside, "sends the robot to a goal, in mm and degrees";
    Stc = "STC", 0x10, STC, OnCondition, "copies a byte on a condition";
    Stic = "STIC", 0x11, STIC, OnCondition, "stores a constant on a condition";
    Oper = "OPER", 0x12, OPER, EachScan, "the sum of two numbers, or their difference";
    Mul = "MUL", 0x13, MUL, EachScan, "the product of two numbers";
    Event = "EVENT", 0x16, EVENT, Outside, "writes an entry into the event log";
}

/// When a function acts: writes its destination, or does something outside of the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Acts {
    /// It writes in every scan.
    EachScan,
    /// It writes in scans in which its condition holds.
    OnCondition,
    /// It writes in scans with an edge; a level never counts.
    OnEdges,
    /// It does something outside, in every scan in which its condition holds; hardly meant with a level.
    Outside,
}

/// What an operand is for, which decides what may stand there and how it is encoded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Role {
    /// A resource that receives a boolean.
    BooleanDestination,
    /// A resource that receives a number.
    NumberDestination,
    /// A resource that receives a whole byte, whatever it stands for.
    ByteDestination,
    /// A resource whose value now is read as a boolean.
    Boolean,
    /// A resource whose whole byte is read as a number.
    Number,
    /// A resource whose byte is read as it is, whatever it stands for.
    Byte,
    /// A resource whose last two values are compared with the edge operand.
    Condition,
    /// Count up or down: a resource, or `UP` or `DOWN`.
    Direction,
    /// 0 to 31.
    TimerNumber,
    /// `MONO` or `OSC`.
    TimerType,
    /// 0 to 3, where `RISE` is 1 and `FALL` is 2.
    Edge,
    /// 1 to 255 quanta of the timer.
    Quanta,
    /// 0 to 255.
    Constant,
    /// 0 or 1: which side of a flip-flop wins.
    Priority,
    /// 0 adds, 1 subtracts.
    Selector,
    /// 0 to 15.
    EventType,
    /// −32768 to 32767 mm.
    Coordinate,
    /// −360 to 360 degrees.
    Heading,
}

/// One operand of a function: its name in the documents, and its role.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Parameter {
    /// As the guide writes it, such as `DEST`.
    pub name: &'static str,
    /// What may stand there.
    pub role: Role,
}

/// A word of the language that is a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Word {
    pub(crate) name: &'static str,
    pub(crate) value: i32,
    /// The operands it is meant for.
    pub(crate) role: Role,
}

/// `RISE`, `FALL`, `UP`, `DOWN`, `MONO`, `OSC`.
pub(crate) const WORDS: [Word; 6] = [
    Word { name: "RISE", value: 1, role: Role::Edge },
    Word { name: "FALL", value: 2, role: Role::Edge },
    Word { name: "UP", value: 1, role: Role::Direction },
    Word { name: "DOWN", value: 0, role: Role::Direction },
    Word { name: "MONO", value: 0, role: Role::TimerType },
    Word { name: "OSC", value: 1, role: Role::TimerType },
];

impl Word {
    pub(crate) fn by_name(name: &str) -> Option<Self> {
        WORDS.into_iter().find(|word| word.name.eq_ignore_ascii_case(name))
    }
}

/// Opcode that reads the inputs; the first byte of every image.
pub const OPCODE_READ_INPUTS: u8 = 0x00;
/// Opcode that writes the outputs and ends the scan; the last byte of every image.
pub const OPCODE_END_OF_CYCLE: u8 = 0x0F;

impl Mnemonic {
    /// The function of that name, in either case.
    pub fn by_name(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|mnemonic| mnemonic.name().eq_ignore_ascii_case(name))
    }

    /// How it is written: `FF DEST,S,R,PRIORITY`.
    pub fn syntax(self) -> String {
        let names: Vec<&str> = self.parameters().iter().map(|p| p.name).collect();
        format!("{self} {}", names.join(","))
    }

    /// What an input that is not used is tied to; only inputs of logic functions can be.
    pub(crate) const fn neutral(self) -> Option<ResourceId> {
        match self {
            Self::And | Self::Nand => Some(ResourceId::ONE),
            Self::Or | Self::Nor | Self::Xor => Some(ResourceId::ZERO),
            _ => None,
        }
    }
}

/// Bytes of an instruction with these operands, the opcode included.
const fn size_bytes(parameters: &[Parameter]) -> usize {
    let (mut size, mut rest) = (1_usize, parameters);
    while let [first, behind @ ..] = rest {
        size = size.saturating_add(first.role.size_bytes());
        rest = behind;
    }
    size
}

const fn p(name: &'static str, role: Role) -> Parameter {
    Parameter { name, role }
}

const CLOCK: Parameter = p("CLOCK", Role::Condition);
const COND: Parameter = p("COND", Role::Condition);
const DEST: Parameter = p("DEST", Role::BooleanDestination);
const DEST_BYTE: Parameter = p("DEST", Role::ByteDestination);
const DEST_NUMBER: Parameter = p("DEST", Role::NumberDestination);
const DESTH: Parameter = p("DESTH", Role::NumberDestination);
const DESTL: Parameter = p("DESTL", Role::NumberDestination);
const DIR: Parameter = p("DIR", Role::Direction);
const EDGE: Parameter = p("EDGE", Role::Edge);
const INPUT: Parameter = p("INPUT", Role::Condition);
const TRIGGER: Parameter = p("TRIGGER", Role::Condition);
const OPERANDS: [Parameter; 4] = [
    p("OP1", Role::Boolean),
    p("OP2", Role::Boolean),
    p("OP3", Role::Boolean),
    p("OP4", Role::Boolean),
];
const NUMBERS: [Parameter; 2] = [p("OP1", Role::Number), p("OP2", Role::Number)];
const BYTES: [Parameter; 2] = [p("OP1", Role::Byte), p("OP2", Role::Byte)];

const LOGIC: &[Parameter] = &[DEST, OPERANDS[0], OPERANDS[1], OPERANDS[2], OPERANDS[3]];
const FF: &[Parameter] =
    &[DEST, p("S", Role::Boolean), p("R", Role::Boolean), p("PRIORITY", Role::Priority)];
const TIMER: &[Parameter] =
    &[p("TMRNO", Role::TimerNumber), p("TYPE", Role::TimerType), INPUT, EDGE, p("K", Role::Quanta)];
const COUNTER: &[Parameter] = &[DEST_NUMBER, DIR, CLOCK, EDGE];
const DCOMP: &[Parameter] = &[DEST, BYTES[0], BYTES[1], p("M", Role::Constant)];
const ACOMP: &[Parameter] = &[DEST, NUMBERS[0], NUMBERS[1]];
const MOVE: &[Parameter] = &[
    TRIGGER,
    p("X", Role::Coordinate),
    p("Y", Role::Coordinate),
    p("HEADING", Role::Heading),
    EDGE,
];
const STC: &[Parameter] = &[DEST_BYTE, p("SRC", Role::Byte), COND, EDGE];
const STIC: &[Parameter] = &[DEST_BYTE, p("K", Role::Constant), COND, EDGE];
const OPER: &[Parameter] = &[DESTH, DESTL, NUMBERS[0], NUMBERS[1], p("SELOP", Role::Selector)];
const MUL: &[Parameter] = &[DESTH, DESTL, NUMBERS[0], NUMBERS[1]];
const EVENT: &[Parameter] = &[p("TYPE", Role::EventType), INPUT, EDGE];

impl fmt::Display for Mnemonic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl Role {
    /// Whether a resource stands there; otherwise it is a constant.
    pub fn is_resource(self) -> bool {
        self.range().is_none()
    }

    /// Whether the function writes to it.
    pub fn is_destination(self) -> bool {
        matches!(self, Self::BooleanDestination | Self::NumberDestination | Self::ByteDestination)
    }

    /// Smallest and greatest constant, or `None` where a resource stands.
    pub fn range(self) -> Option<(i32, i32)> {
        match self {
            Self::TimerNumber => Some((0, 31)),
            Self::TimerType | Self::Priority | Self::Selector => Some((0, 1)),
            Self::Edge => Some((0, 3)),
            Self::Quanta => Some((1, 255)),
            Self::Constant => Some((0, 255)),
            Self::EventType => Some((0, 15)),
            Self::Coordinate => Some((-32768, 32767)),
            Self::Heading => Some((-360, 360)),
            _ => None,
        }
    }

    /// Bytes of its encoding.
    pub const fn size_bytes(self) -> usize {
        match self {
            Self::Coordinate | Self::Heading => 2,
            _ => 1,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn opcodes_and_sizes_are_those_of_the_annex() {
        let table: Vec<(&str, u8, usize)> =
            Mnemonic::ALL.iter().map(|m| (m.name(), m.opcode(), m.size_bytes())).collect();
        let expected = [
            ("AND", 0x04, 6),
            ("NAND", 0x05, 6),
            ("OR", 0x06, 6),
            ("NOR", 0x07, 6),
            ("XOR", 0x08, 6),
            ("FF", 0x09, 5),
            ("TIMER", 0x0A, 6),
            ("COUNTER", 0x0B, 5),
            ("DCOMP", 0x0C, 5),
            ("ACOMP", 0x0D, 4),
            ("MOVE", 0x0E, 9),
            ("STC", 0x10, 5),
            ("STIC", 0x11, 5),
            ("OPER", 0x12, 6),
            ("MUL", 0x13, 5),
            ("EVENT", 0x16, 4),
        ];
        assert_eq!(table, expected);
    }

    #[test]
    fn names_and_opcodes_lead_back() {
        for &mnemonic in Mnemonic::ALL {
            assert_eq!(Mnemonic::by_name(&mnemonic.name().to_lowercase()), Some(mnemonic));
            assert_eq!(Mnemonic::by_opcode(mnemonic.opcode()), Some(mnemonic));
        }
        assert_eq!(Mnemonic::by_opcode(OPCODE_READ_INPUTS), None);
        assert_eq!(Mnemonic::by_opcode(OPCODE_END_OF_CYCLE), None);
    }
}
