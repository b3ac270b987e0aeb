// The bar of a session's time or scans: drag or keys to any place; marks where something was done.

import { h } from "./dom";

/** While it is dragged the program is asked at most this often. */
const ASK_PERIOD_MS = 100;
/** How long a place that was asked for is shown before the program has come there. */
const ASKED_MS = 1500;

export interface SeekOptions {
  label: string;
  title: string;
  /** The finest place. */
  step: number;
  /** How near counts as there. */
  near: number;
  /** Asked while it is dragged, not only when it is let go. */
  isLive: boolean;
  /** How a place is written. */
  text(place: number): string;
  ask(place: number): void;
  /** A place is pointed at. */
  aimed?(place: number): void;
}

export class SeekBar {
  readonly element = h("div", { class: "seek", hidden: true });
  private readonly range: HTMLInputElement;
  private readonly marks = h("div", { class: "marks" });
  private end = 0;
  private now = 0;
  private asked_ms = 0;
  private asked: { place: number; until_ms: number } | null = null;
  private timer = 0;
  private isHeld = false;

  constructor(private readonly options: SeekOptions) {
    const { label, title, step } = options;
    this.range = h("input", { type: "range", min: 0, max: 1, step, value: 0, "aria-label": label, title });
    this.element.append(this.range, this.marks);
    this.range.addEventListener("input", () => {
      if (options.isLive) return this.goTo(Number(this.range.value));
      this.isHeld = true;
      options.aimed?.(Number(this.range.value));
    });
    this.range.addEventListener("change", () => {
      if (!options.isLive) this.goTo(Number(this.range.value));
    });
    this.range.addEventListener("pointerdown", () => (this.isHeld = true));
    for (const end of ["change", "pointerup", "pointercancel", "blur"]) this.range.addEventListener(end, () => (this.isHeld = false));
    this.range.addEventListener("pointerup", () => this.range.blur());
  }

  /** The place that was asked for, until the program is there. */
  get wanted(): number | null {
    return this.asked?.place ?? null;
  }

  /** Somebody holds it. */
  get held(): boolean {
    return this.isHeld;
  }

  set disabled(disabled: boolean) {
    this.range.disabled = disabled;
  }

  set title(title: string) {
    if (this.range.title !== title) this.range.title = title;
  }

  show(isShown: boolean): void {
    this.element.hidden = !isShown;
  }

  setEnd(end: number): void {
    if (this.isHeld) return;
    this.end = end;
    this.range.max = String(end);
  }

  /** Marks: where, whether a person did it, and what. */
  setMarks(marks: readonly (readonly [number, boolean, string])[]): void {
    this.marks.replaceChildren(...marks.map(([place, byPerson, what]) => {
      const when = this.options.text(place);
      const mark = h("button", { class: `mark ${byPerson ? "by-person" : ""}`, type: "button", tabindex: -1, title: `${when}  ${what}`, "aria-label": `${what} at ${when}`, onclick: () => this.goTo(place) });
      mark.style.left = `${(100 * place) / Math.max(this.options.step, this.end)}%`;
      return mark;
    }));
  }

  moveTo(now: number): void {
    this.now = now;
    if (this.asked && (Math.abs(this.asked.place - now) < this.options.near || performance.now() > this.asked.until_ms)) this.asked = null;
    if (this.isHeld || this.asked) return;
    this.range.value = String(now);
    this.range.setAttribute("aria-valuetext", this.options.text(now));
  }

  /** What was asked for counts no more. */
  forget(): void {
    window.clearTimeout(this.timer);
    this.timer = 0;
    this.asked = null;
  }

  goBy(by: number): void {
    if (!this.element.hidden) this.goTo((this.asked?.place ?? this.now) + by);
  }

  private goTo(place: number): void {
    const bounded = Math.min(this.end, Math.max(0, place));
    this.asked = { place: bounded, until_ms: performance.now() + ASKED_MS };
    this.range.value = String(bounded);
    this.options.aimed?.(bounded);
    // The newest place is asked for; those in between are passed over.
    if (this.timer !== 0) return;
    const wait_ms = Math.max(0, this.asked_ms + ASK_PERIOD_MS - performance.now());
    this.timer = window.setTimeout(() => {
      this.timer = 0;
      this.asked_ms = performance.now();
      if (this.asked) this.options.ask(this.asked.place);
    }, wait_ms);
  }
}
