//! What a host asks an RPLIDAR.

use super::START;
use crate::search::{Found, Search};

/// Longest payload of a request, bytes.
const PAYLOAD_MAX: usize = 255;

/// A request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Request {
    /// `25`: ends a scan. No answer.
    Stop,
    /// `40`: restarts the device. No answer.
    Reset,
    /// `20`: samples, once the speed is stable.
    Scan,
    /// `21`: samples at once.
    ForceScan,
    /// `50`: who are you?
    Info,
    /// `52`: how are you?
    Health,
    /// `59`: how long does a sample take?
    SampleTimes,
    /// `F0`: the motor's PWM, 0 to 1023, 0 stops it. No answer.
    MotorPwm(u16),
    /// `FF`: can you drive the motor?
    AdapterFlags,
    /// A request that means nothing here: command and payload.
    Other(u8, Vec<u8>),
}

impl Request {
    fn command(&self) -> u8 {
        match self {
            Self::Scan => 0x20,
            Self::ForceScan => 0x21,
            Self::Stop => 0x25,
            Self::Reset => 0x40,
            Self::Info => 0x50,
            Self::Health => 0x52,
            Self::SampleTimes => 0x59,
            Self::MotorPwm(_) => 0xF0,
            Self::AdapterFlags => 0xFF,
            Self::Other(command, _) => *command,
        }
    }

    /// Appends the bytes on the line; of a longer payload the first 255 bytes.
    pub fn encode(&self, out: &mut Vec<u8>) {
        let command = self.command();
        let start = out.len();
        out.extend_from_slice(&[START, command]);
        if command & 0x80 == 0 {
            return;
        }
        let pwm;
        let payload: &[u8] = match self {
            Self::MotorPwm(value) => {
                pwm = value.to_le_bytes();
                &pwm
            }
            Self::AdapterFlags => &[0; 4],
            Self::Other(_, payload) => payload.get(..PAYLOAD_MAX).unwrap_or(payload),
            _ => &[],
        };
        out.push(u8::try_from(payload.len()).unwrap_or(u8::MAX));
        out.extend_from_slice(payload);
        let sum = out.get(start..).unwrap_or_default().iter().fold(0, |sum, byte| sum ^ byte);
        out.push(sum);
    }

    fn decode(command: u8, payload: &[u8]) -> Self {
        match (command, payload) {
            (0x20, []) => Self::Scan,
            (0x21, []) => Self::ForceScan,
            (0x25, []) => Self::Stop,
            (0x40, []) => Self::Reset,
            (0x50, []) => Self::Info,
            (0x52, []) => Self::Health,
            (0x59, []) => Self::SampleTimes,
            (0xF0, &[low, high]) => Self::MotorPwm(u16::from_le_bytes([low, high])),
            (0xFF, _) => Self::AdapterFlags,
            _ => Self::Other(command, payload.to_vec()),
        }
    }
}

/// Finds requests in received bytes.
///
/// Cost: at most 260 steps per received byte; at most 259 bytes stay behind between calls.
#[derive(Clone, Debug)]
pub struct RequestDecoder {
    search: Search,
    n_requests: u64,
    n_bad_checksums: u64,
}

impl RequestDecoder {
    /// A decoder that has heard nothing.
    pub fn new() -> Self {
        Self { search: Search::new(), n_requests: 0, n_bad_checksums: 0 }
    }

    /// Appends received bytes. Of more than 65 536 bytes not yet asked for, the oldest are dropped and
    /// counted as skipped.
    pub fn push(&mut self, bytes: &[u8]) {
        self.search.push(bytes);
    }

    /// The next whole request, or `None` until more bytes come.
    pub fn next_request(&mut self) -> Option<Request> {
        let n_bad_checksums = &mut self.n_bad_checksums;
        let examine = |bytes: &[u8]| {
            let Some(&command) = bytes.get(1) else { return Found::Unfinished };
            if command == START {
                return Found::Noise;
            }
            if command & 0x80 == 0 {
                return Found::Whole(Request::decode(command, &[]), 2);
            }
            let Some(&len) = bytes.get(2) else { return Found::Unfinished };
            let whole = bytes.get(..usize::from(len).saturating_add(4));
            let Some((sum, before)) = whole.and_then(<[u8]>::split_last) else {
                return Found::Unfinished;
            };
            if before.iter().fold(0, |sum, byte| sum ^ byte) == *sum {
                let request = Request::decode(command, before.get(3..).unwrap_or_default());
                return Found::Whole(request, before.len().saturating_add(1));
            }
            *n_bad_checksums = n_bad_checksums.saturating_add(1);
            Found::Noise
        };
        let request = self.search.next(|byte| byte == START, examine)?;
        self.n_requests = self.n_requests.saturating_add(1);
        Some(request)
    }

    /// Gives up a request that began and did not end, as after a silence; says whether there was one.
    pub fn give_up_unfinished(&mut self) -> bool {
        self.search.give_up_unfinished()
    }

    /// Requests so far, whether or not they mean something.
    pub fn n_requests(&self) -> u64 {
        self.n_requests
    }

    /// Bytes thrown away as noise so far.
    pub fn n_bytes_skipped(&self) -> u64 {
        self.search.n_skipped()
    }

    /// Requests so far whose sum was wrong.
    pub fn n_bad_checksums(&self) -> u64 {
        self.n_bad_checksums
    }

    #[cfg(test)]
    pub(crate) fn n_unread(&self) -> usize {
        self.search.unread().len()
    }
}

impl Default for RequestDecoder {
    fn default() -> Self {
        Self::new()
    }
}
