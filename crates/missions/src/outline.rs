//! What a recording holds, known before it is run again: how long it is, and when something was done.

use crate::{
    intervention::{Intervention, RecordedIntervention},
    mission::{Mission, plan::Action},
};

/// Steps without a word from the hand after which driving by hand begins anew.
const HAND_PAUSE_STEPS: u64 = 100;

/// A recording in brief.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Outline {
    /// Steps of 10 ms that it holds.
    pub n_steps: u64,
    /// What happened on the way, in order.
    pub marks: Vec<Mark>,
}

/// Something that was done.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mark {
    /// Before this step.
    pub step: u64,
    /// Whether a person did it; else the mission.
    pub by_person: bool,
    /// What, in a few words.
    pub text: String,
}

/// The events of a mission and what people did, as far as the recording goes.
pub(crate) fn outline(
    mission: &Mission,
    n_steps: u64,
    interventions: &[RecordedIntervention],
) -> Outline {
    let devices = &mission.parts().devices;
    let planned = mission.parts().events.iter().map(|event| Mark {
        step: event.at.as_nanos() / 10_000_000,
        by_person: false,
        text: match &event.action {
            Action::Button { device, pressed } => {
                let label = devices.get(*device).map_or("a button", |device| &device.label);
                format!("{label} is {}", if *pressed { "pressed" } else { "released" })
            }
            Action::Goal { .. } => "a goal is given".to_owned(),
            Action::Stop { .. } => "a stop is ordered".to_owned(),
            Action::Ask { asked, .. } => asked.done().to_owned(),
            Action::Program(action) => action.to_string(),
            Action::PlaceBox { name, .. } => format!("{name} is put down"),
            Action::Remove { name } => format!("{name} is taken away"),
            Action::Link { cut, .. } => {
                (if *cut { "a line is cut" } else { "a line is mended" }).to_owned()
            }
        },
    });
    let mut last_drive: Option<u64> = None;
    let mut marks: Vec<Mark> = planned.collect();
    for RecordedIntervention { step, intervention } in interventions {
        let text = match intervention {
            Intervention::PressButton { device } => format!("{device} pressed"),
            Intervention::PlaceBox { .. } => "a box put down".to_owned(),
            Intervention::RemoveThing { .. } => "a box taken away".to_owned(),
            Intervention::SendGoal { robot, .. } => format!("a goal for robot {robot}"),
            Intervention::Stop { robot } => format!("robot {robot} stopped"),
            Intervention::CutLink { robot, .. } => format!("a line of robot {robot} cut"),
            Intervention::RestoreLink { robot, .. } => format!("a line of robot {robot} mended"),
            Intervention::Halt => "all robots stopped".to_owned(),
            Intervention::Drive { robot, .. } => {
                let goes_on = last_drive.is_some_and(|last| step - last < HAND_PAUSE_STEPS);
                last_drive = Some(*step);
                if goes_on {
                    continue;
                }
                format!("robot {robot} driven by hand")
            }
        };
        marks.push(Mark { step: *step, by_person: true, text });
    }
    marks.retain(|mark| mark.step <= n_steps);
    marks.sort_by_key(|mark| mark.step);
    Outline { n_steps, marks }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_done_is_told_in_order_and_driving_once() {
        let mission = Mission::load("doorbell", &[]).unwrap();
        let drive = Intervention::Drive { robot: 0, speed_mps: 0.1, turn_rate_radps: 0.0 };
        let at = |step| RecordedIntervention { step, intervention: drive.clone() };
        let mut done: Vec<_> = [300, 310, 320, 900].map(at).into();
        let box_at = Intervention::RemoveThing { id: 9 };
        done.push(RecordedIntervention { step: 950, intervention: box_at });
        let outline = outline(&mission, 940, &done);
        let by_hand: Vec<u64> =
            outline.marks.iter().filter(|mark| mark.by_person).map(|mark| mark.step).collect();
        assert_eq!(by_hand, [300, 900], "and nothing behind the end");
        assert!(outline.marks.iter().any(|mark| !mark.by_person && mark.text.contains("pressed")));
        assert!(outline.marks.is_sorted_by_key(|mark| mark.step));
    }
}
