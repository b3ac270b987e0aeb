// The pheromone field as a heat map: what an antenna would smell at each place, painted once per hello.

import type { PheromoneField } from "../protocol";
import type { Palette } from "./palette";

/** Pixels of the painted image per side of a cell. */
const PIXELS_PER_CELL = 4;
/** Values from here on are reserved in map files (obstacles) and smell of nothing. */
const VALUE_RESERVED = 0x80;

export interface FieldImage {
  canvas: HTMLCanvasElement;
  /** The strongest intensity in it, in the map's own units. */
  peak: number;
}

/**
 * Sums p0·(1 − d/σ) over the sources within σ (thesis, equation 5.37), without the antenna's
 * direction: the picture shows the ground, not a robot's view of it.
 */
export function intensities(field: PheromoneField, pixels_per_cell: number): { values: Float32Array; width: number; height: number } {
  const width = field.width * pixels_per_cell;
  const height = field.height * pixels_per_cell;
  const values = new Float32Array(width * height);
  const pixel_m = field.cell_m / pixels_per_cell;
  const reach = Math.ceil(field.sigma_m / pixel_m);
  for (const [column, row, value] of field.values) {
    if (value >= VALUE_RESERVED) continue;
    const x = (column + 0.5) * pixels_per_cell - 0.5;
    const y = (row + 0.5) * pixels_per_cell - 0.5;
    for (let j = Math.max(0, Math.ceil(y - reach)); j <= Math.min(height - 1, y + reach); j += 1) {
      for (let i = Math.max(0, Math.ceil(x - reach)); i <= Math.min(width - 1, x + reach); i += 1) {
        const share = 1 - (Math.hypot(i - x, j - y) * pixel_m) / field.sigma_m;
        if (share > 0) values[j * width + i] = (values[j * width + i] ?? 0) + value * share;
      }
    }
  }
  return { values, width, height };
}

export function paintField(field: PheromoneField, palette: Palette): FieldImage {
  const { values, width, height } = intensities(field, PIXELS_PER_CELL);
  const peak = values.reduce((most, value) => Math.max(most, value), 0);
  const canvas = document.createElement("canvas");
  canvas.width = width;
  canvas.height = height;
  const context = canvas.getContext("2d");
  if (!context || peak === 0) return { canvas, peak };
  const image = context.createImageData(width, height);
  for (let row = 0; row < height; row += 1) {
    for (let column = 0; column < width; column += 1) {
      const strength = (values[row * width + column] ?? 0) / peak;
      // Row 0 of the field is at the bottom, row 0 of an image at the top.
      const at = ((height - 1 - row) * width + column) * 4;
      for (let channel = 0; channel < 3; channel += 1) {
        const low = palette.heatLow[channel] ?? 0;
        const high = palette.heatHigh[channel] ?? 0;
        image.data[at + channel] = low + (high - low) * strength;
      }
      image.data[at + 3] = strength === 0 ? 0 : 20 + 130 * Math.sqrt(strength);
    }
  }
  context.putImageData(image, 0, 0);
  return { canvas, peak };
}
