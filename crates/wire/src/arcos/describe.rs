//! One line of text per packet, for people who watch the wire.

use std::fmt::Write as _;

use super::{Command, Report};

/// A line of text that says what a packet's body means.
///
/// `from_robot` picks the reading: a robot's report or a client's command. A body that cannot be
/// read is described by its error.
pub fn describe(body: &[u8], from_robot: bool) -> String {
    if from_robot { describe_report(body) } else { describe_command(body) }
}

fn describe_command(body: &[u8]) -> String {
    let command = match Command::decode(body) {
        Ok(command) => command,
        Err(error) => return format!("bad command: {error}"),
    };
    match command {
        Command::Sync0 => "SYNC0 / PULSE".to_owned(),
        Command::Sync1 => "SYNC1".to_owned(),
        Command::Sync2 => "SYNC2".to_owned(),
        Command::Pulse => "PULSE".to_owned(),
        Command::Open => "OPEN".to_owned(),
        Command::Close => "CLOSE".to_owned(),
        Command::Polling(order) => format!("POLLING {} sensors", order.len()),
        Command::Enable(on) => format!("ENABLE motors {}", on_off(on)),
        Command::SetA(value) => format!("SETA {value} mm/s²"),
        Command::SetV(value) => format!("SETV {value} mm/s"),
        Command::SetO => "SETO origin here".to_owned(),
        Command::Move(value) => format!("MOVE {value} mm"),
        Command::Rotate(value) => format!("ROTATE {value} deg/s"),
        Command::SetRv(value) => format!("SETRV {value} deg/s"),
        Command::Vel(value) => format!("VEL {value} mm/s"),
        Command::Head(value) => format!("HEAD {value} deg"),
        Command::DHead(value) => format!("DHEAD {value} deg"),
        Command::Say(tones) => format!("SAY {} bytes", tones.len()),
        Command::Config => "CONFIG wanted".to_owned(),
        Command::Encoder(value) => format!("ENCODER packets {}", how_many(value)),
        Command::RVel(value) => format!("RVEL {value} deg/s"),
        Command::DcHead(value) => format!("DCHEAD {value} deg"),
        Command::SetRa(value) => format!("SETRA {value} deg/s²"),
        Command::Sonar(value) => format!("SONAR {}", on_off(value & 1)),
        Command::Stop => "STOP".to_owned(),
        Command::DigOut(bits) => format!("DIGOUT {bits:#06x}"),
        Command::Vel2 { left, right } => {
            let [left, right] = [left, right].map(|step| i32::from(step).saturating_mul(20));
            format!("VEL2 left {left} mm/s, right {right} mm/s")
        }
        Command::Gripper(value) => format!("GRIPPER {value}"),
        Command::GripperVal(value) => format!("GRIPPERVAL {value}"),
        Command::GripRequest(value) => format!("GRIPREQUEST packets {}", how_many(value)),
        Command::AdSel(port) => format!("ADSEL port {port}"),
        Command::IoRequest(value) => format!("IOREQUEST packets {}", how_many(value)),
        Command::BumpStall(value) => format!("BUMPSTALL {value}"),
        Command::HostBaud(value) => format!("HOSTBAUD {value}"),
        Command::EStop => "E_STOP".to_owned(),
        Command::BatteryInfo(value) => format!("BATTERYINFO packets {}", how_many(value)),
        Command::Sound(value) => format!("SOUND {value}"),
        Command::SoundTog(value) => format!("SOUNDTOG {}", on_off(value)),
        Command::SimSetPose { x_mm, y_mm, heading_deg } => {
            format!("SIM_SET_POSE {x_mm} mm, {y_mm} mm, {heading_deg} deg")
        }
        Command::SimReset => "SIM_RESET".to_owned(),
        Command::SimStat(value) => format!("SIM_STAT packets {}", how_many(value)),
        // Strings come from strangers: escaped, they stay on their line.
        Command::SimMessage(text) => {
            format!("SIM_MESSAGE \"{}\"", String::from_utf8_lossy(&text).escape_debug())
        }
        Command::SimExit(code) => format!("SIM_EXIT {code}"),
        Command::BatTest(decivolts) => format!("BATTEST {:.1} V", 0.1 * f64::from(decivolts)),
        Command::Other { number } => format!("command {number}, not known here"),
    }
}

fn describe_report(body: &[u8]) -> String {
    let report = match Report::decode(body) {
        Ok(report) => report,
        Err(error) => return format!("bad report: {error}"),
    };
    match report {
        Report::Sync0 => "SYNC0 echo".to_owned(),
        Report::Sync1 => "SYNC1 echo".to_owned(),
        Report::Sync2 { name, class, subclass } => {
            // Strings come from strangers: escaped, they stay on their line.
            let (class, subclass) = (class.escape_debug(), subclass.escape_debug());
            format!("SYNC2 echo: {name:?}, {class} {subclass}")
        }
        Report::Sip(sip) => {
            let mut line = format!(
                "SIP {} at {} mm, {} mm, {:.1} deg; wheels {} / {} mm/s; {:.1} V",
                if sip.moving { "moving" } else { "stopped" },
                // Two's complement: a robot behind its origin is at −500 mm, not at 65 036.
                sip.x_mm.cast_signed(),
                sip.y_mm.cast_signed(),
                sip.heading_rad().to_degrees(),
                sip.left_mmps,
                sip.right_mmps,
                f64::from(sip.battery_decivolts) / 10.0,
            );
            if sip.stalled() {
                line.push_str("; stalled");
            }
            let [front, rear] = sip.bumpers();
            if front | rear != 0 {
                // Writing to a string cannot fail.
                let _written = write!(line, "; bumpers front {front:05b}, rear {rear:05b}");
            }
            for (index, reading) in sip.sonar().iter().enumerate() {
                let before = if index == 0 { "; sonar " } else { ", " };
                // Writing to a string cannot fail.
                let _written = write!(line, "{before}{}: {} mm", reading.sensor, reading.range_mm);
            }
            line
        }
        Report::Config(config) => {
            let (name, watchdog) = (config.name, config.watchdog_ms);
            let subclass = config.subclass.escape_debug();
            format!("CONFIG {name:?}, {subclass}, watchdog {watchdog} ms")
        }
        Report::Encoder(ticks) => {
            format!("ENCODER left {} ticks, right {} ticks", ticks.left_ticks, ticks.right_ticks)
        }
        Report::Io(io) => {
            let ([user, front, rear, infrared], [out, _]) = (io.digital_in, io.digital_out);
            format!(
                "IO in {user:#04x}, bumpers front {front:#04x} rear {rear:#04x}, \
                 infrared {infrared:#04x}, out {out:#04x}"
            )
        }
        Report::Gripper(gripper) if gripper.kind == 0 => "GRIPPER none".to_owned(),
        Report::Gripper(gripper) => {
            format!("GRIPPER of kind {}, switches {:#04x}", gripper.kind, gripper.switches)
        }
        Report::SimStat(stat) => format!(
            "SIM_STAT truly at {} mm, {} mm, {} deg; last tick {} ms",
            stat.x_mm, stat.y_mm, stat.heading_deg, stat.last_interval_ms
        ),
        Report::Other { kind } => format!("report {kind:#04x}, not known here"),
    }
}

fn on_off(value: i16) -> &'static str {
    if value == 0 { "off" } else { "on" }
}

fn how_many(value: i16) -> &'static str {
    match value {
        0 => "off",
        1 => "once",
        _ => "continuous",
    }
}
