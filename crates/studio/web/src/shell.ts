// The frame around every session: header, map beside dock, playback bar, connection, keys, help, and what is said.

import { Connection } from "./connection";
import { Dock, type PanelView } from "./dock";
import { h, setText } from "./dom";
import type { Session } from "./emitter";
import { Help } from "./help";
import { icon, swapIcon } from "./icons";
import { attachSplitter } from "./layout";
import { Notice } from "./notice";
import { attachShortcuts, type Shortcut } from "./shortcuts";
import { currentTheme, onThemeChange, toggleTheme } from "./theme";
import { Toasts } from "./toast";

const MAP_WIDTH_MIN_PX = 420;
const DOCK_WIDTH_MIN_PX = 360;
const MAP_HEIGHT_MIN_PX = 220;
const DOCK_HEIGHT_MIN_PX = 260;

export interface ShellOptions {
  /** What the session is: the page's styles and remembered sizes go by it. */
  name: "run" | "survey";
  socket: string;
  protocol: number;
  text(text: string): void;
  binary?(bytes: ArrayBuffer): void;
}

export class Shell<Request extends { type: string }> {
  readonly map = byId("map");
  readonly view = h("div", { class: "map-view" });
  readonly transport = byId("transport");
  readonly toasts: Toasts;
  private readonly header = byId("top");
  private readonly dockElement = byId("dock");
  private readonly connection: Connection<Request>;
  private readonly pill = h("span", { class: "pill", role: "status" }, "Connecting…");
  private readonly theme = h("button", { class: "button bare square", type: "button" }, icon("moon"));
  private help: Help | null = null;

  constructor(private readonly store: Session, private readonly options: ShellOptions) {
    document.body.dataset["session"] = options.name;
    const scheme = location.protocol === "https:" ? "wss" : "ws";
    this.connection = new Connection<Request>(`${scheme}://${location.host}${options.socket}`, {
      text: (text) => options.text(text),
      binary: (bytes) => options.binary?.(bytes),
      change: (state) => store.setConnection(state),
    });
    // Beside the map and never over it: what is said must not cover the robot.
    this.toasts = new Toasts(this.dockElement);
    store.onError((text) => this.toasts.say(text, "bad"));
    store.onSession(() => this.showConnection());
    this.theme.addEventListener("click", toggleTheme);
    onThemeChange(() => this.showTheme());
    this.showTheme();
  }

  /** Sends a request, or says that nothing was sent. */
  readonly send = (request: Request): boolean => {
    const sent = this.connection.send(request);
    if (!sent) this.toasts.say("No connection to the program: nothing was sent.", "bad");
    return sent;
  };

  /** The header: the session's own things between the name and the tail, its pills before the connection's. */
  putHeader(own: readonly Node[], pills: readonly Node[] = []): void {
    const help = h("button", { class: "button bare square", type: "button", "aria-label": "Shortcuts and about", title: "Shortcuts and about (?)", onclick: () => this.help?.open() }, icon("help"));
    this.header.append(
      h("h1", { class: "brand" }, h("img", { src: "/assets/favicon.svg", alt: "", width: 28, height: 28 }), "Cairn"),
      ...own, h("div", { class: "tail" }, ...pills, this.pill, this.theme, help));
  }

  /** The column of the map: what is above and below it. */
  putMap(above: readonly Node[], below: readonly Node[]): void {
    this.map.append(...above, this.view, ...below);
    new Notice(this.view, this.store, this.options.protocol, () => this.connection.retryNow());
  }

  /** The panels that this page can show. */
  putPanels(views: Readonly<Record<string, PanelView>>): Dock {
    const dock = new Dock(this.dockElement, this.options.name === "run" ? "upper" : "mapping", views);
    this.attachMainSplitter();
    return dock;
  }

  /** Keys and their help; from here on the page is alive. */
  open(shortcuts: readonly Shortcut[], isReplay?: () => boolean): void {
    const all: Shortcut[] = [
      ...shortcuts,
      { keys: ["t"], shown: "T", group: "Page", what: "Dark or light", act: toggleTheme },
      { keys: ["?"], shown: "?", group: "Page", what: "This help", act: () => this.help?.open() },
    ];
    this.help = new Help(all, () => this.store.greeting);
    attachShortcuts(all, isReplay);
    this.connection.open();
    window.setInterval(() => this.showConnection(), 1000);
  }

  private showTheme(): void {
    const title = currentTheme() === "dark" ? "Light theme (T)" : "Dark theme (T)";
    swapIcon(this.theme, currentTheme() === "dark" ? "sun" : "moon");
    this.theme.title = title;
    this.theme.setAttribute("aria-label", title.replace(/ \(.*/, ""));
  }

  private showConnection(): void {
    const { phase } = this.store.connection;
    this.pill.className = `pill ${phase === "open" ? "good" : phase === "lost" ? "bad" : ""}`;
    setText(this.pill, phase === "open" ? "Connected" : phase === "lost" ? "Disconnected" : "Connecting…");
  }

  private attachMainSplitter(): void {
    const work = byId("work");
    const isStacked = (): boolean => getComputedStyle(work).gridTemplateColumns.split(" ").length === 1;
    attachSplitter({
      element: byId("split-main"), label: "Size of the map", key: this.options.name === "run" ? "main" : "mapping", isHorizontal: isStacked,
      sizeAt: (x_px, y_px) => (isStacked() ? y_px - work.getBoundingClientRect().top : work.getBoundingClientRect().right - x_px),
      current: () => (isStacked() ? this.map.clientHeight : this.dockElement.clientWidth),
      limits: () => (isStacked() ? [MAP_HEIGHT_MIN_PX, work.clientHeight - DOCK_HEIGHT_MIN_PX] : [DOCK_WIDTH_MIN_PX, Math.max(DOCK_WIDTH_MIN_PX, work.clientWidth - MAP_WIDTH_MIN_PX)]),
      apply: (size_px) => {
        const property = isStacked() ? "--map-height" : "--dock-width";
        if (size_px === null) work.style.removeProperty(property);
        else work.style.setProperty(property, `${size_px}px`);
      },
    });
  }
}

function byId(id: string): HTMLElement {
  const element = document.getElementById(id);
  if (!element) throw new Error(`the page has no element #${id}`);
  return element;
}
