// The bar of a recording: drag or keys to any time; marks where the mission or a person did something.

import { h } from "./dom";
import { clock } from "./format";
import type { MissionInfo } from "./protocol";

/** While it is dragged the program is asked at most this often. */
const ASK_PERIOD_MS = 150;
/** How long a time that was asked for is shown before the program has come there. */
const ASKED_MS = 1500;
const STEP_S = 0.01;

export class SeekBar {
  readonly element = h("div", { class: "seek", hidden: true });
  private readonly range = h("input", { type: "range", min: 0, max: 1, step: STEP_S, value: 0, "aria-label": "Time of the recording", title: "Drag to a time" });
  private readonly marks = h("div", { class: "marks" });
  private length_s = 0;
  private now_s = 0;
  private asked_ms = 0;
  private asked: { t_s: number; until_ms: number } | null = null;
  private timer = 0;
  private isHeld = false;

  constructor(private readonly ask: (t_s: number) => void) {
    this.element.append(this.range, this.marks);
    this.range.addEventListener("input", () => this.goTo(Number(this.range.value)));
    this.range.addEventListener("pointerdown", () => (this.isHeld = true));
    for (const end of ["change", "pointerup", "pointercancel", "blur"]) this.range.addEventListener(end, () => (this.isHeld = false));
  }

  /** The time that was asked for, until the program is there. */
  get wanted_s(): number | null {
    return this.asked?.t_s ?? null;
  }

  show({ length_s, marks }: MissionInfo): void {
    this.element.hidden = !length_s;
    this.length_s = length_s ?? 0;
    this.range.max = String(this.length_s);
    this.marks.replaceChildren(...(marks ?? []).map(([t_s, byPerson, what]) => {
      const mark = h("button", { class: `mark ${byPerson ? "by-person" : ""}`, type: "button", tabindex: -1, title: `${clock(t_s)}  ${what}`, "aria-label": `${what} at ${clock(t_s)}`, onclick: () => this.goTo(t_s) });
      mark.style.left = `${(100 * t_s) / Math.max(STEP_S, this.length_s)}%`;
      return mark;
    }));
  }

  moveTo(now_s: number): void {
    this.now_s = now_s;
    if (this.asked && (Math.abs(this.asked.t_s - now_s) < 0.2 || performance.now() > this.asked.until_ms)) this.asked = null;
    if (this.isHeld || this.asked) return;
    this.range.value = String(now_s);
    this.range.setAttribute("aria-valuetext", clock(now_s));
  }

  goBy(seconds: number): void {
    if (!this.element.hidden) this.goTo((this.asked?.t_s ?? this.now_s) + seconds);
  }

  private goTo(t_s: number): void {
    const bounded = Math.min(this.length_s, Math.max(0, t_s));
    this.asked = { t_s: bounded, until_ms: performance.now() + ASKED_MS };
    this.range.value = String(bounded);
    // The newest time is asked for; those in between are passed over.
    if (this.timer !== 0) return;
    const wait_ms = Math.max(0, this.asked_ms + ASK_PERIOD_MS - performance.now());
    this.timer = window.setTimeout(() => {
      this.timer = 0;
      this.asked_ms = performance.now();
      if (this.asked) this.ask(this.asked.t_s);
    }, wait_ms);
  }
}
