// The playback bar: play, step, restart with a seed, speed, simulated time, and whether the computer keeps up.

import { h, setText } from "./dom";
import { clock, ratio } from "./format";
import { icon, swapIcon } from "./icons";
import type { ClientMessage } from "./protocol";
import { SeekBar } from "./seek";
import type { Store } from "./state";

export const SPEED_MIN = 0.1;
export const SPEED_MAX = 20;
const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 5, 10, 20] as const;
/** The run lags when it gets less than this share of the speed that was asked for. */
const LAG_SHARE = 0.9;
/** How long a speed that was asked for is shown before the program has confirmed it. */
const ASKED_MS = 1000;

export class Controls {
  private readonly play = h("button", { class: "button primary play", type: "button", title: "Play or pause (Space)" }, icon("play"), h("span", {}, "Play"));
  private readonly step = h("button", { class: "button square", type: "button", "aria-label": "One step", title: "One step (.)" }, icon("step"));
  private readonly restart = h("button", { class: "button", type: "button", title: "Restart with this seed (R)" }, icon("restart"), "Restart");
  private readonly seed = h("input", { class: "field seed", type: "number", min: 0, max: 999_999_999_999_999, step: 1, id: "seed", inputmode: "numeric", placeholder: "same" });
  private readonly speed = h("input", { class: "speed", type: "range", min: 0, max: 1000, step: 1, id: "speed", title: "Speed ([ and ])" });
  private readonly speedValue = h("output", { class: "speed-value", for: "speed" }, "1×");
  private readonly time = h("span", { class: "time", role: "timer", "aria-label": "Simulated time" }, "0:00.0");
  private readonly timeMax = h("span", { class: "time-max" });
  private readonly progress = h("div");
  private readonly bar = h("div", { class: "progress", "aria-hidden": "true" }, this.progress);
  private readonly seekBar: SeekBar;
  private readonly achieved = h("span", { class: "pill achieved" });
  /** While a finger is on the slider the server's value must not pull it away. */
  private isSliding = false;
  /** Asked for a moment ago; the states may still tell of the old speed. */
  private asked = { speed: 1, until_ms: 0 };

  constructor(holder: HTMLElement, private readonly store: Store, private readonly send: (message: ClientMessage) => boolean) {
    this.seekBar = new SeekBar((t_s) => this.send({ type: "seek", t_s }));
    holder.append(
      h("div", { class: "group" }, this.play, this.step),
      h("div", { class: "group" }, h("div", {}, this.time, this.timeMax)),
      this.bar, this.seekBar.element,
      h("div", { class: "group" }, h("label", { for: "speed", class: "speed-label" }, "Speed"), this.speed, this.speedValue, this.achieved),
      h("div", { class: "group" }, h("label", { for: "seed", class: "seed-label" }, "Seed"), this.seed, this.restart),
    );
    this.play.addEventListener("click", () => this.togglePlay());
    this.step.addEventListener("click", () => this.oneStep());
    this.restart.addEventListener("click", () => this.restartRun());
    this.seed.addEventListener("keydown", (event) => {
      if (event.key === "Enter") this.restartRun();
    });
    this.speed.addEventListener("input", () => {
      this.isSliding = true;
      this.setSpeed(speedOfSlider(Number(this.speed.value)));
    });
    for (const end of ["change", "blur", "pointerup"]) this.speed.addEventListener(end, () => (this.isSliding = false));
    store.on("hello", () => this.onHello());
    store.on("state", () => this.onState());
    store.on("reset", () => this.onState());
    store.on("connection", () => this.onState());
    this.onState();
  }

  togglePlay(): void {
    this.send({ type: this.store.state?.playing ? "pause" : "play" });
  }

  oneStep(): void {
    if (this.store.state?.playing) this.send({ type: "pause" });
    this.send({ type: "step" });
  }

  /** An empty seed field repeats the run with the seed it had. */
  restartRun(): void {
    if (!this.seed.reportValidity()) return;
    const text = this.seed.value.trim();
    const seed = /^\d{1,15}$/.test(text) ? Number(text) : null;
    this.send({ type: "restart", seed, mission: null });
  }

  /** In a recording: by so many seconds, or to an end. */
  seekBy(seconds: number): void {
    this.seekBar.goBy(seconds);
  }

  nudgeSpeed(direction: 1 | -1): void {
    const now = this.speedNow();
    const next = direction > 0 ? SPEEDS.find((speed) => speed > now * 1.001) : SPEEDS.findLast((speed) => speed < now * 0.999);
    if (next !== undefined) this.setSpeed(next);
  }

  private speedNow(): number {
    return performance.now() < this.asked.until_ms ? this.asked.speed : (this.store.state?.speed_ratio ?? 1);
  }

  private setSpeed(speed: number): void {
    this.asked = { speed, until_ms: performance.now() + ASKED_MS };
    this.showSpeed(speed);
    this.send({ type: "speed", ratio: speed });
  }

  private onHello(): void {
    const mission = this.store.hello?.mission;
    if (!mission) return;
    if (document.activeElement !== this.seed) this.seed.value = String(mission.seed);
    this.seekBar.show(mission);
    this.bar.hidden = !this.seekBar.element.hidden;
    setText(this.timeMax, `/ ${clock(mission.length_s ?? mission.duration_max_s).replace(/\.0$/, "")}`);
    this.onState();
  }

  private onState(): void {
    const { state, hello, connection } = this.store;
    const online = connection.phase === "open" && state !== null;
    for (const control of [this.play, this.step, this.speed]) control.disabled = !online;
    this.restart.disabled = connection.phase !== "open" || !hello;
    this.seed.disabled = hello?.mission.kind === "replay";
    const playing = state?.playing ?? false;
    swapIcon(this.play, playing ? "pause" : "play");
    const word = this.play.querySelector("span");
    if (word) setText(word, playing ? "Pause" : "Play");
    if (!state) return;
    this.seekBar.moveTo(state.t_s);
    setText(this.time, clock(this.seekBar.wanted_s ?? state.t_s));
    const share = hello ? Math.min(1, state.t_s / Math.max(1, hello.mission.duration_max_s)) : 0;
    this.progress.style.transform = `scaleX(${share.toFixed(4)})`;
    if (!this.isSliding) this.showSpeed(this.speedNow());
    const lags = playing && state.achieved_ratio < state.speed_ratio * LAG_SHARE;
    this.achieved.classList.toggle("warn", lags);
    this.achieved.title = lags ? "The computer cannot keep up with the speed asked for" : "Simulated time per real time";
    setText(this.achieved, !playing ? "paused" : lags ? `only ${ratio(state.achieved_ratio)}` : "on time");
  }

  private showSpeed(speed: number): void {
    if (!this.isSliding) this.speed.value = String(sliderOfSpeed(speed));
    setText(this.speedValue, ratio(speed));
    this.speed.setAttribute("aria-valuetext", `${ratio(speed)} real time`);
  }
}

/** The slider is logarithmic: 0 is 0.1×, 1000 is 20×. Sticks to round speeds. */
export function speedOfSlider(position: number): number {
  const speed = SPEED_MIN * (SPEED_MAX / SPEED_MIN) ** (position / 1000);
  const round = SPEEDS.find((candidate) => Math.abs(Math.log(speed / candidate)) < 0.06);
  return round ?? Number(speed.toPrecision(2));
}

export function sliderOfSpeed(speed: number): number {
  const bounded = Math.min(SPEED_MAX, Math.max(SPEED_MIN, speed));
  return Math.round((1000 * Math.log(bounded / SPEED_MIN)) / Math.log(SPEED_MAX / SPEED_MIN));
}
