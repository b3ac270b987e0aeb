//! The link between the ground (decision unit, ground station) and a vehicle.
//!
//! Payloads travel in [`dle`](crate::dle) frames; the first byte says what they are. 16-bit numbers
//! are signed where coordinates, unsigned where distances.
//!
//! | to the vehicle | bytes | effect |
//! | --- | --- | --- |
//! | restart | `00` | connects to the robot anew; answered by `30` |
//! | report sonar | `01` | answered by a sonar report |
//! | stop | `02` | stops and forgets the goal; answered by state 0 |
//! | go to | `FE, x, x, y, y` or `FE, x, x, y, y, heading, heading, check` | goal in the map, mm and degrees; answered by state 1 |
//! | link test | `FF` | answered by `FF` |
//!
//! | to the ground | bytes | meaning |
//! | --- | --- | --- |
//! | state | `00` … `08` | the obstacle avoider entered this state |
//! | restarted | `30` | the character `0` |
//! | sonar | `53`, then 8 × distance | the eight front sonars, cm |
//! | arrived | `A0` | the goal is reached |
//! | failed | `A1, reason` | the goal is given up |
//! | link test | `FF` | echo |
//!
//! The check is the CRC-8 with polynomial 0x07 of the bytes before it: a robot should not drive to
//! a goal that noise has made. The short form of the thesis has none.
//!
//! Source: the thesis, Annex C (remote commands 0, 1, 2, 254, 255 and their answers, states as
//! single bytes). Differences: the annex prints no framing for this link, no heading for the goal,
//! no layout of the sonar report and nothing for success and failure; those are defined here.

use crate::dle::{ByteOrder, Framing, PayloadError, write_frame};

const RESTART: u8 = 0;
const REPORT_SONAR: u8 = 1;
const STOP: u8 = 2;
const GO_TO: u8 = 254;
const LINK_TEST: u8 = 255;

const STATE_MAX: u8 = 8;
const RESTARTED: u8 = b'0';
const SONAR: u8 = b'S';
const ARRIVED: u8 = 0xA0;
const FAILED: u8 = 0xA1;

/// What the ground tells the vehicle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ToVehicle {
    /// Drive to a goal in the map.
    GoTo {
        /// x in the map, mm.
        x_mm: i16,
        /// y in the map, mm.
        y_mm: i16,
        /// Heading to end with, degrees; `None` when any will do, as in the thesis.
        heading_deg: Option<i16>,
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
    /// The goal is reached.
    Arrived,
    /// The goal is given up, for a reason.
    Failed(u8),
    /// I hear you.
    LinkTest,
}

impl ToVehicle {
    /// Appends the framed message to `out`.
    pub fn encode(&self, order: ByteOrder, framing: Framing, out: &mut Vec<u8>) {
        match *self {
            Self::GoTo { x_mm, y_mm, heading_deg } => {
                let [[x0, x1], [y0, y1]] = [x_mm, y_mm].map(|value| order.bytes(value));
                match heading_deg.map(|value| order.bytes(value)) {
                    Some([h0, h1]) => {
                        let check = crc8(&[GO_TO, x0, x1, y0, y1, h0, h1]);
                        write_frame(&[GO_TO, x0, x1, y0, y1, h0, h1, check], framing, out);
                    }
                    None => write_frame(&[GO_TO, x0, x1, y0, y1], framing, out),
                }
            }
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
        let goal = |x, y, heading_deg| Self::GoTo {
            x_mm: order.number(x),
            y_mm: order.number(y),
            heading_deg,
        };
        Ok(match *payload {
            [RESTART] => Self::Restart,
            [REPORT_SONAR] => Self::ReportSonar,
            [STOP] => Self::Stop,
            [LINK_TEST] => Self::LinkTest,
            [GO_TO, x0, x1, y0, y1] => goal([x0, x1], [y0, y1], None),
            [GO_TO, x0, x1, y0, y1, h0, h1, check] => {
                let expected = crc8(&[GO_TO, x0, x1, y0, y1, h0, h1]);
                if check != expected {
                    return Err(PayloadError::Check { kind: "goal", found: check, expected });
                }
                goal([x0, x1], [y0, y1], Some(order.number([h0, h1])))
            }
            [GO_TO, ..] => {
                return Err(PayloadError::Length { kind: "goal", len: payload.len(), expected: 8 });
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
            Self::Arrived => write_frame(&[ARRIVED], framing, out),
            Self::Failed(reason) => write_frame(&[FAILED, reason], framing, out),
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
            [ARRIVED] => Self::Arrived,
            [FAILED, reason] => Self::Failed(reason),
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
            [opcode @ (0..=STATE_MAX | RESTARTED | ARRIVED | FAILED | LINK_TEST), ..] => {
                let expected = if opcode == FAILED { 2 } else { 1 };
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

/// CRC-8, polynomial 0x07, start 0.
fn crc8(bytes: &[u8]) -> u8 {
    bytes.iter().fold(0, |crc, &byte| {
        (0..8).fold(crc ^ byte, |crc, _| if crc & 0x80 == 0 { crc << 1 } else { (crc << 1) ^ 0x07 })
    })
}

fn describe_to_vehicle(message: ToVehicle) -> String {
    match message {
        ToVehicle::GoTo { x_mm, y_mm, heading_deg: Some(heading) } => {
            format!("MOVE to {x_mm} mm, {y_mm} mm, {heading} deg")
        }
        ToVehicle::GoTo { x_mm, y_mm, heading_deg: None } => {
            format!("MOVE to {x_mm} mm, {y_mm} mm")
        }
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
        ToGround::Arrived => "arrived".to_owned(),
        ToGround::Failed(reason) => format!("failed, reason {reason}"),
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
        let goal = ToVehicle::GoTo { x_mm: 5000, y_mm: 3500, heading_deg: Some(45) };
        assert_eq!(
            to_vehicle(goal),
            [254, 0x13, 0x88, 0x0D, 0xAC, 0, 45, crc8(&[254, 0x13, 0x88, 0x0D, 0xAC, 0, 45])]
        );
        let goal = ToVehicle::GoTo { x_mm: -1, y_mm: 16, heading_deg: None };
        assert_eq!(to_vehicle(goal), [254, 0xFF, 0xFF, 0, 16]);
        assert_eq!(to_ground(ToGround::State(7)), [7]);
        assert_eq!(to_ground(ToGround::Restarted), [0x30]);
        assert_eq!(to_ground(ToGround::LinkTest), [255]);
        assert_eq!(to_ground(ToGround::Arrived), [0xA0]);
        assert_eq!(to_ground(ToGround::Failed(3)), [0xA1, 3]);
        let sonar = to_ground(ToGround::Sonar([1, 2, 3, 4, 5, 6, 7, 500]));
        assert_eq!(sonar, [0x53, 0, 1, 0, 2, 0, 3, 0, 4, 0, 5, 0, 6, 0, 7, 1, 0xF4]);
    }

    #[test]
    fn what_does_not_belong_is_refused_with_a_reason() {
        let length = |kind, len, expected| Err(PayloadError::Length { kind, len, expected });
        assert_eq!(ToVehicle::decode(&[254, 0, 0], ORDER), length("goal", 3, 8));
        assert_eq!(ToVehicle::decode(&[2, 2], ORDER), length("message to the vehicle", 2, 1));
        assert_eq!(ToVehicle::decode(&[], ORDER), length("message to the vehicle", 0, 1));
        let opcode = PayloadError::Opcode { kind: "message to the vehicle", opcode: 9 };
        assert_eq!(ToVehicle::decode(&[9], ORDER), Err(opcode));
        let opcode = PayloadError::Opcode { kind: "message to the ground", opcode: 9 };
        assert_eq!(ToGround::decode(&[9], ORDER), Err(opcode));
        assert_eq!(
            ToGround::decode(&[0xA1], ORDER),
            Err(PayloadError::Length { kind: "message to the ground", len: 1, expected: 2 })
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
        let goal = ToVehicle::GoTo { x_mm: 5000, y_mm: 3500, heading_deg: Some(45) };
        let payload = to_vehicle(goal);
        for place in 1..payload.len() {
            let mut damaged = payload.clone();
            *damaged.get_mut(place).unwrap() ^= 0x20;
            let refused = ToVehicle::decode(&damaged, ORDER);
            assert!(matches!(refused, Err(PayloadError::Check { .. })), "{refused:?}");
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
            x_mm: i16, y_mm: i16, heading_deg: Option<i16>, ranges: [u16; 8], state in 0_u8..=8,
            reason: u8,
        ) {
            let goal = ToVehicle::GoTo { x_mm, y_mm, heading_deg };
            prop_assert_eq!(ToVehicle::decode(&to_vehicle(goal), ORDER), Ok(goal));
            for message in [ToGround::State(state), ToGround::Sonar(ranges), ToGround::Failed(reason)] {
                prop_assert_eq!(ToGround::decode(&to_ground(message), ORDER), Ok(message));
            }
        }
    }
}
