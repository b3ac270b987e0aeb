//! Reading little-endian fields off a body, one after the other.

/// What has not been read yet of a body.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fields<'a> {
    rest: &'a [u8],
}

impl<'a> Fields<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { rest: bytes }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.rest.is_empty()
    }

    pub(super) fn u8(&mut self) -> Option<u8> {
        let [byte] = self.array()?;
        Some(byte)
    }

    pub(super) fn u16(&mut self) -> Option<u16> {
        self.array().map(u16::from_le_bytes)
    }

    pub(super) fn i16(&mut self) -> Option<i16> {
        self.array().map(i16::from_le_bytes)
    }

    pub(super) fn i32(&mut self) -> Option<i32> {
        self.array().map(i32::from_le_bytes)
    }

    pub(super) fn bytes(&mut self, len: usize) -> Option<&'a [u8]> {
        let (head, rest) = self.rest.split_at_checked(len)?;
        self.rest = rest;
        Some(head)
    }

    /// A zero-terminated string; bytes that are not UTF-8 become U+FFFD. A string that the packet
    /// cuts short ends where the packet ends.
    pub(super) fn string(&mut self) -> Option<String> {
        if self.rest.is_empty() {
            return None;
        }
        let mut parts = self.rest.splitn(2, |&byte| byte == 0);
        let text = String::from_utf8_lossy(parts.next()?).into_owned();
        self.rest = parts.next().unwrap_or_default();
        Some(text)
    }

    fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (head, rest) = self.rest.split_first_chunk()?;
        self.rest = rest;
        Some(*head)
    }
}

/// Appends a zero-terminated string; a zero inside ends it early, as it would for the reader.
pub(super) fn push_string(text: &str, out: &mut Vec<u8>) {
    out.extend(text.bytes().take_while(|&byte| byte != 0));
    out.push(0);
}
