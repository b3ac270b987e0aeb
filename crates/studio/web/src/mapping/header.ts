// The top of the mapping page: name, what is mapped, open, mission page, connection, theme, help.

import { h, setText } from "../dom";
import { icon, swapIcon } from "../icons";
import { currentTheme, onThemeChange, toggleTheme } from "../theme";
import type { Store } from "./store";

export class Header {
  private readonly mission = h("a", { class: "button small page-link", href: "/", hidden: true, title: "The mission that runs" }, icon("robot"), "Mission");
  private readonly name = h("strong", { class: "source-name" });
  private readonly about = h("p", { class: "about" });
  private readonly connection = h("span", { class: "pill", role: "status" }, "Connecting…");
  private readonly theme = h("button", { class: "button bare square", type: "button" }, icon("moon"));

  constructor(holder: HTMLElement, private readonly store: Store, events: { open(): void; help(): void }) {
    holder.append(
      h("h1", { class: "brand" }, h("img", { src: "/assets/favicon.svg", alt: "", width: 28, height: 28 }), "Cairn", h("span", { class: "page-name" }, "Mapping")),
      h("button", { class: "button", type: "button", title: "Open a recording (O)", onclick: () => events.open() }, icon("open"), "Open…"),
      this.name, this.about, this.mission,
      h("div", { class: "tail" }, this.connection, this.theme,
        h("button", { class: "button bare square", type: "button", "aria-label": "Shortcuts and about", title: "Shortcuts and about (?)", onclick: () => events.help() }, icon("help"))),
    );
    this.theme.addEventListener("click", toggleTheme);
    onThemeChange(() => this.refreshTheme());
    this.refreshTheme();
    store.on("hello", (hello) => (this.mission.hidden = !hello.has_mission));
    store.on("source", () => this.onSource());
    store.on("connection", () => this.onConnection());
    this.onConnection();
  }

  private refreshTheme(): void {
    const title = currentTheme() === "dark" ? "Light theme (T)" : "Dark theme (T)";
    swapIcon(this.theme, currentTheme() === "dark" ? "sun" : "moon");
    this.theme.title = title;
    this.theme.setAttribute("aria-label", title.replace(/ \(.*/, ""));
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

  private onConnection(): void {
    const { connection } = this.store;
    const tone = connection.phase === "open" ? "good" : connection.phase === "lost" ? "bad" : "";
    this.connection.className = `pill ${tone}`;
    setText(this.connection, connection.phase === "open" ? "Connected" : connection.phase === "lost" ? "Disconnected" : "Connecting…");
  }
}
