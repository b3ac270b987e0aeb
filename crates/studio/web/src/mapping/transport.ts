// The playback bar of a survey: the common one, with scans, and from one end of the recording to the other.

import { h, setText } from "../dom";
import { clock, ratio } from "../format";
import { icon, type IconName } from "../icons";
import { SeekBar } from "../seek";
import { Transport } from "../transport";
import type { Request } from "./protocol";
import type { Store } from "./store";

export const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 5, 10, 20, 50, 100, 200] as const;

export class SurveyTransport {
  readonly bar: Transport;
  private readonly start = button("start", "From the start", "Home", () => this.toStart());
  private readonly end = button("end", "To the end as fast as possible", "End", () => this.toEnd());
  private readonly scan = h("span", { class: "scan-count", role: "timer", "aria-label": "Scan" }, "–");
  private readonly time = h("span", { class: "time-max" });
  private readonly seek: SeekBar;

  constructor(holder: HTMLElement, private readonly store: Store, private readonly send: (request: Request) => boolean) {
    this.seek = new SeekBar({
      label: "Scan", title: "Drag to a scan; backwards it is mapped again from the start", step: 1, near: 0.5, isLive: false,
      text: String, ask: (scan) => this.send({ type: "seek", scan }),
      aimed: (scan) => setText(this.scan, `${scan} of ${this.store.newest?.n_scans ?? 0}`),
    });
    this.seek.show(true);
    this.bar = new Transport(holder, {
      speeds: SPEEDS, step: "One scan", about: "Time of the recording per real time", seek: this.seek,
      before: [this.start], after: [this.end], place: h("div", {}, this.scan, this.time),
      isOn: () => this.store.isOpen,
      toggle: () => this.send({ type: this.store.state?.playing ? "pause" : this.isOver ? "rewind" : "play" }),
      oneStep: () => this.send({ type: "step" }),
      setSpeed: (speed) => this.send({ type: "speed", ratio: speed }),
    });
    for (const event of ["state", "source", "connection"] as const) store.on(event, () => this.refresh());
    this.refresh();
  }

  toStart(): void {
    if (!this.start.disabled) this.send({ type: "rewind" });
  }

  toEnd(): void {
    if (!this.end.disabled) this.send({ type: "seek", scan: Number.MAX_SAFE_INTEGER });
  }

  private get isOver(): boolean {
    return this.store.state?.runs.every(({ phase }) => phase === "finished" || phase === "failed") ?? true;
  }

  private refresh(): void {
    const { state, source, newest, isOpen } = this.store;
    const ready = isOpen && newest !== null;
    const over = this.isOver;
    this.start.disabled = this.seek.disabled = !ready;
    this.end.disabled = !ready || over;
    this.bar.show({
      playing: state?.playing ?? false, word: over && ready ? "Again" : "Play", icon: over && ready ? "restart" : "play",
      speed_ratio: state?.speed_ratio ?? 1, achieved_ratio: state?.achieved_ratio ?? 0, told: this.told(), canPlay: ready, canStep: ready && !over,
    });
    if (!newest) {
      setText(this.scan, "–");
      setText(this.time, "");
      this.seek.moveTo(0);
      return;
    }
    this.seek.setEnd(newest.n_scans);
    this.seek.moveTo(newest.scan);
    if (this.seek.held) return;
    setText(this.scan, `${newest.scan} of ${newest.n_scans}`);
    setText(this.time, `${clock(newest.t_s)} / ${clock(source?.recording?.duration_s ?? 0)}`);
  }

  private told(): string | null {
    const { state, newest } = this.store;
    if (newest?.phase === "finishing") return "finishing";
    if (!state?.playing) return this.isOver ? "finished" : "paused";
    return state.hurrying ? ratio(state.achieved_ratio) : null;
  }
}

function button(name: IconName, title: string, key: string, act: () => void): HTMLButtonElement {
  return h("button", { class: "button square", type: "button", "aria-label": title, title: `${title} (${key})`, onclick: act }, icon(name));
}
