//! From the bytes of a file to a text with lines, whatever editor wrote it.
//!
//! Programs come from many hands and many years: with a byte-order mark, in UTF-16, in Latin-1, with
//! the line ends of three families of computers, padded after an end-of-file character. All of
//! that is read; what had to be guessed is said ([`Code::OtherEncoding`](crate::Code)).

/// Bytes of text that are compiled at most: 4 MB, a thousand times what the target holds.
pub const SOURCE_BYTES_MAX: usize = 4 * 1024 * 1024;

/// How the bytes of a text were read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Encoding {
    /// As UTF-8, which plain ASCII is too.
    #[default]
    Utf8,
    /// As UTF-16 of either byte order.
    Utf16,
    /// Lines that are not UTF-8 one character a byte (ISO 8859-1); all others as UTF-8.
    Latin1,
}

/// A text and how it was read.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SourceText {
    /// The text. A byte-order mark and line ends of any kind are still in it.
    pub text: String,
    /// How its bytes were read.
    pub encoding: Encoding,
    /// First line, from 1, that is not UTF-8.
    pub first_odd_line: usize,
    /// How many lines are not UTF-8.
    pub n_odd_lines: usize,
}

/// Reads the bytes of a file as a text. Cannot fail: every byte means something in Latin-1.
///
/// Cost: linear in the bytes.
pub fn read_source(bytes: &[u8]) -> SourceText {
    if let Some(text) = utf_16(bytes) {
        let n_odd_lines = lines(&text).count();
        return SourceText { text, encoding: Encoding::Utf16, first_odd_line: 1, n_odd_lines };
    }
    if let Ok(text) = std::str::from_utf8(bytes) {
        return SourceText { text: text.to_owned(), ..SourceText::default() };
    }
    let mut read = SourceText { encoding: Encoding::Latin1, ..SourceText::default() };
    let mut number: usize = 0;
    // Split at each kind of line end, which stays with its line; `\r\n` makes an empty piece.
    for line in bytes.split_inclusive(|&byte| matches!(byte, b'\n' | b'\r')) {
        let ends_pair = line == b"\n" && read.text.ends_with('\r');
        number = number.saturating_add(usize::from(!ends_pair));
        if let Ok(line) = std::str::from_utf8(line) {
            read.text.push_str(line);
            continue;
        }
        read.text.extend(line.iter().map(|&byte| char::from(byte)));
        read.n_odd_lines = read.n_odd_lines.saturating_add(1);
        if read.first_odd_line == 0 {
            read.first_odd_line = number;
        }
    }
    read
}

/// The text, if the bytes look like UTF-16: a byte-order mark, or a zero in every second place of
/// a beginning that no text has otherwise.
fn utf_16(bytes: &[u8]) -> Option<String> {
    let (body, is_little) = match bytes {
        [0xFF, 0xFE, body @ ..] => (body, true),
        [0xFE, 0xFF, body @ ..] => (body, false),
        [1..=0x7F, 0, 1..=0x7F, 0, ..] => (bytes, true),
        [0, 1..=0x7F, 0, 1..=0x7F, ..] => (bytes, false),
        _ => return None,
    };
    let (pairs, odd) = body.as_chunks::<2>();
    let units = pairs
        .iter()
        .map(|&pair| if is_little { u16::from_le_bytes(pair) } else { u16::from_be_bytes(pair) });
    let characters = char::decode_utf16(units).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER));
    let half = (!odd.is_empty()).then_some(char::REPLACEMENT_CHARACTER);
    Some(characters.chain(half).collect())
}

/// The lines of a text with their offsets: line ends are `\n`, `\r\n` and `\r`, in any mixture, and
/// are not part of the line; a byte-order mark before the first is not either.
pub(crate) fn lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let mut start = if text.starts_with('\u{FEFF}') { '\u{FEFF}'.len_utf8() } else { 0 };
    std::iter::from_fn(move || {
        let rest = text.get(start..).filter(|rest| !rest.is_empty())?;
        let len = rest.find(['\n', '\r']).unwrap_or(rest.len());
        let line = rest.get(..len).unwrap_or(rest);
        let end = rest.get(len..).unwrap_or("");
        let end_len = if end.starts_with("\r\n") { 2 } else { usize::from(!end.is_empty()) };
        let at = start;
        start = start.saturating_add(len).saturating_add(end_len);
        Some((at, line))
    })
}

/// Where the text ends: at the end-of-file character of CP/M and DOS, if it has one. The second
/// value is where something other than padding follows.
pub(crate) fn end_of_text(text: &str) -> (usize, Option<usize>) {
    let Some(end) = text.find(END_OF_FILE) else { return (text.len(), None) };
    let rest = text.get(end..).unwrap_or("");
    let is_padding = |c: char| c == END_OF_FILE || c == '\0' || c.is_whitespace();
    (end, rest.find(|c| !is_padding(c)).map(|at| end.saturating_add(at)))
}

const END_OF_FILE: char = '\u{1A}';

#[cfg(test)]
mod tests {
    use super::*;

    const PROGRAM: &str = "AND O0,I0,1L,1L,1L ; für\nOR O1,I0,0L,0L,0L";

    #[test]
    fn utf_16_of_both_orders_is_read_with_and_without_a_mark() {
        for (little, mark) in [(true, true), (false, true), (true, false), (false, false)] {
            let units = mark.then_some(0xFEFF).into_iter().chain(PROGRAM.encode_utf16());
            let bytes: Vec<u8> = units
                .flat_map(|u: u16| if little { u.to_le_bytes() } else { u.to_be_bytes() })
                .collect();
            let read = read_source(&bytes);
            assert_eq!((read.text.as_str(), read.encoding), (PROGRAM, Encoding::Utf16));
        }
        // Cut in the middle of a character: said, not swallowed.
        assert!(read_source(b"\xFF\xFEA\0N").text.ends_with(char::REPLACEMENT_CHARACTER));
    }

    #[test]
    fn latin_1_is_read_line_by_line() {
        let read = read_source(b"; f\xFCr\r\n; f\xC3\xBCr\r; \xE4\n;");
        assert_eq!(read.text, "; für\r\n; für\r; ä\n;");
        assert_eq!((read.first_odd_line, read.n_odd_lines), (1, 2));
        let read = read_source(b"\r\n\n\r; \xE4");
        assert_eq!((read.first_odd_line, read.encoding), (4, Encoding::Latin1));
    }

    #[test]
    fn every_kind_of_line_end_ends_a_line() {
        let found: Vec<_> = lines("\u{FEFF}a\r\nb\rc\n\nd\n\re").collect();
        assert_eq!(found, [(3, "a"), (6, "b"), (8, "c"), (10, ""), (11, "d"), (13, ""), (14, "e")]);
        assert_eq!(lines("").count(), 0);
        assert_eq!(lines("a\n").count(), 1);
    }

    #[test]
    fn padding_after_the_end_of_file_is_no_text() {
        assert_eq!(end_of_text("a\n"), (2, None));
        assert_eq!(end_of_text("a\n\u{1A}\u{1A}\0 \r\n"), (2, None));
        assert_eq!(end_of_text("a\n\u{1A}\nb"), (2, Some(4)));
    }
}
