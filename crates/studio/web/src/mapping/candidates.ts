// The panel of short-term maps: which poses were tried, their scores as a heat map, the chosen one, and the verdict.

import { h, setText, svg } from "../dom";
import { emptyState } from "../panels/empty";
import type { Candidate, Registration, Slot } from "./protocol";
import { SLOT_NAMES } from "./protocol";
import type { Store } from "./store";

const N_LISTED = 8;
const CELL_PX = 26;
const GAP_PX = 3;
const STEPS = 9;

export class CandidatesPanel {
  readonly element = h("div", { class: "candidates" });
  private readonly empty = emptyState("No short-term map has been compared yet", "With sonars, readings are gathered in a short-term map; when it is ripe, poses around odometry's are tried and scored here. A laser is matched scan by scan; see the counters.");
  private readonly body = h("div", { class: "candidates-body", hidden: true });
  private readonly run = h("select", { class: "field small", "aria-label": "Run", hidden: true }, h("option", { value: 0 }, "Run A"), h("option", { value: 1 }, "Run B"));
  private readonly which = h("span", { class: "number" });
  private readonly older = h("button", { class: "button small", type: "button", "aria-label": "Comparison before" }, "‹");
  private readonly newer = h("button", { class: "button small", type: "button", "aria-label": "Next comparison" }, "›");
  private readonly verdict = h("p", { class: "verdict-line" });
  private readonly heat = h("div", { class: "heat" });
  private readonly list = h("tbody");
  private readonly score = h("th", { scope: "col" }, "Score");
  private slot: Slot = 0;
  /** The comparison that is shown; null follows the newest. */
  private pinned: number | null = null;
  private shown = "";

  constructor(private readonly store: Store) {
    this.body.append(
      h("div", { class: "panel-bar" }, this.run, this.older, this.which, this.newer),
      h("div", { class: "candidates-in" }, this.verdict, this.heat,
        h("table", { class: "scores" }, h("thead", {}, h("tr", {}, h("th", { scope: "col" }, ""), h("th", { scope: "col" }, "x"), h("th", { scope: "col" }, "y"), h("th", { scope: "col" }, "Turn"), this.score)), this.list)),
    );
    this.element.append(this.empty, this.body);
    this.run.addEventListener("change", () => {
      this.slot = this.run.value === "1" ? 1 : 0;
      this.pinned = null;
      this.refresh();
    });
    this.older.addEventListener("click", () => this.move(-1));
    this.newer.addEventListener("click", () => this.move(1));
    store.on("registration", () => this.refresh());
    store.on("state", () => this.onState());
  }

  private onState(): void {
    const isPair = (this.store.state?.runs.length ?? 0) > 1;
    if (isPair === this.run.hidden) {
      this.run.hidden = !isPair;
      this.slot = isPair ? 1 : 0;
      this.run.value = String(this.slot);
      this.pinned = null;
      this.refresh();
    }
  }

  private move(by: number): void {
    const list = this.store.registrations[this.slot];
    const at = this.index(list) + by;
    if (at < 0 || at >= list.length) return;
    this.pinned = at === list.length - 1 ? null : (list[at]?.number ?? null);
    this.refresh();
  }

  private index(list: readonly Registration[]): number {
    const found = this.pinned === null ? -1 : list.findIndex(({ number }) => number === this.pinned);
    return found >= 0 ? found : list.length - 1;
  }

  private refresh(): void {
    const list = this.store.registrations[this.slot];
    const at = this.index(list);
    const now = list[at];
    this.empty.hidden = now !== undefined;
    this.body.hidden = now === undefined;
    if (!now) return;
    this.older.disabled = at <= 0;
    this.newer.disabled = at >= list.length - 1;
    const key = `${this.slot}.${now.run}.${now.number}`;
    setText(this.which, `No. ${now.number}, at scan ${now.scan + 1}${this.pinned === null ? "" : " (held)"}`);
    if (key === this.shown) return;
    this.shown = key;
    this.element.dataset["shown"] = `${SLOT_NAMES[this.slot]} ${now.number}`;
    this.verdict.className = `verdict-line ${now.applied ? "applied" : "refused"}`;
    this.verdict.replaceChildren(h("b", {}, now.applied ? "Applied" : "Not applied"), ` ${now.verdict}`);
    setText(this.score, "Score");
    this.score.title = now.score;
    this.heat.replaceChildren(...heatMaps(now), h("p", { class: "heat-note" }, `${now.score ? `Score: ${now.score}. The better, the stronger the colour; the ring marks the best of the poses tried.` : "The ring marks the best of the poses tried."}${now.applied ? " By how much the robot is moved is weighed from it, dead reckoning and walls." : ""}`));
    this.list.replaceChildren(...ranked(now).slice(0, N_LISTED).map(([index, candidate, rank]) => listRow(candidate, rank, index === now.best)));
  }
}

/** Candidates as listed, with their index, the chosen one first, then by how near their score is to its score. */
export function ranked({ candidates, best }: Registration): [index: number, candidate: Candidate, rank: number][] {
  const top = best === null ? null : (candidates[best]?.[3] ?? null);
  const distance = (score: number | null): number => (score === null ? Infinity : top === null ? 0 : Math.abs(score - top));
  const order = candidates.map((candidate, index): [number, Candidate] => [index, candidate]);
  order.sort((a, b) => Number(b[0] === best) - Number(a[0] === best) || distance(a[1][3]) - distance(b[1][3]) || a[0] - b[0]);
  return order.map(([index, candidate], rank) => [index, candidate, rank + 1]);
}

function listRow([x_m, y_m, yaw_rad, score]: Candidate, rank: number, isBest: boolean): HTMLElement {
  const cm = (value_m: number): string => `${signed(value_m * 100, 1)} cm`;
  return h("tr", isBest ? { class: "best" } : {},
    h("th", { scope: "row" }, isBest ? "best" : String(rank)),
    h("td", { class: "number" }, cm(x_m)), h("td", { class: "number" }, cm(y_m)),
    h("td", { class: "number" }, `${signed((yaw_rad * 180) / Math.PI, 1)}°`),
    h("td", { class: "number" }, score === null ? "too little overlap" : String(Number(score.toPrecision(4)))));
}

/** One square for each turn: a cell for each shift, coloured by how near its score is to the chosen one's. */
function heatMaps({ candidates, best }: Registration): Element[] {
  const scores = candidates.map(([, , , score]) => score).filter((score): score is number => score !== null);
  const top = best === null ? null : (candidates[best]?.[3] ?? null);
  // The chosen one has the best score, whichever way the scores run.
  const worst = scores.reduce((far, score) => (top !== null && Math.abs(score - top) > Math.abs(far - top) ? score : far), top ?? 0);
  const turns = distinct(candidates.map(([, , yaw_rad]) => yaw_rad));
  const [xs, ys] = [distinct(candidates.map(([x]) => x)), distinct(candidates.map(([, y]) => y)).reverse()];
  const cell_px = Math.max(6, Math.min(CELL_PX, Math.floor(150 / Math.max(xs.length, ys.length))));
  return turns.map((turn) => {
    const [width, height] = [xs.length * (cell_px + GAP_PX), ys.length * (cell_px + GAP_PX)];
    const title = `Turned by ${signed((turn * 180) / Math.PI, 1)}°`;
    const picture = svg("svg", { class: "heat-map", viewBox: `0 0 ${width} ${height}`, width, height, role: "img", "aria-label": title });
    candidates.forEach(([x, y, yaw, score], index) => {
      if (!same(yaw, turn)) return;
      const level = score === null || top === null ? null : worst === top ? 1 : 1 - Math.abs(score - top) / Math.abs(worst - top);
      const place = { x: xs.findIndex((value) => same(value, x)) * (cell_px + GAP_PX) + 1.5, y: ys.findIndex((value) => same(value, y)) * (cell_px + GAP_PX) + 1.5, width: cell_px, height: cell_px, rx: 3 };
      const rect = svg("rect", { ...place, class: `heat-cell ${level === null ? "none" : `level-${Math.round(level * (STEPS - 1))}`}${index === best ? " best" : ""}` });
      rect.append(svg("title", {}, `x ${signed(x * 100, 1)} cm, y ${signed(y * 100, 1)} cm: ${score === null ? "too little overlap" : Number(score.toPrecision(4))}`));
      picture.append(rect);
    });
    return h("figure", { class: "heat-figure" }, picture, h("figcaption", {}, `${signed((turn * 180) / Math.PI, 1)}°`));
  });
}

function same(a: number, b: number): boolean {
  return Math.abs(a - b) < 1e-6;
}

function distinct(values: number[]): number[] {
  const sorted = [...values].sort((a, b) => a - b);
  return sorted.filter((value, index) => index === 0 || !same(value, sorted[index - 1] ?? 0));
}

function signed(value: number, digits: number): string {
  const text = Math.abs(value).toFixed(digits);
  return Number(text) === 0 ? text : `${value < 0 ? "−" : "+"}${text}`;
}
