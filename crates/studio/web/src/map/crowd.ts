// A thousand robots as dots: what is drawn of robots of which only the poses are known.

import type { CrowdInfo, CrowdRobot, Point } from "../protocol";
import { wrap } from "./interpolate";
import { compose, type Pen } from "./pen";

const TOUCHES = 1;
const ARRIVED = 2;
/** From this size on screen (px) a robot is drawn by its outline instead of a dot. */
const OUTLINE_FROM_PX = 14;
const DOT_MIN_PX = 2.5;

/** One path per colour: a thousand robots cost three fills, not a thousand. */
export function drawCrowd(pen: Pen, info: CrowdInfo, now: readonly CrowdRobot[], before: readonly CrowdRobot[] | undefined, factor: number): void {
  const { context, camera, palette } = pen;
  const radius_m = Math.max(...info.footprint_m.map(([x, y]) => Math.hypot(x, y)), 0.1);
  const size_px = 2 * radius_m * camera.scale_pxpm;
  const groups = [
    { colour: palette.colour.robot, wanted: 0 },
    { colour: palette.good, wanted: ARRIVED },
    { colour: palette.bad, wanted: TOUCHES },
  ];
  for (const { colour, wanted } of groups) {
    context.beginPath();
    now.forEach((robot, index) => {
      if (groupOf(robot[3]) !== wanted) return;
      const pose = blended(before?.[index], robot, factor);
      const [x, y] = camera.toScreen(pose[0], pose[1]);
      if (x < -size_px || y < -size_px || x > camera.width_px + size_px || y > camera.height_px + size_px) return;
      if (size_px < OUTLINE_FROM_PX) {
        const radius_px = Math.max(DOT_MIN_PX, size_px / 2);
        context.moveTo(x + radius_px, y);
        context.arc(x, y, radius_px, 0, 2 * Math.PI);
      } else {
        outline(pen, pose, info.footprint_m);
      }
    });
    context.fillStyle = colour;
    context.fill();
    if (size_px < OUTLINE_FROM_PX) continue;
    context.strokeStyle = palette.colour["robot-line"];
    context.lineWidth = 1;
    context.stroke();
  }
}

/** How many robots of a crowd are in each group of colour. */
export function countCrowd(crowd: readonly CrowdRobot[]): { under_way: number; arrived: number; touching: number } {
  const count = (wanted: number): number => crowd.filter((robot) => groupOf(robot[3]) === wanted).length;
  return { under_way: count(0), arrived: count(ARRIVED), touching: count(TOUCHES) };
}

/** Touching is told before arrived: it is what somebody has to look at. */
function groupOf(mark: number): number {
  return mark & TOUCHES ? TOUCHES : mark & ARRIVED;
}

/** The outline, and a line from the middle to the front that shows the heading. */
function outline({ context, camera }: Pen, pose: readonly [number, number, number], footprint_m: readonly Point[]): void {
  footprint_m.forEach((corner, index) => {
    const [x_m, y_m] = compose([...pose], corner);
    const at = camera.toScreen(x_m, y_m);
    if (index === 0) context.moveTo(...at);
    else context.lineTo(...at);
  });
  context.closePath();
  const front_m = Math.max(...footprint_m.map(([x]) => x));
  const [tip_x, tip_y] = compose([...pose], [front_m, 0]);
  context.moveTo(...camera.toScreen(pose[0], pose[1]));
  context.lineTo(...camera.toScreen(tip_x, tip_y));
}

function blended(from: CrowdRobot | undefined, to: CrowdRobot, factor: number): [number, number, number] {
  if (!from || factor >= 1) return [to[0], to[1], to[2]];
  return [from[0] + (to[0] - from[0]) * factor, from[1] + (to[1] - from[1]) * factor, from[2] + wrap(to[2] - from[2]) * factor];
}
