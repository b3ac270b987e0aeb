// The logic analyser's memory: when each boolean resource of the program went on and off.

import { isBoolean, isConstant, isHigh } from "./history";
import type { State } from "./protocol";

export interface Edge {
  t_s: number;
  high: boolean;
}

const N_EDGES_MAX = 400;

export class Signals {
  /** By resource name; the first edge is the level at the first state seen. */
  readonly edges = new Map<string, Edge[]>();

  push(state: State): void {
    const told = new Set<string>();
    for (const [t_s, name, high] of state.decision?.edges ?? []) {
      told.add(name);
      if (t_s <= (this.edges.get(name)?.at(-1)?.t_s ?? -1)) continue;
      if (!this.edges.has(name)) this.edges.set(name, [{ t_s: 0, high: !high }]);
      this.add(name, { t_s, high });
    }
    for (const [name, byte] of Object.entries(state.decision?.resources ?? {})) {
      if (!isBoolean(name) || isConstant(name)) continue;
      this.note(name, isHigh(byte), hadPulse(byte) && !told.has(name), state.t_s);
    }
  }

  /** Changes from before this page came, oldest first. */
  recall(edges: readonly [number, string, boolean][]): void {
    this.edges.clear();
    for (const [t_s, name, high] of edges) {
      if (!this.edges.has(name)) this.edges.set(name, [{ t_s: 0, high: !high }]);
      this.add(name, { t_s, high });
    }
  }

  clear(): void {
    this.edges.clear();
  }

  private note(name: string, high: boolean, pulse: boolean, t_s: number): void {
    const last = this.edges.get(name)?.at(-1);
    if (!last || last.high !== high) return this.add(name, { t_s, high });
    // A pulse shorter than the time between two states still leaves a mark.
    if (pulse && t_s > last.t_s + 0.1) this.add(name, { t_s: t_s - 0.02, high: !high }, { t_s, high });
  }

  private add(name: string, ...more: Edge[]): void {
    const edges = this.edges.get(name) ?? [];
    this.edges.set(name, edges);
    edges.push(...more);
    if (edges.length > N_EDGES_MAX) edges.splice(0, edges.length - N_EDGES_MAX);
  }
}

/** A complete pulse lies inside the eight samples: back where it was, but it moved in between. */
function hadPulse(byte: number): boolean {
  const now = byte & 1;
  const oldest = (byte >> 7) & 1;
  return now === oldest && byte !== 0x00 && byte !== 0xff;
}
