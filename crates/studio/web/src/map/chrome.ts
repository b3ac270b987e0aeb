// The controls around the map: tool bar with devices above, view buttons and read-out at its foot.

import { h, setText } from "../dom";
import { clock, taskWords } from "../format";
import { icon, type IconName } from "../icons";
import type { CrowdRobot, Device, Hello, State } from "../protocol";
import type { Store } from "../state";
import { countCrowd } from "./crowd";
import { DEVICE_ICONS, isOn } from "./devices";
import type { MapView } from "./map";
import type { ToolName } from "./tools";
import { ViewTools } from "./view_tools";

const TOOLS: readonly { name: ToolName; icon: IconName; title: string; key: string; hint: string }[] = [
  { name: "select", icon: "pan", title: "Select and pan", key: "V", hint: "" },
  { name: "place", icon: "box", title: "Place a box", key: "B", hint: "Click to put a box of 0.4 m on the floor. Esc ends." },
  { name: "remove", icon: "remove", title: "Remove a box", key: "X", hint: "Click a box to take it away. Esc ends." },
  { name: "goal", icon: "goal", title: "Send the robot to a goal", key: "G", hint: "Press where the robot should go and drag towards its final heading. Esc ends." },
  { name: "drive", icon: "drive", title: "Drive by hand", key: "M", hint: "Hold W A S D, the arrows, a gamepad's stick or the stick below; let go to stop. Esc ends." },
];

const CROWD_WORDS = [
  { key: "under_way", word: "under way" },
  { key: "arrived", word: "arrived" },
  { key: "touching", word: "touching" },
] as const;

export class MapChrome {
  readonly bar = h("div", { class: "map-bar", role: "toolbar", "aria-label": "Map tools and devices" });
  /** Below the map, not over it: scale, what the robot does, what the tool does, where the pointer is, the view. */
  readonly foot = h("div", { class: "map-foot" });
  private readonly toolButtons = new Map<ToolName, HTMLButtonElement>();
  private readonly stop = h("button", { class: "button square stop", type: "button", "aria-label": "Stop the robot", title: "Stop the robot (S)" }, icon("stop"));
  private readonly devices = h("div", { class: "devices", role: "group", "aria-label": "Devices" });
  private readonly deviceElements = new Map<string, HTMLElement>();
  private readonly hint = h("p", { class: "hint", role: "status", hidden: true });
  private readonly viewTools: ViewTools;
  private readonly emptyWorld = h("div", { class: "empty-world", hidden: true }, h("strong", {}, "An empty world"), h("span", {}));
  /** What is shown is not the present. */
  private readonly pastBadge = h("p", { class: "run-badge past-badge", role: "status", hidden: true });
  /** Something has happened in this run: the notice has been read, or is in the way. */
  private isTouched = false;
  private readonly legend = h("div", { class: "legend", hidden: true });
  private readonly legendPeak = h("span");
  private readonly crowd = h("div", { class: "crowd", hidden: true });
  private readonly task = h("span", { class: "readout task", hidden: true });
  /** The same for ears: its task has figures that change several times a second. */
  private readonly phase = h("span", { class: "visually-hidden", role: "status" });

  constructor(
    view: HTMLElement,
    private readonly map: MapView,
    private readonly store: Store,
    private readonly actions: { press(device: string): void; stop(): void; downloads: HTMLElement },
  ) {
    const tools = h("div", { class: "tools", role: "group", "aria-label": "Tool" });
    for (const tool of TOOLS) {
      const button = h("button", { class: "button square", type: "button", "aria-pressed": tool.name === "select", "data-tool": tool.name, "aria-label": tool.title, title: `${tool.title} (${tool.key})`, onclick: () => map.tools.choose(tool.name) }, icon(tool.icon));
      this.toolButtons.set(tool.name, button);
      tools.append(button);
    }
    this.bar.append(tools, this.stop, h("div", { class: "rule" }), this.devices);
    this.stop.addEventListener("click", () => this.actions.stop());

    this.viewTools = new ViewTools("house", { zoom: (factor) => map.zoom(factor), fit: () => map.fit(), toggleFollow: () => map.setFollow(!map.follow) }, map.layers, [{ icon: "download", title: "Download", menu: actions.downloads }]);
    this.legend.append(h("span", {}, "Pheromone intensity"), h("div", { class: "ramp" }), h("div", { class: "ends" }, h("span", {}, "0"), this.legendPeak));
    this.foot.append(
      h("div", { class: "readout" }, this.viewTools.scale, this.legend, this.crowd),
      h("div", { class: "said" }, this.task, this.phase, this.hint),
      this.viewTools.buttons,
    );
    view.append(this.emptyWorld, this.pastBadge, map.layers.menu, this.actions.downloads);
    store.on("hello", () => this.onHello());
    store.on("reset", () => (this.isTouched = false));
    store.on("state", () => this.onState());
    store.on("connection", () => this.onState());
  }

  toggleLayers(): void {
    this.viewTools.toggleLayers();
  }

  /** True when Escape had a menu to close. */
  closeMenus(): boolean {
    return this.viewTools.closeMenus();
  }

  showTool(tool: ToolName): void {
    for (const [name, button] of this.toolButtons) button.setAttribute("aria-pressed", String(name === tool));
    const hint = TOOLS.find(({ name }) => name === tool)?.hint ?? "";
    this.hint.hidden = hint === "";
    setText(this.hint, hint);
  }

  showFollow(follow: boolean): void {
    this.viewTools.showFollow(follow);
  }

  refreshReadout(): void {
    this.viewTools.showScale(this.map.camera.scale_pxpm);
    this.viewTools.showPlace(this.map.tools.cursor_m);
    this.refreshLegend();
  }

  private onHello(): void {
    this.devices.replaceChildren();
    this.deviceElements.clear();
    const all = this.store.hello?.world.devices ?? [];
    // What can be pressed comes first.
    for (const device of [...all].sort((a, b) => Number(b.kind === "button") - Number(a.kind === "button"))) {
      const element = this.deviceElement(device);
      this.deviceElements.set(device.name, element);
      this.devices.append(element);
    }
    this.refreshLegend();
    this.refreshReadout();
    this.onState();
  }

  /** A bare floor is either what the mission wants or a mistake in its file: say what it is, until something happens. */
  private refreshEmptyWorld(): void {
    const { hello, state } = this.store;
    this.isTouched ||= hasBegun(state);
    this.emptyWorld.hidden = !hello || this.isTouched || !isBare(hello);
    if (this.emptyWorld.hidden) return;
    const noRobot = (hello?.robots.length ?? 0) === 0;
    const words = this.emptyWorld.lastElementChild;
    if (words) setText(words, noRobot ? "This mission has no walls, no furniture and no robot: only its devices and its program run." : "This mission has no walls and no furniture. Put boxes down, or send the robot somewhere.");
  }

  private deviceElement(device: Device): HTMLElement {
    const point = device.input !== null ? `I${device.input}` : device.output !== null ? `O${device.output}` : "";
    const glyph = icon(DEVICE_ICONS[device.kind]);
    const tag = h("span", { class: "point" }, point);
    if (device.kind === "button") {
      const title = `Press: ${device.label}${point ? ` (input ${point})` : ""}`;
      return h("button", { class: "device", type: "button", "data-device": device.name, title, onclick: () => this.actions.press(device.name) }, glyph, pressLabel(device), tag);
    }
    const meaning = device.input !== null ? `input ${point}` : point ? `output ${point}` : "not wired";
    return h("span", { class: "device", role: "img", "data-device": device.name, title: `${device.label}, ${meaning}` }, glyph, tag);
  }

  /** How many of a crowd do what; the words have the colours of the dots. */
  private refreshCrowd(): void {
    const crowd = this.store.hello?.crowd ? (this.store.state?.crowd ?? []) : [];
    this.crowd.hidden = crowd.length === 0;
    if (this.crowd.hidden) return;
    // The first robot is told in full, but it is one of them.
    const first = (this.store.state?.robots ?? []).map(({ touching, phase }): CrowdRobot => [0, 0, 0, touching ? 1 : phase === "arrived" ? 2 : 0]);
    const counts = countCrowd([...first, ...crowd]);
    const text = `${counts.under_way} under way · ${counts.arrived} arrived · ${counts.touching} touching`;
    if (this.crowd.dataset["text"] === text) return;
    this.crowd.dataset["text"] = text;
    this.crowd.replaceChildren(...CROWD_WORDS.map(({ key, word }) => h("span", { class: `crowd-${key}` }, `${counts[key]} ${word}`)));
  }

  private onState(): void {
    const { state, hello, canIntervene } = this.store;
    this.refreshCrowd();
    this.refreshEmptyWorld();
    // What a robot makes of an order shows at once, wherever the reader's panels are.
    const robot = state?.robots[0];
    const name = hello?.robots.find(({ id }) => id === robot?.id)?.name ?? "";
    this.task.hidden = !robot;
    this.task.classList.toggle("bad", Boolean(robot?.failure));
    const words = robot ? `${name}: ${taskWords(robot)}` : "";
    setText(this.task, words);
    if (this.task.title !== words) this.task.title = words;
    setText(this.phase, robot ? `${name}: ${robot.failure ? `gives up: ${robot.failure}` : robot.phase}` : "");
    for (const device of hello?.world.devices ?? []) {
      const element = this.deviceElements.get(device.name);
      if (!element) continue;
      const on = isOn(state, device.name);
      element.classList.toggle("on", on);
      if (element instanceof HTMLButtonElement) element.disabled = !canIntervene;
      else element.setAttribute("aria-label", `${device.label}: ${on ? "on" : "off"}`);
    }
    const canSteer = canIntervene && (hello?.robots.length ?? 0) > 0;
    this.stop.disabled = !this.store.canStop || (hello?.robots.length ?? 0) === 0;
    const { past } = this.store;
    this.pastBadge.hidden = past === null;
    if (past) setText(this.pastBadge, `${clock(past.state.t_s)}: the past. The run is at ${clock(this.store.live?.t_s ?? 0)}.`);
    for (const [name, button] of this.toolButtons) button.disabled = name !== "select" && !(name === "goal" || name === "drive" ? canSteer : canIntervene);
  }

  private refreshLegend(): void {
    const { field, layers } = this.map;
    this.legend.hidden = !field || field.peak === 0 || !layers.has("pheromones");
    if (field) setText(this.legendPeak, field.peak.toFixed(field.peak < 10 ? 1 : 0));
  }
}

/** Whether a mission has nothing to look at. Of a shipped one that is meant, unless it has no robot either. */
export function isBare({ mission, missions, world, robots, crowd, pheromones }: Hello): boolean {
  const isShipped = missions.some(({ name, own }) => name === mission.name && !own);
  const nothing = world.walls.length + world.points.length + world.things.length === 0 && !pheromones;
  return nothing && !crowd && (robots.length === 0 || !isShipped);
}

/** Whether anything has been done: a robot was sent or driven, or something was put down. */
export function hasBegun(state: State | null): boolean {
  if (!state) return false;
  return state.things.length > 0 || state.robots.some(({ goal, phase, wheels_mps }) => goal !== null || phase !== "idle" || wheels_mps.some((speed) => speed !== 0));
}

function pressLabel(device: Device): string {
  const name = device.label.charAt(0).toLowerCase() + device.label.slice(1);
  return /bell/i.test(name) ? `Ring the ${name}` : `Press ${name}`;
}
