// The playback bar of a run: the common one, with simulated time, the past, and a restart with a seed.

import { h, setText } from "./dom";
import { clock } from "./format";
import { icon } from "./icons";
import type { ClientMessage, Kept } from "./protocol";
import { SeekBar } from "./seek";
import type { Store } from "./state";
import { Transport } from "./transport";

export const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 5, 10, 20] as const;
/** The bar of a run that has just begun has this length. */
const LENGTH_MIN_S = 10;
/** This near to the present is the present. */
const NOW_S = 0.15;
const MEGABYTE = 1024 * 1024;

export class Controls {
  readonly transport: Transport;
  private readonly restart = h("button", { class: "button", type: "button", title: "Restart with this seed (R)" }, icon("restart"), "Restart");
  private readonly seed = h("input", { class: "field seed", type: "number", min: 0, max: 999_999_999_999_999, step: 1, id: "seed", inputmode: "numeric", placeholder: "same" });
  private readonly time = h("span", { class: "time", role: "timer", "aria-label": "Simulated time" }, "0:00.0");
  private readonly timeMax = h("span", { class: "time-max" });
  private readonly now = h("button", { class: "button small now", type: "button", title: "Back to the present (N)", hidden: true }, "Now");
  private readonly seek: SeekBar;

  constructor(holder: HTMLElement, private readonly store: Store, private readonly send: (message: ClientMessage) => boolean, private readonly events: { lookingBack(): void }) {
    this.seek = new SeekBar({
      label: "Time", title: "Drag to a time", step: 0.01, near: 0.2, isLive: true,
      text: clock, ask: (t_s) => this.goTo(t_s),
    });
    this.transport = new Transport(holder, {
      speeds: SPEEDS, step: "One step", about: "Simulated time per real time", seek: this.seek,
      place: h("div", { class: "group" }, h("div", {}, this.time, this.timeMax), this.now),
      tail: h("div", { class: "group" }, h("label", { for: "seed", class: "seed-label" }, "Seed"), this.seed, this.restart),
      isOn: () => this.store.isOpen,
      toggle: () => this.send({ type: this.store.live?.playing ? "pause" : "play" }),
      oneStep: () => {
        if (this.store.live?.playing) this.send({ type: "pause" });
        this.send({ type: "step" });
      },
      setSpeed: (ratio) => this.send({ type: "speed", ratio }),
    });
    this.now.addEventListener("click", () => this.toNow());
    this.restart.addEventListener("click", () => this.restartRun());
    this.seed.addEventListener("keydown", (event) => {
      if (event.key === "Enter") this.restartRun();
    });
    store.on("hello", () => this.onHello());
    for (const event of ["live", "state", "reset", "connection"] as const) store.on(event, () => this.refresh());
    this.refresh();
  }

  /** An empty seed field repeats the run with the seed it had. */
  restartRun(): void {
    if (!this.seed.reportValidity()) return;
    const text = this.seed.value.trim();
    const seed = /^\d{1,15}$/.test(text) ? Number(text) : null;
    this.send({ type: "restart", seed, mission: null });
  }

  /** By so many seconds, or to an end. */
  seekBy(seconds: number): void {
    this.seek.goBy(seconds);
  }

  /** The present again; a recording has none, its end will do. */
  toNow(): void {
    if (this.isReplay) return this.seek.goBy(Infinity);
    this.seek.forget();
    this.store.lookAtNow();
  }

  private get isReplay(): boolean {
    return this.store.hello?.mission.kind === "replay";
  }

  /** A recording is wound for everybody; into the past of a run each page looks by itself, and the run goes on. */
  private goTo(t_s: number): void {
    if (this.isReplay) {
      this.send({ type: "seek", t_s });
    } else if (t_s > (this.store.live?.t_s ?? 0) - NOW_S) {
      this.toNow();
    } else {
      this.store.lookBack();
      this.events.lookingBack();
      this.send({ type: "past", t_s });
    }
  }

  private onHello(): void {
    const mission = this.store.hello?.mission;
    if (!mission) return;
    if (document.activeElement !== this.seed) this.seed.value = String(mission.seed);
    this.seek.show(true);
    this.seek.setEnd(mission.length_s ?? LENGTH_MIN_S);
    this.seek.setMarks(mission.marks ?? []);
    setText(this.timeMax, `/ ${clock(mission.length_s ?? mission.duration_max_s).replace(/\.0$/, "")}`);
    this.refresh();
  }

  private refresh(): void {
    const { live, past, hello, isOpen } = this.store;
    const online = isOpen && live !== null;
    this.restart.disabled = !isOpen || !hello;
    this.seed.disabled = this.isReplay;
    this.now.hidden = past === null;
    this.transport.show({
      playing: live?.playing ?? false, word: "Play", icon: "play", speed_ratio: live?.speed_ratio ?? 1, achieved_ratio: live?.achieved_ratio ?? 0,
      told: live?.playing ? null : "paused", canPlay: online, canStep: online,
    });
    if (!live) return;
    if (!this.isReplay) this.seek.setEnd(Math.max(LENGTH_MIN_S, live.t_s));
    this.seek.title = this.isReplay ? "Drag to a time" : `Drag to look back; the run goes on${past ? `. ${keptWords(past.kept)}` : ""}`;
    this.seek.moveTo(past?.state.t_s ?? live.t_s);
    setText(this.time, clock(this.seek.wanted ?? past?.state.t_s ?? live.t_s));
    this.time.classList.toggle("past", past !== null);
    this.now.title = `Back to the present, ${clock(live.t_s)} (N)${past ? `. ${keptWords(past.kept)}` : ""}`;
  }
}

/** How much of the past there is, and how fine. */
export function keptWords({ n_states, n_bytes, bytes_max, period_s, gap_max_s }: Kept): string {
  const megabytes = (n: number): string => (n / MEGABYTE).toFixed(n < 10 * MEGABYTE ? 1 : 0);
  const coarse = gap_max_s > 1.5 * period_s ? `; the oldest are up to ${gap_max_s.toFixed(1)} s apart` : "";
  return `Kept: ${n_states} pictures, one every ${period_s} s${coarse}; ${megabytes(n_bytes)} of ${megabytes(bytes_max)} MB`;
}
