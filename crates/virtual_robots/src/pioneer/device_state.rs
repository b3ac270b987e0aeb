//! What a client asked the robot's devices to send.

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

/// Requests that may wait to be taken; the rest are dropped and counted as unexpected.
pub(super) const N_REQUESTS_MAX: usize = 16;
