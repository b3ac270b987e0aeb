// What lies on the floor for ever: tags, and where robots touched something.

import type { Hello } from "../protocol";
import type { Contact } from "../state";
import type { Pen } from "./pen";

/** A tag is drawn so large, as a part of the distance to the next. */
const TAG_RATIO = 0.34;
const TAG_MIN_PX = 1.5;
const TAG_MAX_PX = 9;
const STRONGEST = 255;

/** Every tag as a square; the stronger what it stores, the fuller. */
export function drawTags({ context, camera, palette }: Pen, tags: NonNullable<Hello["tags"]>): void {
  const side = Math.min(TAG_MAX_PX, Math.max(TAG_MIN_PX, tags.pitch_m * TAG_RATIO * camera.scale_pxpm));
  context.lineWidth = 1;
  const strongest = Math.max(1, ...tags.tags.map((tag) => Math.min(STRONGEST, tag[2])));
  context.fillStyle = context.strokeStyle = palette.colour.tag;
  for (const [x_m, y_m, strength] of tags.tags) {
    const [x, y] = camera.toScreen(x_m, y_m);
    if (x < -side || y < -side || x > camera.width_px + side || y > camera.height_px + side) continue;
    context.globalAlpha = 0.35;
    if (side > 3) context.strokeRect(x - side / 2, y - side / 2, side, side);
    if (strength === 0) continue;
    context.globalAlpha = 0.2 + 0.8 * (strength / strongest);
    context.fillRect(x - side / 2, y - side / 2, side, side);
  }
  context.globalAlpha = 1;
}

/** A star where a robot began to touch something, up to a time. */
export function drawContacts({ context, camera, palette }: Pen, contacts: readonly Contact[], until_s: number): void {
  context.strokeStyle = palette.bad;
  context.lineWidth = 2;
  context.lineCap = "round";
  context.beginPath();
  for (const { t_s, at_m } of contacts) {
    if (t_s > until_s) break;
    const [x, y] = camera.toScreen(...at_m);
    for (let i = 0; i < 4; i += 1) {
      const angle = (i * Math.PI) / 4;
      const [dx, dy] = [7 * Math.cos(angle), 7 * Math.sin(angle)];
      context.moveTo(x - dx, y - dy);
      context.lineTo(x + dx, y + dy);
    }
  }
  context.stroke();
}
