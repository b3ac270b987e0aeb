//! The pheromone server as a state machine: request bytes in, reply bytes out.

use std::collections::BTreeMap;

use geometry::Se2;
use wire::{
    dle::{ByteOrder, Framing, Receiver},
    pheromone_link::{Reply, Request},
};

use crate::{Field, Intensities, SenseConfig};

/// How the server perceives and talks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ServerConfig {
    /// Antennas and perception, common to all robots.
    pub sense: SenseConfig,
    /// Order of the bytes of coordinates and headings.
    pub byte_order: ByteOrder,
    /// How replies are framed. [`Framing::Listing`] repeats the fault of the thesis's program, whose
    /// replies break when an intensity is 16.
    pub reply_framing: Framing,
    /// What is sent for what is perceived, from 0 to 1. With 1 a unit source at the antenna is sent as 100.
    /// On trails several cells wide both antennas exceed 255 near the middle and the difference that
    /// controllers live on is cut away; there 0.5 (three cells of 200 mm, σ = 600 mm) is right.
    pub scale_ratio: f64,
}

impl Default for ServerConfig {
    fn default() -> Self {
        Self {
            sense: SenseConfig::default(),
            byte_order: ByteOrder::default(),
            reply_framing: Framing::default(),
            scale_ratio: 1.0,
        }
    }
}

/// What the server has seen so far: its traffic monitor (the thesis, Annex B1).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ServerCounters {
    /// Requests answered.
    pub n_requests: u64,
    /// Whole frames that were no request; not answered.
    pub n_refused: u64,
    /// Intensities above 255 that were sent as 255.
    pub n_clamped: u64,
    /// Broken frames, as the thesis's program counts them: a wrong byte before the payload.
    pub n_frame_errors: u64,
    /// Frames given up after their payload had begun, and such that were too long.
    pub n_frames_dropped: u64,
    /// Bytes received, whatever they were.
    pub n_bytes_received: u64,
    /// Bytes of answers.
    pub n_bytes_sent: u64,
}

impl ServerCounters {
    /// All that was received in vain: broken, given up and refused frames.
    pub fn n_errors(&self) -> u64 {
        self.n_frame_errors + self.n_frames_dropped + self.n_refused
    }
}

/// The last question of a robot and what it was told.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exchange {
    /// What it asked.
    pub request: Request,
    /// What is perceived there, before it was made to fit a byte.
    pub intensities: Intensities,
    /// What it was told.
    pub reply: Reply,
    /// How often it has asked, this time included.
    pub n_requests: u64,
}

/// Answers pose queries of any number of robots: one reply per request, in the order of their arrival.
///
/// A server hears one stream of bytes. Robots that share a radio channel share it; robots with links
/// of their own need a server each, or their frames would be cut up among each other.
///
/// Intensities are rounded down to whole numbers and cut at 255.
///
/// Source: the thesis, Annex B1 (main loop, `parse_buffer`, `make_packet`). Differences: values beyond a
/// byte are cut, not wrapped; reach and spacing are settings.
///
/// ```
/// use pheromones::{Field, Server, ServerConfig};
/// use wire::{dle::{ByteOrder, Framing}, pheromone_link::Request};
///
/// let field = Field::from_text("0 0 0\n1 1 1\n0 0 0", 0.2).unwrap();
/// let mut server = Server::new(ServerConfig::default());
/// let (mut question, mut answer) = (Vec::new(), Vec::new());
/// let request = Request { opcode: 1, robot_id: 7, x_mm: -200, y_mm: 0, heading_deg: 0 };
/// request.encode(ByteOrder::BigEndian, Framing::Stuffed, &mut question);
/// server.receive(&field, &question, &mut answer);
/// assert_eq!(answer[4..6], [0x81, 7]);
/// ```
#[derive(Clone, Debug)]
pub struct Server {
    config: ServerConfig,
    receiver: Receiver,
    counters: ServerCounters,
    /// The counters when the receiver was new.
    before: ServerCounters,
    exchanges: BTreeMap<u8, Exchange>,
}

impl Server {
    /// Makes a server that has not heard anything yet.
    pub fn new(config: ServerConfig) -> Self {
        Self {
            config,
            receiver: Receiver::default(),
            counters: ServerCounters::default(),
            before: ServerCounters::default(),
            exchanges: BTreeMap::new(),
        }
    }

    /// Takes received bytes, in pieces of any size, and appends one reply per whole request to `out`.
    ///
    /// Allocates for robots not heard before and for `out` only.
    pub fn receive(&mut self, field: &Field, bytes: &[u8], out: &mut Vec<u8>) {
        self.receive_with(|_| field, bytes, out);
    }

    /// As [`receive`](Self::receive), with a field for each robot: several kinds of pheromone are several
    /// fields, and `field_of` says which one a robot smells.
    pub fn receive_with<'f>(
        &mut self,
        field_of: impl Fn(u8) -> &'f Field,
        bytes: &[u8],
        out: &mut Vec<u8>,
    ) {
        self.counters.n_bytes_received += bytes.len() as u64;
        let n_out_before = out.len();
        for &byte in bytes {
            let Some(payload) = self.receiver.push(byte) else { continue };
            let Ok(request) = Request::decode(payload, self.config.byte_order) else {
                self.counters.n_refused += 1;
                continue;
            };
            let intensities = field_of(request.robot_id).sense(pose(request), &self.config.sense);
            let reply = request
                .reply(self.cut_to_byte(intensities.left), self.cut_to_byte(intensities.right));
            reply.encode(self.config.reply_framing, out);
            self.counters.n_requests += 1;
            let n_before = self.exchanges.get(&request.robot_id).map_or(0, |last| last.n_requests);
            let exchange = Exchange { request, intensities, reply, n_requests: n_before + 1 };
            self.exchanges.insert(request.robot_id, exchange);
        }
        self.counters.n_bytes_sent += (out.len() - n_out_before) as u64;
        self.counters.n_frame_errors = self.before.n_frame_errors + self.receiver.n_errors();
        self.counters.n_frames_dropped =
            self.before.n_frames_dropped + self.receiver.n_dropped() + self.receiver.n_overflows();
    }

    /// The robots at the other end have gone: forgets half a frame and the last exchanges, and goes on
    /// counting.
    pub fn hang_up(&mut self) {
        self.receiver = Receiver::default();
        self.exchanges.clear();
        self.before = self.counters;
    }

    /// The last exchange with a robot.
    pub fn last_exchange(&self, robot_id: u8) -> Option<&Exchange> {
        self.exchanges.get(&robot_id)
    }

    /// The last exchange with each robot heard so far, by robot.
    pub fn exchanges(&self) -> impl Iterator<Item = (u8, &Exchange)> {
        self.exchanges.iter().map(|(&robot_id, exchange)| (robot_id, exchange))
    }

    /// What happened so far.
    pub fn counters(&self) -> ServerCounters {
        self.counters
    }

    /// How it perceives and talks.
    pub fn config(&self) -> &ServerConfig {
        &self.config
    }

    fn cut_to_byte(&mut self, intensity: f64) -> u8 {
        let intensity = intensity * self.config.scale_ratio;
        if intensity >= 256.0 {
            self.counters.n_clamped += 1;
        }
        intensity.clamp(0.0, 255.0) as u8
    }
}

fn pose(request: Request) -> Se2 {
    let metres = |mm: i16| f64::from(mm) / 1000.0;
    // Not wrapped: the listing's π of 3.14 makes 180° and −180° two different directions.
    Se2 {
        x_m: metres(request.x_mm),
        y_m: metres(request.y_mm),
        yaw_rad: f64::from(request.heading_deg).to_radians(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Perception;
    use proptest::prelude::*;

    fn trail(value: u8) -> Field {
        let mut field = Field::new(21, 21, 0.2).unwrap();
        for col in 0..21 {
            field.set(col, 10, value).unwrap();
        }
        field
    }

    fn listing_server(reply_framing: Framing) -> Server {
        let sense =
            SenseConfig { perception: Perception::Listing, strict: true, ..SenseConfig::default() };
        Server::new(ServerConfig { sense, reply_framing, ..ServerConfig::default() })
    }

    fn ask(server: &mut Server, field: &Field, request: &[u8]) -> Vec<u8> {
        let mut out = Vec::new();
        server.receive(field, request, &mut out);
        out
    }

    /// x = 300, y = −200 mm, heading 90°: the frame the thesis's notes give for this question. The trail lies
    /// 200 mm ahead: two antennas at x = 110 and 490 see the cells of the row y = 0.
    #[test]
    fn answers_the_golden_question() {
        let question = [0x10, 2, 0x10, 0x10, 1, 1, 1, 0x2C, 0xFF, 0x38, 0, 0x5A, 0x10, 3];
        let mut server = listing_server(Framing::Stuffed);
        let answer = ask(&mut server, &trail(1), &question);
        let exchange = server.last_exchange(1).unwrap();
        assert_eq!((exchange.request.x_mm, exchange.request.y_mm), (300, -200));
        let (left, right) = (exchange.reply.left, exchange.reply.right);
        assert!(left > 0 && right > 0);
        assert_eq!(answer, [0x10, 2, 0x10, 0x10, 0x81, 1, left, right, 0, 0, 0x10, 3]);
    }

    /// (0, 0, 0) on the unit trail: 132.14 on both sides, sent as 132.
    #[test]
    fn intensities_are_rounded_down_and_cut_at_a_byte() {
        let question = [0x10, 2, 0x10, 0x10, 1, 9, 0, 0, 0, 0, 0, 0, 0x10, 3];
        let mut server = listing_server(Framing::Stuffed);
        let answer = ask(&mut server, &trail(1), &question);
        assert_eq!(answer[4..8], [0x81, 9, 132, 132]);
        assert_eq!(server.counters().n_clamped, 0);
        let answer = ask(&mut server, &trail(2), &question);
        assert_eq!(answer[4..8], [0x81, 9, 255, 255]);
        assert_eq!(server.counters().n_clamped, 2);
        assert!(server.last_exchange(9).unwrap().intensities.left > 264.0);
    }

    /// Three cells wide, 60 mm left of the middle: about 359 and 448. Uncut, both are 255 and no controller
    /// knows where the trail is.
    #[test]
    fn a_scale_keeps_the_difference_on_wide_trails() {
        let mut field = Field::new(21, 21, 0.2).unwrap();
        let ends = [geometry::Vec2::new(-2.0, 0.0), geometry::Vec2::new(2.0, 0.0)];
        field.draw_wide_trail(&ends, 1, 3);
        let question = [0x10, 2, 0x10, 0x10, 1, 1, 0, 0, 0, 60, 0, 0, 0x10, 3];
        let answer = |scale_ratio| {
            let config = ServerConfig { scale_ratio, ..ServerConfig::default() };
            let answer = ask(&mut Server::new(config), &field, &question);
            (answer[6], answer[7])
        };
        assert_eq!(answer(1.0), (255, 255));
        assert_eq!(answer(0.5), (179, 224));
    }

    /// A single source perceived as exactly 16 by the left antenna: doubled, or not as in the listing.
    #[test]
    fn a_sixteen_is_doubled_unless_the_listing_is_asked_for() {
        let mut field = Field::new(21, 21, 0.2).unwrap();
        field.set(12, 10, 1).unwrap();
        // From x = −63 mm: √(463² + 190²) = 500.5 mm away, ⌊100 (1 − 500.5/600)⌋ = 16.
        let question = [0x10, 2, 0x10, 0x10, 1, 1, 0xFF, 0xC1, 0, 0, 0, 0, 0x10, 3];
        let answer = |framing| ask(&mut listing_server(framing), &field, &question);
        let stuffed = [0x10, 2, 0x10, 0x10, 0x81, 1, 0x10, 0x10, 0x10, 0x10, 0, 0, 0x10, 3];
        let bare = [0x10, 2, 0x10, 0x10, 0x81, 1, 0x10, 0x10, 0, 0, 0x10, 3];
        assert_eq!(answer(Framing::Stuffed), stuffed);
        assert_eq!(answer(Framing::Listing), bare);
    }

    #[test]
    fn every_robot_gets_its_own_answer_in_order() {
        let (near, far) = (trail(1), Field::new(3, 3, 0.2).unwrap());
        let mut server = Server::new(ServerConfig::default());
        let mut bytes = vec![0x55, 0x10, 0x99]; // noise before the first frame
        for robot_id in [3, 200, 3] {
            let request = Request { opcode: 5, robot_id, ..Request::default() };
            request.encode(ByteOrder::BigEndian, Framing::Stuffed, &mut bytes);
        }
        let reply = Reply { opcode: 5, ..Reply::default() };
        reply.encode(Framing::Stuffed, &mut bytes); // another server's answer: no question
        let mut out = Vec::new();
        server.receive_with(|robot_id| if robot_id == 3 { &near } else { &far }, &bytes, &mut out);
        let robots: Vec<u8> = out.chunks(12).map(|frame| frame[5]).collect();
        assert_eq!(robots, [3, 200, 3]);
        assert!(out[6] > 0, "robot 3 smells the trail");
        assert_eq!(out[12 + 6..12 + 8], [0, 0], "robot 200 smells the empty field");
        let counters = server.counters();
        assert_eq!((counters.n_requests, counters.n_refused, counters.n_frame_errors), (3, 1, 1));
        let counts: Vec<(u8, u64)> = server.exchanges().map(|(id, e)| (id, e.n_requests)).collect();
        assert_eq!(counts, [(3, 2), (200, 1)]);
    }

    /// The traffic monitor of the thesis's server: characters received, and errors, over all clients.
    #[test]
    fn traffic_is_counted_across_hang_ups() {
        let field = trail(1);
        let mut server = Server::new(ServerConfig::default());
        let question = [0x10, 2, 0x10, 0x10, 1, 1, 0, 0, 0, 0, 0, 0, 0x10, 3];
        let n_out = ask(&mut server, &field, &question).len() as u64;
        // No STX after the DLE; then a frame that is given up after two bytes of payload.
        ask(&mut server, &field, &[0x10, 7, 0x10, 2, 0x10, 0x10, 1, 2, 0x10, 9]);
        // Half a question of somebody who leaves.
        ask(&mut server, &field, &question[..9]);
        server.hang_up();
        assert!(server.last_exchange(1).is_none());
        ask(&mut server, &field, &question);
        ask(&mut server, &field, &[0x10, 7]);
        let counters = server.counters();
        assert_eq!(counters.n_bytes_received, 14 + 10 + 9 + 14 + 2);
        assert_eq!(counters.n_bytes_sent, 2 * n_out);
        assert_eq!((counters.n_requests, counters.n_frame_errors), (2, 2));
        assert_eq!((counters.n_frames_dropped, counters.n_errors()), (1, 3));
    }

    proptest! {
        #[test]
        fn cutting_the_stream_changes_nothing(
            bytes in proptest::collection::vec(prop_oneof![Just(0x10_u8), Just(2), Just(3), any::<u8>()], 0..60),
            questions in 1_usize..4,
            cut in 0_usize..120,
        ) {
            let mut stream = bytes;
            for robot_id in 0..questions {
                let request = Request { robot_id: robot_id as u8, x_mm: 0x1010, ..Request::default() };
                request.encode(ByteOrder::BigEndian, Framing::Stuffed, &mut stream);
            }
            let field = trail(1);
            let whole = ask(&mut Server::new(ServerConfig::default()), &field, &stream);
            let mut server = Server::new(ServerConfig::default());
            let (head, tail) = stream.split_at(cut.min(stream.len()));
            let mut cut_up = ask(&mut server, &field, head);
            cut_up.extend(ask(&mut server, &field, tail));
            prop_assert_eq!(whole, cut_up);
        }
    }
}
