// One run's map on a canvas: draws the board when it changed, pans, zooms, follows.

import { h, setText } from "../dom";
import type { Camera } from "../map/camera";
import { MapCanvas } from "../map/canvas";
import type { Layers } from "../map/layers";
import { token } from "../theme";
import { drawGraph, drawGrid, drawPatch, drawRobots, drawScan, drawTrack } from "./draw";
import { SLOT_NAMES, type Slot } from "./protocol";
import type { Store } from "./store";

const FIT_MARGINS_PX = { x: 24, top: 44, bottom: 60 };

export interface PaneEvents {
  /** The user moved this pane's window. */
  moved(pane: Pane): void;
  /** Where the pointer is, or null. */
  hover(at_m: [number, number] | null, cell: number): void;
  /** It has another size, or colours are others. */
  resized(pane: Pane): void;
}

export class Pane {
  readonly element = h("div", { class: "pane" });
  private readonly surface: MapCanvas;
  private readonly badge = h("p", { class: "run-badge", hidden: true });

  constructor(readonly slot: Slot, private readonly store: Store, private readonly layers: Layers, events: PaneEvents) {
    const name = SLOT_NAMES[slot];
    this.element.append(this.badge);
    this.surface = new MapCanvas(this.element, `map-canvas-${name.toLowerCase()}`, `Map of run ${name}. Arrow keys pan, plus and minus zoom, F fits.`, {
      draw: () => {
        this.draw();
        return false;
      },
      changed: () => events.resized(this),
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
    this.camera.scale_min_pxpm = 0.5;
    store.on("board", (changed) => {
      if (changed === slot) this.invalidate();
    });
    store.on("state", () => {
      this.invalidate();
      this.showBadge();
    });
  }

  get canvas(): HTMLCanvasElement {
    return this.surface.canvas;
  }

  get camera(): Camera {
    return this.surface.camera;
  }

  get n_frames(): number {
    return this.surface.n_frames;
  }

  invalidate(): void {
    this.surface.invalidate();
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

  private draw(): void {
    const { layers } = this;
    const brush = this.surface.pen();
    const { context, camera, palette } = brush;
    context.fillStyle = token("--cell-unknown");
    context.fillRect(0, 0, camera.width_px, camera.height_px);
    const board = this.store.boards[this.slot];
    const run = this.store.state?.runs[this.slot];
    if (!board || !run) return;
    if (layers.has("map")) board.drawMap(context, (x_m, y_m) => camera.toScreen(x_m, y_m), camera.scale_pxpm);
    if (layers.has("grid")) drawGrid(brush, token("--map-grid-strong"));
    const [odometry, corrected, truth] = board.tracks;
    if (layers.has("patch")) drawPatch(brush, board, `rgb(${token("--patch-cell")})`);
    if (layers.has("graph") || layers.has("closures")) drawGraph(brush, board, { graph: layers.has("graph"), closures: layers.has("closures") });
    if (layers.has("odometry")) drawTrack(brush, odometry, { colour: palette.colour.estimate, width_px: 1.6, dash: [6, 4] });
    if (layers.has("truth")) drawTrack(brush, truth, { colour: palette.colour.goal, width_px: 1.8 });
    if (layers.has("corrected")) drawTrack(brush, corrected, { colour: palette.colour.trail, width_px: 2 });
    const isUnderWay = run.phase === "under way" && run.scan > 0;
    if (layers.has("scan") && isUnderWay) drawScan(brush, board);
    drawRobots(brush, run, layers.has("odometry") && isUnderWay);
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
