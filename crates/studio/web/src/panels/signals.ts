// A logic analyser: one trace per boolean resource of the program over the last half minute.

import { h } from "../dom";
import type { Store } from "../state";
import { onThemeChange, token } from "../theme";
import { emptyState } from "./empty";

const WINDOW_S = 30;
const ROW_PX = 26;
const NAME_PX = 66;

export class SignalsPanel {
  readonly element = h("div", { class: "signals" });
  private readonly canvas = h("canvas", { role: "img", "aria-label": "Traces of the program's inputs, memories, timers and outputs" });
  private visible = false;
  private scheduled = false;

  constructor(private readonly store: Store) {
    this.showEmpty();
    store.on("hello", () => this.showEmpty());
    store.on("state", () => this.schedule());
    store.on("reset", () => this.schedule());
    onThemeChange(() => this.schedule());
    new ResizeObserver(() => this.schedule()).observe(this.element);
  }

  setVisible(visible: boolean): void {
    this.visible = visible;
    this.schedule();
  }

  private showEmpty(): void {
    if (this.store.hello?.program) {
      if (!this.canvas.isConnected) this.element.replaceChildren(this.canvas);
      return this.schedule();
    }
    this.element.replaceChildren(emptyState("No signals", "Inputs, memories and outputs appear here when the mission has a decision program."));
  }

  private schedule(): void {
    if (!this.visible || this.scheduled) return;
    this.scheduled = true;
    requestAnimationFrame(() => {
      this.scheduled = false;
      this.draw();
    });
  }

  private draw(): void {
    const context = this.canvas.getContext("2d");
    const { edges } = this.store.signals;
    if (!context || !this.canvas.isConnected) return;
    const width_px = this.element.clientWidth;
    const height_px = Math.max(this.element.clientHeight, edges.size * ROW_PX + 30);
    const density = window.devicePixelRatio || 1;
    if (this.canvas.width !== Math.round(width_px * density) || this.canvas.height !== Math.round(height_px * density)) {
      this.canvas.width = Math.round(width_px * density);
      this.canvas.height = Math.round(height_px * density);
      this.canvas.style.height = `${height_px}px`;
    }
    context.setTransform(density, 0, 0, density, 0, 0);
    context.clearRect(0, 0, width_px, height_px);
    const now_s = this.store.state?.t_s ?? 0;
    const to_s = Math.max(now_s, WINDOW_S);
    const x = (t_s: number): number => NAME_PX + ((t_s - (to_s - WINDOW_S)) / WINDOW_S) * (width_px - NAME_PX - 14);
    this.drawAxis(context, x, to_s, height_px);
    [...edges.entries()].forEach(([name, list], row) => {
      const low = 12 + (row + 1) * ROW_PX - 6;
      const high = low - ROW_PX + 11;
      const isHigh = (list.findLast((edge) => edge.t_s <= now_s) ?? list[0])?.high ?? false;
      context.font = `12px ${token("--mono")}`;
      context.textAlign = "right";
      context.textBaseline = "middle";
      context.fillStyle = isHigh ? token("--good") : token("--muted");
      context.fillText(name, NAME_PX - 10, (low + high) / 2);
      context.beginPath();
      const from_s = to_s - WINDOW_S;
      const before = list.findLast((edge) => edge.t_s <= from_s) ?? list[0];
      let level = before?.high ?? false;
      context.moveTo(Math.max(NAME_PX, x(before?.t_s ?? 0)), level ? high : low);
      for (const edge of list) {
        if (edge.t_s > now_s) break;
        if (edge.t_s <= (before?.t_s ?? 0)) continue;
        const at = x(edge.t_s);
        context.lineTo(at, level ? high : low);
        level = edge.high;
        context.lineTo(at, level ? high : low);
      }
      context.lineTo(x(now_s), level ? high : low);
      context.strokeStyle = token("--accent");
      context.lineWidth = 1.75;
      context.lineJoin = "round";
      context.stroke();
    });
  }

  private drawAxis(context: CanvasRenderingContext2D, x: (t_s: number) => number, to_s: number, height_px: number): void {
    context.strokeStyle = token("--line");
    context.fillStyle = token("--muted");
    context.lineWidth = 1;
    context.font = `11px ${token("--font")}`;
    context.textAlign = "center";
    context.textBaseline = "alphabetic";
    for (let t_s = Math.ceil((to_s - WINDOW_S) / 5) * 5; t_s <= to_s; t_s += 5) {
      const at = Math.round(x(t_s)) + 0.5;
      context.beginPath();
      context.moveTo(at, 6);
      context.lineTo(at, height_px - 20);
      context.stroke();
      context.fillText(`${t_s} s`, Math.min(at, this.element.clientWidth - 16), height_px - 7);
    }
  }
}
