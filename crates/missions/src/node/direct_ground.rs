//! The ground's line without bytes: what is said is handed over at once, and nothing is lost for good in a cut.
//!
//! It does by itself what the two ends of a wired line do with repetitions, questions and answers: an order waits
//! until the line is mended, an end that could not be reported is heard of then, and a robot of which
//! nothing can be heard for as long as the ground waits has failed, and is to stop.

use std::time::Duration;

use drivers::{GroundStationEvent, sonar_report};
use geometry::Transform2;
use messages::{Command, Observations, Order, Report, Sensed};
use run_context::Stamp;
use wire::ground_link::ToGround;

use super::desk::{Desk, GroundOrder, Telemetry};
use crate::{
    asked::Asked,
    cut::{Cuts, Direction},
    run::line::{Around, Direct},
};

/// A line to the ground without bytes.
#[derive(Debug)]
pub(super) struct DirectGround {
    cuts: Cuts,
    /// The last order, until the robot has it.
    order: Option<GroundOrder>,
    /// What became of the robot's goal, until the ground can hear of it.
    end: Option<Telemetry>,
    /// When the ground could last hear an answer, or gave an order.
    heard: Stamp,
    /// How long it waits for one.
    answer_within: Duration,
}

impl DirectGround {
    pub(super) fn new(answer_within: Duration) -> Self {
        let (cuts, heard) = (Cuts::default(), Stamp::ZERO);
        Self { cuts, order: None, end: None, heard, answer_within }
    }

    /// Takes a new order of the ground; gives what reaches the robot now.
    fn pass_on(
        &mut self,
        now: Stamp,
        order: Option<GroundOrder>,
        telemetry: &mut Telemetry,
    ) -> Option<GroundOrder> {
        if order.is_some() {
            // It replaces the one before, of whose goal nothing more is heard.
            (self.order, self.end, self.heard) = (order, None, now);
        }
        if !self.cuts.any() {
            self.heard = now;
            if let Some(end) = self.end.take() {
                telemetry.end(end);
            }
        }
        if *telemetry == Telemetry::UnderWay && now.since(self.heard) >= self.answer_within {
            telemetry.end(Telemetry::SILENT);
            // It should not drive on to where nobody waits for it.
            self.order = Some(GroundOrder::Stop);
        }
        if self.cuts.back { None } else { self.order.take() }
    }

    /// What reaches the robot of a question, if the line to it is whole: nobody keeps one.
    fn pass(&self, asked: Asked) -> Option<Sensed> {
        let command = match asked {
            Asked::Link => Order::LinkTest,
            Asked::Sonar => Order::ReportSonar,
            Asked::Restart => return None,
        };
        (!self.cuts.back).then_some(Sensed::Order(command))
    }

    /// An answer of the robot as the ground hears it, if the line from it is whole.
    fn heard(&self, answer: ToGround) -> Option<GroundStationEvent> {
        (!self.cuts.away).then_some(GroundStationEvent::Heard(answer))
    }

    /// The robot reports the end of its goal.
    fn report(&mut self, end: Telemetry, telemetry: &mut Telemetry) {
        if self.order.is_some() {
            // The end of a goal before the last order, which the robot does not have yet.
            return;
        }
        if self.cuts.away {
            self.end = Some(end);
        } else {
            telemetry.end(end);
        }
    }
}

impl Direct for DirectGround {
    fn step(&mut self, around: &mut Around<'_>, observations: &mut Observations) {
        let now = around.now;
        let Desk { order, question, telemetry, events } = &mut *around.desk;
        if let Some(value) = question.take().and_then(|asked| self.pass(asked)) {
            observations.push(now, value);
        }
        if let Some(order) = self.pass_on(now, order.take(), telemetry) {
            let value = Sensed::Order(match order {
                GroundOrder::GoTo(pose) => Order::GoTo { goal_in_map: Transform2::new(pose) },
                GroundOrder::Stop => Order::Stop,
                GroundOrder::Restart => {
                    events.extend(self.heard(ToGround::Restarted));
                    Order::Restart
                }
            });
            observations.push(now, value);
        }
    }

    fn command(&mut self, command: &Command, desk: &mut Desk) {
        let Desk { telemetry, events, .. } = desk;
        match command {
            Command::Report(Report::Arrived) => self.report(Telemetry::Arrived, telemetry),
            Command::Report(Report::Failed(reason)) => {
                self.report(Telemetry::Failed(reason.as_str()), telemetry);
            }
            Command::Report(Report::LinkEcho) => events.extend(self.heard(ToGround::LinkTest)),
            Command::Report(Report::Sonar(ranges_m)) => {
                events.extend(self.heard(sonar_report(ranges_m)));
            }
            _ => {}
        }
    }

    fn set_cut(&mut self, direction: Direction, cut: bool) {
        self.cuts.set(direction, cut);
    }
}

#[cfg(test)]
mod tests {
    use geometry::Se2;

    use super::*;

    const STOP: Option<GroundOrder> = Some(GroundOrder::Stop);

    fn goal(x_m: f64) -> GroundOrder {
        GroundOrder::GoTo(Se2::new(x_m, 0.0, 0.0))
    }

    fn at(ms: u64) -> Stamp {
        Stamp::from_millis(ms)
    }

    fn line() -> DirectGround {
        DirectGround::new(Duration::from_secs(5))
    }

    #[test]
    fn an_order_in_a_cut_comes_when_the_line_is_mended_and_only_the_last_one() {
        let mut telemetry = Telemetry::NoGoal;
        for direction in [Direction::Both, Direction::Back] {
            let mut line = line();
            line.set_cut(direction, true);
            assert_eq!(line.pass_on(at(0), Some(goal(1.0)), &mut telemetry), None);
            assert_eq!(line.pass_on(at(10), STOP, &mut telemetry), None);
            assert_eq!(line.pass_on(at(60_000), None, &mut telemetry), None);
            line.set_cut(direction, false);
            assert_eq!(line.pass_on(at(60_010), None, &mut telemetry), STOP);
            assert_eq!(line.pass_on(at(60_020), None, &mut telemetry), None, "once");
        }
        let mut line = line();
        line.set_cut(Direction::Away, true);
        assert_eq!(
            line.pass_on(at(0), STOP, &mut telemetry),
            STOP,
            "the way to the robot is whole"
        );
    }

    #[test]
    fn a_robot_that_cannot_be_heard_has_failed_in_time_and_is_to_stop() {
        for direction in Direction::ALL {
            let (mut line, mut telemetry) = (line(), Telemetry::UnderWay);
            line.pass_on(at(0), Some(goal(1.0)), &mut telemetry);
            line.pass_on(at(20_000), None, &mut telemetry);
            assert_eq!(telemetry, Telemetry::UnderWay, "a long way is no silence");
            line.set_cut(direction, true);
            line.pass_on(at(24_990), None, &mut telemetry);
            assert_eq!(telemetry, Telemetry::UnderWay);
            let mut given = line.pass_on(at(25_000), None, &mut telemetry);
            assert_eq!(telemetry, Telemetry::SILENT, "{direction:?}");
            line.set_cut(direction, false);
            given = given.or(line.pass_on(at(25_010), None, &mut telemetry));
            assert_eq!(given, STOP, "{direction:?}");
        }
    }

    #[test]
    fn an_end_that_was_not_heard_is_heard_late_and_never_of_a_goal_before() {
        let (mut line, mut telemetry) = (line(), Telemetry::UnderWay);
        line.pass_on(at(0), Some(goal(1.0)), &mut telemetry);
        line.set_cut(Direction::Away, true);
        line.report(Telemetry::Arrived, &mut telemetry);
        assert_eq!(telemetry, Telemetry::UnderWay);
        line.set_cut(Direction::Away, false);
        line.pass_on(at(100), None, &mut telemetry);
        assert_eq!(telemetry, Telemetry::Arrived);
        // The next goal waits in a cut while the robot arrives at the one before.
        line.pass_on(at(200), Some(goal(2.0)), &mut telemetry);
        line.set_cut(Direction::Back, true);
        telemetry = Telemetry::UnderWay;
        line.pass_on(at(300), Some(goal(3.0)), &mut telemetry);
        line.report(Telemetry::Arrived, &mut telemetry);
        line.set_cut(Direction::Back, false);
        assert_eq!(line.pass_on(at(400), None, &mut telemetry), Some(goal(3.0)));
        assert_eq!(telemetry, Telemetry::UnderWay);
    }
}
