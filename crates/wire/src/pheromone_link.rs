//! The link between a robot and the pheromone server: one question, one answer.
//!
//! The robot sends where it is, the server answers what the left and the right antenna smell there.
//! Payloads travel in [`dle`](crate::dle) frames:
//!
//! | | bytes |
//! | --- | --- |
//! | request | `opcode, robot, x, x, y, y, heading, heading` (mm, mm, degrees; signed 16 bit) |
//! | reply | `opcode + 0x80, robot, left, right, 0, 0` |
//!
//! The server answers every opcode below 0x80 alike and echoes it, so a client may use it as a
//! number that tells a late reply from the awaited one.
//!
//! Source: the thesis, Annex B1 (`parse_buffer`, `make_packet`).

use crate::dle::{ByteOrder, Framing, PayloadError, write_frame};

/// The opcode to use when none is preferred; the thesis gives no values.
pub const OPCODE_LOCATE: u8 = 1;

/// Set in a reply's opcode.
const REPLY: u8 = 0x80;

/// A robot's question: what do I smell here?
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Request {
    /// Operation, 0 to 127; echoed by the reply.
    pub opcode: u8,
    /// Which robot asks; echoed by the reply.
    pub robot_id: u8,
    /// x in the map, mm.
    pub x_mm: i16,
    /// y in the map, mm.
    pub y_mm: i16,
    /// Heading in the map, degrees.
    pub heading_deg: i16,
}

/// The server's answer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Reply {
    /// The request's operation, 0 to 127; on the wire bit 7 is set.
    pub opcode: u8,
    /// Which robot had asked.
    pub robot_id: u8,
    /// Intensity at the left antenna.
    pub left: u8,
    /// Intensity at the right antenna.
    pub right: u8,
}

impl Request {
    /// Length of the payload, bytes.
    pub const PAYLOAD_LEN: usize = 8;

    /// The payload, before framing.
    pub fn payload(&self, order: ByteOrder) -> [u8; Self::PAYLOAD_LEN] {
        let [x, y, heading] = [self.x_mm, self.y_mm, self.heading_deg].map(|v| order.bytes(v));
        let ([x0, x1], [y0, y1], [h0, h1]) = (x, y, heading);
        [self.opcode & !REPLY, self.robot_id, x0, x1, y0, y1, h0, h1]
    }

    /// Appends the framed request to `out`.
    pub fn encode(&self, order: ByteOrder, framing: Framing, out: &mut Vec<u8>) {
        write_frame(&self.payload(order), framing, out);
    }

    /// Reads a frame's payload.
    ///
    /// # Errors
    ///
    /// [`PayloadError`] when it is not 8 bytes long, or is marked as a reply.
    pub fn decode(payload: &[u8], order: ByteOrder) -> Result<Self, PayloadError> {
        let kind = "pheromone request";
        let length = PayloadError::Length { kind, len: payload.len(), expected: Self::PAYLOAD_LEN };
        let &[opcode, robot_id, x0, x1, y0, y1, h0, h1] = payload else { return Err(length) };
        if opcode & REPLY != 0 {
            return Err(PayloadError::Opcode { kind, opcode });
        }
        Ok(Self {
            opcode,
            robot_id,
            x_mm: order.number([x0, x1]),
            y_mm: order.number([y0, y1]),
            heading_deg: order.number([h0, h1]),
        })
    }

    /// The reply to this request.
    pub fn reply(&self, left: u8, right: u8) -> Reply {
        Reply { opcode: self.opcode & !REPLY, robot_id: self.robot_id, left, right }
    }
}

impl Reply {
    /// Length of the payload, bytes.
    pub const PAYLOAD_LEN: usize = 6;

    /// The payload, before framing.
    pub fn payload(&self) -> [u8; Self::PAYLOAD_LEN] {
        [self.opcode | REPLY, self.robot_id, self.left, self.right, 0, 0]
    }

    /// Appends the framed reply to `out`.
    pub fn encode(&self, framing: Framing, out: &mut Vec<u8>) {
        write_frame(&self.payload(), framing, out);
    }

    /// Reads a frame's payload. The last two bytes are ignored.
    ///
    /// # Errors
    ///
    /// [`PayloadError`] when it is not 6 bytes long, or is not marked as a reply.
    pub fn decode(payload: &[u8]) -> Result<Self, PayloadError> {
        let kind = "pheromone reply";
        let length = PayloadError::Length { kind, len: payload.len(), expected: Self::PAYLOAD_LEN };
        let &[opcode, robot_id, left, right, _, _] = payload else { return Err(length) };
        if opcode & REPLY == 0 {
            return Err(PayloadError::Opcode { kind, opcode });
        }
        Ok(Self { opcode: opcode & !REPLY, robot_id, left, right })
    }
}

/// A line of text that says what a frame's payload means.
pub fn describe(payload: &[u8], order: ByteOrder) -> String {
    if let Ok(request) = Request::decode(payload, order) {
        let Request { opcode, robot_id, x_mm, y_mm, heading_deg } = request;
        return format!(
            "pheromones? #{opcode} robot {robot_id} at {x_mm} mm, {y_mm} mm, {heading_deg} deg"
        );
    }
    match Reply::decode(payload) {
        Ok(Reply { opcode, robot_id, left, right }) => {
            format!("pheromones #{opcode} robot {robot_id}: left {left}, right {right}")
        }
        Err(error) => format!("bad payload: {error}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dle::Receiver;
    use proptest::prelude::*;

    fn receive(bytes: &[u8]) -> Vec<u8> {
        let mut receiver = Receiver::default();
        bytes.iter().find_map(|&byte| receiver.push(byte).map(<[u8]>::to_vec)).unwrap()
    }

    fn request_frame(request: Request) -> Vec<u8> {
        let mut out = Vec::new();
        request.encode(ByteOrder::BigEndian, Framing::Stuffed, &mut out);
        out
    }

    #[test]
    fn requests_and_replies_have_their_golden_frames() {
        let request = Request { opcode: 1, robot_id: 1, x_mm: 300, y_mm: -200, heading_deg: 90 };
        let golden = [0x10, 2, 0x10, 0x10, 1, 1, 1, 0x2C, 0xFF, 0x38, 0, 0x5A, 0x10, 3];
        assert_eq!(request_frame(request), golden);
        assert_eq!(Request::decode(&receive(&golden), ByteOrder::BigEndian), Ok(request));
        let stuffed = Request { opcode: 1, robot_id: 1, x_mm: 4096, y_mm: 100, heading_deg: 45 };
        let golden = [0x10, 2, 0x10, 0x10, 1, 1, 0x10, 0x10, 0, 0, 0x64, 0, 0x2D, 0x10, 3];
        assert_eq!(request_frame(stuffed), golden);
        let mut out = Vec::new();
        request.reply(74, 16).encode(Framing::Stuffed, &mut out);
        let golden = [0x10, 2, 0x10, 0x10, 0x81, 1, 0x4A, 0x10, 0x10, 0, 0, 0x10, 3];
        assert_eq!(out, golden);
        out.clear();
        request.reply(74, 16).encode(Framing::Listing, &mut out);
        assert_eq!(out, [0x10, 2, 0x10, 0x10, 0x81, 1, 0x4A, 0x10, 0, 0, 0x10, 3]);
    }

    #[test]
    fn a_question_and_its_answer_take_26_bytes() {
        let request = Request { opcode: OPCODE_LOCATE, ..Request::default() };
        let mut reply = Vec::new();
        request.reply(1, 2).encode(Framing::Stuffed, &mut reply);
        assert_eq!((request_frame(request).len(), reply.len()), (14, 12));
    }

    #[test]
    fn a_payload_of_the_other_kind_or_length_is_refused() {
        let reply = Request::default().reply(1, 2).payload();
        let request = Request::default().payload(ByteOrder::BigEndian);
        assert!(Request::decode(&reply, ByteOrder::BigEndian).is_err());
        assert!(Reply::decode(&request).is_err());
        let marked = [0x81, 1, 0, 0, 0, 0, 0, 0];
        let error = Request::decode(&marked, ByteOrder::BigEndian).unwrap_err().to_string();
        assert_eq!(
            error,
            "pheromone request with operation code 129; that side of the link never sends it"
        );
        let error = Reply::decode(&[1; 6]).unwrap_err().to_string();
        assert_eq!(
            error,
            "pheromone reply with operation code 1; that side of the link never sends it"
        );
        assert_eq!(
            describe(&request, ByteOrder::BigEndian),
            "pheromones? #0 robot 0 at 0 mm, 0 mm, 0 deg"
        );
        assert_eq!(
            describe(&reply, ByteOrder::BigEndian),
            "pheromones #0 robot 0: left 1, right 2"
        );
        assert!(describe(&[], ByteOrder::BigEndian).starts_with("bad payload"));
    }

    proptest! {
        #[test]
        fn every_question_and_answer_comes_back(
            numbers in any::<(i16, i16, i16)>(), opcode in 0_u8..0x80, robot_id: u8,
            left: u8, right: u8, little: bool,
        ) {
            let order = if little { ByteOrder::LittleEndian } else { ByteOrder::BigEndian };
            let (x_mm, y_mm, heading_deg) = numbers;
            let request = Request { opcode, robot_id, x_mm, y_mm, heading_deg };
            let mut out = Vec::new();
            request.encode(order, Framing::Stuffed, &mut out);
            prop_assert_eq!(Request::decode(&receive(&out), order), Ok(request));
            out.clear();
            let reply = request.reply(left, right);
            reply.encode(Framing::Stuffed, &mut out);
            prop_assert_eq!(Reply::decode(&receive(&out)), Ok(reply));
        }
    }
}
