// People on the map: a circle with a nose in the direction they walk, and their name.

import type { Person } from "../protocol";
import { compose, label, type Pen, traceCircle } from "./pen";

export function drawPerson(pen: Pen, person: Person, withName: boolean): void {
  const { context, camera, palette } = pen;
  const radius_m = person.radius_m;
  context.fillStyle = palette.colour.person;
  context.strokeStyle = palette.colour.person;

  const tip = compose(person.at, [radius_m * 1.75, 0]);
  const left = compose(person.at, [radius_m * 0.75, radius_m * 0.66]);
  const right = compose(person.at, [radius_m * 0.75, -radius_m * 0.66]);
  context.beginPath();
  context.moveTo(...camera.toScreen(left[0], left[1]));
  context.lineTo(...camera.toScreen(tip[0], tip[1]));
  context.lineTo(...camera.toScreen(right[0], right[1]));
  context.closePath();
  context.fill();

  traceCircle(pen, person.at, radius_m);
  context.fillStyle = palette.surface;
  context.fill();
  context.globalAlpha = 0.3;
  context.fillStyle = palette.colour.person;
  context.fill();
  context.globalAlpha = 1;
  context.lineWidth = 2;
  context.stroke();
  traceCircle(pen, person.at, radius_m * 0.42);
  context.fill();

  if (!withName) return;
  const [x, y] = camera.toScreen(person.at[0], person.at[1]);
  label(pen, person.name, [x, y + radius_m * camera.scale_pxpm + 12], { colour: palette.colour.person, size_px: 12, weight: 600 });
}
