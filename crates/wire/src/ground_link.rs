//! The link between the ground (decision unit, ground station) and a vehicle.
//!
//! Payloads travel in [`dle`](crate::dle) frames; the first byte says what they are. 16-bit numbers
//! are signed where coordinates, unsigned where distances.
//!
//! | to the vehicle | bytes | effect |
//! | --- | --- | --- |
//! | restart | `00` | connects to the robot anew and forgets the goal; answered by `30` |
//! | report sonar | `01` | answered by a sonar report |
//! | stop | `02` | stops and forgets the goal; answered by state 0 |
//! | ask | `03, number, check` | what became of that goal? answered by `A0` to `A3` |
//! | go to | `FE, number, x, x, y, y, heading, heading, check` | goal in the map, mm and degrees; answered by `A2` |
//! | target | `FE, x, x, y, y` | the thesis's goal, without heading and number; answered by state 1 |
//! | link test | `FF` | answered by `FF` |
//!
//! | to the ground | bytes | meaning |
//! | --- | --- | --- |
//! | state | `00` … `08` | the obstacle avoider entered this state |
//! | restarted | `30` | the character `0` |
//! | sonar | `53`, then 8 × distance | the eight front sonars, cm |
//! | arrived | `A0, number, check` | that goal is reached |
//! | failed | `A1, number, reason, check` | that goal is given up |
//! | under way | `A2, number, check` | that goal is the vehicle's goal |
//! | unknown | `A3, number, check` | the vehicle has no such goal, or not any more |
//! | link test | `FF` | echo |
//!
//! The number, 1 to 255, ties a report to its goal: a report that was still under way when the next
//! goal was sent is about the one before. 0 stands for a target, which has none. The check is the
//! CRC-8 with polynomial 0x07 of the bytes before it: a robot should not drive to a goal that noise
//! has made, nor a program believe in an arrival that it has made.
//!
//! Source: the thesis, Annex C (remote commands 0, 1, 2, 254, 255 and their answers, states as
//! single bytes). Differences: the annex prints no framing for this link, no heading for the goal,
//! no layout of the sonar report, no question and nothing for success and failure; those are
//! defined here.

use crate::dle::{ByteOrder, Framing, PayloadError, write_frame};

const RESTART: u8 = 0;
const REPORT_SONAR: u8 = 1;
const STOP: u8 = 2;
const ASK: u8 = 3;
const GO_TO: u8 = 254;
const LINK_TEST: u8 = 255;

const STATE_MAX: u8 = 8;
const RESTARTED: u8 = b'0';
const SONAR: u8 = b'S';
const ARRIVED: u8 = 0xA0;
const FAILED: u8 = 0xA1;
const UNDER_WAY: u8 = 0xA2;
const UNKNOWN: u8 = 0xA3;

/// What the ground tells the vehicle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ToVehicle {
    /// Drive to a goal in the map.
    GoTo {
        /// Which goal of this ground it is, 1 to 255.
        number: u8,
        /// x in the map, mm.
        x_mm: i16,
        /// y in the map, mm.
        y_mm: i16,
        /// Heading to end with, degrees.
        heading_deg: i16,
    },
    /// Drive to a place in the map and end with any heading, as in the thesis.
    Target {
        /// x in the map, mm.
        x_mm: i16,
        /// y in the map, mm.
        y_mm: i16,
    },
    /// Say what became of a goal.
    Ask {
        /// Which goal.
        number: u8,
    },
    /// Stop and forget the goal.
    Stop,
    /// Connect to the robot anew.
    Restart,
    /// Report the sonars.
    ReportSonar,
    /// Answer if you hear this.
    LinkTest,
}

/// What the vehicle tells the ground.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ToGround {
    /// The obstacle avoider entered a state, 0 to 8.
    State(u8),
    /// The robot is being connected to anew.
    Restarted,
    /// Distances of the eight front sonars, cm.
    Sonar([u16; 8]),
    /// A goal is reached.
    Arrived {
        /// Which goal; 0 for a target.
        number: u8,
    },
    /// A goal is given up.
    Failed {
        /// Which goal; 0 for a target.
        number: u8,
        /// Why.
        reason: u8,
    },
    /// A goal is the vehicle's present goal.
    UnderWay {
        /// Which goal.
        number: u8,
    },
    /// A goal is not, or not any more, known to the vehicle.
    Unknown {
        /// Which goal.
        number: u8,
    },
    /// I hear you.
    LinkTest,
}

impl ToVehicle {
    /// Appends the framed message to `out`.
    pub fn encode(&self, order: ByteOrder, framing: Framing, out: &mut Vec<u8>) {
        match *self {
            Self::GoTo { number, x_mm, y_mm, heading_deg } => {
                let [[x0, x1], [y0, y1], [h0, h1]] =
                    [x_mm, y_mm, heading_deg].map(|value| order.bytes(value));
                write_checked(&[GO_TO, number, x0, x1, y0, y1, h0, h1], framing, out);
            }
            Self::Target { x_mm, y_mm } => {
                let [[x0, x1], [y0, y1]] = [x_mm, y_mm].map(|value| order.bytes(value));
                write_frame(&[GO_TO, x0, x1, y0, y1], framing, out);
            }
            Self::Ask { number } => write_checked(&[ASK, number], framing, out),
            Self::Stop => write_frame(&[STOP], framing, out),
            Self::Restart => write_frame(&[RESTART], framing, out),
            Self::ReportSonar => write_frame(&[REPORT_SONAR], framing, out),
            Self::LinkTest => write_frame(&[LINK_TEST], framing, out),
        }
    }

    /// Reads a frame's payload.
    ///
    /// # Errors
    ///
    /// [`PayloadError`] when the first byte is none of this direction's, the length is wrong or a
    /// goal's check does not fit.
    pub fn decode(payload: &[u8], order: ByteOrder) -> Result<Self, PayloadError> {
        let kind = "message to the vehicle";
        Ok(match *payload {
            [RESTART] => Self::Restart,
            [REPORT_SONAR] => Self::ReportSonar,
            [STOP] => Self::Stop,
            [LINK_TEST] => Self::LinkTest,
            [GO_TO, x0, x1, y0, y1] => {
                Self::Target { x_mm: order.number([x0, x1]), y_mm: order.number([y0, y1]) }
            }
            [GO_TO, number, x0, x1, y0, y1, h0, h1, _] => {
                check("goal", payload)?;
                let [x_mm, y_mm, heading_deg] =
                    [[x0, x1], [y0, y1], [h0, h1]].map(|pair| order.number(pair));
                Self::GoTo { number, x_mm, y_mm, heading_deg }
            }
            [ASK, number, _] => {
                check("question", payload)?;
                Self::Ask { number }
            }
            [GO_TO, ..] => {
                return Err(PayloadError::Length { kind: "goal", len: payload.len(), expected: 9 });
            }
            [ASK, ..] => {
                let len = payload.len();
                return Err(PayloadError::Length { kind: "question", len, expected: 3 });
            }
            [opcode, ..] if !matches!(opcode, RESTART | REPORT_SONAR | STOP | LINK_TEST) => {
                return Err(PayloadError::Opcode { kind, opcode });
            }
            _ => return Err(PayloadError::Length { kind, len: payload.len(), expected: 1 }),
        })
    }
}

impl ToGround {
    /// Appends the framed message to `out`. A state above 8 is sent as 8.
    pub fn encode(&self, order: ByteOrder, framing: Framing, out: &mut Vec<u8>) {
        match *self {
            Self::State(state) => write_frame(&[state.min(STATE_MAX)], framing, out),
            Self::Restarted => write_frame(&[RESTARTED], framing, out),
            Self::Sonar(ranges_cm) => {
                let mut payload = [SONAR; 17];
                let bytes = ranges_cm.into_iter().flat_map(|cm| order.bytes(cm.cast_signed()));
                payload.iter_mut().skip(1).zip(bytes).for_each(|(place, byte)| *place = byte);
                write_frame(&payload, framing, out);
            }
            Self::Arrived { number } => write_checked(&[ARRIVED, number], framing, out),
            Self::Failed { number, reason } => {
                write_checked(&[FAILED, number, reason], framing, out);
            }
            Self::UnderWay { number } => write_checked(&[UNDER_WAY, number], framing, out),
            Self::Unknown { number } => write_checked(&[UNKNOWN, number], framing, out),
            Self::LinkTest => write_frame(&[LINK_TEST], framing, out),
        }
    }

    /// Reads a frame's payload.
    ///
    /// # Errors
    ///
    /// [`PayloadError`] when the first byte is none of this direction's or the length is wrong.
    pub fn decode(payload: &[u8], order: ByteOrder) -> Result<Self, PayloadError> {
        let kind = "message to the ground";
        Ok(match *payload {
            [state @ 0..=STATE_MAX] => Self::State(state),
            [RESTARTED] => Self::Restarted,
            [opcode @ (ARRIVED | UNDER_WAY | UNKNOWN), number, _] => {
                check("report on a goal", payload)?;
                match opcode {
                    ARRIVED => Self::Arrived { number },
                    UNDER_WAY => Self::UnderWay { number },
                    _ => Self::Unknown { number },
                }
            }
            [FAILED, number, reason, _] => {
                check("report on a goal", payload)?;
                Self::Failed { number, reason }
            }
            [LINK_TEST] => Self::LinkTest,
            [SONAR, ref distances @ ..] => {
                let (pairs, odd) = distances.as_chunks::<2>();
                let length =
                    PayloadError::Length { kind: "sonar report", len: payload.len(), expected: 17 };
                let &pairs: &[[u8; 2]; 8] = pairs.try_into().map_err(|_wrong| length)?;
                if !odd.is_empty() {
                    return Err(length);
                }
                Self::Sonar(pairs.map(|pair| order.number(pair).cast_unsigned()))
            }
            [opcode @ (ARRIVED | FAILED | UNDER_WAY | UNKNOWN), ..] => {
                let (len, expected) = (payload.len(), if opcode == FAILED { 4 } else { 3 });
                return Err(PayloadError::Length { kind: "report on a goal", len, expected });
            }
            [0..=STATE_MAX | RESTARTED | LINK_TEST, ..] => {
                let expected = 1;
                return Err(PayloadError::Length { kind, len: payload.len(), expected });
            }
            [opcode, ..] => return Err(PayloadError::Opcode { kind, opcode }),
            [] => return Err(PayloadError::Length { kind, len: 0, expected: 1 }),
        })
    }
}

/// A line of text that says what a frame's payload means; `from_vehicle` picks the direction.
pub fn describe(payload: &[u8], order: ByteOrder, from_vehicle: bool) -> String {
    let text = if from_vehicle {
        ToGround::decode(payload, order).map(describe_to_ground)
    } else {
        ToVehicle::decode(payload, order).map(describe_to_vehicle)
    };
    text.unwrap_or_else(|error| format!("bad payload: {error}"))
}

/// A payload with its check behind it.
fn write_checked(payload: &[u8], framing: Framing, out: &mut Vec<u8>) {
    let mut checked = [0; 9];
    let bytes = payload.iter().copied().chain([crc8(payload)]);
    let len = checked.iter_mut().zip(bytes).map(|(place, byte)| *place = byte).count();
    write_frame(checked.get(..len).unwrap_or(&checked), framing, out);
}

/// Whether the last byte of a payload is the check of those before it.
fn check(kind: &'static str, payload: &[u8]) -> Result<(), PayloadError> {
    let Some((&found, body)) = payload.split_last() else { return Ok(()) };
    let expected = crc8(body);
    if found == expected { Ok(()) } else { Err(PayloadError::Check { kind, found, expected }) }
}

/// CRC-8, polynomial 0x07, start 0.
fn crc8(bytes: &[u8]) -> u8 {
    bytes.iter().fold(0, |crc, &byte| {
        (0..8).fold(crc ^ byte, |crc, _| if crc & 0x80 == 0 { crc << 1 } else { (crc << 1) ^ 0x07 })
    })
}

fn describe_to_vehicle(message: ToVehicle) -> String {
    match message {
        ToVehicle::GoTo { number, x_mm, y_mm, heading_deg } => {
            format!("MOVE {number} to {x_mm} mm, {y_mm} mm, {heading_deg} deg")
        }
        ToVehicle::Target { x_mm, y_mm } => format!("MOVE to {x_mm} mm, {y_mm} mm"),
        ToVehicle::Ask { number } => format!("how is MOVE {number}?"),
        ToVehicle::Stop => "stop".to_owned(),
        ToVehicle::Restart => "restart".to_owned(),
        ToVehicle::ReportSonar => "report sonar".to_owned(),
        ToVehicle::LinkTest => "link test".to_owned(),
    }
}

fn describe_to_ground(message: ToGround) -> String {
    match message {
        ToGround::State(state) => format!("state {state}"),
        ToGround::Restarted => "restarted".to_owned(),
        ToGround::Sonar(ranges_cm) => format!("sonar {ranges_cm:?} cm"),
        ToGround::Arrived { number } => format!("MOVE {number}: arrived"),
        ToGround::Failed { number, reason } => format!("MOVE {number}: failed, reason {reason}"),
        ToGround::UnderWay { number } => format!("MOVE {number}: under way"),
        ToGround::Unknown { number } => format!("MOVE {number}: not known"),
        ToGround::LinkTest => "link test answered".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dle::Receiver;
    use proptest::prelude::*;

    const ORDER: ByteOrder = ByteOrder::BigEndian;

    fn receive(bytes: &[u8]) -> Vec<u8> {
        let mut receiver = Receiver::default();
        bytes.iter().find_map(|&byte| receiver.push(byte).map(<[u8]>::to_vec)).unwrap()
    }

    fn to_vehicle(message: ToVehicle) -> Vec<u8> {
        let mut out = Vec::new();
        message.encode(ORDER, Framing::Stuffed, &mut out);
        receive(&out)
    }

    fn to_ground(message: ToGround) -> Vec<u8> {
        let mut out = Vec::new();
        message.encode(ORDER, Framing::Stuffed, &mut out);
        receive(&out)
    }

    #[test]
    fn the_codes_are_those_of_the_table() {
        assert_eq!(to_vehicle(ToVehicle::Restart), [0]);
        assert_eq!(to_vehicle(ToVehicle::ReportSonar), [1]);
        assert_eq!(to_vehicle(ToVehicle::Stop), [2]);
        assert_eq!(to_vehicle(ToVehicle::LinkTest), [255]);
        // The checks were computed bit by bit with another program.
        let goal = ToVehicle::GoTo { number: 7, x_mm: 5000, y_mm: 3500, heading_deg: 45 };
        assert_eq!(to_vehicle(goal), [254, 7, 0x13, 0x88, 0x0D, 0xAC, 0, 45, 0x3F]);
        assert_eq!(to_vehicle(ToVehicle::Ask { number: 7 }), [3, 7, 0x2A]);
        let goal = ToVehicle::Target { x_mm: -1, y_mm: 16 };
        assert_eq!(to_vehicle(goal), [254, 0xFF, 0xFF, 0, 16]);
        assert_eq!(to_ground(ToGround::State(7)), [7]);
        assert_eq!(to_ground(ToGround::Restarted), [0x30]);
        assert_eq!(to_ground(ToGround::LinkTest), [255]);
        assert_eq!(to_ground(ToGround::Arrived { number: 7 }), [0xA0, 7, 0x0D]);
        let failed = ToGround::Failed { number: 7, reason: 3 };
        assert_eq!(to_ground(failed), [0xA1, 7, 3, 0x41]);
        assert_eq!(to_ground(ToGround::UnderWay { number: 7 }), [0xA2, 7, 0x27]);
        assert_eq!(to_ground(ToGround::Unknown { number: 7 }), [0xA3, 7, 0x32]);
        let sonar = to_ground(ToGround::Sonar([1, 2, 3, 4, 5, 6, 7, 500]));
        assert_eq!(sonar, [0x53, 0, 1, 0, 2, 0, 3, 0, 4, 0, 5, 0, 6, 0, 7, 1, 0xF4]);
    }

    #[test]
    fn what_does_not_belong_is_refused_with_a_reason() {
        let length = |kind, len, expected| Err(PayloadError::Length { kind, len, expected });
        assert_eq!(ToVehicle::decode(&[254, 0, 0], ORDER), length("goal", 3, 9));
        assert_eq!(ToVehicle::decode(&[254; 8], ORDER), length("goal", 8, 9));
        assert_eq!(ToVehicle::decode(&[3, 1], ORDER), length("question", 2, 3));
        assert_eq!(ToVehicle::decode(&[2, 2], ORDER), length("message to the vehicle", 2, 1));
        assert_eq!(ToVehicle::decode(&[], ORDER), length("message to the vehicle", 0, 1));
        let opcode = PayloadError::Opcode { kind: "message to the vehicle", opcode: 9 };
        assert_eq!(ToVehicle::decode(&[9], ORDER), Err(opcode));
        let opcode = PayloadError::Opcode { kind: "message to the ground", opcode: 9 };
        assert_eq!(ToGround::decode(&[9], ORDER), Err(opcode));
        assert_eq!(
            ToGround::decode(&[0xA1, 1, 1], ORDER),
            Err(PayloadError::Length { kind: "report on a goal", len: 3, expected: 4 })
        );
        assert_eq!(
            ToGround::decode(&[0x53; 16], ORDER),
            Err(PayloadError::Length { kind: "sonar report", len: 16, expected: 17 })
        );
        assert!(ToGround::decode(&[0x53; 18], ORDER).is_err());
        assert!(ToGround::decode(&[], ORDER).is_err());
    }

    #[test]
    fn the_check_has_its_published_value_and_refuses_a_damaged_goal() {
        assert_eq!(crc8(b"123456789"), 0xF4);
        let goal = ToVehicle::GoTo { number: 1, x_mm: 5000, y_mm: 3500, heading_deg: 45 };
        let report = ToGround::Failed { number: 1, reason: 4 };
        for (payload, to_vehicle) in [(to_vehicle(goal), true), (to_ground(report), false)] {
            for place in 1..payload.len() {
                let mut damaged = payload.clone();
                *damaged.get_mut(place).unwrap() ^= 0x20;
                let refused = if to_vehicle {
                    ToVehicle::decode(&damaged, ORDER).err()
                } else {
                    ToGround::decode(&damaged, ORDER).err()
                };
                assert!(matches!(refused, Some(PayloadError::Check { .. })), "{refused:?}");
            }
        }
    }

    #[test]
    fn messages_are_described() {
        assert_eq!(describe(&[254, 0, 1, 0, 2], ORDER, false), "MOVE to 1 mm, 2 mm");
        assert_eq!(describe(&[5], ORDER, true), "state 5");
        assert!(describe(&[9], ORDER, true).starts_with("bad payload"));
    }

    proptest! {
        #[test]
        fn every_message_comes_back(
            x_mm: i16, y_mm: i16, heading_deg: i16, ranges: [u16; 8], state in 0_u8..=8,
            reason: u8, number: u8,
        ) {
            let goal = ToVehicle::GoTo { number, x_mm, y_mm, heading_deg };
            for order in [goal, ToVehicle::Target { x_mm, y_mm }, ToVehicle::Ask { number }] {
                prop_assert_eq!(ToVehicle::decode(&to_vehicle(order), ORDER), Ok(order));
            }
            for message in [
                ToGround::State(state),
                ToGround::Sonar(ranges),
                ToGround::Arrived { number },
                ToGround::Failed { number, reason },
                ToGround::UnderWay { number },
                ToGround::Unknown { number },
            ] {
                prop_assert_eq!(ToGround::decode(&to_ground(message), ORDER), Ok(message));
            }
        }
    }
}
