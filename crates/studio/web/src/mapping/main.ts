// Puts the mapping page together: connection and store, header, maps, panels, playback bar, keys.

import "../styles/tokens.css";
import "../styles/base.css";
import "../styles/layout.css";
import "../styles/map.css";
import "../styles/panels.css";
import "../styles/mapping.css";
import { Connection } from "../connection";
import { h, setText } from "../dom";
import { Help } from "../help";
import { attachSplitter, Tabs } from "../layout";
import type { Point } from "../protocol";
import { attachShortcuts } from "../shortcuts";
import { Toasts } from "../toast";
import { CandidatesPanel } from "./candidates";
import { Header } from "./header";
import { LogPanel } from "./log";
import { NowPanel } from "./now";
import { LostNotice, Opener } from "./opener";
import { ParametersPanel } from "./parameters";
import { MAPPING_PROTOCOL, type Request, type Slot } from "./protocol";
import { mapRamp, patchRamp } from "./ramp";
import { ResultsPanel } from "./results";
import { mappingShortcuts } from "./shortcut_table";
import { Store } from "./store";
import { Transport } from "./transport";
import { View } from "./view";

const store = new Store(mapRamp(), patchRamp());
const scheme = location.protocol === "https:" ? "wss" : "ws";
const connection = new Connection<Request>(`${scheme}://${location.host}/map/ws`, {
  text: (text) => store.acceptText(text),
  binary: (bytes) => store.acceptBinary(bytes),
  change: (state) => store.setConnection(state),
});
const send = (request: Request): boolean => {
  const sent = connection.send(request);
  if (!sent) toasts.say("No connection to the program: nothing was sent.", "bad");
  return sent;
};

const mapSection = byId("map");
const view = new View(store);
mapSection.append(view.element);
const toasts = new Toasts(view.element);
const opener = new Opener(view.element, store, { send, say: (text, tone) => toasts.say(text, tone) });
new LostNotice(view.element, store, MAPPING_PROTOCOL, () => connection.retryNow());
new Header(byId("top"), store, { open: () => opener.open(), help: () => help.open() });
const transport = new Transport(byId("transport"), store, send);

const logCount = h("span", { class: "tab-count", hidden: true });
const log = new LogPanel(store, (n) => {
  logCount.hidden = n === 0;
  setText(logCount, String(n));
});
const results = new ResultsPanel(store, send);
const tabs = new Tabs("mapping", "Panels", [
  { key: "now", title: "Now", panel: new NowPanel(store).element },
  { key: "candidates", title: "Candidates", panel: new CandidatesPanel(store).element },
  { key: "parameters", title: "Parameters", panel: new ParametersPanel(store, send).element },
  { key: "results", title: "Results", panel: results.element },
  { key: "file", title: "File", panel: log.element },
]);
byId("dock").append(tabs.element);
document.getElementById("tab-file")?.append(logCount);
attachMainSplitter();

const shortcuts = mappingShortcuts({ transport, view, showPanel: (key) => tabs.show(key), open: () => opener.open(), help: () => help.open() });
const help = new Help(shortcuts, () => store.hello);
attachShortcuts(shortcuts);

store.on("error", (text) => toasts.say(text, "bad"));
connection.open();

/** For tests and for the curious in the console. */
const probe = {
  state: () => store.state,
  source: () => store.source,
  hello: () => store.hello,
  frames: () => view.panes[0].n_frames,
  board: (slot: Slot) => store.boards[slot],
  registrations: (slot: Slot) => store.registrations[slot],
  pageOf: (slot: Slot, at_m: Point): Point => {
    const pane = view.panes[slot];
    const [x, y] = pane.camera.toScreen(...at_m);
    const box = pane.canvas.getBoundingClientRect();
    return [box.left + x, box.top + y];
  },
};
declare global {
  interface Window {
    mapping: typeof probe;
  }
}
window.mapping = probe;

function attachMainSplitter(): void {
  const work = byId("work");
  const dock = byId("dock");
  const isStacked = (): boolean => getComputedStyle(work).gridTemplateColumns.split(" ").length === 1;
  attachSplitter({
    element: byId("split-main"), label: "Size of the map", key: "mapping", isHorizontal: isStacked,
    sizeAt: (x_px, y_px) => (isStacked() ? y_px - work.getBoundingClientRect().top : work.getBoundingClientRect().right - x_px),
    current: () => (isStacked() ? mapSection.clientHeight : dock.clientWidth),
    limits: () => (isStacked() ? [220, work.clientHeight - 200] : [300, Math.max(300, work.clientWidth - 420)]),
    apply: (size_px) => {
      const property = isStacked() ? "--map-height" : "--dock-width";
      if (size_px === null) work.style.removeProperty(property);
      else work.style.setProperty(property, `${size_px}px`);
    },
  });
}

function byId(id: string): HTMLElement {
  const element = document.getElementById(id);
  if (!element) throw new Error(`map.html has no element #${id}`);
  return element;
}
