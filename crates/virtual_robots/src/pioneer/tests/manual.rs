//! What the manuals say of set points, bumpers, sonars, devices and the battery.

use wire::arcos::GripperPac;

use super::*;

const ARC_DEG: f64 = 180.0 / std::f64::consts::PI;

impl Bench {
    /// Turn of the body since the start, from the ways of its wheels.
    fn turned_deg(&self) -> f64 {
        let wheelbase_m = self.firmware.model.drive.wheelbase_m;
        ARC_DEG * (self.travel_m[1] - self.travel_m[0]) / wheelbase_m
    }

    fn driven_m(&self) -> f64 {
        0.5 * (self.travel_m[0] + self.travel_m[1])
    }

    fn count(&self, wanted: impl Fn(&Report) -> bool) -> usize {
        self.reports.iter().filter(|report| wanted(report)).count()
    }
}

#[test]
fn a_heading_stays_where_it_is_when_the_origin_is_set() {
    // Before the turn, in it, and long after it.
    for after_ms in [10, 700, 5000] {
        for deg in [90_i16, -120] {
            let mut bench = Bench::driving();
            bench.obey(Command::Head(deg), after_ms);
            let before_deg = bench.heading_deg();
            bench.send(&[Command::SetO]);
            bench.pass_ms(200);
            let setpoint_deg = bench.last_sip().control_rad().to_degrees();
            close(setpoint_deg, f64::from(deg) - before_deg, 1.0);
            bench.pass_ms(6000);
            close(bench.turned_deg(), deg.into(), 0.5);
            close(bench.heading_deg(), f64::from(deg) - before_deg, 1.0);
        }
    }
}

#[test]
fn a_turn_by_degrees_counts_on_from_the_set_point_across_a_new_origin() {
    let mut bench = Bench::driving();
    bench.send(&[Command::Head(40), Command::SetO, Command::DcHead(30)]);
    bench.pass_ms(5000);
    close(bench.turned_deg(), 70.0, 0.5);
}

#[test]
fn a_distance_goes_on_to_its_end_when_the_origin_is_set() {
    for mm in [1000_i16, -700] {
        let mut bench = Bench::driving();
        bench.obey(Command::Move(mm), 1500);
        let before_m = bench.x_m();
        assert!(before_m.abs() > 0.1);
        bench.obey(Command::SetO, 6000);
        close(1000.0 * bench.driven_m(), mm.into(), 2.0);
        // The tick that brought SETO drove on by 4 mm, and it stops up to 1 mm short.
        close(1000.0 * (bench.x_m() + before_m), mm.into(), 6.0);
    }
}

/// Drives by `command`, then presses a bumper ring for half a second; the speed in the end.
fn speed_after_a_bump(stall: i16, command: &Command, bumpers: [u8; 2]) -> f64 {
    let mut bench = Bench::driving();
    bench.send(&[Command::BumpStall(stall), command.clone()]);
    bench.pass_ms(1500);
    bench.bumpers = bumpers;
    bench.pass_ms(500);
    bench.firmware.model.drive.body_velocity(bench.reference).linear_mps
}

#[test]
fn a_bumper_stops_motion_in_its_own_direction_only() {
    let [front, rear] = [[0b00100, 0], [0, 0b00001]];
    for direction in [1_i16, -1] {
        let commands = [
            Command::Vel(200 * direction),
            Command::Move(3000 * direction),
            Command::Vel2 { left: 10 * direction as i8, right: 9 * direction as i8 },
        ];
        for command in &commands {
            for stall in 0..4 {
                for (ring, bumpers) in [(1, front), (2, rear), (0, [0, 0])] {
                    let meets = if direction > 0 { ring == 1 } else { ring == 2 };
                    let stops = meets && stall & ring != 0;
                    let speed_mps = speed_after_a_bump(stall, command, bumpers);
                    assert_eq!(speed_mps.abs() < 1e-9, stops, "{command:?} {stall} {bumpers:?}");
                }
            }
        }
    }
}

#[test]
fn a_robot_that_was_stopped_by_its_bumper_turns_and_backs_out_and_waits_to_be_told() {
    let mut bench = Bench::driving();
    bench.send(&[Command::BumpStall(1), Command::Vel(300)]);
    bench.pass_ms(1500);
    bench.bumpers = [0b00010, 0];
    bench.tick(&[]);
    // At once, not along the ramp.
    close(bench.firmware.motion.velocity().linear_mps, 0.0, 1e-12);
    // Ahead it does not go, whatever it is told.
    let stood_m = bench.driven_m();
    bench.obey(Command::Vel(300), 500);
    bench.obey(Command::Move(500), 500);
    close(bench.driven_m(), stood_m, 0.01);
    bench.obey(Command::RVel(30), 1000);
    close(bench.firmware.motion.velocity().angular_radps.to_degrees(), 30.0, 1e-6);
    bench.obey(Command::RVel(0), 1000);
    bench.obey(Command::Vel(-200), 1500);
    close(bench.firmware.motion.velocity().linear_mps, -0.2, 1e-9);
    // Free again, it does not take up what it was doing before.
    bench.obey(Command::Vel(0), 1000);
    bench.bumpers = [0, 0];
    bench.pass_ms(500);
    assert!(bench.reference.is_zero());
    bench.obey(Command::Vel(200), 1500);
    close(bench.firmware.motion.velocity().linear_mps, 0.2, 1e-9);
}

#[test]
fn what_a_client_has_set_returns_to_its_default_when_it_leaves() {
    let leave: [fn(&mut Bench); 3] = [
        |bench| bench.send(&[Command::Close]),
        |bench| bench.firmware.hang_up(),
        // A client that lost track begins anew without CLOSE.
        |bench| bench.send(&[Command::Sync0]),
    ];
    for leave in leave {
        let mut bench = Bench::driving();
        bench.send(&[
            Command::BumpStall(3),
            Command::Polling(vec![1]),
            Command::Sonar(0),
            Command::Encoder(2),
            Command::IoRequest(2),
            Command::GripRequest(2),
            Command::SetV(100),
        ]);
        leave(&mut bench);
        let greet = [Command::Sync0, Command::Sync1, Command::Sync2, Command::Open];
        bench.send(&greet);
        bench.send(&[Command::Enable(1), Command::Vel(400)]);
        bench.reports.clear();
        bench.pinged.clear();
        bench.bumpers = [0b11111, 0];
        bench.pass_ms(2000);
        close(bench.firmware.motion.velocity().linear_mps, 0.4, 1e-9);
        assert_eq!(bench.reports.len(), bench.sips().len(), "no packets beside the usual ones");
        assert_eq!((bench.last_sip().flags, bench.last_sip().stalled()), (0b111, false));
        assert!(bench.pinged.len() > 90, "all sonars fire again: {}", bench.pinged.len());
    }
}

#[test]
fn polling_changes_the_arrays_that_it_names() {
    let mut bench = Bench::driving();
    let mut heard = |order: &[u8]| {
        bench.send(&[Command::Polling(order.to_vec())]);
        bench.pinged.clear();
        bench.pass_ms(800);
        let mut sensors = bench.pinged.clone();
        sensors.sort_unstable();
        sensors.dedup();
        (sensors, bench.pinged.len())
    };
    let rear: Vec<usize> = (8..16).collect();
    let with_rear = |front: &[usize]| [front, &rear].concat();
    // Two of the first array: the second goes on; nobody numbered 0 or 99.
    assert_eq!(heard(&[4, 5, 0, 99]), (with_rear(&[3, 4]), 40));
    // One of the second: the first keeps its two.
    assert_eq!(heard(&[16]), (vec![3, 4, 15], 40));
    assert_eq!(heard(&[0, 77]), (vec![3, 4, 15], 40), "nothing named, nothing changed");
    assert_eq!(heard(&[]), (vec![], 0), "the empty order silences all");
    assert_eq!(bench.last_sip().flags, 1);
    // SONAR switches them on again, in the orders there were.
    bench.obey(Command::Sonar(1), 400);
    assert_eq!(bench.last_sip().flags, 0b111);
    assert!(bench.pinged.iter().all(|sensor| [3, 4, 15].contains(sensor)));
}

#[test]
fn a_ring_of_any_size_is_fired_in_its_own_arrays() {
    let model = {
        let mut model = RobotModel::by_name("pioneer3dx").unwrap();
        model.sonars.truncate(5);
        model.ring.chain_len = 2;
        model.ring.ping_period = Duration::from_millis(20);
        model.status_period = Duration::from_millis(50);
        Arc::new(model)
    };
    let mut bench = Bench::with(PioneerConfig::default());
    let rng = RunSeed(1).stream("sonar");
    bench.firmware = PioneerFirmware::new(model, PioneerConfig::default(), rng);
    bench.send(&[Command::Sync0, Command::Sync1, Command::Sync2, Command::Open]);
    bench.pass_ms(400);
    assert_eq!(bench.pinged[..6], [0, 2, 4, 1, 3, 4]);
    assert_eq!(bench.last_sip().flags, 0b1110);
    assert_eq!(bench.sips().len(), 8);
    bench.send(&[Command::Config]);
    let Some(Report::Config(config)) = bench.reports.pop() else { panic!("no configuration") };
    assert_eq!((config.sip_cycle_ms, config.sonar_cycle_ms), (50, 20));
}

#[test]
fn a_client_that_asks_for_a_gripper_is_told_that_there_is_none() {
    let mut bench = Bench::driving();
    let none = |report: &Report| *report == Report::Gripper(GripperPac::default());
    bench.obey(Command::GripRequest(1), 1000);
    assert_eq!(bench.count(none), 1);
    bench.obey(Command::GripRequest(2), 990);
    assert_eq!(bench.count(none), 11);
    bench.obey(Command::GripRequest(0), 1000);
    assert_eq!(bench.count(none), 11);
    // Its commands are accepted and do nothing.
    bench.send(&[Command::Gripper(1), Command::GripperVal(5)]);
    assert_eq!(bench.firmware.counters().n_unknown, 0);
}

#[test]
fn ports_are_reported_when_asked_for() {
    let mut bench = Bench::driving();
    bench.bumpers = [0b00001, 0b10000];
    bench.send(&[Command::DigOut(0xFF05), Command::IoRequest(1)]);
    let Some(Report::Io(io)) = bench.reports.last() else { panic!("no ports") };
    assert_eq!((io.digital_in, io.digital_out), ([0, 1, 16, 255], [5, 0]));
    bench.reports.clear();
    bench.obey(Command::IoRequest(2), 990);
    assert_eq!(bench.count(|report| matches!(report, Report::Io(_))), 10);
    bench.obey(Command::IoRequest(0), 500);
    assert_eq!(bench.count(|report| matches!(report, Report::Io(_))), 10);
}

#[test]
fn a_robot_that_is_no_simulation_does_not_answer_for_the_truth() {
    let mut bench = Bench::driving();
    bench.obey(Command::SimStat(2), 500);
    bench.obey(Command::SimStat(1), 500);
    assert_eq!(bench.count(|report| matches!(report, Report::SimStat(_))), 0);
}

#[test]
fn the_battery_drains_and_a_low_one_shows() {
    let drain_ratio = 3600.0;
    let battery = BatteryConfig { charge_percent: 100.0, drain_ratio };
    let mut bench = Bench::with(PioneerConfig { battery, ..PioneerConfig::default() });
    bench.send(&[Command::Sync0, Command::Sync1, Command::Sync2, Command::Open]);
    bench.pass_ms(10_000);
    // 3600 times faster: 10 s of 14 W are 10 h of 18 h.
    close(bench.firmware.charge_percent(), 100.0 - 100.0 * 14.0 * 10.0 / 252.0, 0.5);
    assert!(!bench.firmware.battery_is_low());
    let at_rest = bench.firmware.charge_percent();
    bench.send(&[Command::Enable(1), Command::Vel(400)]);
    bench.pass_ms(3000);
    assert!(at_rest - bench.firmware.charge_percent() > 1.5 * 100.0 * 14.0 * 3.0 / 252.0);
    assert!(!bench.reference.is_zero());
    bench.pass_ms(3000);
    // Empty: the motors are off and stay off.
    assert!(bench.reference.is_zero() && bench.firmware.battery_is_low());
    let sip = bench.last_sip();
    assert_eq!((sip.battery_decivolts, sip.power.unwrap().battery_decivolts), (100, 100));
    assert_eq!(sip.flags & 1, 0);
    bench.obey(Command::Enable(1), 200);
    assert_eq!(bench.last_sip().flags & 1, 0);
    // A client may try what a low battery does.
    bench.obey(Command::BatTest(125), 200);
    assert!(bench.last_sip().battery_decivolts > 120 && !bench.firmware.battery_is_low());
}

#[test]
fn a_full_battery_starts_at_12_6_v_and_lasts_longer_than_any_test() {
    let mut bench = Bench::driving();
    bench.pass_ms(20_000);
    assert_eq!(bench.last_sip().battery_decivolts, 126);
    assert!(bench.firmware.charge_percent() < 100.0);
    bench.obey(Command::BatTest(105), 200);
    assert_eq!(bench.last_sip().battery_decivolts, 105);
    assert!(bench.firmware.battery_is_low());
}
