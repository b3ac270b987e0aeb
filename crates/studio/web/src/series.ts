// The curves of the plots: one column for each signal that has a curve, over simulated time, bounded in memory.

import type { SignalInfo } from "./offer";
import type { History, State } from "./protocol";

type Column = (number | null)[];

const PERIOD_MIN_S = 0.05;
const N_POINTS_MAX = 12000;

export class Series {
  t_s: number[] = [];
  /** By the name of the signal; SI units. */
  readonly columns = new Map<string, Column>();

  /** Takes the first robot's signals; states closer than 50 ms of simulated time are skipped. */
  push(state: State, signals: readonly SignalInfo[]): void {
    const robot = state.robots[0];
    const last_s = this.t_s.at(-1);
    if (!robot || (last_s !== undefined && state.t_s - last_s < PERIOD_MIN_S)) return;
    signals.forEach(({ id, curve }, index) => {
      if (curve) this.column(id).push(robot.signals[index] ?? null);
    });
    this.t_s.push(state.t_s);
    if (this.t_s.length > N_POINTS_MAX) this.thin();
  }

  /** Takes the whole past. */
  replace(history: History): void {
    this.clear();
    this.t_s = [...history.t_s];
    for (const [id, column] of Object.entries(history.columns)) this.columns.set(id, [...column]);
  }

  clear(): void {
    this.t_s = [];
    this.columns.clear();
  }

  /** Times and columns from `from_s` on, ready for a plot. */
  since(from_s: number, ids: readonly string[]): [number[], ...Column[]] {
    const first = lowerBound(this.t_s, from_s);
    return [this.t_s.slice(first), ...ids.map((id) => this.column(id).slice(first))];
  }

  /** A signal that is new has nothing to tell of the time before. */
  private column(id: string): Column {
    let column = this.columns.get(id);
    if (!column) {
      column = this.t_s.map(() => null);
      this.columns.set(id, column);
    }
    return column;
  }

  private thin(): void {
    const keep = (_: unknown, index: number): boolean => index % 2 === 0;
    this.t_s = this.t_s.filter(keep);
    for (const [id, column] of this.columns) this.columns.set(id, column.filter(keep));
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
