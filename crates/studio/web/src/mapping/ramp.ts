// The colours of cells, from the tokens of the theme: unknown, free, occupied, and what lies between.

import { token } from "../theme";
import type { Ramp } from "./board";

/** Of the map: opaque; unknown cells stand out from free ones. */
export function mapRamp(): Ramp {
  const [unknown, free, occupied] = [rgb("--cell-unknown"), rgb("--cell-free"), rgb("--cell-occupied")];
  return ramp((share) => [...mix(free, occupied, share), 255], [...unknown, 255]);
}

/** Of the short-term map that lies over it: free cells barely tint, occupied ones cover. */
export function patchRamp(): Ramp {
  const colour = rgb("--patch-cell");
  return ramp((share) => [...colour, share < 0.5 ? 36 : Math.round(36 + 2 * (share - 0.5) * 200)], [0, 0, 0, 0]);
}

type Rgba = [number, number, number, number];

function ramp(colourOf: (share: number) => Rgba, unknown: Rgba): Ramp {
  const bytes = new Uint8ClampedArray(4 * 256);
  bytes.set(unknown, 0);
  for (let value = 1; value < 256; value += 1) bytes.set(colourOf((value - 1) / 254), 4 * value);
  return new Uint32Array(bytes.buffer);
}

function mix(a: [number, number, number], b: [number, number, number], share: number): [number, number, number] {
  return [a[0] + (b[0] - a[0]) * share, a[1] + (b[1] - a[1]) * share, a[2] + (b[2] - a[2]) * share];
}

/** "#rrggbb" or "r g b". */
function rgb(name: string): [number, number, number] {
  const text = token(name);
  if (text.startsWith("#")) {
    const value = Number.parseInt(text.slice(1), 16);
    return [(value >> 16) & 255, (value >> 8) & 255, value & 255];
  }
  const [red = 0, green = 0, blue = 0] = text.split(/\s+/).map(Number);
  return [red, green, blue];
}
