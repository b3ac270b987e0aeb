// What moves with a robot: body, belief, sonar cones, bubble, antennas, goal, preview, driven path.

import type { Hello, Point, Pose, RobotInfo, RobotState } from "../protocol";
import type { Trail } from "../trail";
import { drawScan } from "./lasers";
import type { Layers } from "./layers";
import { compose, label, type Pen, traceArc, traceCircle, tracePolygon, traceSector } from "./pen";

/** A robot's state with poses blended to the moment of the picture. */
export interface RobotNow {
  info: RobotInfo;
  state: RobotState;
  truth: Pose;
  estimate: Pose;
}

/** A range this close to the maximum means that no echo came back. */
const NO_ECHO_MARGIN_M = 0.02;
const TRAIL_FADE_S = 60;
const TRAIL_ALPHA_MIN = 0.28;
const GOAL_TOLERANCE_M = 0.3;
const ARROW_M = 0.55;
/** Millimetres of a link and the rounding of both make no other place. */
const SAME_PLACE_M = 0.02;

export function drawTrail({ context, camera, palette }: Pen, trail: Trail, now_s: number, head: Pose): void {
  context.strokeStyle = palette.colour.trail;
  context.lineWidth = 2.5;
  context.lineCap = "round";
  context.lineJoin = "round";
  // One stroke per step of age: fading without a stroke per point.
  let bucket = -1;
  let open = false;
  const flush = (): void => {
    if (open) context.stroke();
    open = false;
  };
  // What is looked back on ends at its time.
  const last = trail.points.findLastIndex((point) => point.t_s <= now_s + 1e-6);
  trail.points.slice(0, last + 1).forEach((point, index) => {
    const age = Math.min(1, (now_s - point.t_s) / TRAIL_FADE_S);
    const next = Math.floor(age * 12);
    const [x, y] = camera.toScreen(point.x_m, point.y_m);
    if (next !== bucket || point.isBreak || index === 0) {
      if (open && !point.isBreak) context.lineTo(x, y);
      flush();
      bucket = next;
      context.globalAlpha = TRAIL_ALPHA_MIN + (1 - TRAIL_ALPHA_MIN) * (1 - age);
      context.beginPath();
      context.moveTo(x, y);
      open = true;
    } else {
      context.lineTo(x, y);
    }
  });
  if (open) context.lineTo(...camera.toScreen(head[0], head[1]));
  flush();
  context.globalAlpha = 1;
}

/** Cones and bubble lie under the bodies. */
export function drawSensing(pen: Pen, { info, state, truth }: RobotNow, layers: Layers): void {
  const { context, palette } = pen;
  if (layers.has("laser")) {
    for (const scan of state.scans ?? []) {
      const scanner = info.scanners?.[scan[0]];
      if (scanner) drawScan(pen, scanner, scan);
    }
  }
  if (layers.has("tags")) {
    context.strokeStyle = palette.colour.tag;
    context.lineWidth = 1.25;
    for (const reader of info.tag_readers_m ?? []) {
      traceCircle(pen, compose(truth, reader), info.tag_range_m ?? 0);
      context.stroke();
    }
  }
  info.sonars.forEach((sonar, index) => {
    const apex = compose(truth, sonar.at);
    const range_m = state.sonar_m[index];
    const limit_m = state.bubble_m[index];
    const inside = range_m !== undefined && limit_m !== undefined && range_m <= limit_m;
    if (layers.has("sonar") && range_m !== undefined) {
      const hit = range_m < sonar.range_max_m - NO_ECHO_MARGIN_M;
      traceSector(pen, apex, sonar.half_angle_rad, range_m);
      context.fillStyle = hit ? palette.colour["sonar-hit"] : palette.colour["sonar-none"];
      context.globalAlpha = hit ? 0.1 : 0.03;
      context.fill();
      context.globalAlpha = hit ? 0.95 : 0.3;
      context.strokeStyle = context.fillStyle;
      if (hit) {
        context.lineWidth = 2.5;
        context.setLineDash([]);
        traceArc(pen, apex, sonar.half_angle_rad, range_m);
      } else {
        context.lineWidth = 1;
        context.setLineDash([3, 5]);
      }
      context.stroke();
      context.setLineDash([]);
      context.globalAlpha = 1;
    }
    if (layers.has("bubble") && limit_m !== undefined && limit_m > 0) {
      traceSector(pen, apex, sonar.half_angle_rad, limit_m);
      context.fillStyle = palette.colour.bubble;
      context.globalAlpha = inside ? 0.5 : 0.1;
      context.fill();
      context.globalAlpha = inside ? 1 : 0.7;
      context.strokeStyle = palette.colour.bubble;
      context.lineWidth = inside ? 2.5 : 1.25;
      traceArc(pen, apex, sonar.half_angle_rad, limit_m);
      context.stroke();
      context.globalAlpha = 1;
    }
  });
}

export function drawIntentions(pen: Pen, robot: RobotNow, layers: Layers): void {
  const { context, camera, palette } = pen;
  const { state } = robot;
  if (layers.has("preview") && state.preview_m.length > 0) {
    tracePolygon(pen, state.preview_m, false);
    context.strokeStyle = palette.colour.preview;
    context.lineWidth = 2;
    context.setLineDash([6, 4]);
    context.stroke();
    context.setLineDash([]);
    context.fillStyle = palette.colour.preview;
    for (const point of state.preview_m) {
      traceCircle(pen, point, 3 / camera.scale_pxpm);
      context.fill();
    }
  }
  if (state.goal) drawGoal(pen, state.goal, state.goal_tolerance_m ?? GOAL_TOLERANCE_M, 1);
  if (state.target && isDetour(state.target, state.goal)) {
    const [x, y] = camera.toScreen(state.target[0], state.target[1]);
    const [from_x, from_y] = camera.toScreen(robot.truth[0], robot.truth[1]);
    context.strokeStyle = palette.colour.target;
    context.lineWidth = 1.5;
    context.setLineDash([5, 4]);
    context.beginPath();
    context.moveTo(from_x, from_y);
    context.lineTo(x, y);
    context.stroke();
    context.setLineDash([]);
    context.lineWidth = 2.5;
    context.beginPath();
    for (const [dx, dy] of [[-6, -6], [6, -6]] as const) {
      context.moveTo(x + dx, y + dy);
      context.lineTo(x - dx, y - dy);
    }
    context.stroke();
    // Close to the robot the word would only hide it.
    if (Math.hypot(x - from_x, y - from_y) > 60) label(pen, "detour", [x, y - 15], { colour: palette.colour.target, size_px: 11, weight: 600 });
  }
}

/** The avoider drives to the goal itself as long as nothing is in the way; any other target is a detour. */
export function isDetour(target: Point, goal: Pose | null): boolean {
  return goal === null || Math.hypot(target[0] - goal[0], target[1] - goal[1]) > SAME_PLACE_M;
}

/** A flag with heading inside the circle that counts as arrived. */
export function drawGoal(pen: Pen, goal: Pose, tolerance_m: number, alpha: number): void {
  const { context, camera, palette } = pen;
  const [x, y] = camera.toScreen(goal[0], goal[1]);
  context.globalAlpha = alpha;
  context.fillStyle = palette.colour.goal;
  context.strokeStyle = palette.colour.goal;
  traceCircle(pen, goal, tolerance_m);
  context.globalAlpha = 0.14 * alpha;
  context.fill();
  context.globalAlpha = alpha;
  context.lineWidth = 1.5;
  context.stroke();
  drawArrow(pen, goal, ARROW_M, 2.5);
  context.beginPath();
  context.arc(x, y, 4, 0, 2 * Math.PI);
  context.fill();
  context.globalAlpha = 1;
}

/** An arrow of the current stroke style along the heading. */
function drawArrow({ context, camera }: Pen, from: Pose, length_m: number, width_px: number): void {
  const tip = compose(from, [length_m, 0]);
  const left = compose(from, [length_m - 0.13, 0.09]);
  const right = compose(from, [length_m - 0.13, -0.09]);
  context.lineWidth = width_px;
  context.lineCap = "round";
  context.lineJoin = "round";
  context.beginPath();
  context.moveTo(...camera.toScreen(from[0], from[1]));
  context.lineTo(...camera.toScreen(tip[0], tip[1]));
  context.moveTo(...camera.toScreen(left[0], left[1]));
  context.lineTo(...camera.toScreen(tip[0], tip[1]));
  context.lineTo(...camera.toScreen(right[0], right[1]));
  context.stroke();
}

export function drawRobot(pen: Pen, robot: RobotNow, hello: Hello, layers: Layers): void {
  const { context, camera, palette } = pen;
  const { info, state, truth, estimate } = robot;
  const body = (pose: Pose): void => tracePolygon(pen, info.footprint_m.map((corner) => xy(compose(pose, corner))));

  body(truth);
  context.fillStyle = palette.colour.robot;
  context.fill();
  const alarmed = state.touching || state.stalled;
  context.strokeStyle = alarmed ? palette.bad : palette.colour["robot-line"];
  context.lineWidth = alarmed ? 4 : 1.75;
  context.lineJoin = "round";
  context.stroke();
  context.strokeStyle = palette.colour["robot-line"];
  context.fillStyle = palette.colour["robot-line"];
  drawHeading(pen, truth, info);

  if (layers.has("estimate")) {
    body(estimate);
    context.strokeStyle = palette.colour.estimate;
    context.lineWidth = 1.75;
    context.setLineDash([4, 3]);
    context.stroke();
    context.setLineDash([]);
    drawEllipse(pen, estimate, state.ellipse);
  }
  if (layers.has("pheromones") && hello.pheromones && state.intensities) drawAntennas(pen, estimate, hello.pheromones.antenna_spacing_m, state.intensities);
  if (hello.robots.length > 1) {
    const [x, y] = camera.toScreen(truth[0], truth[1]);
    label(pen, info.name, [x, y - 0.4 * camera.scale_pxpm - 8], { colour: palette.ink, size_px: 12, weight: 600 });
  }
}

function drawHeading({ context, camera }: Pen, pose: Pose, info: RobotInfo): void {
  const front_m = Math.max(...info.footprint_m.map(([x]) => x));
  const corners = [[front_m * 0.72, 0], [-front_m * 0.12, front_m * 0.42], [front_m * 0.12, 0], [-front_m * 0.12, -front_m * 0.42]] as const;
  context.beginPath();
  corners.forEach(([x, y], index) => {
    const at = compose(pose, [x, y]);
    const [x_px, y_px] = camera.toScreen(at[0], at[1]);
    if (index === 0) context.moveTo(x_px, y_px);
    else context.lineTo(x_px, y_px);
  });
  context.closePath();
  context.fill();
}

function drawEllipse({ context, camera, palette }: Pen, estimate: Pose, [major_m, minor_m, yaw_rad]: RobotState["ellipse"]): void {
  const [x, y] = camera.toScreen(estimate[0], estimate[1]);
  context.beginPath();
  context.ellipse(x, y, Math.max(1, major_m * camera.scale_pxpm), Math.max(1, minor_m * camera.scale_pxpm), -yaw_rad, 0, 2 * Math.PI);
  context.fillStyle = palette.colour.estimate;
  context.globalAlpha = 0.16;
  context.fill();
  context.globalAlpha = 1;
  context.lineWidth = 1.5;
  context.stroke();
}

/** The two virtual antennas; the fuller the dot, the stronger the smell. */
function drawAntennas(pen: Pen, estimate: Pose, spacing_m: number, [left, right]: [number, number]): void {
  const { context, palette } = pen;
  const peak = Math.max(left, right, 1e-9);
  for (const [side, intensity] of [[1, left], [-1, right]] as const) {
    traceCircle(pen, compose(estimate, [0, (side * spacing_m) / 2]), 0.055);
    context.fillStyle = palette.surface;
    context.fill();
    context.fillStyle = palette.colour.preview;
    context.globalAlpha = Math.max(0, intensity) / peak;
    context.fill();
    context.globalAlpha = 1;
    context.strokeStyle = palette.colour.preview;
    context.lineWidth = 1.75;
    context.stroke();
  }
}

function xy(pose: Pose): [number, number] {
  return [pose[0], pose[1]];
}
