// Live plots over one time axis: cross-track error, wheel speeds, pheromone intensities, clearance.

import uPlot from "uplot";
import "uplot/dist/uPlot.min.css";
import { h } from "../dom";
import { remember, remembered } from "../prefs";
import type { Quantity } from "../series";
import type { Store } from "../state";
import { ticks } from "../ticks";
import { onThemeChange, token } from "../theme";

interface PlotSpec {
  key: string;
  title: string;
  unit: string;
  digits: number;
  curves: readonly { quantity: Quantity; name: string; colour: string }[];
  /** Range shown at least, so that a calm run does not look wild. */
  least: readonly [number, number];
  /** What is said when no value has come yet. */
  empty: string;
}

const PLOTS: readonly PlotSpec[] = [
  { key: "cross", title: "Cross-track error", unit: "mm", digits: 0, least: [-50, 50], empty: "no path is being followed", curves: [{ quantity: "crossTrack_mm", name: "error", colour: "--series-1" }] },
  { key: "wheels", title: "Wheel speeds", unit: "mm/s", digits: 0, least: [0, 350], empty: "no robot", curves: [{ quantity: "wheelLeft_mmps", name: "left", colour: "--series-4" }, { quantity: "wheelRight_mmps", name: "right", colour: "--series-2" }] },
  { key: "smell", title: "Pheromone intensity", unit: "", digits: 0, least: [0, 10], empty: "no pheromones sensed", curves: [{ quantity: "left", name: "left", colour: "--series-4" }, { quantity: "right", name: "right", colour: "--series-2" }] },
  { key: "clearance", title: "Clearance", unit: "m", digits: 2, least: [0, 1], empty: "no robot", curves: [{ quantity: "clearance_m", name: "clearance", colour: "--series-3" }] },
];

const WINDOWS = [["30", "30 s"], ["60", "60 s"], ["all", "All"]] as const;
const REDRAW_MIN_MS = 66;
const N_POINTS_SHOWN = 1500;

export class PlotsPanel {
  readonly element = h("div", { class: "plots" });
  private readonly grid = h("div", { class: "plot-grid" });
  private readonly holders = PLOTS.map((spec) => h("figure", { class: "plot", "data-plot": spec.key }));
  private plots: uPlot[] = [];
  private window: string = remembered<string>("plots.window", "60");
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
    PLOTS.forEach((spec, index) => {
      const legend = spec.curves.map(({ name, colour }) => {
        const swatch = h("i", { class: "line" });
        swatch.style.background = `var(${colour})`;
        return h("span", { class: "curve" }, swatch, name);
      });
      const caption = h("figcaption", {}, h("b", {}, spec.title), spec.unit ? h("span", { class: "unit" }, spec.unit) : null, h("span", { class: "curves" }, ...(spec.curves.length > 1 ? legend : [])));
      this.holders[index]?.append(caption, h("div", { class: "plot-area", role: "img", "aria-label": `${spec.title} over time` }), h("p", { class: "plot-empty" }, spec.empty));
    });
    this.grid.append(...this.holders);
    this.element.append(h("div", { class: "panel-bar" }, h("span", { class: "bar-text" }, "Last"), choices, h("span", { class: "count" }, "simulated time in seconds")), this.grid);
    store.on("state", () => this.schedule());
    store.on("reset", () => this.schedule());
    onThemeChange(() => this.rebuild());
    new ResizeObserver(() => this.resize()).observe(this.grid);
  }

  setVisible(visible: boolean): void {
    this.visible = visible;
    if (visible && this.plots.length === 0) requestAnimationFrame(() => this.rebuild());
    this.schedule();
  }

  /** The plots as they are drawn, for a download; none before the panel was open. */
  pictures(): { title: string; canvas: HTMLCanvasElement }[] {
    return this.plots.map((plot, index) => {
      const spec = PLOTS[index];
      return { title: spec ? `${spec.title}${spec.unit ? `, ${spec.unit}` : ""}` : "", canvas: plot.ctx.canvas };
    });
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
    const now_s = this.store.state?.t_s ?? 0;
    const length_s = this.window === "all" ? Math.max(10, now_s) : Number(this.window);
    const from_s = Math.max(0, now_s - length_s);
    this.plots.forEach((plot, index) => {
      const spec = PLOTS[index];
      if (!spec) return;
      const data = this.store.series.since(from_s, spec.curves.map(({ quantity }) => quantity));
      this.holders[index]?.classList.toggle("is-empty", !data.slice(1).some((column) => column.some((value) => value !== null)));
      plot.batch(() => {
        plot.setData(thinned(data) as uPlot.AlignedData, false);
        plot.setScale("x", { min: from_s, max: from_s + length_s });
      });
    });
  }

  private rebuild(): void {
    for (const plot of this.plots) plot.destroy();
    this.plots = [];
    const areas = this.holders.map((holder) => holder.querySelector<HTMLElement>(".plot-area"));
    if (!areas[0] || areas[0].clientWidth === 0) return;
    this.plots = PLOTS.flatMap((spec, index) => {
      const area = areas[index];
      return area ? [new uPlot(options(spec, area.clientWidth, area.clientHeight), emptyData(spec), area)] : [];
    });
    this.draw();
  }

  private resize(): void {
    if (!this.visible) return;
    if (this.plots.length === 0) return this.rebuild();
    this.plots.forEach((plot, index) => {
      const area = this.holders[index]?.querySelector<HTMLElement>(".plot-area");
      if (area && area.clientWidth > 0) plot.setSize({ width: area.clientWidth, height: area.clientHeight });
    });
  }
}

function emptyData(spec: PlotSpec): uPlot.AlignedData {
  return [[], ...spec.curves.map(() => [])];
}

function options(spec: PlotSpec, width: number, height: number): uPlot.Options {
  const axis: uPlot.Axis = {
    stroke: token("--muted"),
    font: `11px ${token("--font")}`,
    grid: { stroke: token("--line"), width: 1 },
    ticks: { stroke: token("--line"), width: 1, size: 3 },
    gap: 3,
  };
  return {
    width, height,
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
      ...spec.curves.map(({ name, colour }) => ({
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
