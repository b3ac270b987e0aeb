// Puts a run's page together: store, map with tools, panels, playback bar, keys.

import { Controls } from "./controls";
import { downloadMenu } from "./downloads";
import { Drive } from "./drive";
import { RunHeader } from "./header";
import { MapChrome } from "./map/chrome";
import { MapView } from "./map/map";
import type { ToolName } from "./map/tools";
import { MissionOpener } from "./mission_opener";
import { AvoiderPanel } from "./panels/avoider";
import { FiguresPanel } from "./panels/figures";
import { PlotsPanel } from "./panels/plots";
import { ProgramPanel } from "./panels/program";
import { SignalsPanel } from "./panels/signals";
import { WirePanel } from "./panels/wire";
import { type ClientMessage, parseServerMessage, type Point, PROTOCOL_VERSION } from "./protocol";
import { Shell } from "./shell";
import { shortcutTable } from "./shortcut_table";
import { Store } from "./state";
import { VerdictBanner } from "./verdict";

export function openRun(): void {
  const store = new Store();
  const shell = new Shell<ClientMessage>(store, {
    name: "run", socket: "/ws", protocol: PROTOCOL_VERSION,
    text: (text) => {
      const message = parseServerMessage(text);
      if (message) store.accept(message, performance.now());
    },
  });
  const { send, view, toasts } = shell;
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
  const plots = new PlotsPanel(store);
  const downloads = downloadMenu(store, { map: () => map.canvas, plots: () => plots.pictures(), say: (text) => toasts.say(text) });
  const stopRobot = (): void => {
    const robot = store.hello?.robots[0];
    if (robot && store.canStop) send({ type: "stop", robot: robot.id });
  };
  const chrome: MapChrome = new MapChrome(view, map, store, { press: (device) => send({ type: "press", device }), stop: stopRobot, downloads });
  const controls = new Controls(shell.transport, store, send, {
    // A hand that holds the wheel must see where the robot is.
    lookingBack: () => {
      if (map.tools.tool !== "select") map.tools.choose("select");
    },
  });
  const verdict = new VerdictBanner(view, store, () => controls.restartRun());
  const opener = new MissionOpener((text) => toasts.say(text, "bad"));
  const header = new RunHeader(store, {
    openMission: () => opener.choose(),
    chooseMission: (name) => send({ type: "restart", seed: null, mission: name }),
    showVerdict: () => verdict.show(),
  });
  shell.putHeader(header.own, header.pills);
  shell.putMap([chrome.bar], [chrome.foot, drive.element]);
  const dock = shell.putPanels({
    program: new ProgramPanel(store),
    signals: new SignalsPanel(store),
    avoider: new AvoiderPanel(store),
    plots,
    wire: new WirePanel(store, send),
    figures: new FiguresPanel(store),
  });
  store.on("hello", (hello) => dock.offer(hello.panels));
  store.on("failure", (text) => toasts.say(text, "bad"));
  const press = (): void => {
    const button = store.hello?.world.devices.find(({ kind }) => kind === "button");
    if (button && store.canIntervene) send({ type: "press", device: button.name });
  };
  shell.open(shortcutTable({ controls, map, chrome, verdict, press, stop: stopRobot, showDigit: (digit) => dock.showDigit(digit) }), () => store.hello?.mission.kind === "replay");
  window.cairn = probeOf(store, map);
}

/** For tests and for the curious in the console: where things are drawn, and how often. */
function probeOf(store: Store, map: MapView) {
  return {
    pageOf: (at_m: Point): Point => {
      const [x, y] = map.camera.toScreen(...at_m);
      const box = map.canvas.getBoundingClientRect();
      return [box.left + x, box.top + y];
    },
    frames: () => map.n_frames,
    state: () => store.state,
    live: () => store.live,
    /** The value of a signal by its name, of the first robot or of the run. */
    signal: (id: string): number | null => {
      const of = (signals: readonly { id: string }[] = []): number => signals.findIndex((signal) => signal.id === id);
      const [robot, run] = [of(store.hello?.robot_signals), of(store.hello?.run_signals)];
      return (robot >= 0 ? store.state?.robots[0]?.signals[robot] : store.state?.signals[run]) ?? null;
    },
    tool: (): ToolName => map.tools.tool,
    known: () => {
      const way = store.trails.get(0)?.truth.points ?? [];
      const lengths = way.slice(1).map((point, index) => Math.hypot(point.x_m - (way[index]?.x_m ?? 0), point.y_m - (way[index]?.y_m ?? 0)));
      return { n_curve_points: store.series.t_s.length, first_s: store.series.t_s[0] ?? NaN, way_m: lengths.reduce((sum, length_m) => sum + length_m, 0) };
    },
  };
}

declare global {
  interface Window {
    cairn: ReturnType<typeof probeOf>;
  }
}
