// Numbers for people: fixed digits so that columns do not dance, units spelled with a thin space.

import type { RobotState } from "./protocol";

/** 72.34 → "1:12.3" */
export function clock(seconds: number): string {
  const tenths = Math.max(0, Math.floor(seconds * 10 + 1e-6));
  const minutes = Math.floor(tenths / 600);
  const rest = (tenths % 600) / 10;
  return `${minutes}:${rest.toFixed(1).padStart(4, "0")}`;
}

export function degrees(yaw_rad: number): string {
  const rounded = Math.round((yaw_rad * 180) / Math.PI);
  return `${rounded === 0 ? 0 : rounded}°`;
}

/** 0.1 → "0.1×", 2 → "2×" */
export function ratio(value: number): string {
  const digits = value < 0.995 ? 2 : value < 9.95 ? 1 : 0;
  return `${Number(value.toFixed(digits))}×`;
}

const UNITS: readonly [suffix: string, unit: string, scale: number, digits: number][] = [
  ["_mps2", "m/s²", 1, 2],
  ["_radps", "rad/s", 1, 2],
  ["_mps", "m/s", 1, 2],
  ["_rad", "°", 180 / Math.PI, 1],
  ["_deg", "°", 1, 1],
  ["_ms", "ms", 1, 1],
  ["_hz", "Hz", 1, 1],
  ["_m", "m", 1, 2],
  ["_s", "s", 1, 1],
  ["_v", "V", 1, 1],
  ["_prob", "", 1, 2],
  ["_ratio", "", 1, 2],
];

/** "cross_track_rms_m", 0.0123 → { label: "Cross track rms", value: "12", unit: "mm" } */
export function figure(name: string, value: number | null): { label: string; value: string; unit: string } {
  const rule = UNITS.find(([suffix]) => name.endsWith(suffix));
  const stem = (rule ? name.slice(0, -rule[0].length) : name).replace(/^n_/, "").replaceAll("_", " ");
  const label = stem.charAt(0).toUpperCase() + stem.slice(1);
  if (value === null || !Number.isFinite(value)) return { label, value: "–", unit: "" };
  if (!rule) return { label, value: Number.isInteger(value) ? String(value) : value.toFixed(2), unit: "" };
  const [suffix, unit, scale, digits] = rule;
  if (suffix === "_m" && Math.abs(value) < 0.1 && value !== 0) {
    return { label, value: (value * 1000).toFixed(0), unit: "mm" };
  }
  return { label, value: (value * scale).toFixed(digits), unit };
}

/** "−1.25, 3.40" with a true minus sign. */
export function coordinate(value_m: number): string {
  const text = value_m.toFixed(2);
  return text.startsWith("-") ? (Number(text) === 0 ? text.slice(1) : `−${text.slice(1)}`) : text;
}

/** What a robot makes of its goal; what it is busy with where it has none, or a person has the wheel. */
export function taskWords({ phase, task = "", failure }: Pick<RobotState, "phase" | "task" | "failure">): string {
  if (failure) return task.includes(failure) ? task : `gives up: ${failure}`;
  return task === "" || phase === "driven by hand" ? phase : task;
}
