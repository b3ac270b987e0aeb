// The playback bar of the mapping page: play, step, to the start, to the end, where the recording is, speed.

import { h, setText } from "../dom";
import { clock, ratio } from "../format";
import { icon, swapIcon } from "../icons";
import type { Request } from "./protocol";
import type { Store } from "./store";

export const SPEED_MIN = 0.1;
export const SPEED_MAX = 200;
const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 5, 10, 20, 50, 100, 200] as const;
const LAG_SHARE = 0.9;
/** How long a speed that was asked for counts before the program has confirmed it. */
const ASKED_MS = 1000;

export class Transport {
  private readonly play = h("button", { class: "button primary play", type: "button", title: "Play or pause (Space)" }, icon("play"), h("span", {}, "Play"));
  private readonly step = h("button", { class: "button square", type: "button", "aria-label": "One scan", title: "One scan (.)" }, icon("step"));
  private readonly start = h("button", { class: "button square", type: "button", "aria-label": "From the start", title: "From the start (Home)" }, icon("start"));
  private readonly end = h("button", { class: "button square", type: "button", "aria-label": "To the end as fast as possible", title: "To the end as fast as possible (End)" }, icon("end"));
  private readonly place = h("input", { class: "place", type: "range", min: 0, max: 1, step: 1, value: 0, "aria-label": "Scan", title: "Drag to a scan; backwards it is mapped again from the start" });
  private readonly scan = h("span", { class: "scan-count", role: "timer", "aria-label": "Scan" }, "–");
  private readonly time = h("span", { class: "time-max" });
  private readonly speed = h("input", { class: "speed", type: "range", min: 0, max: 1000, step: 1, value: 606, id: "speed", title: "Speed ([ and ])" });
  private readonly speedValue = h("output", { class: "speed-value", for: "speed" }, "10×");
  private readonly achieved = h("span", { class: "pill achieved" });
  private isSliding = false;
  private asked = { speed: 1, until_ms: 0 };
  private isPlacing = false;

  constructor(holder: HTMLElement, private readonly store: Store, private readonly send: (request: Request) => boolean) {
    holder.append(
      h("div", { class: "group" }, this.start, this.play, this.step, this.end),
      h("div", { class: "group counts" }, h("div", {}, this.scan, this.time)),
      this.place,
      h("div", { class: "group" }, h("label", { for: "speed", class: "speed-label" }, "Speed"), this.speed, this.speedValue, this.achieved),
    );
    this.play.addEventListener("click", () => this.togglePlay());
    this.step.addEventListener("click", () => this.oneScan());
    this.start.addEventListener("click", () => this.toStart());
    this.end.addEventListener("click", () => this.toEnd());
    this.place.addEventListener("input", () => {
      this.isPlacing = true;
      setText(this.scan, `${this.place.value} of ${this.place.max}`);
    });
    this.place.addEventListener("change", () => {
      this.isPlacing = false;
      this.send({ type: "seek", scan: Number(this.place.value) });
    });
    this.speed.addEventListener("input", () => {
      this.isSliding = true;
      this.setSpeed(speedOfSlider(Number(this.speed.value)));
    });
    for (const end of ["change", "blur", "pointerup"]) this.speed.addEventListener(end, () => (this.isSliding = false));
    // A slider that was dragged gives the keyboard back: Space must keep meaning play and pause.
    for (const slider of [this.place, this.speed]) slider.addEventListener("pointerup", () => slider.blur());
    for (const event of ["state", "source", "connection"] as const) store.on(event, () => this.refresh());
    this.refresh();
  }

  togglePlay(): void {
    if (this.play.disabled) return;
    const { state } = this.store;
    const over = state?.runs.every(({ phase }) => phase === "finished" || phase === "failed") ?? false;
    this.send({ type: state?.playing ? "pause" : over ? "rewind" : "play" });
  }

  oneScan(): void {
    if (!this.step.disabled) this.send({ type: "step" });
  }

  toStart(): void {
    if (!this.start.disabled) this.send({ type: "rewind" });
  }

  toEnd(): void {
    if (!this.end.disabled) this.send({ type: "seek", scan: Number.MAX_SAFE_INTEGER });
  }

  nudgeSpeed(direction: 1 | -1): void {
    const now = this.speedNow();
    const next = direction > 0 ? SPEEDS.find((speed) => speed > now * 1.001) : SPEEDS.findLast((speed) => speed < now * 0.999);
    if (next !== undefined && !this.speed.disabled) this.setSpeed(next);
  }

  /** Three quick presses are three steps: the states that come in between still tell of the first. */
  private speedNow(): number {
    return performance.now() < this.asked.until_ms ? this.asked.speed : (this.store.state?.speed_ratio ?? 1);
  }

  private setSpeed(speed: number): void {
    this.asked = { speed, until_ms: performance.now() + ASKED_MS };
    this.showSpeed(speed);
    this.send({ type: "speed", ratio: speed });
  }

  private refresh(): void {
    const { state, source, newest } = this.store;
    const ready = this.store.isOpen && newest !== null;
    const over = state?.runs.every(({ phase }) => phase === "finished" || phase === "failed") ?? true;
    for (const control of [this.play, this.start, this.speed, this.place]) control.disabled = !ready;
    for (const control of [this.step, this.end]) control.disabled = !ready || over;
    const playing = state?.playing ?? false;
    swapIcon(this.play, playing ? "pause" : over && ready ? "restart" : "play");
    const word = this.play.querySelector("span");
    if (word) setText(word, playing ? "Pause" : over && ready ? "Again" : "Play");
    if (!newest || !state) {
      setText(this.scan, "–");
      setText(this.time, "");
      this.place.value = "0";
      setText(this.achieved, "");
      return;
    }
    if (!this.isPlacing) {
      this.place.max = String(newest.n_scans);
      this.place.value = String(newest.scan);
      setText(this.scan, `${newest.scan} of ${newest.n_scans}`);
      setText(this.time, `${clock(newest.t_s)} / ${clock(source?.recording?.duration_s ?? 0)}`);
    }
    if (!this.isSliding) this.showSpeed(state.speed_ratio);
    const lags = playing && !state.hurrying && state.achieved_ratio < state.speed_ratio * LAG_SHARE;
    this.achieved.classList.toggle("warn", lags);
    const text = newest.phase === "finishing" ? "finishing" : !playing ? (over ? "finished" : "paused") : lags || state.hurrying ? `${lags ? "only " : ""}${ratio(state.achieved_ratio)}` : "on time";
    this.achieved.title = lags ? "The computer cannot keep up with the speed asked for" : "Time of the recording per real time";
    setText(this.achieved, ready ? text : "");
  }

  private showSpeed(speed: number): void {
    if (!this.isSliding) this.speed.value = String(sliderOfSpeed(speed));
    setText(this.speedValue, ratio(speed));
    this.speed.setAttribute("aria-valuetext", `${ratio(speed)} real time`);
  }
}

/** The slider is logarithmic: 0 is 0.1×, 1000 is 200×. Sticks to round speeds. */
export function speedOfSlider(position: number): number {
  const speed = SPEED_MIN * (SPEED_MAX / SPEED_MIN) ** (position / 1000);
  const round = SPEEDS.find((candidate) => Math.abs(Math.log(speed / candidate)) < 0.08);
  return round ?? Number(speed.toPrecision(2));
}

export function sliderOfSpeed(speed: number): number {
  const bounded = Math.min(SPEED_MAX, Math.max(SPEED_MIN, speed));
  return Math.round((1000 * Math.log(bounded / SPEED_MIN)) / Math.log(SPEED_MAX / SPEED_MIN));
}
