// Puts a survey's page together: store, maps side by side, panels, playback bar, keys.

import type { Point } from "../protocol";
import { Shell } from "../shell";
import { CandidatesPanel } from "./candidates";
import { SurveyHeader } from "./header";
import { LogPanel } from "./log";
import { NowPanel } from "./now";
import { Opener } from "./opener";
import { ParametersPanel } from "./parameters";
import { MAPPING_PROTOCOL, type Request, type Slot } from "./protocol";
import { mapRamp, patchRamp } from "./ramp";
import { ResultsPanel } from "./results";
import { mappingShortcuts } from "./shortcut_table";
import { Store } from "./store";
import { SurveyTransport } from "./transport";
import { View } from "./view";

export function openSurvey(): void {
  const store = new Store(mapRamp(), patchRamp());
  const shell = new Shell<Request>(store, {
    name: "survey", socket: "/map/ws", protocol: MAPPING_PROTOCOL,
    text: (text) => store.acceptText(text),
    binary: (bytes) => store.acceptBinary(bytes),
  });
  const { send, toasts } = shell;
  const view = new View(shell.view, store);
  const opener = new Opener(shell.view, store, { send, say: (text, tone) => toasts.say(text, tone) });
  shell.putHeader(new SurveyHeader(store, () => opener.open()).own);
  shell.putMap([], [view.foot]);
  const transport = new SurveyTransport(shell.transport, store, send);
  const dock = shell.putPanels({
    now: new NowPanel(store),
    candidates: new CandidatesPanel(store),
    parameters: new ParametersPanel(store, send),
    results: new ResultsPanel(store, send),
    file: new LogPanel(store),
  });
  store.on("source", (source) => dock.offer(source.panels));
  shell.open(mappingShortcuts({ transport, view, showDigit: (digit) => dock.showDigit(digit), open: () => opener.open() }));
  window.mapping = probeOf(store, view);
}

/** For tests and for the curious in the console. */
function probeOf(store: Store, view: View) {
  return {
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
}

declare global {
  interface Window {
    mapping: ReturnType<typeof probeOf>;
  }
}
