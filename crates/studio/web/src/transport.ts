// The playback bar of every session: play, step, where in time it is, speed, and whether the computer keeps up.

import { h, setText } from "./dom";
import { ratio } from "./format";
import { icon, type IconName, swapIcon } from "./icons";
import type { SeekBar } from "./seek";

/** It lags when it gets less than this share of the speed that was asked for. */
const LAG_SHARE = 0.9;
/** How long a speed that was asked for is shown before the program has confirmed it. */
const ASKED_MS = 1000;
/** The slider sticks to a round speed that is this near, as a logarithm. */
const STICK = 0.06;

export interface TransportOptions {
  /** Round speeds, rising; the first and the last are the limits. */
  speeds: readonly number[];
  /** What one step is called. */
  step: string;
  /** What the achieved ratio is. */
  about: string;
  seek: SeekBar;
  /** What stands around the button Play, and at the end. */
  before?: readonly Node[];
  after?: readonly Node[];
  /** Time and place, beside the buttons. */
  place: Node;
  tail?: Node;
  isOn(): boolean;
  toggle(): void;
  oneStep(): void;
  setSpeed(ratio: number): void;
}

/** What the bar shows. */
export interface Playing {
  playing: boolean;
  /** What the button does when time stands still. */
  word: string;
  icon: IconName;
  speed_ratio: number;
  achieved_ratio: number;
  /** Instead of "on time": why nothing plays, or that it hurries. */
  told: string | null;
  canPlay: boolean;
  canStep: boolean;
}

export class Transport {
  private readonly play = h("button", { class: "button primary play", type: "button", title: "Play or pause (Space)" }, icon("play"), h("span", {}, "Play"));
  private readonly step: HTMLButtonElement;
  private readonly speed = h("input", { class: "speed", type: "range", min: 0, max: 1000, step: 1, id: "speed", title: "Speed ([ and ])" });
  private readonly speedValue = h("output", { class: "speed-value", for: "speed" }, "1×");
  private readonly achieved = h("span", { class: "pill achieved" });
  /** While a finger is on the slider the program's value must not pull it away. */
  private isSliding = false;
  private speed_ratio = 1;
  private asked = { speed: 1, until_ms: 0 };

  constructor(holder: HTMLElement, private readonly options: TransportOptions) {
    this.step = h("button", { class: "button square", type: "button", "aria-label": options.step, title: `${options.step} (.)` }, icon("step"));
    holder.append(
      h("div", { class: "group" }, ...(options.before ?? []), this.play, this.step, ...(options.after ?? [])),
      h("div", { class: "group counts" }, options.place),
      options.seek.element,
      h("div", { class: "group" }, h("label", { for: "speed", class: "speed-label" }, "Speed"), this.speed, this.speedValue, this.achieved),
    );
    if (options.tail) holder.append(options.tail);
    this.play.addEventListener("click", () => this.togglePlay());
    this.step.addEventListener("click", () => this.oneStep());
    this.speed.addEventListener("input", () => {
      this.isSliding = true;
      this.setSpeed(speedOfSlider(Number(this.speed.value), options.speeds));
    });
    for (const end of ["change", "blur", "pointerup"]) this.speed.addEventListener(end, () => (this.isSliding = false));
    // A slider that was dragged gives the keyboard back: Space must keep meaning play and pause.
    this.speed.addEventListener("pointerup", () => this.speed.blur());
  }

  togglePlay(): void {
    if (!this.play.disabled) this.options.toggle();
  }

  oneStep(): void {
    if (!this.step.disabled) this.options.oneStep();
  }

  nudgeSpeed(direction: 1 | -1): void {
    const now = this.speedNow();
    const { speeds } = this.options;
    const next = direction > 0 ? speeds.find((speed) => speed > now * 1.001) : speeds.findLast((speed) => speed < now * 0.999);
    if (next !== undefined && !this.speed.disabled) this.setSpeed(next);
  }

  show(now: Playing): void {
    this.play.disabled = this.speed.disabled = !now.canPlay;
    this.step.disabled = !now.canStep;
    swapIcon(this.play, now.playing ? "pause" : now.icon);
    const word = this.play.querySelector("span");
    if (word) setText(word, now.playing ? "Pause" : now.word);
    this.speed_ratio = now.speed_ratio;
    if (!this.isSliding) this.showSpeed(this.speedNow());
    const lags = now.playing && now.told === null && now.achieved_ratio < now.speed_ratio * LAG_SHARE;
    this.achieved.classList.toggle("warn", lags);
    this.achieved.title = lags ? "The computer cannot keep up with the speed asked for" : this.options.about;
    setText(this.achieved, !now.canPlay ? "" : now.told ?? (lags ? `only ${ratio(now.achieved_ratio)}` : "on time"));
  }

  /** Three quick presses are three steps: the states that come in between still tell of the first. */
  private speedNow(): number {
    return performance.now() < this.asked.until_ms ? this.asked.speed : this.speed_ratio;
  }

  private setSpeed(speed: number): void {
    this.asked = { speed, until_ms: performance.now() + ASKED_MS };
    this.showSpeed(speed);
    this.options.setSpeed(speed);
  }

  private showSpeed(speed: number): void {
    if (!this.isSliding) this.speed.value = String(sliderOfSpeed(speed, this.options.speeds));
    setText(this.speedValue, ratio(speed));
    this.speed.setAttribute("aria-valuetext", `${ratio(speed)} real time`);
  }
}

/** The slider is logarithmic: 0 is the first speed, 1000 the last. Sticks to round speeds. */
export function speedOfSlider(position: number, speeds: readonly number[]): number {
  const [least, most] = limits(speeds);
  const speed = least * (most / least) ** (position / 1000);
  const round = speeds.find((candidate) => Math.abs(Math.log(speed / candidate)) < STICK);
  return round ?? Number(speed.toPrecision(2));
}

export function sliderOfSpeed(speed: number, speeds: readonly number[]): number {
  const [least, most] = limits(speeds);
  const bounded = Math.min(most, Math.max(least, speed));
  return Math.round((1000 * Math.log(bounded / least)) / Math.log(most / least));
}

function limits(speeds: readonly number[]): [number, number] {
  return [speeds[0] ?? 1, speeds.at(-1) ?? 1];
}
