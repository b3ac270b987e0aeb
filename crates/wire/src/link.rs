//! A byte pipe in virtual time: baud rate, latency, jitter, loss and corruption.
//!
//! It stands for an RS232 cable, a radio modem or, with [`LinkConfig::default`], for a socket.
//! Bytes leave one after the other at 10 bits each (start, eight data, stop), arrive in order after
//! the latency, and nothing depends on when or in what pieces the far end listens.
//!
//! Source: the thesis, §7.2 and 7.4 (RS232 and radio modem at 9600 baud).

use std::{collections::VecDeque, time::Duration};

use rand_core::{Rng, SeedableRng};
use run_context::{RandomStream, Stamp};

/// Bits on the line for one byte: start, eight data, stop.
const BITS_PER_BYTE: u64 = 10;

/// Bytes under way in one direction at most; a sender that is faster than its line for that long
/// loses the rest, as a full transmit buffer does.
const UNDER_WAY_MAX: usize = 1 << 16;

/// How a link behaves; the default is direct: no delay, no faults.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LinkConfig {
    /// Line speed in bits per second; `None` sends any number of bytes at once.
    pub baud: Option<u32>,
    /// Time from the end of a byte on the line to its arrival.
    pub latency: Duration,
    /// Greatest additional delay; drawn evenly for each burst of bytes sent without a pause.
    pub jitter: Duration,
    /// Chance for each byte to vanish, 0 to 1.
    pub loss_prob: f64,
    /// Chance for each byte to arrive as another byte, 0 to 1.
    pub corruption_prob: f64,
}

/// A [`LinkConfig`] that describes no link.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LinkConfigError {
    /// A speed of zero never delivers anything.
    #[error("link.baud = 0: must be positive, or absent for a direct link")]
    Baud,
    /// A probability outside 0 to 1.
    #[error("link.{key} = {value}: must be between 0 and 1")]
    Probability {
        /// The field.
        key: &'static str,
        /// Its value.
        value: f64,
    },
}

/// One end of a link.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// By custom the client, driver or ground.
    A,
    /// By custom the robot, server or vehicle.
    B,
}

/// What became of the bytes sent from one end.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LinkCounters {
    /// Bytes handed to the link.
    pub n_sent: u64,
    /// Bytes received at the far end.
    pub n_delivered: u64,
    /// Bytes that vanished on the line, by a fault or in a cut.
    pub n_lost: u64,
    /// Bytes that arrived, or will arrive, as other bytes.
    pub n_corrupted: u64,
    /// Bytes refused because 65 536 were already under way.
    pub n_overflowed: u64,
}

/// A link with two directions.
///
/// Cost: constant per byte; no allocation once as many bytes as ever have been under way at a time.
#[derive(Clone, Debug)]
pub struct Link {
    from_a: Direction,
    from_b: Direction,
}

impl Link {
    /// A silent link. All faults follow from `rng`; the two directions draw independently.
    ///
    /// # Errors
    ///
    /// [`LinkConfigError`] for a speed of zero or a probability outside 0 to 1.
    pub fn new(config: &LinkConfig, mut rng: RandomStream) -> Result<Self, LinkConfigError> {
        let from_a = Direction::new(config, &mut rng)?;
        let from_b = Direction::new(config, &mut rng)?;
        Ok(Self { from_a, from_b })
    }

    /// Hands bytes to the link at `end`. They queue behind the bytes already sent from there.
    pub fn send(&mut self, end: End, now: Stamp, bytes: &[u8]) {
        match end {
            End::A => self.from_a.send(now, bytes),
            End::B => self.from_b.send(now, bytes),
        }
    }

    /// Appends the bytes that have arrived at `end` by `now` to `into`.
    pub fn receive(&mut self, end: End, now: Stamp, into: &mut Vec<u8>) {
        match end {
            End::A => self.from_b.receive(now, into),
            End::B => self.from_a.receive(now, into),
        }
    }

    /// What became of the bytes sent from `end`.
    pub fn counters(&self, end: End) -> LinkCounters {
        match end {
            End::A => self.from_a.counters,
            End::B => self.from_b.counters,
        }
    }

    /// Cuts or mends the direction of the bytes sent from `end`. A cut loses what is under way; what is
    /// sent into it takes its time on the line and is lost as well. Faults that are drawn later do not
    /// depend on it.
    pub fn set_cut(&mut self, end: End, cut: bool) {
        match end {
            End::A => self.from_a.set_cut(cut),
            End::B => self.from_b.set_cut(cut),
        }
    }

    /// From now on bytes are sent from `end` at so many bits per second; 0 changes nothing.
    pub fn set_baud(&mut self, end: End, baud: u32) {
        let direction = match end {
            End::A => &mut self.from_a,
            End::B => &mut self.from_b,
        };
        if let Some(time) = byte_time(baud) {
            direction.byte_time = time;
        }
    }

    /// Whether the bytes sent from `end` are lost in a cut.
    pub fn is_cut(&self, end: End) -> bool {
        match end {
            End::A => self.from_a.cut,
            End::B => self.from_b.cut,
        }
    }

    /// Whether nothing is under way in either direction.
    pub fn is_idle(&self) -> bool {
        self.from_a.under_way.is_empty() && self.from_b.under_way.is_empty()
    }

    /// When the last byte sent from `end` will have left it: the line is free then.
    pub fn free_at(&self, end: End) -> Stamp {
        match end {
            End::A => self.from_a.free_at,
            End::B => self.from_b.free_at,
        }
    }
}

#[derive(Clone, Debug)]
struct Direction {
    byte_time: Duration,
    latency: Duration,
    jitter: Duration,
    loss_prob: f64,
    corruption_prob: f64,
    rng: RandomStream,
    under_way: VecDeque<(Stamp, u8)>,
    cut: bool,
    free_at: Stamp,
    burst_delay: Duration,
    counters: LinkCounters,
}

impl Direction {
    fn new(config: &LinkConfig, rng: &mut RandomStream) -> Result<Self, LinkConfigError> {
        let &LinkConfig { baud, latency, jitter, loss_prob, corruption_prob } = config;
        for (key, value) in [("loss_prob", loss_prob), ("corruption_prob", corruption_prob)] {
            if !(0.0..=1.0).contains(&value) {
                return Err(LinkConfigError::Probability { key, value });
            }
        }
        let byte_time = match baud {
            None => Duration::ZERO,
            Some(baud) => byte_time(baud).ok_or(LinkConfigError::Baud)?,
        };
        Ok(Self {
            byte_time,
            latency,
            jitter,
            loss_prob,
            corruption_prob,
            rng: RandomStream::seed_from_u64(rng.next_u64()),
            under_way: VecDeque::new(),
            cut: false,
            free_at: Stamp::ZERO,
            burst_delay: Duration::ZERO,
            counters: LinkCounters::default(),
        })
    }

    fn send(&mut self, now: Stamp, bytes: &[u8]) {
        if self.free_at <= now && !bytes.is_empty() {
            self.free_at = now;
            self.burst_delay = self.jitter.mul_f64(self.draw_for(!self.jitter.is_zero()));
        }
        for &byte in bytes {
            self.send_byte(byte);
        }
    }

    fn send_byte(&mut self, byte: u8) {
        self.counters.n_sent = self.counters.n_sent.saturating_add(1);
        if self.under_way.len() >= UNDER_WAY_MAX {
            self.counters.n_overflowed = self.counters.n_overflowed.saturating_add(1);
            return;
        }
        self.free_at = shift(self.free_at, self.byte_time);
        if self.draw_for(self.loss_prob > 0.0) < self.loss_prob {
            self.lose(1);
            return;
        }
        let mut byte = byte;
        if self.draw_for(self.corruption_prob > 0.0) < self.corruption_prob {
            self.counters.n_corrupted = self.counters.n_corrupted.saturating_add(1);
            byte ^= self.wrong_bits();
        }
        if self.cut {
            self.lose(1);
            return;
        }
        let delay = self.latency.saturating_add(self.burst_delay);
        self.under_way.push_back((shift(self.free_at, delay), byte));
    }

    fn set_cut(&mut self, cut: bool) {
        self.cut = cut;
        if cut {
            self.lose(self.under_way.len() as u64);
            self.under_way.clear();
        }
    }

    fn lose(&mut self, n_bytes: u64) {
        self.counters.n_lost = self.counters.n_lost.saturating_add(n_bytes);
    }

    fn receive(&mut self, now: Stamp, into: &mut Vec<u8>) {
        // A later burst may have drawn less jitter, but it waits for its turn: bytes never overtake
        // each other.
        while let Some(&(arrival, byte)) = self.under_way.front()
            && arrival <= now
        {
            self.under_way.pop_front();
            into.push(byte);
            self.counters.n_delivered = self.counters.n_delivered.saturating_add(1);
        }
    }

    /// An even draw from [0, 1), or 1 without drawing when nothing depends on it: a fault that is
    /// switched off costs no time.
    fn draw_for(&mut self, needed: bool) -> f64 {
        if !needed {
            return 1.0;
        }
        // 53 bits are exactly what an f64 in [0, 1) can hold.
        (self.rng.next_u64() >> 11) as f64 * 2.0_f64.powi(-53)
    }

    /// One to eight bits to flip, evenly over the 255 wrong bytes.
    fn wrong_bits(&mut self) -> u8 {
        let draw = self.rng.next_u32() >> 8;
        // The remainder is under 255, so the sum fits.
        u8::try_from(draw % 255).unwrap_or(0).saturating_add(1)
    }
}

fn byte_time(baud: u32) -> Option<Duration> {
    let nanos = BITS_PER_BYTE.saturating_mul(1_000_000_000);
    nanos.checked_div(u64::from(baud)).map(Duration::from_nanos)
}

/// What a receiver that listens at `read_baud` makes of bytes that were sent, without a pause, at `sent_baud` (bits per
/// second): it waits for a start bit, looks at the middle of the nine bits after it by its own time, and takes what it
/// sees for a byte. Speeds that differ by less than 5 % give the bytes that were sent.
#[expect(clippy::arithmetic_side_effects, reason = "bits of what is in memory fit into 64 bits")]
pub fn misread(sent: &[u8], sent_baud: u32, read_baud: u32, into: &mut Vec<u8>) {
    // Time in halves of 1 / (sent_baud · read_baud) s, so that it is whole.
    let (sent_bit, read_bit) = (2 * u64::from(read_baud), 2 * u64::from(sent_baud));
    if sent_bit == 0 || read_bit == 0 {
        return;
    }
    let level = |bit: u64| {
        let byte = usize::try_from(bit / BITS_PER_BYTE).ok().and_then(|i| sent.get(i));
        match (byte, bit % BITS_PER_BYTE) {
            (None, _) | (Some(_), 9) => true,
            (Some(_), 0) => false,
            (Some(byte), data) => byte >> (data - 1) & 1 != 0,
        }
    };
    let n_bits = BITS_PER_BYTE.saturating_mul(sent.len() as u64);
    let mut bit = 0;
    while bit < n_bits {
        let is_edge = !level(bit) && (bit == 0 || level(bit - 1));
        if !is_edge {
            bit += 1;
            continue;
        }
        let begin = bit * sent_bit;
        let middle = |k: u64| (begin + k * read_bit + read_bit / 2) / sent_bit;
        into.push((1..9).fold(0, |byte, k| byte | u8::from(level(middle(k))) << (k - 1)));
        // The next start bit is looked for behind the one in which the stop bit was looked for.
        bit = middle(9) + 1;
    }
}

fn shift(stamp: Stamp, by: Duration) -> Stamp {
    #[expect(clippy::arithmetic_side_effects, reason = "the sum saturates")]
    let later = stamp + by;
    later
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::{collection::vec, prelude::*};
    use run_context::RunSeed;

    fn link(config: &LinkConfig, seed: u64) -> Link {
        Link::new(config, RunSeed(seed).stream("link")).unwrap()
    }

    fn at_9600() -> LinkConfig {
        LinkConfig { baud: Some(9600), ..LinkConfig::default() }
    }

    /// Same speed: same bytes; up to 4 % off still; twice or half the speed: others, and about as many bits.
    #[test]
    fn bytes_at_another_speed_are_other_bytes() {
        let sent: Vec<u8> = (0..=255).collect();
        let read = |sent_baud, read_baud| {
            let mut into = Vec::new();
            misread(&sent, sent_baud, read_baud, &mut into);
            into
        };
        for baud in [9600, 9984, 9216] {
            assert_eq!(read(9600, baud), sent, "{baud}");
        }
        // U is 1, 0, 1, 0 … after its start bit; read twice as fast it is 0 (start), 1, 1, 0, 0, 1, 1, 0.
        let mut into = Vec::new();
        misread(b"U", 9600, 19_200, &mut into);
        assert_eq!(into.first(), Some(&0b0110_0110));
        for (sent_baud, read_baud) in [(9600, 19_200), (19_200, 9600), (230_400, 9600)] {
            let read = read(sent_baud, read_baud);
            assert_ne!(read, sent);
            assert!(!read.is_empty() && read.len() <= 2 * sent.len() * 2, "{}", read.len());
        }
    }

    fn received(link: &mut Link, end: End, now: Stamp) -> Vec<u8> {
        let mut into = Vec::new();
        link.receive(end, now, &mut into);
        into
    }

    /// The instant at which the last of the bytes under way arrives, to the microsecond.
    fn last_arrival(link: &mut Link, end: End, n_bytes: usize) -> Stamp {
        let mut into = Vec::new();
        (0..1_000_000)
            .map(|micros| Stamp::from_nanos(micros * 1000))
            .find(|&now| {
                link.receive(end, now, &mut into);
                into.len() == n_bytes
            })
            .unwrap()
    }

    /// The thesis, 7.4: a question of 14 bytes and its answer of 12 at 9600 baud, ten bits each.
    #[test]
    fn question_and_answer_spend_27_1_ms_on_the_wire() {
        let mut link = link(&at_9600(), 1);
        link.send(End::A, Stamp::ZERO, &[0; 14]);
        let asked = last_arrival(&mut link, End::B, 14);
        assert!((asked.as_secs_f64() - 0.014_583).abs() < 2e-6, "{asked}");
        link.send(End::B, asked, &[0; 12]);
        let answered = last_arrival(&mut link, End::A, 12);
        assert!((answered.as_secs_f64() - 0.027_083).abs() < 3e-6, "{answered}");
    }

    #[test]
    fn bytes_come_one_by_one() {
        let mut link = link(&at_9600(), 1);
        link.send(End::A, Stamp::ZERO, b"abc");
        // 1.0417 ms a byte.
        assert_eq!(received(&mut link, End::B, Stamp::from_millis(1)), b"");
        assert_eq!(received(&mut link, End::B, Stamp::from_nanos(1_042_000)), b"a");
        assert_eq!(received(&mut link, End::B, Stamp::from_millis(3)), b"b");
        assert_eq!(received(&mut link, End::B, Stamp::from_millis(4)), b"c");
        assert_eq!(link.free_at(End::A), Stamp::from_nanos(3_124_998));
    }

    #[test]
    fn a_busy_line_makes_the_next_packet_wait() {
        let mut link = link(&at_9600(), 1);
        link.send(End::A, Stamp::ZERO, &[1; 96]);
        link.send(End::A, Stamp::from_millis(50), &[2; 96]);
        // 192 bytes take 200 ms although the second half was sent at 50 ms.
        assert_eq!(received(&mut link, End::B, Stamp::from_millis(199)).len(), 191);
        assert_eq!(received(&mut link, End::B, Stamp::from_millis(200)).len(), 1);
    }

    #[test]
    fn the_directions_do_not_disturb_each_other() {
        let mut link = link(&at_9600(), 1);
        link.send(End::A, Stamp::ZERO, &[1; 10]);
        link.send(End::B, Stamp::ZERO, &[2; 5]);
        assert_eq!(received(&mut link, End::A, Stamp::from_millis(6)), [2; 5]);
        assert_eq!(received(&mut link, End::B, Stamp::from_millis(11)), [1; 10]);
        assert_eq!(received(&mut link, End::A, Stamp::from_millis(99)), []);
    }

    #[test]
    fn a_direct_link_delivers_at_once_and_latency_delays() {
        let mut direct = link(&LinkConfig::default(), 1);
        direct.send(End::B, Stamp::from_millis(5), b"now");
        assert_eq!(received(&mut direct, End::A, Stamp::from_millis(5)), b"now");
        let latency = Duration::from_millis(20);
        let mut slow = link(&LinkConfig { latency, ..LinkConfig::default() }, 1);
        slow.send(End::A, Stamp::from_millis(5), b"later");
        assert_eq!(received(&mut slow, End::B, Stamp::from_millis(24)), b"");
        assert_eq!(received(&mut slow, End::B, Stamp::from_millis(25)), b"later");
    }

    /// 100 000 bytes each; a binomial count strays more than five standard deviations (of 95 and
    /// 69) once in two million seeds.
    #[test]
    fn faults_come_as_often_as_configured() {
        let config = LinkConfig { loss_prob: 0.1, corruption_prob: 0.05, ..LinkConfig::default() };
        let mut link = link(&config, 3);
        let mut into = Vec::new();
        for _ in 0..1000 {
            link.send(End::A, Stamp::ZERO, &[0x5A; 100]);
            link.receive(End::B, Stamp::ZERO, &mut into);
        }
        let counters = link.counters(End::A);
        assert!(counters.n_lost.abs_diff(10_000) < 475, "{counters:?}");
        assert!(counters.n_corrupted.abs_diff(4500) < 345, "{counters:?}");
        assert_eq!(counters.n_sent, 100_000);
        assert_eq!(counters.n_delivered, counters.n_sent - counters.n_lost);
        let wrong = into.iter().filter(|&&byte| byte != 0x5A).count() as u64;
        assert_eq!(wrong, counters.n_corrupted);
        assert_eq!(link.counters(End::B), LinkCounters::default());
    }

    #[test]
    fn certain_loss_loses_everything_and_still_takes_the_line() {
        let mut link = link(&LinkConfig { loss_prob: 1.0, ..at_9600() }, 1);
        link.send(End::A, Stamp::ZERO, &[1; 96]);
        assert_eq!(received(&mut link, End::B, Stamp::from_millis(1000)), []);
        assert_eq!(
            (link.counters(End::A).n_lost, link.free_at(End::A).as_nanos() / 1_000_000),
            (96, 99)
        );
    }

    #[test]
    fn a_cut_loses_what_is_under_way_and_what_is_sent_one_way_only() {
        let config = LinkConfig { loss_prob: 0.3, corruption_prob: 0.3, ..at_9600() };
        let run = |cut: bool| {
            let mut link = link(&config, 4);
            let at = Stamp::from_millis;
            link.send(End::A, at(0), &[1; 20]);
            link.send(End::B, at(0), &[2; 20]);
            let first = received(&mut link, End::B, at(10));
            if cut {
                link.set_cut(End::A, true);
            }
            assert_eq!((link.is_cut(End::A), link.is_cut(End::B)), (cut, false));
            link.send(End::A, at(40), &[3; 20]);
            let second = received(&mut link, End::B, at(100));
            let back = received(&mut link, End::A, at(100));
            link.set_cut(End::A, false);
            link.send(End::A, at(200), &[4; 20]);
            let third = received(&mut link, End::B, at(300));
            (first, second, third, back, link.counters(End::A), link.free_at(End::A))
        };
        let (whole, cut) = (run(false), run(true));
        assert_eq!((&whole.0, &whole.2, &whole.3, whole.5), (&cut.0, &cut.2, &cut.3, cut.5));
        assert!(whole.1.len() > 10 && cut.1.is_empty());
        assert_eq!(cut.4.n_lost - whole.4.n_lost, whole.1.len() as u64);
        assert_eq!(cut.4.n_delivered + cut.4.n_lost, cut.4.n_sent);
    }

    #[test]
    fn an_overfull_line_refuses_bytes_and_says_so() {
        let mut link = link(&at_9600(), 1);
        link.send(End::A, Stamp::ZERO, &vec![1; 70_000]);
        assert_eq!(link.counters(End::A).n_overflowed, 70_000 - 65_536);
    }

    #[test]
    fn impossible_configurations_are_named() {
        let rng = || RunSeed(1).stream("link");
        let error = |config: LinkConfig| Link::new(&config, rng()).unwrap_err().to_string();
        assert_eq!(
            error(LinkConfig { baud: Some(0), ..LinkConfig::default() }),
            "link.baud = 0: must be positive, or absent for a direct link"
        );
        assert_eq!(
            error(LinkConfig { loss_prob: 1.5, ..LinkConfig::default() }),
            "link.loss_prob = 1.5: must be between 0 and 1"
        );
        assert!(
            error(LinkConfig { corruption_prob: f64::NAN, ..LinkConfig::default() })
                .contains("corruption_prob")
        );
    }

    #[test]
    fn a_warm_link_allocates_nothing() {
        let config = LinkConfig { jitter: Duration::from_millis(3), loss_prob: 0.01, ..at_9600() };
        let mut link = link(&config, 1);
        let mut into = Vec::with_capacity(4096);
        let mut round = |ticks: std::ops::Range<u64>| {
            for tick in ticks {
                let now = Stamp::from_millis(10 * tick);
                link.send(End::A, now, &[7; 9]);
                into.clear();
                link.receive(End::B, now, &mut into);
            }
        };
        round(0..100);
        assert_eq!(allocation_counter::measure(|| round(100..1000)).count_total, 0);
    }

    proptest! {
        #[test]
        fn order_is_kept_and_neither_cuts_nor_listening_change_anything(
            bytes in vec(any::<u8>(), 1..200), gaps_ms in vec(0_u64..30, 1..10), seed: u64,
        ) {
            let config = LinkConfig {
                latency: Duration::from_millis(2),
                jitter: Duration::from_millis(25),
                loss_prob: 0.05,
                corruption_prob: 0.05,
                ..at_9600()
            };
            let far = Stamp::from_millis(10_000);
            let run = |listen: bool| {
                let mut link = link(&config, seed);
                let (mut now, mut into) = (Stamp::ZERO, Vec::new());
                for (chunk, gap_ms) in bytes.chunks(20).zip(gaps_ms.iter().cycle()) {
                    link.send(End::A, now, chunk);
                    now += Duration::from_millis(*gap_ms);
                    if listen {
                        link.receive(End::B, now, &mut into);
                    }
                }
                link.receive(End::B, far, &mut into);
                into
            };
            prop_assert_eq!(run(true), run(false));
        }

        #[test]
        fn without_faults_the_same_bytes_come_out(chunks in vec(vec(any::<u8>(), 0..30), 0..10)) {
            let config = LinkConfig { jitter: Duration::from_millis(40), ..at_9600() };
            let mut link = link(&config, 5);
            for (index, chunk) in chunks.iter().enumerate() {
                link.send(End::A, Stamp::from_millis(7 * index as u64), chunk);
            }
            prop_assert_eq!(received(&mut link, End::B, Stamp::from_millis(9999)), chunks.concat());
        }
    }
}
