//! What the ground has asked a robot, and what it hears of it.

use std::time::Duration;

use drivers::GroundStationEvent;
use run_context::{Stamp, StateHash};
use wire::ground_link::ToGround;

use crate::{asked::Asked, view::LogLevel};

/// Distances of a sonar report from here on mean that nothing came back: the link's largest number, cm.
const NOTHING_CM: u16 = u16::MAX;

/// What the ground waits for, and since when.
#[derive(Clone, Debug, Default)]
pub(crate) struct Inquiry {
    since: [Option<Stamp>; Asked::ALL.len()],
}

impl Inquiry {
    /// It was asked just now; asked again before its answer it begins anew.
    pub(crate) fn begin(&mut self, asked: Asked, now: Stamp) {
        self.since[asked as usize] = Some(now);
    }

    /// What a message of the robot, or its silence, says to what was asked; nothing to what was not.
    pub(crate) fn hear(
        &mut self,
        event: GroundStationEvent,
        now: Stamp,
    ) -> Option<(LogLevel, String)> {
        let asked = Asked::ALL.into_iter().find(|asked| match event {
            GroundStationEvent::Heard(heard) => answers(heard, *asked),
            GroundStationEvent::Unanswered(order) => order == asked.message(),
            GroundStationEvent::Goal { .. } => false,
        })?;
        let since = self.since[asked as usize].take()?;
        let after_s = now.since(since).as_secs_f64();
        Some(match (event, asked) {
            (GroundStationEvent::Heard(ToGround::Sonar(ranges)), _) => {
                (LogLevel::Info, format!("reports its front sonars: {}", distances(&ranges)))
            }
            (GroundStationEvent::Heard(_), Asked::Restart) => {
                (LogLevel::Info, format!("begins anew, as it says after {after_s:.2} s"))
            }
            (GroundStationEvent::Heard(_), _) => {
                (LogLevel::Good, format!("answers the link test after {after_s:.2} s"))
            }
            _ => {
                let text = format!("does not answer for {after_s:.1} s: {}", asked.done());
                (LogLevel::Bad, text)
            }
        })
    }

    /// Over a line without bytes nobody repeats a question: it is given up after so long a silence.
    pub(crate) fn give_up(&mut self, now: Stamp, after: Duration) -> Option<(LogLevel, String)> {
        let is_late = |asked: &Asked| {
            self.since[*asked as usize].is_some_and(|since| now.since(since) >= after)
        };
        let asked = Asked::ALL.into_iter().find(is_late)?;
        self.hear(GroundStationEvent::Unanswered(asked.message()), now)
    }

    pub(crate) fn absorb_state(&self, hash: &mut StateHash) {
        for since in self.since {
            hash.absorb_u64(since.map_or(0, |since| since.as_nanos() + 1));
        }
    }
}

fn answers(heard: ToGround, asked: Asked) -> bool {
    matches!(
        (heard, asked),
        (ToGround::LinkTest, Asked::Link)
            | (ToGround::Sonar(_), Asked::Sonar)
            | (ToGround::Restarted, Asked::Restart)
    )
}

fn distances(ranges_cm: &[u16; 8]) -> String {
    let word = |cm: &u16| match *cm {
        NOTHING_CM => "–".to_owned(),
        cm => format!("{:.2}", f64::from(cm) / 100.0),
    };
    format!("{} m", ranges_cm.iter().map(word).collect::<Vec<_>>().join(" "))
}

#[cfg(test)]
mod tests {
    use wire::ground_link::ToVehicle;

    use super::*;

    fn at(ms: u64) -> Stamp {
        Stamp::from_millis(ms)
    }

    #[test]
    fn an_answer_is_told_once_and_only_to_what_was_asked() {
        let mut inquiry = Inquiry::default();
        let echo = GroundStationEvent::Heard(ToGround::LinkTest);
        assert_eq!(inquiry.hear(echo, at(5)), None, "nobody asked");
        inquiry.begin(Asked::Link, at(10));
        let sonar = GroundStationEvent::Heard(ToGround::Sonar([123; 8]));
        assert_eq!(inquiry.hear(sonar, at(15)), None, "another question");
        let (level, text) = inquiry.hear(echo, at(130)).unwrap();
        assert_eq!((level, text.as_str()), (LogLevel::Good, "answers the link test after 0.12 s"));
        assert_eq!(inquiry.hear(echo, at(140)), None, "told once");
    }

    #[test]
    fn silence_is_told() {
        let mut inquiry = Inquiry::default();
        inquiry.begin(Asked::Sonar, at(0));
        let lost = GroundStationEvent::Unanswered(ToVehicle::ReportSonar);
        let (level, text) = inquiry.hear(lost, at(5000)).unwrap();
        assert_eq!(level, LogLevel::Bad);
        assert_eq!(text, "does not answer for 5.0 s: a sonar report is asked for");
        inquiry.begin(Asked::Restart, at(6000));
        assert_eq!(inquiry.give_up(at(6900), Duration::from_secs(1)), None);
        assert!(inquiry.give_up(at(7000), Duration::from_secs(1)).unwrap().1.contains("restart"));
    }

    #[test]
    fn distances_are_metres_and_nothing_is_a_dash() {
        let text = distances(&[50, 123, 5000, NOTHING_CM, 1, 2, 3, 4]);
        assert_eq!(text, "0.50 1.23 50.00 – 0.01 0.02 0.03 0.04 m");
    }
}
