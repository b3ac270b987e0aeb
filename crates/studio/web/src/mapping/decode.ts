// Reads the binary messages: map tiles, tracks, graph, scan and short-term map. Little-endian throughout.

import type { Pose } from "../protocol";
import type { Slot } from "./protocol";

export const TILE_SIDE = 64;

export interface Tile {
  column: number;
  row: number;
  /** From the bottom row; 0 unknown, else 1 + 254 × probability. */
  cells: Uint8Array;
}

export interface Patch {
  pose: Pose;
  origin_m: [number, number];
  cell_m: number;
  columns: number;
  rows: number;
  cells: Uint8Array;
}

interface Head {
  slot: Slot;
  run: number;
}

export type Binary =
  | (Head & { kind: "tiles"; origin_m: [number, number]; cell_m: number; tiles: Tile[] })
  /** 0 odometry, 1 corrected, 2 true; poses from `first` on, three numbers each. */
  | (Head & { kind: "track"; which: number; first: number; poses: Float32Array })
  /** Vertices as x, y; edges as from, to, 1 for a closure. */
  | (Head & { kind: "graph"; vertices: Float32Array; edges: Uint32Array })
  /** Points as x, y when the half angle is 0, else cones as x, y, yaw, range, 1 for an echo. */
  | (Head & { kind: "scan"; half_angle_rad: number; values: Float32Array })
  | (Head & { kind: "patch"; patch: Patch | null });

/** null for a message that this page does not know, or one that ends early. */
export function decode(buffer: ArrayBuffer): Binary | null {
  try {
    const reader = new Reader(buffer);
    const kind = reader.u8();
    const slot: Slot = reader.u8() === 0 ? 0 : 1;
    reader.u16();
    const head = { slot, run: reader.u32() };
    switch (kind) {
      case 1: return { ...head, kind: "tiles", ...tiles(reader) };
      case 2: {
        const [which, first, n] = [reader.u32(), reader.u32(), reader.u32()];
        return { ...head, kind: "track", which, first, poses: reader.floats(3 * n) };
      }
      case 3: {
        const vertices = reader.floats(2 * reader.u32());
        return { ...head, kind: "graph", vertices, edges: reader.uints(3 * reader.u32()) };
      }
      case 4: {
        const half_angle_rad = reader.f32();
        return { ...head, kind: "scan", half_angle_rad, values: reader.floats((half_angle_rad > 0 ? 5 : 2) * reader.u32()) };
      }
      case 5: return { ...head, kind: "patch", patch: patch(reader) };
      default: return null;
    }
  } catch {
    return null;
  }
}

/** Runs of bytes: n below 128 and n + 1 bytes as they are, or n from 129 and a byte that stands 257 − n times. */
export function unpack(packed: Uint8Array, n_cells: number): Uint8Array {
  const cells = new Uint8Array(n_cells);
  let at = 0;
  for (let i = 0; i < packed.length && at < n_cells; ) {
    const n = packed[i] ?? 0;
    if (n < 128) {
      const end = Math.min(n_cells, at + n + 1);
      cells.set(packed.subarray(i + 1, i + 1 + end - at), at);
      at = end;
      i += n + 2;
    } else {
      const end = at + 257 - n;
      cells.fill(packed[i + 1] ?? 0, at, end);
      at = end;
      i += 2;
    }
  }
  return cells;
}

function tiles(reader: Reader): { origin_m: [number, number]; cell_m: number; tiles: Tile[] } {
  const origin_m: [number, number] = [reader.f64(), reader.f64()];
  const cell_m = reader.f64();
  const list: Tile[] = [];
  for (let n = reader.u32(); n > 0; n -= 1) {
    const [column, row] = [reader.i32(), reader.i32()];
    list.push({ column, row, cells: unpack(reader.bytes(reader.u16()), TILE_SIDE * TILE_SIDE) });
  }
  return { origin_m, cell_m, tiles: list };
}

function patch(reader: Reader): Patch | null {
  const pose: Pose = [reader.f64(), reader.f64(), reader.f64()];
  const origin_m: [number, number] = [reader.f64(), reader.f64()];
  const cell_m = reader.f64();
  const [columns, rows] = [reader.u32(), reader.u32()];
  const cells = unpack(reader.bytes(reader.u32()), columns * rows);
  return columns * rows === 0 ? null : { pose, origin_m, cell_m, columns, rows, cells };
}

/** Reads numbers one after the other; beyond the end it throws. */
class Reader {
  private readonly view: DataView;
  private at = 0;

  constructor(private readonly buffer: ArrayBuffer) {
    this.view = new DataView(buffer);
  }

  u8(): number { return this.view.getUint8(this.advance(1)); }
  u16(): number { return this.view.getUint16(this.advance(2), true); }
  u32(): number { return this.view.getUint32(this.advance(4), true); }
  i32(): number { return this.view.getInt32(this.advance(4), true); }
  f32(): number { return this.view.getFloat32(this.advance(4), true); }
  f64(): number { return this.view.getFloat64(this.advance(8), true); }

  bytes(n: number): Uint8Array {
    return new Uint8Array(this.buffer, this.advance(n), n);
  }

  floats(n: number): Float32Array {
    return new Float32Array(this.buffer.slice(this.advance(4 * n), this.at));
  }

  uints(n: number): Uint32Array {
    return new Uint32Array(this.buffer.slice(this.advance(4 * n), this.at));
  }

  private advance(n: number): number {
    const start = this.at;
    if (start + n > this.buffer.byteLength) throw new RangeError("the message ends early");
    this.at += n;
    return start;
  }
}
