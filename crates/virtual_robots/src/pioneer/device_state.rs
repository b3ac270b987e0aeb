//! What a client asked the robot's devices to send, and what a simulator is asked for.

use geometry::Se2;

/// Packets asked for: none, one, or one with each information packet.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Stream {
    #[default]
    Off,
    Once,
    Continuous,
}

impl Stream {
    /// What the argument of ENCODER, IOREQUEST, GRIPREQUEST and `SIM_STAT` asks for.
    pub(super) fn asked(argument: i16) -> Self {
        match argument {
            i16::MIN..=0 => Self::Off,
            1 => Self::Once,
            _ => Self::Continuous,
        }
    }

    pub(super) fn is_wanted(self) -> bool {
        self != Self::Off
    }

    pub(super) fn is_continuous(self) -> bool {
        self == Self::Continuous
    }

    /// One was sent.
    pub(super) fn sent(&mut self) {
        if *self == Self::Once {
            *self = Self::Off;
        }
    }
}

/// Packets beside the standard ones.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Streams {
    pub(super) encoder: Stream,
    pub(super) io: Stream,
    pub(super) gripper: Stream,
    pub(super) sim_stat: Stream,
}

/// What a client of a simulated robot wants of the simulator.
#[derive(Clone, Debug, PartialEq)]
pub enum SimRequest {
    /// That the true robot is put there, in the world.
    PlaceAt(Se2),
    /// That the true robot is put where it began.
    Reset,
    /// That whoever watches reads this; at most 195 bytes, from a stranger.
    Say(String),
    /// That the simulator ends with this exit code.
    Exit(i16),
}

/// Requests that may wait to be taken; the rest are dropped and counted as unexpected.
pub(super) const N_REQUESTS_MAX: usize = 16;

/// A set of command numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct CommandSet([u64; 4]);

impl CommandSet {
    pub(super) fn insert(&mut self, number: u8) {
        self.0[usize::from(number >> 6)] |= 1 << (number & 63);
    }

    pub(super) fn iter(self) -> impl Iterator<Item = u8> {
        (0..=u8::MAX).filter(move |n| self.0[usize::from(n >> 6)] >> (n & 63) & 1 != 0)
    }
}
