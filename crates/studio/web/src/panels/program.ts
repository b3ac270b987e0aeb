// The decision program: its source with every operand lit live, timers as bars, MOVE flashing.

import { EditorState } from "@codemirror/state";
import { EditorView, highlightActiveLine, lineNumbers } from "@codemirror/view";
import { h, setText, svg } from "../dom";
import { describe, isBoolean, isConstant, waveformPath } from "../history";
import type { DecisionState, LogItem, ProgramInfo } from "../protocol";
import type { Store } from "../state";
import { emptyState } from "./empty";
import { lightsField, type Place, placesOf, setLights } from "./operands";
import { rdplLanguage } from "./rdpl";

const FLASH_MS = 1600;

export class ProgramPanel {
  readonly element = h("div", { class: "program" });
  private view: EditorView | null = null;
  private program: ProgramInfo | null = null;
  private places: Place[] = [];
  private lit = "";
  private flashed: number[] = [];
  private readonly timers = h("div", { class: "timers", role: "group", "aria-label": "Timers" });
  private readonly timerRows = new Map<number, { row: HTMLElement; bar: HTMLElement; text: HTMLElement }>();
  private readonly clock = h("span", { class: "number", title: "The clock of the decision node" });
  private readonly move = h("span", { class: "move" });
  private readonly counts = h("span");
  private readonly trouble = h("span", { class: "trouble", role: "status" });
  private readonly node = h("div", { class: "program-node", role: "group", "aria-label": "Decision node" }, this.clock, this.move, this.counts, this.trouble);
  private readonly foot = h("div", { class: "program-foot" });
  private readonly scans = h("span", { class: "number" });
  private readonly tip = h("div", { class: "tip", role: "tooltip", id: "operand-tip", hidden: true });
  private tipped: string | null = null;

  constructor(private readonly store: Store) {
    this.showEmpty();
    store.on("hello", () => this.onHello());
    store.on("state", () => this.refresh());
    store.on("reset", () => this.refresh());
    store.on("log", (items) => this.flashMoves(items));
    for (const type of ["pointerover", "focusin"]) this.element.addEventListener(type, (event) => this.point(event.target));
    for (const type of ["pointerleave", "focusout"]) this.element.addEventListener(type, () => this.point(null));
  }

  private onHello(): void {
    const program = this.store.hello?.program ?? null;
    if (JSON.stringify(program) === JSON.stringify(this.program) && this.view) return this.refresh();
    this.program = program;
    this.view?.destroy();
    this.view = null;
    this.lit = "";
    this.timers.replaceChildren();
    this.timerRows.clear();
    if (!program) return this.showEmpty();
    const holder = h("div", { class: "source" });
    this.view = new EditorView({
      parent: holder,
      state: EditorState.create({
        doc: program.source.replace(/\n+$/, ""),
        extensions: [
          EditorState.readOnly.of(true), EditorView.editable.of(false), lineNumbers(), highlightActiveLine(), lightsField,
          rdplLanguage(program.functions.map(({ mnemonic }) => mnemonic)),
          EditorView.contentAttributes.of({ "aria-label": "Source of the decision program", tabindex: "0" }),
        ],
      }),
    });
    this.places = placesOf(this.view.state.doc, program);
    const key = h("div", { class: "key", "aria-hidden": "true" },
      ...(["high", "low", "rising", "falling"] as const).map((kind) => h("span", { class: `operand operand-${kind}` }, { high: "on", low: "off", rising: "rise", falling: "fall" }[kind])));
    this.foot.replaceChildren(key, h("span", { class: "mode" }, `${program.mode} mode`), this.scans);
    this.element.replaceChildren(holder, this.timers, this.node, this.foot, this.tip);
    this.refresh();
  }

  private showEmpty(): void {
    const loading = this.store.hello === null;
    this.element.replaceChildren(loading
      ? emptyState("Waiting for the program", "The decision program appears with the first message.")
      : emptyState("No decision program", "This mission sends its robots without one. Doorbell has one."));
  }

  private refresh(): void {
    const decision = this.store.state?.decision ?? null;
    this.refreshLights(decision);
    if (!this.view) return;
    this.refreshTimers(decision);
    this.refreshNode(decision);
    setText(this.scans, decision ? counted(decision.scans, "scan") : "");
    if (this.tipped) this.fillTip(this.tipped);
  }

  private refreshLights(decision: DecisionState | null): void {
    const resources = decision?.resources ?? {};
    const names = new Set(this.places.map(({ resource }) => resource));
    const lit = [...names].map((name) => (isBoolean(name) ? (resources[name] ?? -1) & 3 : resources[name])).join() + `|${this.flashed.join()}|${this.places.length}`;
    if (!this.view || lit === this.lit) return;
    this.lit = lit;
    const focused = this.operandElements().indexOf(document.activeElement as HTMLElement);
    this.view.dispatch({ effects: setLights.of({ places: this.places, resources, flashed: this.flashed }) });
    // The lit element is a new one: a reader's focus must not fall off it.
    if (focused >= 0) this.operandElements()[focused]?.focus({ preventScroll: true });
  }

  private refreshTimers(decision: DecisionState | null): void {
    for (const { index, remaining_s, total_s, on } of decision?.timers ?? []) {
      let parts = this.timerRows.get(index);
      if (!parts) {
        const bar = h("div", { class: "fill" });
        const text = h("span", { class: "number" });
        const row = h("div", { class: "timer", "data-timer": index }, h("span", { class: "name" }, `YTMR${index}`), h("div", { class: "bar" }, bar), text);
        parts = { row, bar, text };
        this.timerRows.set(index, parts);
        this.timers.append(row);
      }
      const share = total_s > 0 ? Math.min(1, Math.max(0, remaining_s / total_s)) : 0;
      parts.bar.style.transform = `scaleX(${share.toFixed(4)})`;
      parts.row.classList.toggle("on", on);
      const digits = total_s < 1 ? 2 : 1;
      setText(parts.text, `${remaining_s.toFixed(digits)} / ${total_s.toFixed(digits)} s`);
    }
  }

  /** What the program cannot say itself: its clock, its last MOVE, and whether its outputs are its own. */
  private refreshNode(decision: DecisionState | null): void {
    this.node.hidden = !decision;
    if (!decision) return;
    const { clock = "", last_move: [number, became] = [0, "idle"], n_events = 0, n_watchdog_resets = 0 } = decision;
    // Hundredths would only flicker.
    setText(this.clock, clock.replace(/\.\d+$/, ""));
    setText(this.move, number > 0 ? `MOVE ${number}: ${became}` : "no MOVE yet");
    this.move.dataset["became"] = number > 0 ? became : "idle";
    const counts = [n_events > 0 ? counted(n_events, "event") : "", n_watchdog_resets > 0 ? counted(n_watchdog_resets, "watchdog restart") : ""];
    setText(this.counts, counts.filter((text) => text !== "").join(", "));
    setText(this.trouble, troubleWords(decision));
  }

  /** The program's log says when a MOVE left: a pulse shorter than a picture still flashes. */
  private flashMoves(items: readonly LogItem[]): void {
    if (!items.some(({ text }) => /^MOVE\b/.test(text))) return;
    this.flashed = (this.program?.functions ?? []).filter(({ mnemonic }) => mnemonic.toUpperCase() === "MOVE").map(({ line }) => line);
    this.refresh();
    window.setTimeout(() => {
      this.flashed = [];
      this.refresh();
    }, FLASH_MS);
  }

  private operandElements(): HTMLElement[] {
    return [...this.element.querySelectorAll<HTMLElement>(".source [data-resource]")];
  }

  private point(target: EventTarget | null): void {
    const operand = target instanceof Element ? target.closest<HTMLElement>(".source [data-resource]") : null;
    this.tipped = operand?.dataset["resource"] ?? null;
    this.tip.hidden = this.tipped === null;
    if (!operand || !this.tipped) return;
    this.fillTip(this.tipped);
    const box = operand.getBoundingClientRect();
    const frame = this.element.getBoundingClientRect();
    const left = Math.min(box.left - frame.left, frame.width - this.tip.offsetWidth - 8);
    const below = box.bottom - frame.top + 6;
    const top = below + this.tip.offsetHeight > frame.height ? box.top - frame.top - this.tip.offsetHeight - 6 : below;
    this.tip.style.transform = `translate(${Math.max(8, left).toFixed(0)}px, ${Math.max(4, top).toFixed(0)}px)`;
  }

  private fillTip(resource: string): void {
    const byte = this.store.state?.decision?.resources[resource];
    const key = `${resource}:${byte}`;
    if (this.tip.dataset["key"] === key) return;
    this.tip.dataset["key"] = key;
    const device = this.deviceOf(resource);
    const title = h("div", { class: "tip-title" }, byte === undefined ? `${resource} has no value yet` : describe(resource, byte));
    const source = device ? h("div", { class: "tip-source" }, device) : null;
    if (byte === undefined || !isBoolean(resource) || isConstant(resource)) return this.tip.replaceChildren(title, source ?? "");
    const wave = svg("svg", { viewBox: "-1 0 162 26", width: 162, height: 26, class: "wave", role: "img", "aria-label": `Last eight samples: ${byte.toString(2).padStart(8, "0")}` },
      ...Array.from({ length: 7 }, (_, index) => svg("path", { d: `M${(index + 1) * 20} 0V26`, class: "tick" })),
      svg("path", { d: waveformPath(byte, 160, 26), class: "line" }));
    this.tip.replaceChildren(title, source ?? "", wave, h("div", { class: "tip-axis" }, h("span", {}, "7 scans ago"), h("span", {}, "now")));
  }

  private deviceOf(resource: string): string {
    const found = /^(N?I|O)(\d+)$/i.exec(resource);
    if (!found) return "";
    const number = Number(found[2]);
    const isOutput = found[1]?.toUpperCase() === "O";
    const device = this.store.hello?.world.devices.find(({ input, output }) => (isOutput ? output : input) === number);
    return device ? `${isOutput ? "drives" : "from"}: ${device.label}` : "";
  }
}

function counted(n: number, what: string): string {
  return `${n.toLocaleString("en")} ${what}${n === 1 ? "" : "s"}`;
}

export function troubleWords({ fault, run, drives_outputs = true }: Pick<DecisionState, "fault" | "run" | "drives_outputs">): string {
  const outputs = drives_outputs ? "" : "outputs at their fail-safe values";
  const stands = fault ? `stands on error ${fault}` : run ? "" : "stopped";
  return [stands, outputs].filter((text) => text !== "").join("; ");
}
