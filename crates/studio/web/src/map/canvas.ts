// A map's canvas: pixels, camera and gestures, and a picture whenever something has changed. What is drawn is others' matter.

import { h } from "../dom";
import { onThemeChange } from "../theme";
import { Camera } from "./camera";
import { attachGestures, type GestureEvents } from "./gestures";
import { readPalette } from "./palette";
import type { Pen } from "./pen";

export interface MapDrawing extends GestureEvents {
  /** Paints; true while the picture is still on its way to what is known. */
  draw(now_ms: number): boolean;
  /** The canvas has another size, or colours are others. */
  changed(): void;
}

export class MapCanvas {
  readonly canvas: HTMLCanvasElement;
  readonly camera = new Camera();
  readonly context: CanvasRenderingContext2D;
  palette = readPalette();
  n_frames = 0;
  private isStale = true;

  constructor(private readonly holder: HTMLElement, id: string, label: string, private readonly drawing: MapDrawing) {
    this.canvas = h("canvas", { id, tabindex: 0, role: "application", "aria-roledescription": "map", "aria-label": label });
    const context = this.canvas.getContext("2d");
    if (!context) throw new Error("this browser has no canvas 2-D context");
    this.context = context;
    holder.prepend(this.canvas);
    attachGestures(this.canvas, this.camera, drawing);
    new ResizeObserver(() => this.resize()).observe(holder);
    onThemeChange(() => {
      this.palette = readPalette();
      drawing.changed();
      this.invalidate();
    });
    const frame = (now_ms: number): void => {
      if (this.isStale) this.paint(now_ms);
      requestAnimationFrame(frame);
    };
    requestAnimationFrame(frame);
  }

  get density(): number {
    return this.canvas.width / this.camera.width_px;
  }

  invalidate(): void {
    this.isStale = true;
  }

  /** A pen on this canvas, or on another of the same size. */
  pen(context: CanvasRenderingContext2D = this.context): Pen {
    context.setTransform(this.density, 0, 0, this.density, 0, 0);
    return { context, camera: this.camera, palette: this.palette };
  }

  private paint(now_ms: number): void {
    if (this.holder.clientWidth === 0) return;
    this.n_frames += 1;
    this.isStale = this.drawing.draw(now_ms);
  }

  private resize(): void {
    const box = this.holder.getBoundingClientRect();
    if (box.width === 0) return;
    const density = window.devicePixelRatio || 1;
    this.camera.width_px = Math.max(1, box.width);
    this.camera.height_px = Math.max(1, box.height);
    this.canvas.width = Math.round(box.width * density);
    this.canvas.height = Math.round(box.height * density);
    this.drawing.changed();
    this.paint(performance.now());
  }
}
