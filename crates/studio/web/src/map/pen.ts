// A canvas context that draws in world metres: the few shapes from which the map is made.

import type { Point, Pose } from "../protocol";
import type { Camera } from "./camera";
import type { Palette } from "./palette";

export interface Pen {
  context: CanvasRenderingContext2D;
  camera: Camera;
  palette: Palette;
}

export function tracePolygon({ context, camera }: Pen, corners_m: readonly Point[], close = true): void {
  context.beginPath();
  corners_m.forEach(([x_m, y_m], index) => {
    const [x_px, y_px] = camera.toScreen(x_m, y_m);
    if (index === 0) context.moveTo(x_px, y_px);
    else context.lineTo(x_px, y_px);
  });
  if (close) context.closePath();
}

export function traceCircle({ context, camera }: Pen, at_m: readonly [number, number, ...number[]], radius_m: number): void {
  const [x_px, y_px] = camera.toScreen(at_m[0], at_m[1]);
  context.beginPath();
  context.arc(x_px, y_px, radius_m * camera.scale_pxpm, 0, 2 * Math.PI);
}

/** A piece of pie: the cone of a sonar. */
export function traceSector({ context, camera }: Pen, apex: Pose, half_angle_rad: number, radius_m: number): void {
  const [x_px, y_px] = camera.toScreen(apex[0], apex[1]);
  context.beginPath();
  context.moveTo(x_px, y_px);
  context.arc(x_px, y_px, radius_m * camera.scale_pxpm, -apex[2] - half_angle_rad, -apex[2] + half_angle_rad);
  context.closePath();
}

export function traceArc({ context, camera }: Pen, apex: Pose, half_angle_rad: number, radius_m: number): void {
  const [x_px, y_px] = camera.toScreen(apex[0], apex[1]);
  context.beginPath();
  context.arc(x_px, y_px, radius_m * camera.scale_pxpm, -apex[2] - half_angle_rad, -apex[2] + half_angle_rad);
}

/** The place of `local` (a pose in the frame of `frame`) in the frame that `frame` is given in. */
export function compose(frame: Pose, local: readonly [number, number, number?]): Pose {
  const cos = Math.cos(frame[2]);
  const sin = Math.sin(frame[2]);
  return [
    frame[0] + local[0] * cos - local[1] * sin,
    frame[1] + local[0] * sin + local[1] * cos,
    frame[2] + (local[2] ?? 0),
  ];
}

/** Text with a halo, so that it reads over lines. */
export function label(pen: Pen, text: string, at_px: Point, options: { colour: string; size_px: number; weight?: number; align?: CanvasTextAlign }): void {
  const { context, palette } = pen;
  context.font = `${options.weight ?? 500} ${options.size_px}px ${palette.font}`;
  context.textAlign = options.align ?? "center";
  context.textBaseline = "middle";
  context.lineJoin = "round";
  context.lineWidth = 3;
  context.strokeStyle = palette.colour.floor;
  context.globalAlpha = 0.85;
  context.strokeText(text, at_px[0], at_px[1]);
  context.globalAlpha = 1;
  context.fillStyle = options.colour;
  context.fillText(text, at_px[0], at_px[1]);
}

export function centroid(corners_m: readonly Point[]): Point {
  const n = Math.max(1, corners_m.length);
  const sum = corners_m.reduce<Point>(([x, y], corner) => [x + corner[0], y + corner[1]], [0, 0]);
  return [sum[0] / n, sum[1] / n];
}

export function contains(corners_m: readonly Point[], [x, y]: Point): boolean {
  let inside = false;
  for (let i = 0, j = corners_m.length - 1; i < corners_m.length; j = i, i += 1) {
    const a = corners_m[i];
    const b = corners_m[j];
    if (!a || !b || a[1] > y === b[1] > y) continue;
    if (x < ((b[0] - a[0]) * (y - a[1])) / (b[1] - a[1]) + a[0]) inside = !inside;
  }
  return inside;
}
