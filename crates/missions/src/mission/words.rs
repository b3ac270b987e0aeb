//! Words of mission files that choose among a few and that no other crate owns.
//!
//! Each enum is the one list of its words: checks, template and guide read it.

/// What a line is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum LineKind {
    Memory,
    Direct,
    Tcp,
    Serial,
}

settings::choices!(LineKind {
    Memory = "memory": "simulated, with the real bytes",
    Direct = "direct": "no bytes: messages are handed over at once",
    Tcp = "tcp": "bytes over a socket, to a robot elsewhere",
    Serial = "serial": "bytes over a serial port, to a robot elsewhere",
});

impl LineKind {
    /// Those between nodes that are always simulated here.
    pub(super) const SIMULATED: &'static [Self] = &[Self::Memory, Self::Direct];
}

/// A device of the smart environment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum DeviceKind {
    Button,
    Motion,
    Latch,
    Lamp,
}

settings::choices!(DeviceKind {
    Button = "button": "an input that people press",
    Motion = "motion": "an input that is 1 while a person moves in its area",
    Latch = "latch": "an output that opens a door",
    Lamp = "lamp": "an output that gives light",
});

impl DeviceKind {
    /// Whether the program reads it; otherwise it drives it.
    pub(super) fn is_input(self) -> bool {
        matches!(self, Self::Button | Self::Motion)
    }
}

/// What cells of a map that nobody knows are, and what is outside of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum UnknownCells {
    Wall,
    Free,
}

settings::choices!(UnknownCells {
    Wall = "wall": "solid",
    Free = "free": "free space",
});

/// Where a robot's sonars are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum RingKind {
    Model,
    Five,
    Eight,
    Own,
}

settings::choices!(RingKind {
    Model = "model": "where its model has them",
    Five = "five": "ARTEMIC's front ring of five",
    Eight = "eight": "ARTEMIC's front ring of eight",
    Own = "own": "as ring_at lists them",
});

/// What happens.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum EventKind {
    Press,
    Release,
    Goal,
    Stop,
    PlaceBox,
    Remove,
    CutLine,
    RestoreLine,
    StopProgram,
    RunProgram,
    StallProgram,
    TestLine,
    ReportSonar,
    Restart,
}

settings::choices!(EventKind {
    Press = "press": "a button is pressed",
    Release = "release": "a button is let go",
    Goal = "goal": "robots are given a goal",
    Stop = "stop": "robots are told to stop",
    PlaceBox = "place_box": "a box is put down",
    Remove = "remove": "a thing is taken away",
    CutLine = "cut_line": "a line of robots is cut",
    RestoreLine = "restore_line": "a line of robots is mended",
    StopProgram = "stop_program": "the decision program is stopped",
    RunProgram = "run_program": "the decision program is set running",
    StallProgram = "stall_program": "the loop of the decision node stands still",
    TestLine = "test_line": "the ground asks robots whether they hear it",
    ReportSonar = "report_sonar": "the ground asks robots what their front sonars measure",
    Restart = "restart": "the ground has robots begin anew",
});

impl EventKind {
    /// The keys that it reads beside `at_s` and `do`.
    pub(super) fn keys(self) -> &'static [&'static str] {
        match self {
            Self::Press | Self::Release => &["device"],
            Self::Goal => &["robot", "pose", "pose_from_start", "after_arrival"],
            Self::Stop | Self::TestLine | Self::ReportSonar | Self::Restart => &["robot"],
            Self::PlaceBox => &["at_m", "size_m", "thing"],
            Self::Remove => &["thing"],
            Self::CutLine | Self::RestoreLine => &["robot", "line", "direction"],
            Self::StopProgram | Self::RunProgram => &[],
            Self::StallProgram => &["for_s"],
        }
    }

    /// Whether it is about the decision program.
    pub(super) fn needs_program(self) -> bool {
        matches!(self, Self::StopProgram | Self::RunProgram | Self::StallProgram)
    }
}
