// The mock's run: ticks of 10 ms that move robot and people, scan the program, and write trace and log.

import { Decision, functions, SOURCE } from "./decision.mjs";
import { BOUNDS, DEVICES, distance, pheromones, ROBOT, ROOMS, segmentsOf, THINGS, TRAIL, WALLS } from "./house.mjs";
import { OFFER, offerOf, valuesOf } from "./offer.mjs";
import { Robot } from "./robot.mjs";
import { SCANNER, scanAt } from "./scans.mjs";

export const MISSIONS = [
  { name: "doorbell", title: "The doorbell", about: "The bell rings, nobody moves for 15 s: the robot goes to the entrance along a pheromone trail." },
  { name: "empty_flat", title: "Empty flat", about: "A robot without program and without trail: send it goals by hand." },
];
const ENDS = [["navigation", "robot"], ["navigation", "server"], ["navigation", "decision"]];
const GOAL = [5, 3.5, Math.PI / 4];

export class Run {
  /** `n_lasers` more robots stand about, each with a scanner of 361 beams. */
  constructor(mission, seed, kind, n_lasers = 0) {
    this.n_lasers = n_lasers;
    this.mission = MISSIONS.find(({ name }) => name === mission) ?? MISSIONS[0];
    this.seed = seed;
    this.kind = kind;
    this.isBare = this.mission.name === "empty_flat";
    this.robot = new Robot();
    this.decision = this.isBare ? null : new Decision();
    this.step_number = 0;
    this.pressed_until_s = -1;
    this.next_id = 20;
    this.things = this.isBare ? [] : [square(12, [-1.7, -0.28], 0.4)];
    this.people = [];
    this.verdict = null;
    this.traces = [];
    this.logs = [];
    this.movePeople();
    this.robot.control(this.segments());
    this.say("info", `run of ${this.mission.name} with seed ${seed}`);
  }

  get t_s() {
    return this.step_number / 100;
  }

  hello() {
    return {
      type: "hello", protocol: 2, cairn: "0.1.0",
      mission: { ...this.mission, seed: this.seed, duration_max_s: 180, kind: this.kind },
      missions: MISSIONS.map(({ name, title }) => ({ name, title })),
      world: { bounds_m: BOUNDS, walls: WALLS, points: [], things: THINGS, rooms: ROOMS, devices: this.isBare ? [] : DEVICES },
      robots: [ROBOT, ...this.lasers().map((_, i) => ({ ...ROBOT, id: i + 1, name: `laser ${i + 1}`, sonars: [], scanners: [SCANNER] }))],
      ...offerOf(this.isBare, this.n_lasers > 0),
      pheromones: this.isBare ? null : pheromones(),
      planned_path_m: this.isBare ? [] : TRAIL,
      program: this.isBare ? null : { source: SOURCE, mode: "corrected", functions: functions() },
      links: ["robot", "pheromones", "ground"].slice(0, this.isBare ? 1 : 3).map((name, id) => ({ id, name, ends: ENDS[id], baud: 9600, robot: 0, line: name })),
    };
  }

  state(playing, speed_ratio, achieved_ratio) {
    const { robot } = this;
    return {
      type: "state", t_s: this.t_s, step: this.step_number, playing, speed_ratio, achieved_ratio, verdict: this.verdict,
      robots: [robot.view(), ...this.lasers()], people: this.people, things: this.things,
      devices: this.isBare ? [] : this.inputs().map((on, i) => ({ name: DEVICES[i].name, on })).concat([{ name: "latch", on: robot.arrived }, { name: "lamp", on: robot.goal !== null }]),
      decision: this.decision?.state() ?? null,
      signals: valuesOf(OFFER.run_signals, {
        time_s: this.t_s, path_length_m: robot.path_m, clearance_min_m: robot.clearance_min_m, contacts: 0,
        cross_track_rms_m: robot.n_cross ? Math.sqrt(robot.sum_cross2 / robot.n_cross) : null,
      }),
    };
  }

  /** Robots that turn on the spot and scan. */
  lasers() {
    return Array.from({ length: this.n_lasers }, (_, i) => {
      const pose = [-4 + (i % 5) * 2, i < 5 ? 1.6 : -1.8, this.t_s / 3 + i];
      return { ...this.robot.view(), id: i + 1, truth: pose, estimate: pose, sonar_m: [], bubble_m: [], preview_m: [], goal: null, target: null, scans: [scanAt(pose, this.segments(), this.step_number)] };
    });
  }

  tick() {
    this.step_number += 1;
    const { robot, t_s } = this;
    if (t_s === 2 && !this.isBare) this.press("bell", "the visitor");
    if (this.decision?.scan(this.inputs())) {
      robot.send([...GOAL], false);
      this.say("info", "MOVE to (5.00, 3.50) m, 45° sent by the decision program");
      this.trace(2, "navigation", "10 02 10 10 FE 88 13 AC 0D 2D 00 10 03", "MOVE x 5000 mm, y 3500 mm, heading 45°");
    }
    this.movePeople();
    if (this.step_number % 20 === 0) this.control();
    robot.move(t_s);
    if (this.step_number % 10 === 0) this.trace(0, "navigation", `FA FB 2A 32 ${hex(robot.pose[0] * 1000)} ${hex(robot.pose[1] * 1000)} ${hex((robot.pose[2] * 2048) / Math.PI)}`, `SIP x ${(robot.pose[0] * 1000).toFixed(0)} mm, y ${(robot.pose[1] * 1000).toFixed(0)} mm, battery 12.6 V`);
    if (robot.arrived && this.verdict === null && !this.isBare) this.judge();
    if (t_s >= 180 && this.verdict === null) this.fail();
  }

  control() {
    const { robot } = this;
    const before = robot.state;
    robot.control(this.segments());
    if (robot.state === 5 && before !== 5) this.say("warn", "obstacle inside the bubble: the avoider takes over");
    if (robot.state !== before) this.trace(2, "decision", `10 02 10 10 0${robot.state} 10 03`, `state ${robot.state} entered`);
    const [left, right] = (robot.reference ?? [0, 0]).map((speed) => Math.round(speed * 1000));
    this.trace(0, "robot", `FA FB 06 20 3B ${hex(left / 20).slice(0, 2)} ${hex(right / 20).slice(0, 2)}`, `VEL2 left ${left} mm/s, right ${right} mm/s`);
    if (this.isBare) return;
    const [x, y] = robot.pose.map((value) => Math.round(value * 1000));
    this.trace(1, "server", `10 02 10 10 01 00 ${hex(x)} ${hex(y)} 10 03`, `query at x ${x} mm, y ${y} mm`);
    const [pl, pr] = robot.intensities() ?? [0, 0];
    this.trace(1, "navigation", `10 02 10 10 01 00 ${hex(pl).slice(0, 2)} ${hex(pr).slice(0, 2)} 10 03`, `intensity left ${pl}, right ${pr}`);
  }

  press(name, who = "hand") {
    this.pressed_until_s = this.t_s + 0.5;
    this.say("info", `${name} pressed by ${who}`);
  }

  place(at_m, size_m) {
    if (distance(this.segments(), ...at_m) < 0.02) return "the box would stand in a wall; choose a free place";
    const gap_m = Math.hypot(at_m[0] - this.robot.pose[0], at_m[1] - this.robot.pose[1]);
    if (gap_m < 0.45) return `the box would stand on the robot (${gap_m.toFixed(2)} m away); keep 0.45 m`;
    this.things = [...this.things, square(this.next_id, at_m, size_m)];
    this.next_id += 1;
    this.say("info", `box placed at (${at_m[0].toFixed(2)}, ${at_m[1].toFixed(2)}) m by hand`);
    return null;
  }

  remove(id) {
    if (!this.things.some((thing) => thing.id === id)) return `there is no removable thing with id ${id}`;
    this.things = this.things.filter((thing) => thing.id !== id);
    this.say("info", "box removed by hand");
    return null;
  }

  goal(pose) {
    this.robot.send(pose, true);
    this.say("info", `goal (${pose[0].toFixed(2)}, ${pose[1].toFixed(2)}) m sent by hand`);
  }

  inputs() {
    const moving = (index) => this.people.some(({ at, moves }) => moves && inside(DEVICES[index].area_m, at));
    return [this.t_s < this.pressed_until_s, moving(1), moving(2), moving(3)];
  }

  movePeople() {
    if (this.isBare) return;
    const { t_s } = this;
    const visitor = Math.min(1, t_s / 2);
    // The resident sleeps, and wakes up once the robot is on its way.
    const wander = Math.max(0, t_s - 24) * 0.4;
    const angle = wander / 0.9;
    this.people = [
      { name: "visitor", at: [5.72, 5.4 - visitor * 0.75, -Math.PI / 2 - 0.4], radius_m: 0.22, moves: visitor < 1 },
      { name: "resident", at: [-3.0 - 0.35 * Math.cos(angle), 2.0 + 0.45 * Math.sin(angle), Math.atan2(0.45 * Math.cos(angle), 0.35 * Math.sin(angle))], radius_m: 0.25, moves: wander > 0 },
    ];
  }

  segments() {
    return segmentsOf([...THINGS, ...this.things], this.people);
  }

  judge() {
    const [x, y, yaw] = this.robot.pose;
    const gap_m = Math.hypot(x - this.robot.goal[0], y - this.robot.goal[1]);
    const turn = Math.abs(((yaw - this.robot.goal[2]) * 180) / Math.PI);
    this.verdict = {
      passed: true, text: `The robot was at the entrance ${(this.t_s - 2).toFixed(1)} s after the bell.`,
      checks: [
        { name: "arrived", passed: true, text: `${gap_m.toFixed(2)} m, ${turn.toFixed(0)}° from the goal at ${this.t_s.toFixed(1)} s (allowed 0.30 m, 15°)` },
        { name: "no_collision", passed: true, text: "0 contacts (allowed 0)" },
        { name: "clearance", passed: true, text: `${this.robot.clearance_min_m.toFixed(2)} m at least (required 0.02 m)` },
        { name: "one_move", passed: true, text: "exactly 1 MOVE, 15.0 s after the bell" },
      ],
    };
    this.say("good", "arrived at the entrance: mission passed");
  }

  fail() {
    this.verdict = { passed: false, text: "The time was over before the robot arrived.", checks: [{ name: "arrived", passed: false, text: "not within 180 s" }, { name: "no_collision", passed: true, text: "0 contacts (allowed 0)" }] };
    this.say("bad", "time is over: mission failed");
  }

  trace(link, to, hexText, text) {
    this.traces.push({ t_s: this.t_s, link, to, hex: hexText, text });
  }

  say(level, text) {
    this.logs.push({ t_s: this.t_s, level, text });
  }
}

function square(id, [x, y], size_m) {
  const r = size_m / 2;
  return { id, name: "box", kind: "box", material: "cardboard", corners_m: [[x - r, y - r], [x + r, y - r], [x + r, y + r], [x - r, y + r]], removable: true };
}

function inside(corners, [x, y]) {
  return x > corners[0][0] && x < corners[2][0] && y > corners[0][1] && y < corners[2][1];
}

function hex(value) {
  const word = Math.round(value) & 0xffff;
  return [word & 0xff, word >> 8].map((byte) => byte.toString(16).toUpperCase().padStart(2, "0")).join(" ");
}
