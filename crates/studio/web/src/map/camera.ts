// Where the map's window is: world metres (y up) to CSS pixels (y down) and back, zoom and pan.

import type { Point } from "../protocol";

const SCALE_MIN_PXPM = 4;
const SCALE_MAX_PXPM = 900;

export class Camera {
  scale_min_pxpm = SCALE_MIN_PXPM;
  centre_m: Point = [0, 0];
  scale_pxpm = 60;
  width_px = 1;
  height_px = 1;

  toScreen(x_m: number, y_m: number): Point {
    return [
      this.width_px / 2 + (x_m - this.centre_m[0]) * this.scale_pxpm,
      this.height_px / 2 - (y_m - this.centre_m[1]) * this.scale_pxpm,
    ];
  }

  toWorld(x_px: number, y_px: number): Point {
    return [
      this.centre_m[0] + (x_px - this.width_px / 2) / this.scale_pxpm,
      this.centre_m[1] - (y_px - this.height_px / 2) / this.scale_pxpm,
    ];
  }

  panBy(dx_px: number, dy_px: number): void {
    this.centre_m = [this.centre_m[0] - dx_px / this.scale_pxpm, this.centre_m[1] + dy_px / this.scale_pxpm];
  }

  /** Zooms so that the world point under the given pixel stays there. */
  zoomAt(x_px: number, y_px: number, factor: number): void {
    const [x_m, y_m] = this.toWorld(x_px, y_px);
    this.scale_pxpm = Math.min(SCALE_MAX_PXPM, Math.max(this.scale_min_pxpm, this.scale_pxpm * factor));
    const [x_after_px, y_after_px] = this.toScreen(x_m, y_m);
    this.panBy(x_px - x_after_px, y_px - y_after_px);
  }

  /** Shows the whole box with room around it for what floats over the map. */
  fit(bounds_m: readonly [number, number, number, number], margins_px: { x: number; top: number; bottom: number }): void {
    const width_m = Math.max(0.5, bounds_m[2] - bounds_m[0]);
    const height_m = Math.max(0.5, bounds_m[3] - bounds_m[1]);
    const free_width_px = Math.max(80, this.width_px - 2 * margins_px.x);
    const free_height_px = Math.max(80, this.height_px - margins_px.top - margins_px.bottom);
    this.scale_pxpm = Math.min(free_width_px / width_m, free_height_px / height_m);
    const shift_m = (margins_px.top - margins_px.bottom) / 2 / this.scale_pxpm;
    this.centre_m = [(bounds_m[0] + bounds_m[2]) / 2, (bounds_m[1] + bounds_m[3]) / 2 + shift_m];
  }
}

/** A round length (1, 2 or 5 times a power of ten) whose bar is at most `max_px` long. */
export function scaleBar(scale_pxpm: number, max_px: number): { length_m: number; length_px: number; label: string } {
  const limit_m = max_px / scale_pxpm;
  const power = 10 ** Math.floor(Math.log10(limit_m));
  const step = [5, 2, 1].find((candidate) => candidate * power <= limit_m * 1.000001) ?? 1;
  const length_m = step * power;
  const label = length_m >= 1 ? `${length_m} m` : `${Math.round(length_m * 100)} cm`;
  return { length_m, length_px: length_m * scale_pxpm, label };
}
