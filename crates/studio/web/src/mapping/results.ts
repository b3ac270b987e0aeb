// The panel of results: the figures of one run, or of two side by side with the parameters in which they differ.

import { h, setText } from "../dom";
import { emptyState } from "../panels/empty";
import type { Request, RunState, Slot } from "./protocol";
import { SLOT_NAMES } from "./protocol";
import type { Store } from "./store";
import { figureText, tidyNumber, unitOf } from "./units";

const GROUPS: Record<string, string> = {
  truth: "Error against the true poses", "truth.odometry": "Error of odometry alone",
  relations: "Error against known relations", "relations.consecutive": "Error between consecutive places", "relations.revisiting": "Error between visits of a place", "relations.odometry": "Error of odometry against the relations",
  reference: "Distance from the poses in the file", "reference.odometry": "Distance of odometry from them",
  "": "Run", map: "Map", graph: "Graph",
};

/** Lengths and angles have figures of the same names: what is measured stands beside the name. */
const SHOWN_UNITS = new Map([["m", "(length)"], ["°", "(angle)"], ["rad", "(angle)"]]);

export class ResultsPanel {
  readonly element = h("div", { class: "results" });
  private readonly empty = emptyState("The figures come at the end", "When all scans are in: errors where the truth is known, entropy, closures, time. To the end goes as fast as possible.");
  private readonly body = h("div", { class: "results-body", hidden: true });
  private readonly invitation = h("p", { class: "results-note" });
  private readonly differences = h("tbody");
  private readonly differenceTable = h("table", { class: "figures-table" }, h("caption", {}, "Parameters that differ"), h("thead", {}, h("tr", {}, h("th", { scope: "col" }, ""), h("th", { scope: "col" }, "Run A"), h("th", { scope: "col" }, "Run B"))), this.differences);
  private readonly same = h("p", { class: "results-note" }, "Both runs have the same parameters.");
  private readonly head = h("tr");
  private readonly figures = h("tbody");
  private readonly actions = h("div", { class: "results-actions" });
  private shown = "";

  constructor(private readonly store: Store, private readonly send: (request: Request) => boolean) {
    this.body.append(this.differenceTable, this.same, h("table", { class: "figures-table", id: "figures-table" }, h("caption", {}, "Figures"), h("thead", {}, this.head), this.figures), this.invitation, this.actions);
    this.element.append(this.empty, this.body);
    store.on("state", () => this.refresh());
  }

  private refresh(): void {
    const { state } = this.store;
    const runs = state?.runs ?? [];
    const key = JSON.stringify([runs.map(({ run, phase, figures }) => [run, phase, figures.length]), state?.differences]);
    if (key === this.shown) return;
    this.shown = key;
    const any = runs.some(({ figures }) => figures.length > 0);
    this.empty.hidden = any || runs.length > 1;
    this.body.hidden = !(any || runs.length > 1);
    const isPair = runs.length > 1;
    this.showDifferences(isPair);
    this.head.replaceChildren(h("th", { scope: "col" }, ""), ...runs.map((run, slot) => h("th", { scope: "col" }, isPair ? `Run ${SLOT_NAMES[slot as Slot]}` : "Value", run.figures.length === 0 ? h("small", {}, ` ${run.phase === "failed" ? "failed" : "under way"}`) : null)));
    this.figures.replaceChildren(...rows(runs));
    setText(this.invitation, isPair ? "" : "Change a parameter and run again: both runs then stand side by side.");
    this.actions.replaceChildren(...(isPair ? this.buttons() : []));
  }

  private showDifferences(isPair: boolean): void {
    const differences = this.store.state?.differences ?? [];
    this.differenceTable.hidden = !isPair || differences.length === 0;
    this.same.hidden = !isPair || differences.length > 0;
    this.differences.replaceChildren(...differences.map(([key, a, b]) => h("tr", { "data-key": key }, h("th", { scope: "row" }, key), h("td", { class: "number" }, tidyNumber(a)), h("td", { class: "number" }, tidyNumber(b)))));
  }

  private buttons(): HTMLElement[] {
    const keep = (slot: Slot, text: string): HTMLElement => h("button", { class: "button small", type: "button", onclick: () => void this.send({ type: "keep", slot }) }, text);
    return [keep(0, "Keep A only"), keep(1, "Keep B only"), h("button", { class: "button small", type: "button", onclick: () => void this.send({ type: "rewind" }) }, "Play both from the start")];
  }
}

/** All figures of all runs, in the order in which the program tells them, under the heads of their groups. */
function rows(runs: readonly RunState[]): HTMLElement[] {
  const names = [...new Set(runs.flatMap(({ figures }) => figures.map(([name]) => name)))];
  // What a run is judged by comes first; the sort keeps the program's order within a group.
  const order = Object.keys(GROUPS);
  const place = (name: string): number => (order.indexOf(groupOf(name)) + order.length) % order.length;
  names.sort((a, b) => place(a) - place(b));
  const values = runs.map(({ figures }) => new Map(figures));
  let group: string | null = null;
  return names.flatMap((name) => {
    const here = groupOf(name);
    const { stem, unit } = unitOf(name.slice(name.lastIndexOf(".") + 1));
    const row = h("tr", { "data-figure": name }, h("th", { scope: "row", title: name }, stem, SHOWN_UNITS.has(unit) ? h("small", { class: "unit" }, ` ${SHOWN_UNITS.get(unit)}`) : null), ...values.map((map) => h("td", { class: "number" }, figureText(map.get(name) ?? null, unit))));
    if (here === group) return [row];
    group = here;
    return [h("tr", { class: "group-head" }, h("th", { colspan: 1 + runs.length, scope: "colgroup" }, GROUPS[here] ?? here)), row];
  });
}

/** "map.entropy_mean_bits" is of the group "map". */
function groupOf(name: string): string {
  return name.includes(".") ? name.slice(0, name.lastIndexOf(".")) : "";
}
