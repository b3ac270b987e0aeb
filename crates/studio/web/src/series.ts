// The curves of the plots: one column per quantity over simulated time, bounded in memory.

import type { History, State } from "./protocol";

export const QUANTITIES = ["crossTrack_mm", "wheelLeft_mmps", "wheelRight_mmps", "left", "right", "clearance_m"] as const;
export type Quantity = (typeof QUANTITIES)[number];

type Column = (number | null)[];

const PERIOD_MIN_S = 0.05;
const N_POINTS_MAX = 12000;

export class Series {
  t_s: number[] = [];
  readonly columns: Record<Quantity, Column> = {
    crossTrack_mm: [], wheelLeft_mmps: [], wheelRight_mmps: [], left: [], right: [], clearance_m: [],
  };

  /** Takes the first robot's figures; states closer than 50 ms of simulated time are skipped. */
  push(state: State): void {
    const robot = state.robots[0];
    const last_s = this.t_s.at(-1);
    if (!robot || (last_s !== undefined && state.t_s - last_s < PERIOD_MIN_S)) return;
    this.t_s.push(state.t_s);
    const { columns } = this;
    columns.crossTrack_mm.push(robot.cross_track_m === null ? null : robot.cross_track_m * 1000);
    columns.wheelLeft_mmps.push(robot.wheels_mps[0] * 1000);
    columns.wheelRight_mmps.push(robot.wheels_mps[1] * 1000);
    columns.left.push(robot.intensities?.[0] ?? null);
    columns.right.push(robot.intensities?.[1] ?? null);
    columns.clearance_m.push(robot.clearance_m);
    if (this.t_s.length > N_POINTS_MAX) this.thin();
  }

  /** Takes the whole past. */
  replace(history: History): void {
    const milli = (column: Column): Column => column.map((value) => (value === null ? null : value * 1000));
    this.t_s = [...history.t_s];
    Object.assign(this.columns, {
      crossTrack_mm: milli(history.cross_track_m),
      wheelLeft_mmps: milli(history.wheel_left_mps),
      wheelRight_mmps: milli(history.wheel_right_mps),
      left: [...history.left],
      right: [...history.right],
      clearance_m: [...history.clearance_m],
    } satisfies Record<Quantity, Column>);
  }

  clear(): void {
    this.t_s = [];
    for (const quantity of QUANTITIES) this.columns[quantity] = [];
  }

  /** Times and columns from `from_s` on, ready for a plot. */
  since(from_s: number, quantities: readonly Quantity[]): [number[], ...Column[]] {
    const first = lowerBound(this.t_s, from_s);
    return [this.t_s.slice(first), ...quantities.map((quantity) => this.columns[quantity].slice(first))];
  }

  private thin(): void {
    const keep = (_: unknown, index: number): boolean => index % 2 === 0;
    this.t_s = this.t_s.filter(keep);
    for (const quantity of QUANTITIES) this.columns[quantity] = this.columns[quantity].filter(keep);
  }
}

/** Index of the first element that is not below `value` in a rising list. */
export function lowerBound(sorted: readonly number[], value: number): number {
  let low = 0;
  let high = sorted.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if ((sorted[middle] ?? Infinity) < value) low = middle + 1;
    else high = middle;
  }
  return low;
}
