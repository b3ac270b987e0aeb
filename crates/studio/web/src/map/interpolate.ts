// Poses between two states, by the wall clock: the map moves smoothly and is never late by more than one state.

import type { Pose } from "../protocol";
import type { Sample } from "../state";

const INTERVAL_MIN_MS = 12;
const INTERVAL_MAX_MS = 180;

/** How far from the previous state (0) to the latest (1) the picture should be now. */
export function blendFactor(previous: Sample | null, latest: Sample, now_ms: number): number {
  if (!previous || !latest.state.playing) return 1;
  const interval_ms = latest.arrived_ms - previous.arrived_ms;
  if (interval_ms > INTERVAL_MAX_MS) return 1;
  return Math.min(1, Math.max(0, (now_ms - latest.arrived_ms) / Math.max(INTERVAL_MIN_MS, interval_ms)));
}

/** Straight between positions, the short way round between headings. */
export function blendPose(from: Pose | undefined, to: Pose, factor: number): Pose {
  if (!from || factor >= 1) return to;
  return [
    from[0] + (to[0] - from[0]) * factor,
    from[1] + (to[1] - from[1]) * factor,
    from[2] + wrap(to[2] - from[2]) * factor,
  ];
}

/** The same angle in [−π, π). */
export function wrap(angle_rad: number): number {
  const turned = (angle_rad + Math.PI) % (2 * Math.PI);
  return (turned < 0 ? turned + 2 * Math.PI : turned) - Math.PI;
}
