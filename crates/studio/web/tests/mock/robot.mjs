// The mock's robot: follows the trail by pure pursuit, rebounds from obstacles, smells and hears plausibly.

import { cast, distance, ROBOT, TRAIL } from "./house.mjs";
import { OFFER, valuesOf } from "./offer.mjs";

const SPEED = 0.3;
const NAMES = ["idle", "aim at target", "rotating", "control step", "supervise", "obstacle", "rotating away", "control to detour", "supervise detour"];
const wrap = (angle) => Math.atan2(Math.sin(angle), Math.cos(angle));
const LENGTHS = TRAIL.slice(1).map(([x, y], i) => Math.hypot(x - TRAIL[i][0], y - TRAIL[i][1]));
const TRAIL_LENGTH = LENGTHS.reduce((sum, length) => sum + length, 0);

export function pointAt(s) {
  let rest = Math.max(0, Math.min(TRAIL_LENGTH, s));
  for (let i = 0; i < LENGTHS.length; i += 1) {
    if (rest <= LENGTHS[i] || i === LENGTHS.length - 1) {
      const t = Math.min(1, rest / LENGTHS[i]);
      return [TRAIL[i][0] + (TRAIL[i + 1][0] - TRAIL[i][0]) * t, TRAIL[i][1] + (TRAIL[i + 1][1] - TRAIL[i][1]) * t];
    }
    rest -= LENGTHS[i];
  }
  return TRAIL.at(-1);
}

export class Robot {
  pose = [...ROBOT.start];
  drift = [0, 0, 0];
  sigma = 0.01;
  wheels = [0, 0];
  sonar = ROBOT.sonars.map(() => 5);
  bubble = [];
  state = 0;
  phase = "idle";
  goal = null;
  isFree = false;
  target = null;
  s = 0;
  cross = null;
  path_m = 0;
  clearance_m = 5;
  clearance_min_m = 5;
  sum_cross2 = 0;
  n_cross = 0;
  arrived = false;
  failure = null;

  send(goal, isFree) {
    this.goal = goal;
    this.isFree = isFree;
    this.arrived = false;
    this.target = null;
    this.state = 1;
    this.phase = "aim at trail";
    this.failure = null;
  }

  giveUp(why) {
    this.failure = why;
    this.drive(0, 0);
  }

  /** The same in a sentence. */
  task() {
    if (!this.goal) return "";
    const goal = `(${this.goal[0].toFixed(1)}, ${this.goal[1].toFixed(1)})`;
    if (this.failure) return `gave up ${goal}: ${this.failure}`;
    return this.phase === "aim at trail" ? `looking for a trail to ${goal}` : this.arrived ? `stands at ${goal}` : `on the way to ${goal}`;
  }

  /** Every 200 ms. */
  control(segments) {
    const { pose } = this;
    this.sonar = ROBOT.sonars.map(({ at, half_angle_rad, range_max_m }) => {
      const [cos, sin] = [Math.cos(pose[2]), Math.sin(pose[2])];
      const [x, y] = [pose[0] + at[0] * cos - at[1] * sin, pose[1] + at[0] * sin + at[1] * cos];
      const ranges = [-1, -0.5, 0, 0.5, 1].map((k) => cast(segments, x, y, pose[2] + at[2] + k * half_angle_rad, range_max_m));
      return Math.round(Math.min(...ranges) * 1000) / 1000;
    });
    this.clearance_m = Math.max(0, distance(segments, pose[0], pose[1]) - 0.22);
    this.clearance_min_m = Math.min(this.clearance_min_m, this.clearance_m);
    const speed = (this.wheels[0] + this.wheels[1]) / 2;
    this.bubble = [3, 4, 6, 8, 8, 6, 4, 3].map((gain) => Math.max(0.12, gain * speed * 0.2));
    if (!this.goal || this.arrived || this.failure) return this.rest();
    const toGoal = Math.hypot(this.goal[0] - pose[0], this.goal[1] - pose[1]);
    if (toGoal < 0.06 || this.phase === "align heading") return this.align();
    const hit = this.sonar.some((range, i) => i > 0 && i < 7 && range <= this.bubble[i]) && toGoal > 0.8;
    if (hit && this.state !== 5) {
      this.state = 5;
      this.phase = "avoid";
      return this.drive(0, 0);
    }
    if (this.state === 5) return this.rebound();
    if (this.target && Math.hypot(this.target[0] - pose[0], this.target[1] - pose[1]) < 0.15) {
      this.target = null;
      this.state = 1;
      this.phase = "rejoin";
    }
    return this.steer(toGoal);
  }

  rest() {
    this.state = 0;
    this.phase = this.failure ? "failed" : this.arrived ? "arrived" : "idle";
    this.drive(0, 0);
  }

  align() {
    const turn = wrap(this.goal[2] - this.pose[2]);
    this.phase = "align heading";
    this.state = 2;
    this.cross = null;
    if (Math.abs(turn) < 0.02) {
      this.arrived = true;
      return this.rest();
    }
    return this.drive(0, Math.max(-0.8, Math.min(0.8, turn * 3)));
  }

  rebound() {
    const angles = ROBOT.sonars.map(({ at }) => at[2]);
    const sum = this.sonar.reduce((total, range) => total + range, 0);
    let angle = this.sonar.reduce((total, range, i) => total + range * angles[i], 0) / sum;
    if (Math.abs(angle) < 0.5) angle = angle >= 0 ? 0.8 : -0.85;
    const heading = this.pose[2] + angle;
    this.target = [this.pose[0] + 0.75 * Math.cos(heading), this.pose[1] + 0.75 * Math.sin(heading)];
    this.state = 6;
    this.drive(0, 0);
  }

  steer(toGoal) {
    const { pose } = this;
    this.follow();
    const ahead = this.target ?? (this.isFree || toGoal < 0.5 ? this.goal : pointAt(this.s + 0.5));
    const turn = wrap(Math.atan2(ahead[1] - pose[1], ahead[0] - pose[0]) - pose[2]);
    if (Math.abs(turn) > 0.7) {
      this.state = this.target ? 6 : 2;
      return this.drive(0, Math.sign(turn) * 0.9);
    }
    const [first, second] = this.target ? [7, 8] : [3, 4];
    this.state = this.state === first ? second : first;
    this.phase = this.target ? "avoid" : toGoal < 0.5 ? "approach" : "follow trail";
    return this.drive(Math.min(SPEED, 0.1 + toGoal * 0.5), 2.2 * turn);
  }

  follow() {
    let best = [Infinity, this.s];
    for (let s = Math.max(0, this.s - 0.5); s < this.s + 1.6; s += 0.02) {
      const [x, y] = pointAt(s);
      const gap = Math.hypot(x - this.pose[0], y - this.pose[1]);
      if (gap < best[0]) best = [gap, s];
    }
    this.s = best[1];
    const [a, b] = [pointAt(this.s), pointAt(this.s + 0.05)];
    this.cross = (b[0] - a[0]) * (this.pose[1] - a[1]) - (b[1] - a[1]) * (this.pose[0] - a[0]) > 0 ? best[0] : -best[0];
    this.sum_cross2 += this.cross ** 2;
    this.n_cross += 1;
  }

  drive(v, w) {
    this.reference = [v - w * 0.165, v + w * 0.165];
  }

  /** Every 10 ms. */
  move(t_s) {
    const reference = this.reference ?? [0, 0];
    this.wheels = this.wheels.map((speed, i) => speed + Math.max(-0.012, Math.min(0.012, reference[i] - speed)));
    const [v, w] = [(this.wheels[0] + this.wheels[1]) / 2, (this.wheels[1] - this.wheels[0]) / 0.33];
    this.pose[2] = wrap(this.pose[2] + w * 0.01);
    this.pose[0] += v * 0.01 * Math.cos(this.pose[2]);
    this.pose[1] += v * 0.01 * Math.sin(this.pose[2]);
    this.path_m += Math.abs(v) * 0.01;
    this.sigma = 0.01 + 0.006 * this.path_m;
    this.drift = [0.004 * this.path_m * Math.sin(t_s / 9), 0.005 * this.path_m * Math.cos(t_s / 7), 0.01 * Math.sin(t_s / 5)];
  }

  intensities() {
    if (this.cross === null || this.isFree) return null;
    const side = (sign) => Math.max(0, Math.min(255, 140 - sign * this.cross * 320 + 6 * Math.sin(this.s * 31)));
    return [Math.round(side(1)), Math.round(side(-1))];
  }

  view() {
    const estimate = this.pose.map((value, i) => value + this.drift[i]);
    const intensities = this.intensities();
    const preview = this.phase === "follow trail" || this.phase === "avoid" ? Array.from({ length: 9 }, (_, k) => pointAt(this.s + 0.3 + k * 0.35)) : [];
    return {
      id: 0, truth: [...this.pose], estimate, ellipse: [2 * this.sigma, this.sigma, this.pose[2]], wheels_mps: [...this.wheels],
      sonar_m: this.sonar, bubble_m: this.bubble, phase: this.phase, task: this.task(), failure: this.failure, avoider: { state: this.state, name: NAMES[this.state] },
      goal: this.goal, target: this.target, preview_m: preview, intensities,
      stalled: false, touching: this.clearance_m <= 0,
      signals: valuesOf(OFFER.robot_signals, {
        speed_mps: (this.wheels[0] + this.wheels[1]) / 2, position_error_m: Math.hypot(this.drift[0], this.drift[1]), clearance_m: this.clearance_m, battery_v: 12.6 - this.path_m * 0.01,
        cross_track_m: this.isFree ? null : this.cross, wheel_left_mps: this.wheels[0], wheel_right_mps: this.wheels[1], intensity_left: intensities?.[0], intensity_right: intensities?.[1],
      }),
    };
  }
}
