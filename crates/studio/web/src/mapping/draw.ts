// Draws what lies over the map: tracks, pose graph, short-term map, scan and robot.

import type { Pen } from "../map/pen";
import type { Pose } from "../protocol";
import type { Board, TrackLine } from "./board";
import type { RunState } from "./protocol";

type Brush = Pen;

const ROBOT_RADIUS_M = 0.2;
const ROBOT_RADIUS_MIN_PX = 7;
/** From so many edges on, closures are drawn finer, so that the map stays visible. */
const EDGES_DENSE = 120;
/** Points of a track closer together than this are not drawn. */
const TRACK_STEP_PX = 1.5;

export function drawGrid({ context, camera }: Brush, colour: string): void {
  const step_m = camera.scale_pxpm > 12 ? 1 : 10;
  const [left, top] = camera.toWorld(0, 0);
  const [right, bottom] = camera.toWorld(camera.width_px, camera.height_px);
  context.beginPath();
  for (let x_m = Math.ceil(left / step_m) * step_m; x_m <= right; x_m += step_m) {
    const [x] = camera.toScreen(x_m, 0);
    context.moveTo(Math.round(x) + 0.5, 0);
    context.lineTo(Math.round(x) + 0.5, camera.height_px);
  }
  for (let y_m = Math.ceil(bottom / step_m) * step_m; y_m <= top; y_m += step_m) {
    const [, y] = camera.toScreen(0, y_m);
    context.moveTo(0, Math.round(y) + 0.5);
    context.lineTo(camera.width_px, Math.round(y) + 0.5);
  }
  context.strokeStyle = colour;
  context.lineWidth = 1;
  context.stroke();
}

export function drawTrack(brush: Brush, track: TrackLine, style: { colour: string; width_px: number; dash?: number[] }): void {
  const { context, camera } = brush;
  if (track.n < 2) return;
  context.beginPath();
  let [last_x, last_y] = [NaN, NaN];
  for (let i = 0; i < track.n; i += 1) {
    const [x, y] = camera.toScreen(track.values[3 * i] ?? 0, track.values[3 * i + 1] ?? 0);
    if (Math.abs(x - last_x) + Math.abs(y - last_y) < TRACK_STEP_PX && i < track.n - 1) continue;
    if (i === 0) context.moveTo(x, y);
    else context.lineTo(x, y);
    [last_x, last_y] = [x, y];
  }
  context.lineJoin = "round";
  context.setLineDash(style.dash ?? []);
  // A halo keeps the line readable over black walls and white floors.
  context.strokeStyle = brush.palette.surface;
  context.globalAlpha = 0.55;
  context.lineWidth = style.width_px + 2;
  context.stroke();
  context.globalAlpha = 1;
  context.strokeStyle = style.colour;
  context.lineWidth = style.width_px;
  context.stroke();
  context.setLineDash([]);
}

export function drawGraph(brush: Brush, board: Board, show: { graph: boolean; closures: boolean }): void {
  const { context, camera, palette } = brush;
  const at = (vertex: number): [number, number] => camera.toScreen(board.vertices[2 * vertex] ?? 0, board.vertices[2 * vertex + 1] ?? 0);
  const edges = (kind: number): void => {
    context.beginPath();
    for (let i = 0; i + 2 < board.edges.length; i += 3) {
      if (board.edges[i + 2] !== kind) continue;
      context.moveTo(...at(board.edges[i] ?? 0));
      context.lineTo(...at(board.edges[i + 1] ?? 0));
    }
  };
  if (show.graph) {
    edges(0);
    context.strokeStyle = palette.colour.zone;
    context.lineWidth = 1;
    context.stroke();
    context.fillStyle = palette.colour.zone;
    const radius = Math.min(3, Math.max(1.2, camera.scale_pxpm * 0.05));
    for (let i = 0; 2 * i < board.vertices.length; i += 1) {
      const [x, y] = at(i);
      context.fillRect(x - radius, y - radius, 2 * radius, 2 * radius);
    }
  }
  if (show.closures) {
    edges(1);
    const isDense = board.edges.length > 3 * EDGES_DENSE;
    context.strokeStyle = palette.colour.preview;
    context.globalAlpha = isDense ? 0.55 : 0.9;
    context.lineWidth = isDense ? 1 : 1.8;
    context.stroke();
    context.globalAlpha = 1;
  }
}

export function drawPatch({ context, camera }: Brush, board: Board, colour: string): void {
  const { patch, patchImage } = board;
  if (!patch || !patchImage) return;
  const [x, y] = camera.toScreen(patch.pose[0], patch.pose[1]);
  const scale = camera.scale_pxpm;
  context.save();
  context.translate(x, y);
  context.rotate(-patch.pose[2]);
  const [left, top] = [patch.origin_m[0] * scale, -(patch.origin_m[1] + patch.rows * patch.cell_m) * scale];
  const [width, height] = [patch.columns * patch.cell_m * scale, patch.rows * patch.cell_m * scale];
  context.imageSmoothingEnabled = false;
  context.drawImage(patchImage, left, top, width, height);
  context.strokeStyle = colour;
  context.setLineDash([4, 3]);
  context.lineWidth = 1;
  context.strokeRect(left, top, width, height);
  context.restore();
}

export function drawScan({ context, camera, palette }: Brush, board: Board): void {
  const { scan, half_angle_rad } = board;
  if (half_angle_rad === 0) {
    context.fillStyle = palette.colour["sonar-hit"];
    const side = Math.min(4, Math.max(2, camera.scale_pxpm * 0.05));
    for (let i = 0; i + 1 < scan.length; i += 2) {
      const [x, y] = camera.toScreen(scan[i] ?? 0, scan[i + 1] ?? 0);
      context.fillRect(x - side / 2, y - side / 2, side, side);
    }
    return;
  }
  for (let i = 0; i + 4 < scan.length; i += 5) {
    const isEcho = scan[i + 4] === 1;
    const [x, y] = camera.toScreen(scan[i] ?? 0, scan[i + 1] ?? 0);
    const [yaw, radius] = [scan[i + 2] ?? 0, (scan[i + 3] ?? 0) * camera.scale_pxpm];
    const [from, to] = [-yaw - half_angle_rad, -yaw + half_angle_rad];
    context.beginPath();
    context.moveTo(x, y);
    context.arc(x, y, radius, from, to);
    context.closePath();
    context.fillStyle = context.strokeStyle = isEcho ? palette.colour["sonar-hit"] : palette.colour["sonar-none"];
    context.globalAlpha = isEcho ? 0.2 : 0.08;
    context.fill();
    context.globalAlpha = isEcho ? 1 : 0.5;
    context.lineWidth = isEcho ? 2.5 : 1;
    context.setLineDash(isEcho ? [] : [3, 3]);
    context.beginPath();
    context.arc(x, y, radius, from, to);
    context.stroke();
    context.setLineDash([]);
    context.globalAlpha = 1;
  }
}

export function drawRobots(brush: Brush, run: RunState, showOdometry: boolean): void {
  const { colour } = brush.palette;
  if (showOdometry && run.odometry) drawRobot(brush, run.odometry, "transparent", colour.estimate, [4, 3]);
  if (run.pose) drawRobot(brush, run.pose, colour.robot, colour["robot-line"], []);
}

function drawRobot({ context, camera }: Brush, pose: Pose, fill: string, line: string, dash: number[]): void {
  const [x, y] = camera.toScreen(pose[0], pose[1]);
  const radius = Math.max(ROBOT_RADIUS_MIN_PX, ROBOT_RADIUS_M * camera.scale_pxpm);
  context.beginPath();
  context.arc(x, y, radius, 0, 2 * Math.PI);
  context.fillStyle = fill;
  context.fill();
  context.setLineDash(dash);
  context.strokeStyle = line;
  context.lineWidth = 2;
  context.stroke();
  context.setLineDash([]);
  context.beginPath();
  context.moveTo(x, y);
  context.lineTo(x + radius * 1.5 * Math.cos(pose[2]), y - radius * 1.5 * Math.sin(pose[2]));
  context.stroke();
}
