//! The packets a robot sends when asked: configuration and encoder counts.

use super::{
    BodyLength, ReportError,
    fields::{Fields, push_string},
    write_packet,
};

/// The robot's configuration. Units as the firmware keeps them: mm, degrees, seconds, tenths of a
/// volt. Defaults are those of a Pioneer 3-DX.
///
/// Reading stops without complaint where the packet ends: older firmware sends fewer fields, and
/// the rest keep their defaults. Fields after the kinematics delay are not read.
#[derive(Clone, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "the fields have the names of the manufacturer's table")]
pub struct ConfigPac {
    pub class: String,
    pub subclass: String,
    pub serial: String,
    pub four_motors: u8,
    pub rotation_top_degps: u16,
    pub speed_top_mmps: u16,
    pub rotation_acceleration_top_degps2: u16,
    pub acceleration_top_mmps2: u16,
    pub pwm_max: u16,
    pub name: String,
    pub sip_cycle_ms: u8,
    pub host_baud: u8,
    pub aux_baud: u8,
    pub gripper: u16,
    pub front_sonar: u16,
    pub rear_sonar: u8,
    pub low_battery_decivolts: u16,
    pub rev_count: u16,
    pub watchdog_ms: u16,
    pub normal_sips: u8,
    pub stall_value: u16,
    pub stall_count: u16,
    pub joystick_speed_mmps: u16,
    pub joystick_rotation_degps: u16,
    pub rotation_max_degps: u16,
    pub speed_max_mmps: u16,
    pub rotation_acceleration_degps2: u16,
    pub rotation_deceleration_degps2: u16,
    pub rotation_kp: u16,
    pub rotation_kv: u16,
    pub rotation_ki: u16,
    pub acceleration_mmps2: u16,
    pub deceleration_mmps2: u16,
    pub translation_kp: u16,
    pub translation_kv: u16,
    pub translation_ki: u16,
    pub front_bumpers: u8,
    pub rear_bumpers: u8,
    pub charger: u8,
    pub sonar_cycle_ms: u8,
    pub autobaud: u8,
    pub gyro: u8,
    pub drift: i16,
    pub aux2_baud: u8,
    pub aux3_baud: u8,
    pub ticks_per_mm: u16,
    pub shutdown_decivolts: u16,
    pub firmware_version: String,
    pub gyro_cw: u16,
    pub gyro_ccw: u16,
    pub kinematics_delay_ms: u8,
}

/// Encoder counts since the robot was switched on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct EncoderPac {
    /// Ticks of the left wheel, forwards positive; wraps.
    pub left_ticks: i32,
    /// Ticks of the right wheel, forwards positive; wraps.
    pub right_ticks: i32,
}

impl Default for ConfigPac {
    fn default() -> Self {
        Self {
            class: "Pioneer".to_owned(),
            subclass: "p3dx-sh".to_owned(),
            serial: "cairn-0001".to_owned(),
            four_motors: 0,
            rotation_top_degps: 500,
            speed_top_mmps: 2200,
            rotation_acceleration_top_degps2: 600,
            acceleration_top_mmps2: 4000,
            pwm_max: 500,
            name: "cairn".to_owned(),
            sip_cycle_ms: 100,
            host_baud: 0,
            aux_baud: 0,
            gripper: 0,
            front_sonar: 1,
            rear_sonar: 1,
            low_battery_decivolts: 110,
            rev_count: 16_570,
            watchdog_ms: 2000,
            normal_sips: 1,
            stall_value: 200,
            stall_count: 200,
            joystick_speed_mmps: 600,
            joystick_rotation_degps: 50,
            rotation_max_degps: 100,
            speed_max_mmps: 750,
            rotation_acceleration_degps2: 100,
            rotation_deceleration_degps2: 100,
            rotation_kp: 40,
            rotation_kv: 20,
            rotation_ki: 0,
            acceleration_mmps2: 300,
            deceleration_mmps2: 300,
            translation_kp: 40,
            translation_kv: 30,
            translation_ki: 0,
            front_bumpers: 0,
            rear_bumpers: 0,
            charger: 0,
            sonar_cycle_ms: 40,
            autobaud: 0,
            gyro: 0,
            drift: 0,
            aux2_baud: 0,
            aux3_baud: 0,
            ticks_per_mm: 128,
            shutdown_decivolts: 100,
            firmware_version: "2.9".to_owned(),
            gyro_cw: 0,
            gyro_ccw: 0,
            kinematics_delay_ms: 0,
        }
    }
}

/// Names every field once, in the packet's order, for both directions.
macro_rules! in_order {
    ($visit:ident) => {
        $visit! {
            text class, text subclass, text serial, u8 four_motors, u16 rotation_top_degps,
            u16 speed_top_mmps, u16 rotation_acceleration_top_degps2, u16 acceleration_top_mmps2,
            u16 pwm_max, text name, u8 sip_cycle_ms, u8 host_baud, u8 aux_baud, u16 gripper,
            u16 front_sonar, u8 rear_sonar, u16 low_battery_decivolts, u16 rev_count,
            u16 watchdog_ms, u8 normal_sips, u16 stall_value, u16 stall_count,
            u16 joystick_speed_mmps, u16 joystick_rotation_degps, u16 rotation_max_degps,
            u16 speed_max_mmps, u16 rotation_acceleration_degps2, u16 rotation_deceleration_degps2,
            u16 rotation_kp, u16 rotation_kv, u16 rotation_ki, u16 acceleration_mmps2,
            u16 deceleration_mmps2, u16 translation_kp, u16 translation_kv, u16 translation_ki,
            u8 front_bumpers, u8 rear_bumpers, u8 charger, u8 sonar_cycle_ms, u8 autobaud, u8 gyro,
            i16 drift, u8 aux2_baud, u8 aux3_baud, u16 ticks_per_mm, u16 shutdown_decivolts,
            text firmware_version, u16 gyro_cw, u16 gyro_ccw, u8 kinematics_delay_ms
        }
    };
}

impl ConfigPac {
    /// The packet's type byte.
    pub const KIND: u8 = 0x20;

    /// Appends the packet to `out`.
    ///
    /// # Errors
    ///
    /// [`BodyLength`] when the strings make it longer than a packet; `out` is left as it was.
    pub fn encode(&self, out: &mut Vec<u8>) -> Result<(), BodyLength> {
        let mut body = vec![Self::KIND];
        macro_rules! write_field {
            (text $field:ident) => {
                push_string(&self.$field, &mut body)
            };
            ($number:ident $field:ident) => {
                body.extend(self.$field.to_le_bytes())
            };
        }
        macro_rules! write_all {
            ($($kind:ident $field:ident),*) => { $( write_field!($kind $field); )* };
        }
        in_order!(write_all);
        write_packet(&body, out)
    }

    /// Reads the packet's body.
    ///
    /// # Errors
    ///
    /// [`ReportError`] when the type is not 0x20 or there is not even a class.
    pub fn decode(body: &[u8]) -> Result<Self, ReportError> {
        let mut fields = Fields::new(body);
        let kind = fields.u8().ok_or(ReportError::Empty)?;
        if kind != Self::KIND {
            return Err(ReportError::Kind { kind, expected: "0x20" });
        }
        if fields.is_empty() {
            return Err(ReportError::CutShort { kind, len: body.len(), field: "class" });
        }
        let mut config = Self::default();
        // Ends early where the packet does; what was read by then stays.
        let _whole = config.read(&mut fields);
        Ok(config)
    }

    #[expect(clippy::cognitive_complexity, reason = "fifty fields, one after the other")]
    fn read(&mut self, fields: &mut Fields<'_>) -> Option<()> {
        macro_rules! read_field {
            (text $field:ident) => {
                self.$field = fields.string()?
            };
            ($number:ident $field:ident) => {
                self.$field = fields.$number()?
            };
        }
        macro_rules! read_all {
            ($($kind:ident $field:ident),*) => { $( read_field!($kind $field); )* };
        }
        in_order!(read_all);
        Some(())
    }
}

impl EncoderPac {
    /// The packet's type byte.
    pub const KIND: u8 = 0x90;

    /// Appends the packet to `out`.
    pub fn encode(&self, out: &mut Vec<u8>) {
        let [[a, b, c, d], [e, f, g, h]] =
            [self.left_ticks, self.right_ticks].map(i32::to_le_bytes);
        let written = write_packet(&[Self::KIND, a, b, c, d, e, f, g, h], out);
        debug_assert!(written.is_ok(), "nine bytes fit a packet");
    }

    /// Reads the packet's body.
    ///
    /// # Errors
    ///
    /// [`ReportError`] when the type is not 0x90 or a count is missing.
    pub fn decode(body: &[u8]) -> Result<Self, ReportError> {
        let mut fields = Fields::new(body);
        let kind = fields.u8().ok_or(ReportError::Empty)?;
        if kind != Self::KIND {
            return Err(ReportError::Kind { kind, expected: "0x90" });
        }
        let mut ticks =
            |field| fields.i32().ok_or(ReportError::CutShort { kind, len: body.len(), field });
        Ok(Self { left_ticks: ticks("left count")?, right_ticks: ticks("right count")? })
    }
}
