// The top of the page: name, mission chooser, what kind of run, verdict, connection, theme, help.

import { h, setText } from "./dom";
import { plain, prose } from "./prose";
import { icon, swapIcon } from "./icons";
import type { Store } from "./state";
import { currentTheme, onThemeChange, toggleTheme } from "./theme";

export interface HeaderEvents {
  chooseMission(name: string): void;
  openMission(): void;
  showVerdict(): void;
  showHelp(): void;
}

export class Header {
  private readonly mission = h("select", { class: "field mission", "aria-label": "Mission", disabled: true });
  private readonly about = h("p", { class: "about" });
  private readonly open = h("button", { class: "button bare square", type: "button", "aria-label": "Open a file of your own", title: "Open a mission of your own (TOML)" }, icon("open"));
  private readonly more = h("button", { class: "button bare square", type: "button", "aria-label": "What this is about", title: "What this mission is about" }, icon("info"));
  private readonly sheet = h("dialog", { class: "sheet mission-sheet", "aria-labelledby": "mission-title" });
  private readonly recording = h("span", { class: "pill bad", hidden: true });
  private readonly kind = h("span", { class: "pill warn", hidden: true, title: "A recording: it can be watched, not changed" }, "Replay");
  private readonly verdict = h("button", { class: "pill", type: "button", hidden: true });
  private readonly connection = h("span", { class: "pill", role: "status" }, "Connecting…");
  private readonly theme = h("button", { class: "button bare square", type: "button" }, icon("moon"));

  constructor(holder: HTMLElement, private readonly store: Store, events: HeaderEvents) {
    const help = h("button", { class: "button bare square", type: "button", "aria-label": "Shortcuts and about", title: "Shortcuts and about (?)", onclick: events.showHelp }, icon("help"));
    holder.append(
      h("h1", { class: "brand" }, h("img", { src: "/assets/favicon.svg", alt: "", width: 28, height: 28 }), "Cairn"),
      h("div", { class: "mission-group" }, this.mission, this.open, this.more), this.about,
      h("a", { class: "button small page-link", href: "/map", title: "Build maps from recordings" }, icon("layers"), "Mapping"),
      h("div", { class: "tail" }, this.recording, this.kind, this.verdict, this.connection, this.theme, help),
    );
    document.body.append(this.sheet);
    this.open.addEventListener("click", events.openMission);
    this.more.addEventListener("click", () => this.showSheet());
    this.sheet.addEventListener("click", (event) => {
      if (event.target === this.sheet) this.sheet.close();
    });
    this.mission.addEventListener("change", () => events.chooseMission(this.mission.value));
    this.verdict.addEventListener("click", events.showVerdict);
    this.theme.addEventListener("click", toggleTheme);
    onThemeChange(() => this.refreshTheme());
    this.refreshTheme();
    store.on("hello", () => this.onHello());
    store.on("state", () => this.onState());
    store.on("reset", () => (this.verdict.hidden = true));
    store.on("connection", () => this.onConnection());
    window.setInterval(() => this.onConnection(), 1000);
  }

  private refreshTheme(): void {
    const title = currentTheme() === "dark" ? "Light theme (T)" : "Dark theme (T)";
    swapIcon(this.theme, currentTheme() === "dark" ? "sun" : "moon");
    this.theme.title = title;
    this.theme.setAttribute("aria-label", title.replace(/ \(.*/, ""));
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

  private onConnection(): void {
    const { connection } = this.store;
    const tone = connection.phase === "open" ? "good" : connection.phase === "lost" ? "bad" : "";
    this.connection.className = `pill ${tone}`;
    setText(this.connection, connection.phase === "open" ? "Connected" : connection.phase === "lost" ? "Disconnected" : "Connecting…");
  }
}
