// One run's map on a canvas: draws the board when it changed, pans, zooms, follows.

import { h, setText } from "../dom";
import { Camera } from "../map/camera";
import { attachGestures } from "../map/gestures";
import { readPalette } from "../map/palette";
import { token } from "../theme";
import { drawGraph, drawGrid, drawPatch, drawRobots, drawScan, drawTrack } from "./draw";
import type { Layers } from "./layers";
import { SLOT_NAMES, type Slot } from "./protocol";
import type { Store } from "./store";

const FIT_MARGINS_PX = { x: 24, top: 44, bottom: 60 };

export interface PaneEvents {
  /** The user moved this pane's window. */
  moved(pane: Pane): void;
  /** Where the pointer is, or null. */
  hover(at_m: [number, number] | null, cell: number): void;
}

export class Pane {
  readonly element: HTMLElement;
  readonly canvas: HTMLCanvasElement;
  readonly camera = new Camera();
  n_frames = 0;
  private readonly context: CanvasRenderingContext2D;
  private readonly badge = h("p", { class: "run-badge", hidden: true });
  private palette = readPalette();
  private isStale = true;

  constructor(readonly slot: Slot, private readonly store: Store, private readonly layers: Layers, events: PaneEvents) {
    const name = SLOT_NAMES[slot];
    this.canvas = h("canvas", {
      id: `map-canvas-${name.toLowerCase()}`, tabindex: 0, role: "application", "aria-roledescription": "map",
      "aria-label": `Map of run ${name}. Arrow keys pan, plus and minus zoom, F fits.`,
    });
    const context = this.canvas.getContext("2d");
    if (!context) throw new Error("this browser has no canvas 2-D context");
    this.context = context;
    this.camera.scale_min_pxpm = 0.5;
    this.element = h("div", { class: "pane" }, this.canvas, this.badge);
    attachGestures(this.canvas, this.camera, {
      press: () => false,
      drag: () => {},
      release: () => {},
      cancel: () => {},
      click: () => {},
      hover: (at_px) => {
        const at_m = at_px && this.camera.toWorld(...at_px);
        events.hover(at_m, at_m ? (store.boards[slot]?.cellAt(...at_m) ?? 0) : 0);
      },
      moved: () => {
        this.invalidate();
        events.moved(this);
      },
    });
    store.on("board", (changed) => {
      if (changed === slot) this.invalidate();
    });
    store.on("state", () => {
      this.invalidate();
      this.showBadge();
    });
  }

  invalidate(): void {
    this.isStale = true;
  }

  restyle(): void {
    this.palette = readPalette();
    this.invalidate();
  }

  resize(): void {
    const box = this.element.getBoundingClientRect();
    const density = window.devicePixelRatio || 1;
    this.camera.width_px = Math.max(1, box.width);
    this.camera.height_px = Math.max(1, box.height);
    this.canvas.width = Math.round(this.camera.width_px * density);
    this.canvas.height = Math.round(this.camera.height_px * density);
    this.invalidate();
  }

  fit(bounds_m: [number, number, number, number]): void {
    this.camera.fit(bounds_m, FIT_MARGINS_PX);
    this.invalidate();
  }

  /** The same window as another pane. */
  copyWindow(other: Pane): void {
    this.camera.centre_m = [...other.camera.centre_m];
    this.camera.scale_pxpm = other.camera.scale_pxpm;
    this.invalidate();
  }

  frame(): void {
    if (!this.isStale || this.element.hidden) return;
    this.isStale = false;
    this.n_frames += 1;
    this.draw();
  }

  private draw(): void {
    const { context, camera, layers, palette } = this;
    const density = this.canvas.width / camera.width_px;
    context.setTransform(density, 0, 0, density, 0, 0);
    context.fillStyle = token("--cell-unknown");
    context.fillRect(0, 0, camera.width_px, camera.height_px);
    const board = this.store.boards[this.slot];
    const run = this.store.state?.runs[this.slot];
    if (!board || !run) return;
    const brush = { context, camera, palette };
    if (layers.map) board.drawMap(context, (x_m, y_m) => camera.toScreen(x_m, y_m), camera.scale_pxpm);
    if (layers.grid) drawGrid(brush, token("--map-grid-strong"));
    const [odometry, corrected, truth] = board.tracks;
    if (layers.patch) drawPatch(brush, board, `rgb(${token("--patch-cell")})`);
    if (layers.graph || layers.closures) drawGraph(brush, board, layers);
    if (layers.odometry) drawTrack(brush, odometry, { colour: palette.colour.estimate, width_px: 1.6, dash: [6, 4] });
    if (layers.truth) drawTrack(brush, truth, { colour: palette.colour.goal, width_px: 1.8 });
    if (layers.corrected) drawTrack(brush, corrected, { colour: palette.colour.trail, width_px: 2 });
    const isUnderWay = run.phase === "under way" && run.scan > 0;
    if (layers.scan && isUnderWay) drawScan(brush, board);
    drawRobots(brush, run, layers.odometry && isUnderWay);
  }

  private showBadge(): void {
    const runs = this.store.state?.runs ?? [];
    const run = runs[this.slot];
    this.badge.hidden = runs.length < 2 || !run;
    if (!run || this.badge.hidden) return;
    const n_set = Object.keys(run.values).length;
    const what = n_set === 0 ? "default parameters" : `${n_set} ${n_set === 1 ? "parameter" : "parameters"} set`;
    setText(this.badge, `Run ${SLOT_NAMES[this.slot]} · ${what}`);
  }
}
