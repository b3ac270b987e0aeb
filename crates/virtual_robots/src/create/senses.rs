//! What the robot senses, as its packets say it.

use std::time::Duration;

use geometry::{Ray, RayCaster as _, Vec2};
use wire::create_oi::{Readings, ids, members};

use super::state::{CreateFirmware, Feel, Mode, Site};

/// What a floor sensor's echo is worth above floor and above none.
const FLOOR_SIGNALS: [i32; 2] = [2500, 5];
/// Greatest value of a light bumper's echo.
const LIGHT_SIGNAL_MAX: f64 = 4095.0;
/// Greatest value of the wall sensor's echo.
const WALL_SIGNAL_MAX: f64 = 1023.0;
/// Byte that a virtual wall sends, and the one around a home base.
const IR_VIRTUAL_WALL: i32 = 162;
const IR_HOME_BASE: i32 = 161;
/// How far the home base's field reaches, metres.
const HOME_BASE_REACH_M: f64 = 0.6;
/// Current of a wheel's motor at full speed, and of one that is stopped by something, mA.
const WHEEL_CURRENT_MA: f64 = 250.0;
const STALL_CURRENT_MA: i32 = 1200;
/// Temperature that it reports, °C.
const TEMPERATURE_C: i32 = 25;
impl CreateFirmware {
    /// What is felt in every step, asked for or not.
    pub(super) fn sense(&mut self, site: Site<'_>, dt: Duration) {
        let Site { world, body_id } = site;
        let body = world.body(body_id);
        let before = self.ticks.replace(body.encoder_ticks).unwrap_or(body.encoder_ticks);
        let metres_per_tick = self.model.drive.metres_per_tick();
        let mut ways_m = [0.0; 2];
        for side in 0..2 {
            // The encoder tells how far, not which way.
            let counted = (body.encoder_ticks[side] - before[side]).abs() * self.signs[side];
            self.counts[side] += counted;
            ways_m[side] = metres_per_tick * counted as f64;
        }
        self.distance_m += 0.5 * (ways_m[0] + ways_m[1]);
        self.angle_rad += (ways_m[1] - ways_m[0]) / self.model.drive.wheelbase_m;
        let world_from_base = body.world_from_base.se2();
        let floor =
            |place: Vec2| world.fixtures().has_floor(world_from_base.transform_point(place));
        let wheel_y_m = 0.5 * self.model.drive.wheelbase_m;
        let mut cliffs = [false; 4];
        for (cliff, mount) in cliffs.iter_mut().zip(&self.model.devices.cliffs) {
            *cliff = !floor(mount.place);
        }
        self.feel = Feel {
            // The bumper moves in only where something lies against it.
            bumps: if body.touching { self.bumpers.pressed(world, body_id) as u8 } else { 0 },
            drops: [-wheel_y_m, wheel_y_m].map(|y_m| !floor(Vec2::new(0.0, y_m))),
            cliffs,
            stalled: body.stalled,
            is_docked: world.fixtures().is_docked(world_from_base),
            hears_wall: world.fixtures().in_virtual_wall(world_from_base.position()),
        };
        let top_mps = self.model.limits.speed_max_mps;
        let effort = 0.5 * (self.wheels.left_mps.abs() + self.wheels.right_mps.abs()) / top_mps;
        self.power.pass(dt, effort, self.charges());
    }

    /// It charges neither in safe nor in full mode.
    fn charges(&self) -> bool {
        self.feel.is_docked && self.mode < Mode::Safe
    }

    /// The packets of `wanted`, read now: way and angle among them start anew.
    pub(super) fn read(&mut self, site: Site<'_>, wanted: &[u8]) -> Readings {
        let asks = |id: u8| wanted.iter().any(|&w| members(w).is_some_and(|ids| ids.contains(&id)));
        let mut r = Readings::default();
        self.read_contacts(&mut r);
        self.read_state(&mut r);
        self.read_motion(&mut r);
        let looks = asks(ids::WALL) || asks(ids::WALL_SIGNAL);
        let looks_ahead = (ids::LIGHT_BUMPER..=ids::LIGHT_LEFT_SIGNAL + 5).any(asks);
        if looks || looks_ahead {
            self.read_infrareds(site, &mut r);
        }
        let hears = match self.feel.hears_wall {
            true => IR_VIRTUAL_WALL,
            false if near_home(site) => IR_HOME_BASE,
            false => 0,
        };
        for id in [ids::IR_OMNI, ids::IR_LEFT, ids::IR_RIGHT] {
            r.set(id, hears);
        }
        if asks(ids::DISTANCE) {
            let whole_mm = (1000.0 * self.distance_m).trunc();
            r.set(ids::DISTANCE, whole_mm as i32);
            self.distance_m -= 0.001 * whole_mm;
        }
        if asks(ids::ANGLE) {
            let whole_deg = self.angle_rad.to_degrees().trunc();
            r.set(ids::ANGLE, whole_deg as i32);
            self.angle_rad -= whole_deg.to_radians();
        }
        r
    }

    fn read_contacts(&self, r: &mut Readings) {
        let Feel { bumps, drops, cliffs, stalled, hears_wall, .. } = self.feel;
        let drops = i32::from(drops[0]) << 2 | i32::from(drops[1]) << 3;
        r.set(ids::BUMPS_AND_DROPS, i32::from(bumps & 0b11) | drops);
        for (id, cliff) in (0..).zip(cliffs) {
            r.set(ids::CLIFF_LEFT + id, cliff.into());
            r.set(ids::CLIFF_LEFT_SIGNAL + id, FLOOR_SIGNALS[usize::from(cliff)]);
        }
        r.set(ids::VIRTUAL_WALL, hears_wall.into());
        let [left, right] = stalled.map(i32::from);
        r.set(ids::OVERCURRENTS, right << 3 | left << 4);
    }

    fn read_state(&self, r: &mut Readings) {
        let charging = match (self.charges(), self.power.is_full()) {
            (false, _) => 0,
            (true, false) => 2,
            (true, true) => 3,
        };
        let rounded = |value: f64| value.round() as i32;
        r.set(ids::BUTTONS, if self.now < self.buttons_end { self.buttons.into() } else { 0 });
        r.set(ids::CHARGING_STATE, charging);
        r.set(ids::VOLTAGE, rounded(1000.0 * self.power.voltage_v()));
        r.set(ids::CURRENT, rounded(self.power.current_ma));
        r.set(ids::TEMPERATURE, TEMPERATURE_C);
        r.set(ids::CHARGE, rounded(self.power.charge_mah));
        r.set(ids::CAPACITY, rounded(self.power.model.capacity_mah));
        r.set(ids::CHARGING_SOURCES, i32::from(self.feel.is_docked) << 1);
        r.set(ids::MODE, self.mode as i32);
        r.set(ids::SONG_NUMBER, self.song_number.into());
        r.set(ids::SONG_PLAYING, (self.now < self.song_ends).into());
        r.set(ids::STREAM_PACKETS, self.stream.len() as i32);
    }

    fn read_motion(&self, r: &mut Readings) {
        let asked = self.requested;
        r.set(ids::REQUESTED_VELOCITY, asked.velocity_mmps.into());
        r.set(ids::REQUESTED_RADIUS, asked.radius.to_wire().into());
        r.set(ids::REQUESTED_RIGHT, asked.right_mmps.into());
        r.set(ids::REQUESTED_LEFT, asked.left_mmps.into());
        let [left, right] = self.counts.map(|count| count.rem_euclid(1 << 16) as i32);
        r.set(ids::ENCODER_LEFT, left);
        r.set(ids::ENCODER_RIGHT, right);
        let top_mps = self.model.limits.speed_max_mps;
        let current = |mps: f64, is_stalled: bool| {
            let turning = (WHEEL_CURRENT_MA * mps / top_mps).round() as i32;
            if is_stalled { STALL_CURRENT_MA * turning.signum() } else { turning }
        };
        let [left, right] = self.feel.stalled;
        r.set(ids::MOTOR_LEFT_CURRENT, current(self.wheels.left_mps, left));
        r.set(ids::MOTOR_RIGHT_CURRENT, current(self.wheels.right_mps, right));
        let forwards = self.wheels.left_mps + self.wheels.right_mps > 0.0;
        r.set(ids::STASIS, (forwards && self.feel.stalled == [false; 2]).into());
    }

    /// The first infrared sensor is the wall's, the others are the light bumper's, from left to right.
    fn read_infrareds(&self, site: Site<'_>, r: &mut Readings) {
        let scene = site.world.scene(Some(site.body_id));
        let world_from_base = site.world.body(site.body_id).world_from_base;
        let mut light = 0;
        for (index, mount) in (0_u8..).zip(&self.model.devices.infrareds) {
            let sensor = (world_from_base * mount.base_from_sensor).se2();
            let (sin, cos) = sensor.yaw_rad.sin_cos();
            let ray = Ray { origin: sensor.position(), direction: Vec2::new(cos, sin) };
            let hit = scene.cast(&ray, mount.range_max_m);
            // The nearer, the stronger.
            let strength = hit.map_or(0.0, |hit| 1.0 - hit.distance_m / mount.range_max_m);
            match index.checked_sub(1) {
                None => {
                    r.set(ids::WALL, hit.is_some().into());
                    r.set(ids::WALL_SIGNAL, (WALL_SIGNAL_MAX * strength).round() as i32);
                }
                Some(place @ 0..=5) => {
                    light |= i32::from(hit.is_some()) << place;
                    let signal = (LIGHT_SIGNAL_MAX * strength).round() as i32;
                    r.set(ids::LIGHT_LEFT_SIGNAL + place, signal);
                }
                Some(_) => {}
            }
        }
        r.set(ids::LIGHT_BUMPER, light);
    }
}

fn near_home(site: Site<'_>) -> bool {
    let place = site.world.body(site.body_id).position();
    let docks = &site.world.fixtures().docks;
    docks.iter().any(|dock| (dock.position() - place).norm() <= HOME_BASE_REACH_M)
}
