//! MAT files of level 5: the numeric matrices of a MATLAB workspace, read and written.
//!
//! Reads every numeric class, complex parts left aside, stored in any of the smaller types that MATLAB chooses,
//! compressed or not, in both byte orders; and logical matrices as 0 and 1. Texts, cells, structures, sparse
//! matrices and objects are named and left out. Every length is compared with the bytes that are left; what is
//! unpacked is bounded.
//!
//! Source: `MathWorks`, "MAT-File Format" (level 5: header, data elements, tables 1-1 to 1-3; array flags).

use std::{fmt, io::Read};

use flate2::{Compression, bufread::ZlibDecoder, write::ZlibEncoder};

/// Bytes before the first element.
pub(crate) const HEADER: usize = 128;

const MI_INT8: u32 = 1;
const MI_INT32: u32 = 5;
const MI_UINT32: u32 = 6;
const MI_DOUBLE: u32 = 9;
const MI_MATRIX: u32 = 14;
const MI_COMPRESSED: u32 = 15;
/// Array classes: names of those that are not read, and the first and last numeric one.
const CLASS_DOUBLE: u8 = 6;
const CLASS_UINT64: u8 = 15;
const FLAG_LOGICAL: u32 = 0x0200;
/// No matrix of ours has more dimensions.
const DIMENSIONS_MAX: usize = 32;

/// A numeric matrix.
#[derive(Clone, Debug, PartialEq)]
pub struct Matrix {
    /// The variable's name.
    pub name: String,
    /// Rows, columns, and further dimensions; at least two.
    pub dimensions: Vec<usize>,
    /// Its class in MATLAB, such as `double` or `uint8`.
    pub class: Class,
    /// The values, column after column: row `r` of column `c` is at `c * rows + r`.
    pub values: Vec<f64>,
}

/// Classes of numeric matrices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Class {
    /// 64-bit floating point.
    Double,
    /// 32-bit floating point.
    Single,
    /// Signed integers of so many bits.
    Int(u8),
    /// Unsigned integers of so many bits.
    Uint(u8),
    /// True or false.
    Logical,
}

impl fmt::Display for Class {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Double => f.write_str("double"),
            Self::Single => f.write_str("single"),
            Self::Int(bits) => write!(f, "int{bits}"),
            Self::Uint(bits) => write!(f, "uint{bits}"),
            Self::Logical => f.write_str("logical"),
        }
    }
}

impl Matrix {
    /// Rows.
    pub fn n_rows(&self) -> usize {
        self.dimensions.first().copied().unwrap_or(0)
    }

    /// Columns; those of all further dimensions side by side.
    pub fn n_columns(&self) -> usize {
        self.values.len().checked_div(self.n_rows()).unwrap_or(0)
    }

    /// The value in a row and a column, from 0.
    ///
    /// # Panics
    ///
    /// When there is no such row or column.
    pub fn at(&self, row: usize, column: usize) -> f64 {
        assert!(row < self.n_rows(), "row {row} of {}", self.n_rows());
        self.values[column * self.n_rows() + row]
    }

    /// One row, from left to right.
    pub fn row(&self, row: usize) -> impl Iterator<Item = f64> + '_ {
        (0..self.n_columns()).map(move |column| self.at(row, column))
    }
}

/// A part of a MAT file that was not read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unread {
    /// Where its element begins.
    pub byte: usize,
    /// What it is, or what is wrong with it.
    pub what: String,
}

/// The numeric matrices of a MAT file, in its order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MatFile {
    /// The matrices.
    pub matrices: Vec<Matrix>,
    /// What else is there: other classes, and parts that are damaged.
    pub unread: Vec<Unread>,
}

/// A file that is no MAT file of level 5.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum MatError {
    /// The header is another one.
    #[error("no MAT file of level 5: {0}")]
    Header(String),
    /// The matrices unpack to more than was allowed.
    #[error("the matrices unpack to more than {bytes_max} bytes")]
    TooLarge {
        /// What was allowed.
        bytes_max: usize,
    },
}

impl MatFile {
    /// Reads the matrices of a file; compressed ones may unpack to `bytes_max` bytes together. A file that is cut off is
    /// read as far as it goes.
    ///
    /// # Errors
    ///
    /// [`MatError`] when the header is none, or too much would be unpacked.
    pub fn parse(bytes: &[u8], bytes_max: usize) -> Result<Self, MatError> {
        let order = header_order(bytes)?;
        let mut file = Self::default();
        let mut budget = bytes_max;
        let mut source = Source { bytes, at: HEADER, order };
        while source.at < bytes.len() {
            let byte = source.at;
            let element = match source.element() {
                Ok(element) => element,
                Err(what) => {
                    file.unread.push(Unread { byte, what });
                    break;
                }
            };
            let outcome = if element.kind == MI_COMPRESSED {
                let (unpacked, problem) =
                    unpack(element.data, &mut budget).ok_or(MatError::TooLarge { bytes_max })?;
                let mut inner = Source { bytes: &unpacked, at: 0, order };
                let outcome = inner.element().and_then(|inner| matrix_of(inner, order));
                outcome.map_err(|what| problem.map_or(what.clone(), |p| format!("{what} ({p})")))
            } else {
                matrix_of(element, order)
            };
            match outcome {
                Ok(matrix) => file.matrices.push(matrix),
                Err(what) => file.unread.push(Unread { byte, what }),
            }
        }
        Ok(file)
    }

    /// The matrix of that name; of several the last one, as MATLAB would load it.
    pub fn matrix(&self, name: &str) -> Option<&Matrix> {
        self.matrices.iter().rev().find(|m| m.name == name)
    }

    /// What is in the file, in words.
    pub(crate) fn contents(&self) -> String {
        let matrices = self.matrices.iter().map(|m| {
            let size: Vec<String> = m.dimensions.iter().map(ToString::to_string).collect();
            format!("{} ({} {})", crate::numbers::shown(&m.name), size.join("×"), m.class)
        });
        let parts: Vec<String> =
            matrices.chain(self.unread.iter().map(|u| u.what.clone())).take(20).collect();
        if parts.is_empty() { "no matrix".to_owned() } else { parts.join(", ") }
    }
}

/// A MAT file of these matrices of doubles, compressed, little endian. Equal matrices give equal bytes. Names
/// are cut to 63 characters.
pub fn write(matrices: &[Matrix]) -> Vec<u8> {
    let mut out = b"MATLAB 5.0 MAT-file, written by cairn".to_vec();
    out.resize(116, b' ');
    out.resize(124, 0);
    out.extend([0x00, 0x01]);
    out.extend(b"IM");
    for matrix in matrices {
        let mut body = Vec::new();
        put(&mut body, MI_UINT32, &[u32::from(CLASS_DOUBLE).to_le_bytes(), [0; 4]].concat());
        let size = |n: &usize| i32::try_from(*n).unwrap_or(i32::MAX).to_le_bytes();
        put(&mut body, MI_INT32, &matrix.dimensions.iter().flat_map(size).collect::<Vec<u8>>());
        let name: Vec<u8> = matrix.name.bytes().filter(u8::is_ascii).take(63).collect();
        put(&mut body, MI_INT8, &name);
        let values = matrix.values.iter().flat_map(|v| v.to_le_bytes());
        put(&mut body, MI_DOUBLE, &values.collect::<Vec<u8>>());
        let mut element = Vec::new();
        put(&mut element, MI_MATRIX, &body);
        let packed = pack(&element);
        // A compressed element has no padding.
        out.extend(MI_COMPRESSED.to_le_bytes());
        out.extend(u32::try_from(packed.len()).unwrap_or(u32::MAX).to_le_bytes());
        out.extend(packed);
    }
    out
}

/// Whether the bytes have the header of a MAT file of level 5.
pub(crate) fn is_mat(bytes: &[u8]) -> bool {
    bytes.len() >= HEADER && header_order(bytes).is_ok()
}

#[derive(Clone, Copy, PartialEq)]
enum Order {
    Little,
    Big,
}

fn header_order(bytes: &[u8]) -> Result<Order, MatError> {
    let Some(mark) = bytes.get(124..HEADER) else {
        let found = format!("{} bytes, the header alone has {HEADER}", bytes.len());
        return Err(MatError::Header(found));
    };
    match mark {
        [_, 0x01, b'I', b'M'] => Ok(Order::Little),
        [0x01, _, b'M', b'I'] => Ok(Order::Big),
        [.., b'I', b'M'] | [.., b'M', b'I'] => {
            Err(MatError::Header(format!("its version is {:02x}{:02x}", mark[0], mark[1])))
        }
        _ => Err(MatError::Header("no endian indicator at byte 126".to_owned())),
    }
}

/// Unpacks within the budget: what came out, and what was wrong if it ended early. `None`: too much.
fn unpack(packed: &[u8], budget: &mut usize) -> Option<(Vec<u8>, Option<String>)> {
    let mut out = Vec::new();
    let limit = u64::try_from(*budget).unwrap_or(u64::MAX).saturating_add(1);
    let mut limited = ZlibDecoder::new(packed).take(limit);
    let problem = limited.read_to_end(&mut out).err().map(|e| e.to_string());
    *budget = budget.checked_sub(out.len())?;
    Some((out, problem))
}

fn pack(bytes: &[u8]) -> Vec<u8> {
    use std::io::Write;
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
    // Writing to memory does not fail.
    encoder.write_all(bytes).and_then(|()| encoder.finish()).unwrap_or_default()
}

/// Appends an element, padded to eight bytes.
fn put(out: &mut Vec<u8>, kind: u32, data: &[u8]) {
    out.extend(kind.to_le_bytes());
    out.extend(u32::try_from(data.len()).unwrap_or(u32::MAX).to_le_bytes());
    out.extend(data);
    out.resize(out.len().next_multiple_of(8), 0);
}

/// An element: its type and its bytes.
#[derive(Clone, Copy)]
struct Element<'a> {
    kind: u32,
    data: &'a [u8],
}

/// Takes elements off bytes.
struct Source<'a> {
    bytes: &'a [u8],
    at: usize,
    order: Order,
}

impl<'a> Source<'a> {
    fn element(&mut self) -> Result<Element<'a>, String> {
        let left = self.bytes.get(self.at..).unwrap_or_default();
        let Some((tag, rest)) = left.split_at_checked(8) else {
            return Err("the file ends in the tag of an element".to_owned());
        };
        let first = self.order.u32(&tag[..4]);
        let second = self.order.u32(&tag[4..]);
        if first >> 16 != 0 {
            // The small format: length and type share a word, the data follow in the same eight bytes.
            let length = (first >> 16) as usize;
            let data = tag[4..].get(..length).ok_or("a small element of more than four bytes")?;
            self.at += 8;
            return Ok(Element { kind: first & 0xffff, data });
        }
        let length = usize::try_from(second).unwrap_or(usize::MAX);
        let Some(data) = rest.get(..length) else {
            return Err(format!("an element of {length} bytes, {} are left", rest.len()));
        };
        let padded = if first == MI_COMPRESSED { length } else { length.next_multiple_of(8) };
        self.at += 8 + padded.min(rest.len());
        Ok(Element { kind: first, data })
    }
}

impl Order {
    fn u32(self, bytes: &[u8]) -> u32 {
        let four = bytes.first_chunk().copied().unwrap_or_default();
        match self {
            Self::Little => u32::from_le_bytes(four),
            Self::Big => u32::from_be_bytes(four),
        }
    }

    /// Each `N` bytes as a number.
    fn numbers<const N: usize>(self, bytes: &[u8], number: impl Fn([u8; N]) -> f64) -> Vec<f64> {
        let turned = |chunk: &[u8; N]| {
            let mut chunk = *chunk;
            if self == Self::Big {
                chunk.reverse();
            }
            number(chunk)
        };
        bytes.as_chunks::<N>().0.iter().map(turned).collect()
    }
}

fn matrix_of(element: Element<'_>, order: Order) -> Result<Matrix, String> {
    if element.kind != MI_MATRIX {
        return Err(format!("an element of type {}", element.kind));
    }
    let mut source = Source { bytes: element.data, at: 0, order };
    let flags = source.element()?;
    if flags.kind != MI_UINT32 || flags.data.len() != 8 {
        return Err("a matrix without flags".to_owned());
    }
    let flags = order.u32(flags.data);
    let dimensions = dimensions(source.element()?, order)?;
    let name = source.element()?;
    let name = String::from_utf8_lossy(name.data).trim_end_matches('\0').to_owned();
    let class = (flags & 0xff) as u8;
    let Some(class) = class_of(class, flags & FLAG_LOGICAL != 0) else {
        return Err(format!("{} (class {})", crate::numbers::shown(&name), class_name(class)));
    };
    let values = values(source.element()?, order)?;
    let n = dimensions.iter().try_fold(1_usize, |n, d| n.checked_mul(*d));
    if n != Some(values.len()) {
        let size: Vec<String> = dimensions.iter().map(ToString::to_string).collect();
        let (name, found) = (crate::numbers::shown(&name), values.len());
        return Err(format!("{name}: {found} values for a size of {}", size.join("×")));
    }
    Ok(Matrix { name, dimensions, class, values })
}

fn dimensions(element: Element<'_>, order: Order) -> Result<Vec<usize>, String> {
    let n = element.data.len() / 4;
    if element.kind != MI_INT32 || !(2..=DIMENSIONS_MAX).contains(&n) {
        return Err("a matrix without a size".to_owned());
    }
    let size = |b: &[u8; 4]| {
        let value = order.u32(b).cast_signed();
        usize::try_from(value).map_err(|_e| format!("a size of {value}"))
    };
    element.data.as_chunks().0.iter().map(size).collect()
}

fn class_of(class: u8, is_logical: bool) -> Option<Class> {
    if is_logical && (CLASS_DOUBLE..=CLASS_UINT64).contains(&class) {
        return Some(Class::Logical);
    }
    Some(match class {
        6 => Class::Double,
        7 => Class::Single,
        8 => Class::Int(8),
        9 => Class::Uint(8),
        10 => Class::Int(16),
        11 => Class::Uint(16),
        12 => Class::Int(32),
        13 => Class::Uint(32),
        14 => Class::Int(64),
        15 => Class::Uint(64),
        _ => return None,
    })
}

fn class_name(class: u8) -> &'static str {
    match class {
        1 => "cell",
        2 => "struct",
        3 => "object",
        4 => "char",
        5 => "sparse",
        16 => "function",
        17 => "opaque",
        _ => "unknown",
    }
}

/// Values of any storage type; 64-bit integers beyond 2⁵³ are rounded.
fn values(element: Element<'_>, order: Order) -> Result<Vec<f64>, String> {
    let data = element.data;
    Ok(match element.kind {
        MI_INT8 => order.numbers(data, |b| f64::from(i8::from_le_bytes(b))),
        2 => order.numbers(data, |b| f64::from(u8::from_le_bytes(b))),
        3 => order.numbers(data, |b| f64::from(i16::from_le_bytes(b))),
        4 => order.numbers(data, |b| f64::from(u16::from_le_bytes(b))),
        MI_INT32 => order.numbers(data, |b| f64::from(i32::from_le_bytes(b))),
        MI_UINT32 => order.numbers(data, |b| f64::from(u32::from_le_bytes(b))),
        7 => order.numbers(data, |b| f64::from(f32::from_le_bytes(b))),
        MI_DOUBLE => order.numbers(data, f64::from_le_bytes),
        12 => order.numbers(data, |b| i64::from_le_bytes(b) as f64),
        13 => order.numbers(data, |b| u64::from_le_bytes(b) as f64),
        other => return Err(format!("values of storage type {other}")),
    })
}

#[cfg(test)]
#[path = "mat_tests.rs"]
mod tests;
