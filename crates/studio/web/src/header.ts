// What a run has in the header: mission chooser, what it is about, what kind of run, verdict.

import { h, setText } from "./dom";
import { plain, prose } from "./prose";
import { icon } from "./icons";
import type { Store } from "./state";

export interface HeaderEvents {
  chooseMission(name: string): void;
  openMission(): void;
  showVerdict(): void;
}

export class RunHeader {
  /** Between the name and the tail. */
  readonly own: readonly Node[];
  /** In the tail. */
  readonly pills: readonly Node[];
  private readonly mission = h("select", { class: "field mission", "aria-label": "Mission", disabled: true });
  private readonly about = h("p", { class: "about" });
  private readonly open = h("button", { class: "button bare square", type: "button", "aria-label": "Open a file of your own", title: "Open a mission of your own (TOML)" }, icon("open"));
  private readonly more = h("button", { class: "button bare square", type: "button", "aria-label": "What this is about", title: "What this mission is about" }, icon("info"));
  private readonly sheet = h("dialog", { class: "sheet mission-sheet", "aria-labelledby": "mission-title" });
  private readonly recording = h("span", { class: "pill bad", hidden: true });
  private readonly kind = h("span", { class: "pill warn", hidden: true, title: "A recording: it can be watched, not changed" }, "Replay");
  private readonly verdict = h("button", { class: "pill", type: "button", hidden: true });

  constructor(private readonly store: Store, events: HeaderEvents) {
    this.own = [
      h("div", { class: "mission-group" }, this.mission, this.open, this.more), this.about,
      h("a", { class: "button small page-link", href: "/map", title: "Build maps from recordings" }, icon("layers"), "Mapping"),
    ];
    this.pills = [this.recording, this.kind, this.verdict];
    document.body.append(this.sheet);
    this.open.addEventListener("click", events.openMission);
    this.more.addEventListener("click", () => this.showSheet());
    this.sheet.addEventListener("click", (event) => {
      if (event.target === this.sheet) this.sheet.close();
    });
    this.mission.addEventListener("change", () => events.chooseMission(this.mission.value));
    this.verdict.addEventListener("click", events.showVerdict);
    store.on("hello", () => this.onHello());
    store.on("state", () => this.onState());
    store.on("reset", () => (this.verdict.hidden = true));
  }

  private onHello(): void {
    const hello = this.store.hello;
    if (!hello) return;
    const { mission, missions } = hello;
    const choices = missions.some(({ name }) => name === mission.name) ? missions : [{ name: mission.name, title: mission.title }, ...missions];
    const options = (own: boolean): HTMLElement[] => choices.filter((choice) => (choice.own ?? false) === own).map(({ name, title }) => h("option", { value: name }, title));
    const own = options(true);
    this.mission.replaceChildren(...(own.length > 0 ? [h("optgroup", { label: "Your own" }, ...own), h("optgroup", { label: "Shipped" }, ...options(false))] : options(false)));
    this.mission.value = mission.name;
    this.mission.disabled = mission.kind === "replay";
    this.open.disabled = mission.kind === "replay";
    this.recording.hidden = !mission.recording;
    setText(this.recording, "Recording");
    this.recording.title = `This run is recorded in ${mission.recording}`;
    setText(this.about, plain(mission.about));
    this.about.title = plain(mission.about);
    this.kind.hidden = mission.kind !== "replay";
    document.title = `${mission.title} – Cairn studio`;
  }

  /** All that the mission says of itself, however narrow the page is. */
  private showSheet(): void {
    const mission = this.store.hello?.mission;
    if (!mission || this.sheet.open) return;
    const close = h("button", { class: "button bare square", type: "button", "aria-label": "Close", onclick: () => this.sheet.close() }, icon("close"));
    const facts: [string, string][] = [["Name", mission.name], ["Seed", String(mission.seed)], ["At most", `${mission.duration_max_s} s`]];
    if (mission.recording) facts.push(["Recorded in", mission.recording]);
    this.sheet.replaceChildren(
      h("div", { class: "sheet-head" }, h("h2", { id: "mission-title" }, mission.title), close),
      h("div", { class: "mission-about" }, h("p", {}, ...prose(mission.about || "Its file says nothing about it.")), mission.about.includes("--set") ? h("p", { class: "about-note" }, "Words with ", h("code", {}, "--set"), " belong to the command line: ", h("code", {}, `cairn run ${mission.name} --set …`)) : null, h("dl", {}, ...facts.flatMap(([what, told]) => [h("dt", {}, what), h("dd", {}, told)]))),
    );
    this.sheet.showModal();
  }

  private onState(): void {
    const verdict = this.store.state?.verdict ?? null;
    this.verdict.hidden = verdict === null;
    if (!verdict) return;
    this.verdict.className = `pill ${verdict.passed ? "good" : "bad"}`;
    this.verdict.title = `${verdict.text} – show the checks`;
    setText(this.verdict, verdict.passed ? "Passed" : "Failed");
  }
}
