// Puts the page together: connection and store, header, map, panels, playback bar, keys.

import "./styles/tokens.css";
import "./styles/base.css";
import "./styles/layout.css";
import "./styles/map.css";
import "./styles/panels.css";
import "./styles/editor.css";
import { Connection } from "./connection";
import { Controls } from "./controls";
import { downloadMenu } from "./downloads";
import { Drive } from "./drive";
import { Header } from "./header";
import { MissionOpener } from "./mission_opener";
import { Help } from "./help";
import { attachSplitter, Tabs } from "./layout";
import { h } from "./dom";
import { MapChrome } from "./map/chrome";
import { MapView } from "./map/map";
import type { ToolName } from "./map/tools";
import { Notice } from "./notice";
import { AvoiderPanel } from "./panels/avoider";
import { FiguresPanel } from "./panels/figures";
import { PlotsPanel } from "./panels/plots";
import { ProgramPanel } from "./panels/program";
import { SignalsPanel } from "./panels/signals";
import { WirePanel } from "./panels/wire";
import { type ClientMessage, parseServerMessage, type Point } from "./protocol";
import { attachShortcuts } from "./shortcuts";
import { shortcutTable } from "./shortcut_table";
import { Store } from "./state";
import { Toasts } from "./toast";
import { VerdictBanner } from "./verdict";

const store = new Store();
const scheme = location.protocol === "https:" ? "wss" : "ws";
const connection = new Connection<ClientMessage>(`${scheme}://${location.host}/ws`, {
  text: (text) => {
    const message = parseServerMessage(text);
    if (message) store.accept(message, performance.now());
  },
  change: (state) => store.setConnection(state),
});
const send = (message: ClientMessage): boolean => {
  const sent = connection.send(message);
  if (!sent) toasts.say("No connection to the program: nothing was sent.", "bad");
  return sent;
};

const mapSection = byId("map");
const view = h("div", { class: "map-view" });
// Beside the map and never over it: what is said must not cover the robot.
const toasts = new Toasts(byId("dock"));
const map: MapView = new MapView(view, store, {
  send,
  say: (text) => toasts.say(text),
  toolChanged: (tool) => {
    chrome.showTool(tool);
    drive.setActive(tool === "drive");
  },
  followChanged: (follow) => chrome.showFollow(follow),
  viewChanged: () => chrome.refreshReadout(),
});
const drive: Drive = new Drive(store, send);
const downloads = downloadMenu(store, { map: () => map.canvas, plots: () => plots.pictures(), say: (text) => toasts.say(text) });
const chrome: MapChrome = new MapChrome(view, map, store, { press: (device) => send({ type: "press", device }), stop: () => stopRobot(), downloads });
mapSection.append(chrome.bar, view, chrome.foot, drive.element);

const controls = new Controls(byId("transport"), store, send);
const verdict = new VerdictBanner(view, store, () => controls.restartRun());
new Notice(view, store, () => connection.retryNow());
const opener = new MissionOpener((text) => toasts.say(text, "bad"));
new Header(byId("top"), store, {
  openMission: () => opener.choose(),
  chooseMission: (name) => send({ type: "restart", seed: null, mission: name }),
  showVerdict: () => verdict.show(),
  showHelp: () => help.open(),
});

const signals = new SignalsPanel(store);
const wire = new WirePanel(store);
const plots = new PlotsPanel(store);
const upper = new Tabs("upper", "Decision and avoidance", [
  { key: "program", title: "Program", panel: new ProgramPanel(store).element },
  { key: "signals", title: "Signals", panel: signals.element, shown: (visible) => signals.setVisible(visible) },
  { key: "avoider", title: "Avoider", panel: new AvoiderPanel(store).element },
]);
const lower = new Tabs("lower", "Measurements", [
  { key: "plots", title: "Plots", panel: plots.element, shown: (visible) => plots.setVisible(visible) },
  { key: "wire", title: "Wire", panel: wire.element, shown: (visible) => wire.setVisible(visible) },
  { key: "figures", title: "Figures & log", panel: new FiguresPanel(store).element },
]);
const dock = byId("dock");
const dockSplit = h("div", { class: "split rows" });
dock.append(upper.element, dockSplit, lower.element);
attachSplitters();

const shortcuts = shortcutTable({
  controls, map, chrome, verdict,
  press: () => pressFirstButton(),
  stop: () => stopRobot(),
  showPanel: (key) => upper.show(key) || lower.show(key),
  help: () => help.open(),
});
const help = new Help(shortcuts, () => store.hello);
attachShortcuts(shortcuts, () => store.hello?.mission.kind === "replay");

store.on("error", (text) => toasts.say(text, "bad"));
store.on("failure", (text) => toasts.say(text, "bad"));
connection.open();

/** For tests and for the curious in the console: where things are drawn, and how often. */
const probe = {
  pageOf: (at_m: Point): Point => {
    const [x, y] = map.camera.toScreen(...at_m);
    const box = map.canvas.getBoundingClientRect();
    return [box.left + x, box.top + y];
  },
  frames: () => map.n_frames,
  state: () => store.state,
  tool: (): ToolName => map.tools.tool,
  known: () => {
    const way = store.trails.get(0)?.truth.points ?? [];
    const lengths = way.slice(1).map((point, index) => Math.hypot(point.x_m - (way[index]?.x_m ?? 0), point.y_m - (way[index]?.y_m ?? 0)));
    return { n_curve_points: store.series.t_s.length, first_s: store.series.t_s[0] ?? NaN, way_m: lengths.reduce((sum, length_m) => sum + length_m, 0) };
  },
};
declare global {
  interface Window {
    cairn: typeof probe;
  }
}
window.cairn = probe;

function pressFirstButton(): void {
  const button = store.hello?.world.devices.find(({ kind }) => kind === "button");
  if (button && store.canIntervene) send({ type: "press", device: button.name });
}

function stopRobot(): void {
  const robot = store.hello?.robots[0];
  if (robot && store.canIntervene) send({ type: "stop", robot: robot.id });
}

function attachSplitters(): void {
  const work = byId("work");
  const main = byId("split-main");
  const isStacked = (): boolean => getComputedStyle(work).gridTemplateColumns.split(" ").length === 1;
  attachSplitter({
    element: main, label: "Size of the map", key: "main", isHorizontal: isStacked,
    sizeAt: (x_px, y_px) => (isStacked() ? y_px - work.getBoundingClientRect().top : work.getBoundingClientRect().right - x_px),
    current: () => (isStacked() ? mapSection.clientHeight : dock.clientWidth),
    limits: () => (isStacked() ? [220, work.clientHeight - 260] : [360, Math.max(360, work.clientWidth - 420)]),
    apply: (size_px) => {
      setSize(work, isStacked() ? "--map-height" : "--dock-width", size_px);
    },
  });
  attachSplitter({
    element: dockSplit, label: "Size of the upper panel", key: "dock", isHorizontal: () => true,
    sizeAt: (_x_px, y_px) => y_px - dock.getBoundingClientRect().top,
    current: () => upper.element.clientHeight,
    limits: () => [120, Math.max(120, dock.clientHeight - 309)],
    apply: (size_px) => setSize(dock, "--dock-split", size_px),
  });
}

function setSize(element: HTMLElement, property: string, size_px: number | null): void {
  if (size_px === null) element.style.removeProperty(property);
  else element.style.setProperty(property, `${size_px}px`);
}

function byId(id: string): HTMLElement {
  const element = document.getElementById(id);
  if (!element) throw new Error(`index.html has no element #${id}`);
  return element;
}
