//! The bytes that go into the memory of the target, and back.
//!
//! An image is 0x00 (read the inputs), the functions in order, 0x0F (write the outputs, end of
//! cycle). Each function is its opcode and its operands: resources and small constants in one
//! byte, coordinates and headings in two, high byte first.

use std::fmt::Write as _;

use crate::{
    Code, Function, Mnemonic, OPCODE_END_OF_CYCLE, OPCODE_READ_INPUTS, Operand, OperandKind,
    Parameter, Program, ResourceId, Role, Span,
};

/// Bytes of program memory on the target (4 KB of EEPROM).
pub const IMAGE_BYTES_MAX: usize = 4096;

/// Why bytes are not the image of a program.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ImageError {
    /// The first byte is not 0x00.
    #[error("an image begins with 0x00 (read inputs), this one does not")]
    NoStart,
    /// No function has that opcode.
    #[error("byte {offset} is 0x{opcode:02X}, which is no opcode")]
    UnknownOpcode {
        /// Offset in the image.
        offset: usize,
        /// What stands there.
        opcode: u8,
    },
    /// The bytes end inside an instruction, or before 0x0F.
    #[error("the image ends at byte {offset}, before its 0x0F (end of cycle)")]
    Truncated {
        /// Offset of the instruction that is cut off.
        offset: usize,
    },
    /// No resource has that address.
    #[error("byte {offset} is 0x{address:02X}, which is the address of no resource")]
    UnknownAddress {
        /// Offset in the image.
        offset: usize,
        /// What stands there.
        address: u8,
    },
    /// A constant outside the range of its operand.
    #[error("{name} of {mnemonic} at byte {offset} is {value}, outside its range")]
    ValueOutOfRange {
        /// Offset in the image.
        offset: usize,
        /// The function.
        mnemonic: Mnemonic,
        /// The operand.
        name: &'static str,
        /// What stands there.
        value: i32,
    },
    /// Something other than padding follows the end of cycle.
    #[error("byte {offset}, after the end of cycle, is not 0x00")]
    Trailing {
        /// Offset in the image.
        offset: usize,
    },
}

impl ImageError {
    /// The problem code it falls under.
    pub fn code(self) -> Code {
        match self {
            Self::NoStart | Self::Truncated { .. } | Self::Trailing { .. } => Code::TruncatedImage,
            Self::UnknownOpcode { .. } => Code::UnknownOpcode,
            Self::UnknownAddress { .. } => Code::UnknownAddress,
            Self::ValueOutOfRange { .. } => Code::ImageValueOutOfRange,
        }
    }
}

impl Program {
    /// Its encoding, padded with 0x00 to `size` bytes, as the thesis's compiler writes it; `None`
    /// when it does not fit.
    pub fn fixed_size_image(&self, size: usize) -> Option<Vec<u8>> {
        let padding = size.checked_sub(self.image.len())?;
        Some([&self.image, vec![0; padding].as_slice()].concat())
    }
}

pub(crate) fn encode(functions: &[Function]) -> Vec<u8> {
    let mut bytes = vec![OPCODE_READ_INPUTS];
    for function in functions {
        bytes.push(function.mnemonic.opcode());
        for operand in &function.operands {
            match operand.kind {
                OperandKind::Resource(id) => bytes.push(id.address()),
                // Both casts keep the low bits; the parser has checked the range.
                OperandKind::Immediate(value) if operand.role.size_bytes() == 2 => {
                    bytes.extend((value as i16).to_be_bytes());
                }
                OperandKind::Immediate(value) => bytes.push(value as u8),
            }
        }
    }
    bytes.push(OPCODE_END_OF_CYCLE);
    bytes
}

/// Reads an image back. The program's source is written anew, one function a line, so that its
/// spans and lines mean something; compiling that source gives the same image, if a compiler
/// made it.
///
/// # Errors
///
/// [`ImageError`] at the first byte that cannot stand where it stands. Padding with 0x00 after
/// the end of cycle is allowed.
pub fn decode(image: &[u8]) -> Result<Program, ImageError> {
    let mut decoder = Decoder { image, offset: 0, source: String::new(), functions: Vec::new() };
    if decoder.next_byte(0)? != OPCODE_READ_INPUTS {
        return Err(ImageError::NoStart);
    }
    while decoder.function()? {}
    let end = decoder.offset;
    let mut rest = image.iter().enumerate().skip(end);
    if let Some((offset, _)) = rest.find(|&(_, &byte)| byte != 0) {
        return Err(ImageError::Trailing { offset });
    }
    let image = image.get(..end).unwrap_or(image).into();
    Ok(Program { source: decoder.source.into(), functions: decoder.functions, image })
}

/// Whether an image decodes to these functions. Keeps one function at a time.
pub(crate) fn decodes_to(image: &[u8], functions: &[Function]) -> bool {
    let mut decoder = Decoder { image, offset: 0, source: String::new(), functions: Vec::new() };
    if decoder.next_byte(0) != Ok(OPCODE_READ_INPUTS) {
        return false;
    }
    for function in functions {
        decoder.source.clear();
        decoder.functions.clear();
        let is_same = decoder.function() == Ok(true)
            && decoder.functions.first().is_some_and(|decoded| {
                (decoded.mnemonic, decoded.address) == (function.mnemonic, function.address)
                    && kinds(decoded).eq(kinds(function))
            });
        if !is_same {
            return false;
        }
    }
    decoder.function() == Ok(false) && decoder.offset == image.len()
}

fn kinds(function: &Function) -> impl Iterator<Item = OperandKind> + '_ {
    function.operands.iter().map(|operand| operand.kind)
}

struct Decoder<'i> {
    image: &'i [u8],
    offset: usize,
    source: String,
    functions: Vec<Function>,
}

impl Decoder<'_> {
    fn next_byte(&mut self, instruction: usize) -> Result<u8, ImageError> {
        let truncated = ImageError::Truncated { offset: instruction };
        let byte = *self.image.get(self.offset).ok_or(truncated)?;
        self.offset = self.offset.saturating_add(1);
        Ok(byte)
    }

    /// Decodes one instruction; false at the end of cycle.
    fn function(&mut self) -> Result<bool, ImageError> {
        let address = self.offset;
        let opcode = self.next_byte(address)?;
        if opcode == OPCODE_END_OF_CYCLE {
            return Ok(false);
        }
        let unknown = ImageError::UnknownOpcode { offset: address, opcode };
        let mnemonic = Mnemonic::by_opcode(opcode).ok_or(unknown)?;
        let (line, start) = (self.functions.len().saturating_add(1), self.source.len());
        let mut function = Function {
            line,
            span: Span { start, end: start },
            address,
            mnemonic,
            operands: Vec::with_capacity(mnemonic.parameters().len()),
        };
        self.source.push_str(mnemonic.name());
        self.source.push(' ');
        for (i, &parameter) in mnemonic.parameters().iter().enumerate() {
            if i > 0 {
                self.source.push(',');
            }
            let kind = self.operand(&function, parameter)?;
            function.operands.push(self.written(&function, parameter, kind));
        }
        function.span.end = self.source.len();
        self.source.push('\n');
        self.functions.push(function);
        Ok(true)
    }

    fn operand(
        &mut self,
        function: &Function,
        parameter: Parameter,
    ) -> Result<OperandKind, ImageError> {
        let offset = self.offset;
        let first = self.next_byte(function.address)?;
        let Some((min, max)) = parameter.role.range() else {
            let unknown = ImageError::UnknownAddress { offset, address: first };
            return ResourceId::from_address(first).map(OperandKind::Resource).ok_or(unknown);
        };
        let value = if parameter.role.size_bytes() == 2 {
            let second = self.next_byte(function.address)?;
            i32::from(i16::from_be_bytes([first, second]))
        } else {
            i32::from(first)
        };
        if !(min..=max).contains(&value) {
            let (mnemonic, name) = (function.mnemonic, parameter.name);
            return Err(ImageError::ValueOutOfRange { offset, mnemonic, name, value });
        }
        Ok(OperandKind::Immediate(value))
    }

    /// Writes the operand into the source.
    fn written(&mut self, function: &Function, parameter: Parameter, kind: OperandKind) -> Operand {
        let text = match (parameter.role, kind) {
            (Role::Direction, OperandKind::Resource(ResourceId::ONE)) => "UP".to_owned(),
            (Role::Direction, OperandKind::Resource(ResourceId::ZERO)) => "DOWN".to_owned(),
            (_, OperandKind::Resource(id)) => id.to_string(),
            (Role::Edge, OperandKind::Immediate(1)) => "RISE".to_owned(),
            (Role::Edge, OperandKind::Immediate(2)) => "FALL".to_owned(),
            (Role::TimerType, OperandKind::Immediate(0)) => "MONO".to_owned(),
            (Role::TimerType, OperandKind::Immediate(_)) => "OSC".to_owned(),
            (_, OperandKind::Immediate(value)) => value.to_string(),
        };
        let start = self.source.len();
        self.source.push_str(&text);
        Operand {
            span: Span { start, end: self.source.len() },
            line: function.line,
            // The text is ASCII: bytes are characters.
            column: start.saturating_sub(function.span.start).saturating_add(1),
            length: text.len(),
            text,
            name: parameter.name,
            role: parameter.role,
            kind,
        }
    }
}

/// Bytes as two hexadecimal digits each, with blanks between.
pub(crate) fn hex(bytes: &[u8]) -> String {
    let mut text = String::with_capacity(bytes.len().saturating_mul(3));
    for byte in bytes {
        let separator = if text.is_empty() { "" } else { " " };
        // Writing to a string cannot fail.
        let _always_fine = write!(text, "{separator}{byte:02X}");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_damage_is_told_apart_and_placed() {
        let name = "TMRNO";
        let table: [(&[u8], ImageError); 8] = [
            (&[], ImageError::Truncated { offset: 0 }),
            (&[0x0F], ImageError::NoStart),
            (&[0x00], ImageError::Truncated { offset: 1 }),
            (&[0x00, 0x0D, 0x40, 0x30], ImageError::Truncated { offset: 1 }),
            (&[0x00, 0x01, 0x0F], ImageError::UnknownOpcode { offset: 1, opcode: 1 }),
            (
                &[0x00, 0x0D, 0x40, 0xDA, 0x30, 0x0F],
                ImageError::UnknownAddress { offset: 3, address: 0xDA },
            ),
            (
                &[0x00, 0x0A, 0x20, 0x00, 0x00, 0x01, 0x0F, 0x0F],
                ImageError::ValueOutOfRange {
                    offset: 2,
                    mnemonic: Mnemonic::Timer,
                    name,
                    value: 32,
                },
            ),
            (&[0x00, 0x0F, 0x00, 0x02, 0x01], ImageError::Trailing { offset: 3 }),
        ];
        for (image, error) in table {
            assert_eq!(decode(image), Err(error), "{image:02X?}");
        }
        assert_eq!(decode(&[0x00, 0x0F, 0x00, 0x00]).map(|program| program.image().len()), Ok(2));
    }
}
