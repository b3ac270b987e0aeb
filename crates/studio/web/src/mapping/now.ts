// The panel that tells how the runs stand: scans, counters, how the last scan was placed, time by stage.

import { h, setText } from "../dom";
import { emptyState } from "../panels/empty";
import { type RunState, SLOT_NAMES, type Slot } from "./protocol";
import type { Store } from "./store";

const PHASES = { "under way": "Under way", finishing: "Finishing: last loops, whole map, errors…", finished: "Finished", failed: "Stopped by an error" } as const;

export class NowPanel {
  readonly element = h("div", { class: "now" });
  private readonly cards: [Card, Card] = [new Card(0), new Card(1)];
  private readonly empty = emptyState("Nothing is being mapped", "Open a log or make a sample; the figures of the run stand here.");

  constructor(private readonly store: Store) {
    this.element.append(this.empty, this.cards[0].element, this.cards[1].element);
    store.on("state", () => this.refresh());
    store.on("source", () => this.refresh());
    this.refresh();
  }

  private refresh(): void {
    const runs = this.store.state?.runs ?? [];
    this.empty.hidden = runs.length > 0;
    for (const slot of [0, 1] as const) this.cards[slot].show(runs[slot], runs.length > 1);
  }
}

class Card {
  readonly element = h("section", { class: "run-card" });
  private readonly title = h("h3");
  private readonly problem = h("p", { class: "alarm", role: "alert", hidden: true });
  private readonly counters = h("dl", { class: "counters" });
  private readonly cells = new Map<string, HTMLElement>();
  private readonly stages = h("tbody");
  private readonly stageTable = h("table", { class: "stages" },
    h("caption", {}, "Time by stage"),
    h("thead", {}, h("tr", {}, h("th", { scope: "col" }, "Stage"), h("th", { scope: "col" }, "Share"), h("th", { scope: "col" }, "Total"), h("th", { scope: "col" }, "Longest"), h("th", { scope: "col" }, "Times"))),
    this.stages);
  private readonly rows = new Map<string, HTMLElement[]>();
  private run = -1;

  constructor(private readonly slot: Slot) {
    this.element.append(this.title, this.problem, this.counters, this.stageTable);
  }

  show(run: RunState | undefined, isPair: boolean): void {
    this.element.hidden = !run;
    if (!run) return;
    if (run.run !== this.run) this.begin(run.run);
    setText(this.title, `${isPair ? `Run ${SLOT_NAMES[this.slot]}: ` : ""}${PHASES[run.phase]}`);
    this.problem.hidden = run.problem === null && !run.is_cut;
    setText(this.problem, run.problem ?? (run.is_cut ? "The map is larger than this page can show; the rest is mapped, but not drawn." : ""));
    this.counter("scans", "Scans", `${run.scan} of ${run.n_scans}`);
    for (const { name, label, value } of run.counters) this.counter(name, label.charAt(0).toUpperCase() + label.slice(1), String(value));
    if (run.tracking) this.counter("tracking", "Last scan", run.tracking);
    const total_s = run.stages.reduce((sum, stage) => sum + stage.total_s, 0);
    this.stageTable.hidden = run.stages.length === 0;
    for (const stage of run.stages) {
      const cells = this.row(stage.name);
      const share = total_s > 0 ? stage.total_s / total_s : 0;
      const bar = cells[1]?.firstElementChild;
      if (bar instanceof HTMLElement) bar.style.transform = `scaleX(${share.toFixed(3)})`;
      setCell(cells[2], seconds(stage.total_s));
      setCell(cells[3], seconds(stage.longest_s));
      setCell(cells[4], String(stage.n_times));
    }
  }

  private begin(run: number): void {
    this.run = run;
    this.counters.replaceChildren();
    this.cells.clear();
    this.stages.replaceChildren();
    this.rows.clear();
  }

  private counter(name: string, label: string, text: string): void {
    let cell = this.cells.get(name);
    if (!cell) {
      cell = h("dd", { class: "number" });
      this.cells.set(name, cell);
      this.counters.append(h("div", { "data-counter": name }, h("dt", {}, label), cell));
    }
    setText(cell, text);
  }

  private row(name: string): HTMLElement[] {
    let cells = this.rows.get(name);
    if (!cells) {
      cells = [h("th", { scope: "row" }, name), h("td", { class: "share" }, h("div")), h("td", { class: "number" }), h("td", { class: "number" }), h("td", { class: "number" })];
      this.rows.set(name, cells);
      this.stages.append(h("tr", {}, ...cells));
    }
    return cells;
  }
}

function setCell(cell: HTMLElement | undefined, text: string): void {
  if (cell) setText(cell, text);
}

/** 0.00042 → "0.42 ms", 12.3 → "12.3 s" */
export function seconds(time_s: number): string {
  if (time_s >= 9.95) return `${time_s.toFixed(0)} s`;
  if (time_s >= 0.995) return `${time_s.toFixed(1)} s`;
  const ms = time_s * 1000;
  return `${ms.toFixed(ms < 9.95 ? 2 : ms < 99.5 ? 1 : 0)} ms`;
}
