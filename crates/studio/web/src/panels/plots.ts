// Plots over one time axis: which there are, and which curves are in them, the program says.

import uPlot from "uplot";
import "uplot/dist/uPlot.min.css";
import { h } from "../dom";
import { remember, remembered } from "../prefs";
import type { PlotInfo } from "../offer";
import type { Hello } from "../protocol";
import type { Store } from "../state";
import { ticks } from "../ticks";
import { onThemeChange, token } from "../theme";

/** Colours of the curves of a plot; a plot of one curve takes the next in turn. */
const PAIR = ["--series-4", "--series-2", "--series-3", "--series-1"];
const SINGLE = ["--series-1", "--series-3", "--series-4", "--series-2"];

interface Curve {
  id: string;
  name: string;
  colour: string;
}

interface Shown {
  spec: PlotInfo;
  curves: readonly Curve[];
  holder: HTMLElement;
  plot: uPlot | null;
}

const WINDOWS = [["30", "30 s"], ["60", "60 s"], ["all", "All"]] as const;
const REDRAW_MIN_MS = 66;
const N_POINTS_SHOWN = 1500;

export class PlotsPanel {
  readonly element = h("div", { class: "plots" });
  private readonly grid = h("div", { class: "plot-grid" });
  private shown: Shown[] = [];
  private window: string = remembered<string>("plots.window", "60");
  private offered = "";
  private visible = false;
  private drawn_ms = 0;
  private scheduled = false;

  constructor(private readonly store: Store) {
    const choices = h("div", { class: "segments", role: "group", "aria-label": "Time shown" });
    for (const [key, text] of WINDOWS) {
      const button = h("button", { class: "segment", type: "button", "aria-pressed": String(key === this.window), "data-window": key }, text);
      button.addEventListener("click", () => {
        this.window = key;
        remember("plots.window", key);
        for (const other of choices.children) other.setAttribute("aria-pressed", String(other === button));
        this.schedule();
      });
      choices.append(button);
    }
    this.element.append(h("div", { class: "panel-bar" }, h("span", { class: "bar-text" }, "Last"), choices, h("span", { class: "count" }, "simulated time in seconds")), this.grid);
    store.on("hello", (hello) => this.offer(hello));
    store.on("live", () => this.schedule());
    store.on("state", () => this.schedule());
    store.on("reset", () => this.schedule());
    onThemeChange(() => this.rebuild());
    new ResizeObserver(() => this.resize()).observe(this.grid);
  }

  setVisible(visible: boolean): void {
    this.visible = visible;
    if (visible) requestAnimationFrame(() => this.resize());
    this.schedule();
  }

  /** The plots as they are drawn, for a download; none before the panel was open. */
  pictures(): { title: string; canvas: HTMLCanvasElement }[] {
    return this.shown.flatMap(({ spec, plot }) => (plot ? [{ title: `${spec.title}${spec.unit ? `, ${spec.unit}` : ""}`, canvas: plot.ctx.canvas }] : []));
  }

  /** The plots that the mission has, with the curves of its signals. */
  private offer({ plots, robot_signals }: Hello): void {
    const told = JSON.stringify([plots, robot_signals]);
    if (told === this.offered) return;
    this.offered = told;
    for (const { plot } of this.shown) plot?.destroy();
    let n_single = 0;
    this.shown = plots.map((spec) => {
      const mine = robot_signals.filter(({ curve }) => curve?.[0] === spec.id);
      const colours = mine.length > 1 ? PAIR : [SINGLE[n_single++ % SINGLE.length] ?? "--series-1"];
      const curves = mine.map(({ id, curve }, index) => ({ id, name: curve?.[1] ?? id, colour: colours[index % colours.length] ?? "--series-1" }));
      return { spec, curves, holder: holderOf(spec, curves), plot: null };
    });
    this.grid.replaceChildren(...this.shown.map(({ holder }) => holder));
    this.grid.classList.toggle("many", plots.length > 4);
    if (this.visible) this.rebuild();
  }

  private schedule(): void {
    if (!this.visible || this.scheduled) return;
    this.scheduled = true;
    const wait_ms = Math.max(0, REDRAW_MIN_MS - (performance.now() - this.drawn_ms));
    window.setTimeout(() => requestAnimationFrame(() => this.draw()), wait_ms);
  }

  private draw(): void {
    this.scheduled = false;
    this.drawn_ms = performance.now();
    const now_s = this.store.live?.t_s ?? 0;
    const length_s = this.window === "all" ? Math.max(10, now_s) : Number(this.window);
    // What is looked back on stays in sight.
    const until_s = this.store.until_s;
    const from_s = Math.max(0, Math.min(now_s - length_s, until_s - length_s / 2));
    for (const { spec, curves, holder, plot } of this.shown) {
      if (!plot) continue;
      const [t_s, ...columns] = this.store.series.since(from_s, curves.map(({ id }) => id));
      const data = [t_s, ...columns.map((column) => column.map((value) => (value === null ? null : value * spec.per_si_ratio)))];
      holder.classList.toggle("is-empty", !columns.some((column) => column.some((value) => value !== null)));
      plot.batch(() => {
        plot.setData(thinned(data) as uPlot.AlignedData, false);
        plot.setScale("x", { min: from_s, max: from_s + length_s });
      });
    }
  }

  private rebuild(): void {
    for (const shown of this.shown) {
      shown.plot?.destroy();
      const area = shown.holder.querySelector<HTMLElement>(".plot-area");
      shown.plot = area && area.clientWidth > 0 ? new uPlot(options(shown, area, () => this.store.until_s), emptyData(shown), area) : null;
    }
    this.draw();
  }

  private resize(): void {
    if (!this.visible) return;
    if (this.shown.some(({ plot }) => !plot)) return this.rebuild();
    for (const { holder, plot } of this.shown) {
      const area = holder.querySelector<HTMLElement>(".plot-area");
      if (area && area.clientWidth > 0) plot?.setSize({ width: area.clientWidth, height: area.clientHeight });
    }
  }
}

function holderOf(spec: PlotInfo, curves: readonly Curve[]): HTMLElement {
  const legend = curves.map(({ name, colour }) => {
    const swatch = h("i", { class: "line" });
    swatch.style.background = `var(${colour})`;
    return h("span", { class: "curve" }, swatch, name);
  });
  return h("figure", { class: "plot", "data-plot": spec.id },
    h("figcaption", {}, h("b", {}, spec.title), spec.unit ? h("span", { class: "unit" }, spec.unit) : null, h("span", { class: "curves" }, ...(curves.length > 1 ? legend : []))),
    h("div", { class: "plot-area", role: "img", "aria-label": `${spec.title} over time` }), h("p", { class: "plot-empty" }, spec.empty));
}

/** A line at the time that is looked back on. */
function markTime(plot: uPlot, t_s: number): void {
  if (!Number.isFinite(t_s)) return;
  const x = plot.valToPos(t_s, "x", true);
  const { left, top, width, height } = plot.bbox;
  if (x < left || x > left + width) return;
  plot.ctx.save();
  plot.ctx.strokeStyle = token("--rise");
  plot.ctx.lineWidth = 2 * (window.devicePixelRatio || 1);
  plot.ctx.beginPath();
  plot.ctx.moveTo(x, top);
  plot.ctx.lineTo(x, top + height);
  plot.ctx.stroke();
  plot.ctx.restore();
}

function emptyData({ curves }: Shown): uPlot.AlignedData {
  return [[], ...curves.map(() => [])];
}

function options({ spec, curves }: Shown, area: HTMLElement, until_s: () => number): uPlot.Options {
  const axis: uPlot.Axis = {
    stroke: token("--muted"),
    font: `11px ${token("--font")}`,
    grid: { stroke: token("--line"), width: 1 },
    ticks: { stroke: token("--line"), width: 1, size: 3 },
    gap: 3,
  };
  return {
    width: area.clientWidth, height: area.clientHeight,
    hooks: { draw: [(plot) => markTime(plot, until_s())] },
    legend: { show: false },
    cursor: { sync: { key: "time" }, drag: { x: false, y: false }, points: { size: 6 } },
    padding: [6, 8, 0, 0],
    scales: {
      x: { time: false },
      y: { range: (_plot, min, max) => [Math.min(min ?? 0, spec.least[0]), Math.max(max ?? 0, spec.least[1]) * 1.02] },
    },
    axes: [
      { ...axis, size: 22, space: 50, values: (_plot, values) => values.map((value) => String(value)) },
      { ...axis, size: 38, space: 10, splits: (_plot, _axis, min, max) => ticks(min, max), values: (_plot, values) => values.map((value) => String(value)) },
    ],
    series: [
      {},
      ...curves.map(({ name, colour }) => ({
        label: name, stroke: token(colour), width: 1.6, points: { show: false }, spanGaps: false,
      })),
    ],
  };
}

/** A plot a few hundred pixels wide gains nothing from more points. */
function thinned<T extends unknown[][]>(columns: T): T {
  const n = columns[0]?.length ?? 0;
  if (n <= N_POINTS_SHOWN) return columns;
  const stride = Math.ceil(n / N_POINTS_SHOWN);
  return columns.map((column) => column.filter((_, index) => index % stride === 0)) as T;
}
