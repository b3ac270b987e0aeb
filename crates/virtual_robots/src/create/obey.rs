//! What each command does to the robot.

use std::time::Duration;

use robot_models::WheelSpeeds;
use wire::create_oi::{BAUDS, Command, Radius};

use super::state::{CreateFirmware, Mode, N_SONGS, REST, Requested, STREAM_PERIOD, Site};
use crate::NumberSet;

/// The fastest a wheel turns, mm/s.
const SPEED_MAX_MMPS: i16 = 500;
/// The greatest radius, mm.
const RADIUS_MAX_MM: i16 = 2000;
/// The greatest duty of a wheel.
const PWM_MAX: i16 = 255;
/// How long a button is pressed that a command pressed.
const BUTTON_TIME: Duration = Duration::from_micros(166_667);
/// A unit of a note's duration.
const NOTE_UNIT: Duration = Duration::from_micros(15_625);

impl CreateFirmware {
    pub(super) fn listen(&mut self, site: Site<'_>, received: &[u8], out: &mut Vec<u8>) {
        if self.is_asleep {
            return;
        }
        self.decoder.push(received);
        while let Some(command) = self.decoder.next_command() {
            self.n_heard += 1;
            self.obey(site, &command, out);
        }
        self.decoder.take_dropped().for_each(|byte| self.unknown.insert(byte));
    }

    fn obey(&mut self, site: Site<'_>, command: &Command, out: &mut Vec<u8>) {
        if !self.is_in_place(command) {
            return;
        }
        match command {
            Command::Reset => {
                self.enter(Mode::Off);
                self.is_streaming = false;
                self.stream.clear();
            }
            Command::Start => {
                if self.mode == Mode::Off {
                    self.unknown = NumberSet::default();
                }
                self.enter(Mode::Passive);
            }
            Command::Stop => {
                self.enter(Mode::Off);
                self.is_streaming = false;
            }
            Command::Power => self.fall_asleep("it was switched off (133)"),
            Command::Safe => self.enter(Mode::Safe),
            Command::Full => self.enter(Mode::Full),
            Command::Spot | Command::Clean | Command::Max | Command::Dock => {
                self.enter(Mode::Passive);
                let number = command.opcode();
                self.note(format!(
                    "{number}: it neither cleans nor docks here; in passive mode now"
                ));
            }
            Command::Baud(code) => match BAUDS.get(usize::from(*code)) {
                Some(&baud) => self.baud = baud,
                None => self.note(format!("129 {code}: there is no such speed of the line")),
            },
            Command::Drive { speed_mmps, radius } => self.drive(*speed_mmps, *radius),
            Command::DriveDirect { right_mmps, left_mmps } => {
                let limited = |mmps: i16| mmps.clamp(-SPEED_MAX_MMPS, SPEED_MAX_MMPS);
                let (right_mmps, left_mmps) = (limited(*right_mmps), limited(*left_mmps));
                self.turn_wheels(Requested { right_mmps, left_mmps, ..REST });
            }
            Command::DrivePwm { right, left } => {
                let (right_mmps, left_mmps) = (speed_of_pwm(*right), speed_of_pwm(*left));
                self.turn_wheels(Requested { right_mmps, left_mmps, ..REST });
            }
            Command::Sensors(id) => self.answer(site, &[*id], out),
            Command::QueryList(ids) => self.answer(site, ids, out),
            Command::Stream(ids) => {
                self.stream.clone_from(ids);
                self.go_on_streaming(!ids.is_empty());
            }
            Command::Pause { streams } => self.go_on_streaming(*streams && !self.stream.is_empty()),
            Command::Song { number, notes } => {
                if let Some(song) = self.songs.get_mut(usize::from(*number)) {
                    song.clone_from(notes);
                }
            }
            Command::Play(number) => self.play(*number),
            Command::Buttons(bits) => {
                self.buttons = *bits;
                self.buttons_end = self.now + BUTTON_TIME;
            }
            Command::Motors(_)
            | Command::Leds { .. }
            | Command::PwmMotors(_)
            | Command::SchedulingLeds(_)
            | Command::DigitLedsRaw(_)
            | Command::DigitLedsAscii(_)
            | Command::Schedule(_)
            | Command::SetDayTime(_) => {}
        }
    }

    /// Whether its mode lets the robot obey; if not, whoever watches is told once.
    fn is_in_place(&mut self, command: &Command) -> bool {
        let least = match command {
            Command::Reset | Command::Start => Mode::Off,
            Command::Drive { .. }
            | Command::DriveDirect { .. }
            | Command::DrivePwm { .. }
            | Command::Motors(_)
            | Command::PwmMotors(_)
            | Command::Leds { .. }
            | Command::SchedulingLeds(_)
            | Command::DigitLedsRaw(_)
            | Command::DigitLedsAscii(_)
            | Command::Play(_) => Mode::Safe,
            _ => Mode::Passive,
        };
        if self.mode >= least {
            return true;
        }
        let number = command.opcode();
        if !self.unexpected.iter().any(|known| known == number) {
            self.unexpected.insert(number);
            let why = match self.mode {
                Mode::Off => "the interface is off; 128 (START) comes first",
                _ => "it is in passive mode; 131 (SAFE) or 132 (FULL) comes first",
            };
            self.note(format!("command {number} has no effect: {why}"));
        }
        false
    }

    fn drive(&mut self, speed_mmps: i16, radius: Radius) {
        let speed_mmps = speed_mmps.clamp(-SPEED_MAX_MMPS, SPEED_MAX_MMPS);
        let speed = f64::from(speed_mmps);
        let half_base_mm = 500.0 * self.model.drive.wheelbase_m;
        let [left, right] = match radius {
            Radius::Straight => [speed, speed],
            Radius::Clockwise => [speed, -speed],
            // A radius of 0 is not described; it turns on the spot.
            Radius::CounterClockwise | Radius::Arc(0) => [-speed, speed],
            Radius::Arc(radius_mm) => {
                let radius_mm = f64::from(radius_mm.clamp(-RADIUS_MAX_MM, RADIUS_MAX_MM));
                [speed * (1.0 - half_base_mm / radius_mm), speed * (1.0 + half_base_mm / radius_mm)]
            }
        };
        let limit = f64::from(SPEED_MAX_MMPS);
        // A wheel that cannot turn so fast turns as fast as it can.
        let [left_mmps, right_mmps] =
            [left, right].map(|mmps| mmps.clamp(-limit, limit).round() as i16);
        let requested = Requested { velocity_mmps: speed_mmps, radius, right_mmps, left_mmps };
        self.turn_wheels(requested);
    }

    fn turn_wheels(&mut self, requested: Requested) {
        self.requested = requested;
        self.wheels = WheelSpeeds {
            left_mps: 0.001 * f64::from(requested.left_mmps),
            right_mps: 0.001 * f64::from(requested.right_mmps),
        };
        for (sign, mmps) in self.signs.iter_mut().zip([requested.left_mmps, requested.right_mmps]) {
            if mmps != 0 {
                *sign = i64::from(mmps.signum());
            }
        }
    }

    fn go_on_streaming(&mut self, on: bool) {
        self.is_streaming = on;
        self.next_frame = self.now + STREAM_PERIOD;
    }

    fn answer(&mut self, site: Site<'_>, ids: &[u8], out: &mut Vec<u8>) {
        let readings = self.read(site, ids);
        for &id in ids {
            if !readings.write(id, out) {
                self.note(format!("there is no packet {id}"));
            }
        }
    }

    fn play(&mut self, number: u8) {
        if usize::from(number) >= N_SONGS {
            return;
        }
        self.song_number = number;
        let notes = &self.songs[usize::from(number)];
        let units: u32 = notes.iter().map(|note| u32::from(note[1])).sum();
        self.song_ends = self.now + NOTE_UNIT * units;
    }
}

/// The speed of a wheel at that duty, mm/s.
fn speed_of_pwm(pwm: i16) -> i16 {
    let share = i32::from(pwm.clamp(-PWM_MAX, PWM_MAX));
    // Within ±500.
    (share * i32::from(SPEED_MAX_MMPS) / i32::from(PWM_MAX)) as i16
}
