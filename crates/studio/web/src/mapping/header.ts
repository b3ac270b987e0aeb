// What a survey has in the header: open, what is mapped, the way to the mission.

import { h, setText } from "../dom";
import { icon } from "../icons";
import type { Store } from "./store";

export class SurveyHeader {
  readonly own: readonly Node[];
  private readonly mission = h("a", { class: "button small page-link", href: "/", hidden: true, title: "The mission that runs" }, icon("robot"), "Mission");
  private readonly name = h("strong", { class: "source-name" });
  private readonly about = h("p", { class: "about" });

  constructor(private readonly store: Store, open: () => void) {
    this.own = [
      h("span", { class: "page-name" }, "Mapping"),
      h("button", { class: "button", type: "button", title: "Open a recording (O)", onclick: open }, icon("open"), "Open…"),
      this.name, this.about, this.mission,
    ];
    store.on("hello", (hello) => (this.mission.hidden = !hello.has_mission));
    store.on("source", () => this.onSource());
  }

  private onSource(): void {
    const { source } = this.store;
    const info = source?.recording;
    setText(this.name, info ? (source?.name ?? "") : "");
    this.name.title = source?.name ?? "";
    document.title = info ? `${source?.name} – Mapping – Cairn studio` : "Mapping – Cairn studio";
    if (!info) return setText(this.about, "");
    const minutes = info.duration_s / 60;
    const duration = minutes < 2 ? `${Math.round(info.duration_s)} s` : `${minutes.toFixed(0)} min`;
    const rig = info.rig === "laser" ? `laser with ${info.n_readings} beams` : `ring of ${info.n_readings} sonars`;
    setText(this.about, `${info.format}, ${rig}; ${info.n_scans} scans in ${duration}, ${info.path_length_m.toFixed(0)} m driven${info.has_truth ? "; true poses known" : ""}`);
    this.about.title = this.about.textContent ?? "";
  }
}
