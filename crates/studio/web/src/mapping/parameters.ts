// The form of all parameters of a survey, made from what the program says about them; runs the recording again.

import { h, setText } from "../dom";
import { icon } from "../icons";
import { emptyState } from "../panels/empty";
import type { Parameter, Request, Slot } from "./protocol";
import type { Store } from "./store";
import { tidyNumber, unitOf } from "./units";

const MODE_KEY = "survey.mode";

type Input = HTMLInputElement | HTMLSelectElement;

interface Field {
  parameter: Parameter;
  input: Input;
  row: HTMLElement;
  note: HTMLElement;
  reset: HTMLButtonElement;
}

export class ParametersPanel {
  readonly element = h("div", { class: "parameters" });
  private readonly empty = emptyState("No parameters yet", "They appear with the recording: every one with its unit, its default and what it means.");
  private readonly search = h("input", { class: "field small", type: "text", placeholder: "Find a parameter", "aria-label": "Find a parameter" });
  private readonly onlySet = h("input", { type: "checkbox", id: "only-set" });
  private readonly list = h("div", { class: "parameter-list" });
  private readonly again = h("button", { class: "button primary", type: "button", title: "Map the recording again and compare (Enter in a field)" }, icon("compare"), "Run again and compare");
  private readonly keepA = h("label", { class: "keep-a", hidden: true });
  private readonly keepBox = h("input", { type: "checkbox" });
  private readonly summary = h("span", { class: "count" });
  private readonly body = h("div", { class: "parameters-body", hidden: true });
  private fields: Field[] = [];
  /** What the user has changed and not run yet. */
  private readonly edits = new Map<string, string>();
  private run = -1;
  private known = "";

  constructor(private readonly store: Store, private readonly send: (request: Request) => boolean) {
    this.keepA.append(this.keepBox, "Run A stays");
    this.body.append(
      h("div", { class: "panel-bar" }, this.search, h("label", { class: "only-set", for: "only-set" }, this.onlySet, "changed only"), this.summary),
      this.list,
      h("div", { class: "parameters-foot" }, this.again, this.keepA));
    this.element.append(this.empty, this.body);
    this.search.addEventListener("input", () => this.filter());
    this.onlySet.addEventListener("change", () => this.filter());
    this.again.addEventListener("click", () => this.runAgain());
    store.on("source", () => this.onSource());
    store.on("state", () => this.onState());
    store.on("connection", () => this.onState());
  }

  private onSource(): void {
    const parameters = this.store.source?.parameters ?? [];
    this.empty.hidden = parameters.length > 0;
    this.body.hidden = parameters.length === 0;
    const known = `${this.store.hello?.server} ${parameters.map(({ key }) => key).join()}`;
    if (known !== this.known) {
      this.known = known;
      this.build(parameters);
    }
    this.edits.clear();
    this.show();
  }

  private onState(): void {
    const { state, newest } = this.store;
    this.keepA.hidden = (state?.runs.length ?? 0) < 2;
    this.again.disabled = !this.store.isOpen || !newest;
    if (newest && newest.run !== this.run) {
      this.run = newest.run;
      this.show();
    }
  }

  private build(parameters: readonly Parameter[]): void {
    this.fields = [];
    this.list.replaceChildren();
    const groups = new Map<string, HTMLElement>();
    for (const parameter of parameters) {
      let group = groups.get(parameter.table);
      if (!group) {
        group = h("div", { class: "group-rows" });
        groups.set(parameter.table, group);
        this.list.append(h("details", { class: "parameter-group", open: groups.size <= 2, "data-table": parameter.table }, h("summary", {}, h("b", {}, parameter.table), h("span", { class: "group-note" })), group));
      }
      const field = this.field(parameter);
      this.fields.push(field);
      group.append(field.row);
    }
  }

  private field(parameter: Parameter): Field {
    const id = `parameter-${parameter.key}`;
    const input = inputFor(parameter, id);
    const unit = unitOf(parameter.name);
    const note = h("span", { class: "default" });
    const reset = h("button", { class: "button bare small", type: "button", "aria-label": `Default for ${parameter.key}`, title: "Back to the default" }, "default");
    const row = h("div", { class: "parameter", "data-key": parameter.key },
      h("label", { for: id, title: parameter.key }, unit.stem), h("span", { class: "entry" }, input, h("span", { class: "unit" }, unit.unit)), reset,
      h("p", { id: `${id}-about` }, sentence(parameter.about), " ", note));
    input.addEventListener("change", () => this.edit(parameter.key, valueOf(input)));
    if (input instanceof HTMLInputElement && input.type === "text") {
      input.addEventListener("input", () => this.edit(parameter.key, valueOf(input)));
      input.addEventListener("keydown", (event) => {
        if (event.key === "Enter") this.runAgain();
      });
    }
    reset.addEventListener("click", () => {
      this.edit(parameter.key, this.default(parameter));
      this.show();
    });
    return { parameter, input, row, note, reset };
  }

  private edit(key: string, value: string): void {
    this.edits.set(key, value);
    // Another mode has other defaults; what was set by hand stays.
    if (key === MODE_KEY) this.show();
    else this.mark();
  }

  private get mode(): string {
    return this.edits.get(MODE_KEY) ?? this.store.newest?.values[MODE_KEY] ?? this.store.source?.parameters.find(({ key }) => key === MODE_KEY)?.default ?? "";
  }

  private default({ key, by_mode, default: otherwise }: Parameter): string {
    return key === MODE_KEY ? otherwise : (by_mode[this.mode] ?? otherwise);
  }

  private value(parameter: Parameter): string {
    return this.edits.get(parameter.key) ?? this.store.newest?.values[parameter.key] ?? this.default(parameter);
  }

  /** Puts every value into its field. */
  private show(): void {
    for (const { parameter, input, note } of this.fields) {
      if (document.activeElement !== input || !this.edits.has(parameter.key)) setValue(input, this.value(parameter));
      setText(note, `Default ${tidyNumber(this.default(parameter))}; ${parameter.allowed}.`);
    }
    this.mark();
  }

  /** Marks what differs from the default, and what has been changed since the run. */
  private mark(): void {
    let n_set = 0;
    const perTable = new Map<string, number>();
    for (const { parameter, row, reset } of this.fields) {
      const isSet = !sameValue(parameter, this.value(parameter), this.default(parameter));
      row.classList.toggle("is-set", isSet);
      row.classList.toggle("is-edited", this.edits.has(parameter.key) && !sameValue(parameter, this.value(parameter), this.store.newest?.values[parameter.key] ?? this.default(parameter)));
      reset.hidden = !isSet;
      if (!isSet) continue;
      n_set += 1;
      perTable.set(parameter.table, (perTable.get(parameter.table) ?? 0) + 1);
    }
    for (const group of this.list.querySelectorAll<HTMLElement>(".parameter-group")) {
      const note = group.querySelector(".group-note");
      const n = perTable.get(group.dataset["table"] ?? "") ?? 0;
      if (note) setText(note, n === 0 ? "" : `${n} changed`);
    }
    setText(this.summary, n_set === 0 ? "all at their defaults" : `${n_set} changed`);
    if (this.onlySet.checked) this.filter();
  }

  private filter(): void {
    const words = this.search.value.trim().toLowerCase().split(/\s+/);
    const filtering = this.search.value.trim() !== "" || this.onlySet.checked;
    for (const { parameter, row } of this.fields) {
      const text = `${parameter.key} ${parameter.about}`.toLowerCase();
      row.hidden = !words.every((word) => text.includes(word)) || (this.onlySet.checked && !row.classList.contains("is-set"));
    }
    for (const group of this.list.querySelectorAll("details")) {
      const any = [...group.querySelectorAll<HTMLElement>(".parameter")].some((row) => !row.hidden);
      group.hidden = !any;
      if (filtering && any) group.open = true;
    }
  }

  private runAgain(): void {
    if (this.again.disabled) return;
    const values: Record<string, string> = {};
    for (const { parameter } of this.fields) {
      const value = this.value(parameter);
      if (!sameValue(parameter, value, this.default(parameter))) values[parameter.key] = value;
    }
    const n_runs = this.store.state?.runs.length ?? 1;
    const keep: Slot = n_runs > 1 && !this.keepBox.checked ? 1 : 0;
    this.send({ type: "run", values, keep });
  }
}

function inputFor({ kind, choices }: Parameter, id: string): Input {
  const described = { id, "aria-describedby": `${id}-about` };
  if (kind === "choice") return h("select", { class: "field small", ...described }, ...choices.map((word) => h("option", { value: word }, word)));
  if (kind === "flag") return h("input", { type: "checkbox", ...described });
  return h("input", { class: "field small", type: "text", inputmode: kind === "count" ? "numeric" : "decimal", autocomplete: "off", spellcheck: "false", ...described });
}

function valueOf(input: Input): string {
  return input instanceof HTMLInputElement && input.type === "checkbox" ? String(input.checked) : input.value.trim();
}

function setValue(input: Input, value: string): void {
  if (input instanceof HTMLInputElement && input.type === "checkbox") input.checked = value === "true";
  else input.value = value;
}

function sentence(text: string): string {
  return `${text.charAt(0).toUpperCase()}${text.slice(1)}${/[.!?]$/.test(text) ? "" : "."}`;
}

/** "0.10" is "0.1". */
function sameValue({ kind }: Parameter, a: string, b: string): boolean {
  if (a === b) return true;
  return (kind === "number" || kind === "count") && a !== "" && b !== "" && Number(a) === Number(b);
}
