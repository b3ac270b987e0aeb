// What the page knows of one run's picture: the map as blocks of pixels, tracks, graph, scan, short-term map.

import { type Binary, type Patch, type Tile, TILE_SIDE } from "./decode";

/** Tiles on the side of a block: one canvas of 512 × 512 pixels, a megabyte. */
const BLOCK_TILES = 8;
const BLOCK_SIDE = BLOCK_TILES * TILE_SIDE;

/** Colours of all 256 cell values, as the canvas stores them. */
export type Ramp = Uint32Array;

interface Block {
  column: number;
  row: number;
  canvas: HTMLCanvasElement;
  tiles: Map<number, Uint8Array>;
}

/** x, y, yaw of many poses in one growing array. */
export class TrackLine {
  n = 0;
  values = new Float32Array(3 * 256);

  replaceFrom(first: number, poses: Float32Array): void {
    const n = first + poses.length / 3;
    if (3 * n > this.values.length) {
      const larger = new Float32Array(Math.max(3 * n, 2 * this.values.length));
      larger.set(this.values.subarray(0, 3 * first));
      this.values = larger;
    }
    this.values.set(poses, 3 * first);
    this.n = n;
  }
}

export class Board {
  origin_m: [number, number] = [0, 0];
  cell_m = 1;
  readonly tracks: readonly [TrackLine, TrackLine, TrackLine] = [new TrackLine(), new TrackLine(), new TrackLine()];
  vertices: Float32Array = new Float32Array(0);
  edges: Uint32Array = new Uint32Array(0);
  half_angle_rad = 0;
  scan: Float32Array = new Float32Array(0);
  patch: Patch | null = null;
  patchImage: HTMLCanvasElement | null = null;
  n_tiles = 0;
  private readonly blocks = new Map<string, Block>();
  private bounds_cells: [number, number, number, number] | null = null;

  constructor(readonly run: number, private ramp: Ramp, private patchRamp: Ramp) {}

  accept(message: Binary): void {
    switch (message.kind) {
      case "tiles":
        this.origin_m = message.origin_m;
        this.cell_m = message.cell_m;
        for (const tile of message.tiles) this.setTile(tile);
        return;
      case "track":
        this.tracks[message.which as 0 | 1 | 2]?.replaceFrom(message.first, message.poses);
        return;
      case "graph":
        this.vertices = message.vertices;
        this.edges = message.edges;
        return;
      case "scan":
        this.half_angle_rad = message.half_angle_rad;
        this.scan = message.values;
        return;
      case "patch":
        this.patch = message.patch;
        this.patchImage = message.patch && patchImage(message.patch, this.patchRamp);
    }
  }

  /** Other colours: everything is painted again. */
  restyle(ramp: Ramp, patchRamp: Ramp): void {
    this.ramp = ramp;
    this.patchRamp = patchRamp;
    for (const block of this.blocks.values()) for (const [place, cells] of block.tiles) this.paint(block, place, cells);
    this.patchImage = this.patch && patchImage(this.patch, patchRamp);
  }

  /** Left, bottom, right and top of everything drawn, or null. */
  bounds_m(): [number, number, number, number] | null {
    let bounds: [number, number, number, number] | null = null;
    const include = (x_m: number, y_m: number): void => {
      bounds = bounds
        ? [Math.min(bounds[0], x_m), Math.min(bounds[1], y_m), Math.max(bounds[2], x_m), Math.max(bounds[3], y_m)]
        : [x_m, y_m, x_m, y_m];
    };
    if (this.bounds_cells) {
      const [left, bottom, right, top] = this.bounds_cells;
      include(this.origin_m[0] + left * this.cell_m, this.origin_m[1] + bottom * this.cell_m);
      include(this.origin_m[0] + right * this.cell_m, this.origin_m[1] + top * this.cell_m);
    }
    const track = this.tracks[1];
    for (let i = 0; i < track.n; i += 1) include(track.values[3 * i] ?? 0, track.values[3 * i + 1] ?? 0);
    return bounds;
  }

  /** Draws the map: `toScreen` gives the pixel of a place, `scale_pxpm` the pixels of a metre. */
  drawMap(context: CanvasRenderingContext2D, toScreen: (x_m: number, y_m: number) => [number, number], scale_pxpm: number): void {
    const side_px = BLOCK_SIDE * this.cell_m * scale_pxpm;
    // Large cells keep their edges; small ones are blended.
    context.imageSmoothingEnabled = this.cell_m * scale_pxpm < 1;
    for (const { column, row, canvas } of this.blocks.values()) {
      const [x, y] = toScreen(this.origin_m[0] + column * BLOCK_SIDE * this.cell_m, this.origin_m[1] + (row + 1) * BLOCK_SIDE * this.cell_m);
      if (x > context.canvas.width || y > context.canvas.height || x + side_px < 0 || y + side_px < 0) continue;
      context.drawImage(canvas, x, y, side_px, side_px);
    }
  }

  /** The value of the cell at a place: 0 unknown, else 1 + 254 × probability. */
  cellAt(x_m: number, y_m: number): number {
    const column = Math.floor((x_m - this.origin_m[0]) / this.cell_m);
    const row = Math.floor((y_m - this.origin_m[1]) / this.cell_m);
    const [tile_column, tile_row] = [Math.floor(column / TILE_SIDE), Math.floor(row / TILE_SIDE)];
    const block = this.blocks.get(`${Math.floor(tile_column / BLOCK_TILES)},${Math.floor(tile_row / BLOCK_TILES)}`);
    const cells = block?.tiles.get(placeOf(tile_column, tile_row));
    return cells?.[(row - tile_row * TILE_SIDE) * TILE_SIDE + column - tile_column * TILE_SIDE] ?? 0;
  }

  private setTile({ column, row, cells }: Tile): void {
    const [tile_column, tile_row] = [column / TILE_SIDE, row / TILE_SIDE];
    const [block_column, block_row] = [Math.floor(tile_column / BLOCK_TILES), Math.floor(tile_row / BLOCK_TILES)];
    const key = `${block_column},${block_row}`;
    let block = this.blocks.get(key);
    if (!block) {
      const canvas = document.createElement("canvas");
      canvas.width = canvas.height = BLOCK_SIDE;
      block = { column: block_column, row: block_row, canvas, tiles: new Map() };
      this.blocks.set(key, block);
    }
    const place = placeOf(tile_column, tile_row);
    if (!block.tiles.has(place)) this.n_tiles += 1;
    block.tiles.set(place, cells);
    this.paint(block, place, cells);
    this.widenBounds(column, row, cells);
  }

  private paint(block: Block, place: number, cells: Uint8Array): void {
    const context = block.canvas.getContext("2d");
    if (!context) return;
    const [x, y] = [(place % BLOCK_TILES) * TILE_SIDE, Math.floor(place / BLOCK_TILES) * TILE_SIDE];
    // The canvas' rows go down, the map's go up.
    context.putImageData(image(cells, TILE_SIDE, TILE_SIDE, this.ramp), x, BLOCK_SIDE - TILE_SIDE - y);
  }

  private widenBounds(column: number, row: number, cells: Uint8Array): void {
    let [left, bottom, right, top] = this.bounds_cells ?? [Infinity, Infinity, -Infinity, -Infinity];
    for (let i = 0; i < cells.length; i += 1) {
      if (cells[i] === 0) continue;
      const [x, y] = [column + (i % TILE_SIDE), row + Math.floor(i / TILE_SIDE)];
      left = Math.min(left, x);
      bottom = Math.min(bottom, y);
      right = Math.max(right, x + 1);
      top = Math.max(top, y + 1);
    }
    if (left < right) this.bounds_cells = [left, bottom, right, top];
  }
}

function placeOf(tile_column: number, tile_row: number): number {
  const wrap = (n: number): number => ((n % BLOCK_TILES) + BLOCK_TILES) % BLOCK_TILES;
  return wrap(tile_row) * BLOCK_TILES + wrap(tile_column);
}

/** The cells as pixels, top row first. */
function image(cells: Uint8Array, columns: number, rows: number, ramp: Ramp): ImageData {
  const pixels = new Uint32Array(columns * rows);
  for (let row = 0; row < rows; row += 1) {
    const from = (rows - 1 - row) * columns;
    const to = row * columns;
    for (let column = 0; column < columns; column += 1) pixels[to + column] = ramp[cells[from + column] ?? 0] ?? 0;
  }
  return new ImageData(new Uint8ClampedArray(pixels.buffer), columns, rows);
}

function patchImage(patch: Patch, ramp: Ramp): HTMLCanvasElement {
  const canvas = document.createElement("canvas");
  canvas.width = patch.columns;
  canvas.height = patch.rows;
  canvas.getContext("2d")?.putImageData(image(patch.cells, patch.columns, patch.rows, ramp), 0, 0);
  return canvas;
}
