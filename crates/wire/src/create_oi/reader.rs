//! Reading along on a Create's line.

use std::fmt::Write as _;

use super::{Command, CommandDecoder, Frame, Radius, Readings, StreamDecoder, format, ids};
use crate::{Reader, Take, Towards};

/// Reads along in one direction.
pub(crate) fn reader(towards: Towards) -> Box<dyn Reader> {
    match towards {
        Towards::Robot => Box::new(Commands(CommandDecoder::new())),
        Towards::Client => Box::new(Frames(StreamDecoder::new())),
    }
}

#[derive(Debug)]
struct Commands(CommandDecoder);

impl Reader for Commands {
    fn push(&mut self, bytes: &[u8], take: Take<'_>) {
        self.0.push(bytes);
        while let Some(command) = self.0.next_command() {
            let mut raw = Vec::new();
            command.encode(&mut raw);
            take(raw, describe(&command));
        }
        let dropped: Vec<u8> = self.0.take_dropped().collect();
        if !dropped.is_empty() {
            let text = format!("{} bytes that are no opcode", dropped.len());
            take(dropped, text);
        }
    }
}

#[derive(Debug)]
struct Frames(StreamDecoder);

impl Reader for Frames {
    fn push(&mut self, bytes: &[u8], take: Take<'_>) {
        self.0.push(bytes);
        loop {
            let before = self.0.bytes_skipped();
            let frame = self.0.next_frame();
            let skipped = self.0.bytes_skipped().saturating_sub(before);
            if skipped > 0 {
                take(Vec::new(), format!("{skipped} bytes outside of any frame"));
            }
            let Some(Frame { readings, .. }) = frame else { return };
            let known: Vec<u8> = (0..=u8::MAX).filter(|&id| readings.get(id).is_some()).collect();
            let mut raw = Vec::new();
            super::write_frame(&known, &readings, &mut raw);
            take(raw, describe_readings(&known, &readings));
        }
    }
}

fn describe_readings(known: &[u8], readings: &Readings) -> String {
    let mut line = "STREAM".to_owned();
    for (index, &id) in known.iter().enumerate() {
        let (Some(format), Some(value)) = (format(id), readings.get(id)) else { continue };
        let before = if index == 0 { " " } else { ", " };
        // Writing to a string cannot fail.
        let _written = match id {
            ids::MODE => write!(line, "{before}mode {}", mode_name(value)),
            _ => write!(line, "{before}{} {value}", format.name),
        };
    }
    line
}

fn mode_name(mode: i32) -> &'static str {
    match mode {
        0 => "off",
        1 => "passive",
        2 => "safe",
        3 => "full",
        _ => "not known here",
    }
}

/// A line of text that says what a command means.
fn describe(command: &Command) -> String {
    match command {
        Command::Reset => "RESET".to_owned(),
        Command::Start => "START: passive".to_owned(),
        Command::Baud(code) => match super::BAUDS.get(usize::from(*code)) {
            Some(baud) => format!("BAUD {baud}"),
            None => format!("BAUD of code {code}, which there is not"),
        },
        Command::Safe => "SAFE".to_owned(),
        Command::Full => "FULL".to_owned(),
        Command::Power => "POWER off".to_owned(),
        Command::Spot => "SPOT".to_owned(),
        Command::Clean => "CLEAN".to_owned(),
        Command::Max => "MAX".to_owned(),
        Command::Drive { speed_mmps, radius } => {
            let how = match radius {
                Radius::Straight => "straight".to_owned(),
                Radius::Clockwise => "on the spot, clockwise".to_owned(),
                Radius::CounterClockwise => "on the spot, counter-clockwise".to_owned(),
                Radius::Arc(radius_mm) => format!("radius {radius_mm} mm"),
            };
            format!("DRIVE {speed_mmps} mm/s, {how}")
        }
        Command::Motors(bits) => format!("MOTORS {bits:#04x}"),
        Command::Leds { bits, colour, intensity } => {
            format!("LEDS {bits:#04x}, colour {colour}, brightness {intensity}")
        }
        Command::Song { number, notes } => format!("SONG {number} of {} notes", notes.len()),
        Command::Play(number) => format!("PLAY song {number}"),
        Command::Sensors(id) => format!("SENSORS packet {id} wanted"),
        Command::Dock => "DOCK".to_owned(),
        Command::PwmMotors([main, side, vacuum]) => format!("PWM MOTORS {main}, {side}, {vacuum}"),
        Command::DriveDirect { right_mmps, left_mmps } => {
            format!("DRIVE DIRECT left {left_mmps} mm/s, right {right_mmps} mm/s")
        }
        Command::DrivePwm { right, left } => format!("DRIVE PWM left {left}, right {right} of 255"),
        Command::Stream(ids) => format!("STREAM of packets {ids:?}"),
        Command::QueryList(ids) => format!("QUERY LIST of packets {ids:?}"),
        Command::Pause { streams: true } => "STREAM goes on".to_owned(),
        Command::Pause { streams: false } => "STREAM is held".to_owned(),
        Command::SchedulingLeds(_) => "SCHEDULING LEDS".to_owned(),
        Command::DigitLedsRaw(_) => "DIGIT LEDS RAW".to_owned(),
        // Strings come from strangers: escaped, they stay on their line.
        Command::DigitLedsAscii(text) => format!("DIGIT LEDS \"{}\"", text.escape_ascii()),
        Command::Buttons(bits) => format!("BUTTONS {bits:#04x}"),
        Command::Schedule(_) => "SCHEDULE".to_owned(),
        Command::SetDayTime([day, hour, minute]) => {
            format!("SET DAY/TIME {day} {hour}:{minute:02}")
        }
        Command::Stop => "STOP: interface off".to_owned(),
    }
}
