// A driven path: points a few centimetres apart with the time they were passed, thinned when long.

import type { Point } from "./protocol";

export interface TrailPoint {
  x_m: number;
  y_m: number;
  t_s: number;
  /** The path does not connect to the point before (the robot was carried, or we were offline). */
  isBreak: boolean;
}

const STEP_MIN_M = 0.02;
const BREAK_M = 1.0;
const N_POINTS_MAX = 6000;

export class Trail {
  points: TrailPoint[] = [];

  push(at: Point, t_s: number): void {
    const last = this.points.at(-1);
    const step_m = last ? Math.hypot(at[0] - last.x_m, at[1] - last.y_m) : Infinity;
    if (step_m < STEP_MIN_M) return;
    this.points.push({ x_m: at[0], y_m: at[1], t_s, isBreak: step_m > BREAK_M });
    if (this.points.length > N_POINTS_MAX) this.thin();
  }

  /** Drops every second point of the older half; the shape stays, memory is bounded. */
  private thin(): void {
    const half = this.points.length >> 1;
    this.points = this.points.filter((point, index) => index >= half || index % 2 === 0 || point.isBreak);
  }
}
