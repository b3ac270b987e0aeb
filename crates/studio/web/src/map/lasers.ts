// Planar scans: points where a beam came back, a pale fan over what was seen to be free, nothing where nothing is known.

import type { Pose, Scan, ScannerInfo } from "../protocol";
import type { Pen } from "./pen";

const UNSEEN = 0;
const FREE = 65535;
/** Side of a point on screen. */
const POINT_MIN_PX = 3;
const POINT_MAX_PX = 5;
const POINT_M = 0.05;

/** Beams as the program packs them: 0 unseen, 65535 free, else millimetres. */
export function beamsOf(text: string): Uint16Array {
  const bytes = atob(text);
  const beams = new Uint16Array(bytes.length >> 1);
  for (let i = 0; i < beams.length; i += 1) beams[i] = bytes.charCodeAt(2 * i) | (bytes.charCodeAt(2 * i + 1) << 8);
  return beams;
}

/** Where beams end, in the map: x, y, and 1 for an echo, 0 for free; beams that say nothing have NaN. */
export function endsOf(info: ScannerInfo, at: Pose, beams: Uint16Array): Float32Array {
  const ends = new Float32Array(3 * beams.length);
  for (let i = 0; i < beams.length; i += 1) {
    const beam = beams[i] ?? UNSEEN;
    const range_m = beam === UNSEEN ? NaN : beam === FREE ? info.range_max_m : beam / 1000;
    const angle = at[2] + info.first_angle_rad + i * info.step_rad;
    ends[3 * i] = at[0] + range_m * Math.cos(angle);
    ends[3 * i + 1] = at[1] + range_m * Math.sin(angle);
    ends[3 * i + 2] = beam === FREE ? 0 : 1;
  }
  return ends;
}

/** A scan is the same object in many pictures. */
const known = new WeakMap<Scan, Float32Array>();

export function drawScan(pen: Pen, info: ScannerInfo, scan: Scan): void {
  let ends = known.get(scan);
  if (!ends) {
    ends = endsOf(info, scan[1], beamsOf(scan[2]));
    known.set(scan, ends);
  }
  drawFan(pen, scan[1], ends);
  const { context, camera, palette } = pen;
  const side = Math.round(Math.min(POINT_MAX_PX, Math.max(POINT_MIN_PX, POINT_M * camera.scale_pxpm)));
  context.fillStyle = palette.colour.laser;
  for (let i = 0; i < ends.length; i += 3) {
    if (ends[i + 2] !== 1) continue;
    const [x, y] = camera.toScreen(ends[i] ?? NaN, ends[i + 1] ?? NaN);
    // Comparisons with NaN are false: what is unseen is not drawn.
    if (x > -side && y > -side && x < camera.width_px + side && y < camera.height_px + side) context.fillRect(Math.round(x - side / 2), Math.round(y - side / 2), side, side);
  }
}

/** One path: a gap of unseen beams closes the fan at the scanner and begins another. */
function drawFan({ context, camera, palette }: Pen, at: Pose, ends: Float32Array): void {
  const [apex_x, apex_y] = camera.toScreen(at[0], at[1]);
  let isOpen = false;
  context.beginPath();
  for (let i = 0; i < ends.length; i += 3) {
    const [x, y] = camera.toScreen(ends[i] ?? NaN, ends[i + 1] ?? NaN);
    if (Number.isNaN(x)) {
      if (isOpen) context.closePath();
      isOpen = false;
      continue;
    }
    if (!isOpen) context.moveTo(apex_x, apex_y);
    isOpen = true;
    context.lineTo(x, y);
  }
  if (isOpen) context.closePath();
  context.fillStyle = palette.colour.laser;
  context.globalAlpha = 0.08;
  context.fill();
  context.globalAlpha = 1;
}
