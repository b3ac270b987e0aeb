// Every key of the page and what it does; the help dialog prints this same table.

import type { Controls } from "./controls";
import type { MapChrome } from "./map/chrome";
import type { MapView } from "./map/map";
import type { ToolName } from "./map/tools";
import type { Shortcut } from "./shortcuts";
import type { VerdictBanner } from "./verdict";

export interface ShortcutTargets {
  controls: Controls;
  map: MapView;
  chrome: MapChrome;
  verdict: VerdictBanner;
  press(): void;
  stop(): void;
  showDigit(digit: number): void;
}

const PAN_PX = 60;
const CURSOR_STEP_M = 0.1;
const DIGITS = ["1", "2", "3", "4", "5", "6", "7", "8", "9"] as const;
const TURN_RAD = Math.PI / 12;

export function shortcutTable(targets: ShortcutTargets): Shortcut[] {
  const { controls, map, chrome, verdict } = targets;
  const tool = (name: ToolName) => (): void => {
    map.tools.choose(name);
    if (name !== "select" && map.tools.tool === name) map.canvas.focus({ preventScroll: true });
  };
  const arrow = (event: KeyboardEvent): void => {
    const right = Number(event.key === "ArrowRight") - Number(event.key === "ArrowLeft");
    const up = Number(event.key === "ArrowUp") - Number(event.key === "ArrowDown");
    const step_m = CURSOR_STEP_M * (event.shiftKey ? 5 : 1);
    if (!map.tools.moveCursor(right * step_m, up * step_m)) map.pan(-right * PAN_PX, up * PAN_PX);
  };
  return [
    { keys: [" "], shown: "Space", group: "Playback", what: "Play or pause", act: () => controls.transport.togglePlay() },
    { keys: ["."], shown: ".", group: "Playback", what: "One step", act: () => controls.transport.oneStep() },
    { keys: ["ArrowLeft"], needsReplay: true, shown: "← →", group: "Playback", what: "In a recording: 1 s back or on (Shift: 10 s)", act: (event) => controls.seekBy(event.shiftKey ? -10 : -1) },
    { keys: ["ArrowRight"], needsReplay: true, shown: "", group: "Playback", what: "", act: (event) => controls.seekBy(event.shiftKey ? 10 : 1) },
    { keys: ["Home"], needsReplay: true, shown: "Home End", group: "Playback", what: "In a recording: to its beginning or end", act: () => controls.seekBy(-Infinity) },
    { keys: ["End"], needsReplay: true, shown: "", group: "Playback", what: "", act: () => controls.seekBy(Infinity) },
    { keys: ["<"], shown: "<", group: "Playback", what: "Look back by 1 s; the run goes on", act: () => controls.seekBy(-1) },
    { keys: [">"], shown: ">", group: "Playback", what: "Forward by 1 s", act: () => controls.seekBy(1) },
    { keys: ["n"], shown: "N", group: "Playback", what: "Back to the present", act: () => controls.toNow() },
    { keys: ["["], shown: "[", group: "Playback", what: "Slower", act: () => controls.transport.nudgeSpeed(-1) },
    { keys: ["]"], shown: "]", group: "Playback", what: "Faster", act: () => controls.transport.nudgeSpeed(1) },
    { keys: ["r"], shown: "R", group: "Playback", what: "Restart with the seed in the field", act: () => controls.restartRun() },
    { keys: ["d"], shown: "D", group: "Tools", what: "Ring the bell (first button)", act: () => targets.press() },
    { keys: ["s"], shown: "S", group: "Tools", what: "Stop the robot", act: () => targets.stop() },
    { keys: ["v"], shown: "V", group: "Tools", what: "Select and pan", act: tool("select") },
    { keys: ["b"], shown: "B", group: "Tools", what: "Place a box", act: tool("place") },
    { keys: ["x"], shown: "X", group: "Tools", what: "Remove a box", act: tool("remove") },
    { keys: ["g"], shown: "G", group: "Tools", what: "Send the robot to a goal", act: tool("goal") },
    { keys: ["m"], shown: "M", group: "Tools", what: "Drive the robot by hand; then W A S D or arrows, held", act: tool("drive") },
    { keys: ["Enter"], needsMap: true, shown: "Enter", group: "Tools", what: "Use the tool at the cross", act: () => map.tools.actAtCursor() },
    { keys: ["PageUp"], needsMap: true, shown: "PgUp PgDn", group: "Tools", what: "Turn the goal's heading by 15°", act: () => map.tools.turnGoal(TURN_RAD) },
    { keys: ["PageDown"], needsMap: true, shown: "", group: "Page", what: "", act: () => map.tools.turnGoal(-TURN_RAD) },
    { keys: ["ArrowLeft", "ArrowRight", "ArrowUp", "ArrowDown"], needsMap: true, shown: "← ↑ → ↓", group: "Map", what: "Pan, or move the tool's cross (Shift: faster)", act: arrow },
    { keys: ["+", "="], shown: "+", group: "Map", what: "Zoom in", act: () => map.zoom(1.3) },
    { keys: ["-"], shown: "−", group: "Map", what: "Zoom out", act: () => map.zoom(1 / 1.3) },
    { keys: ["f"], shown: "F", group: "Map", what: "Fit the house", act: () => map.fit() },
    { keys: ["c"], shown: "C", group: "Map", what: "Follow the robot", act: () => map.setFollow(!map.follow) },
    { keys: ["l"], shown: "L", group: "Map", what: "Layers", act: () => chrome.toggleLayers() },
    { keys: DIGITS, shown: "1 – 6", group: "Page", what: "Panels, as far as the mission has them", act: (event) => targets.showDigit(Number(event.key)) },
    {
      keys: ["Escape"], shown: "Esc", group: "Page", what: "Put the tool away, close what is open",
      act: () => {
        if (map.tools.tool !== "select") map.tools.choose("select");
        else if (!chrome.closeMenus()) verdict.dismiss();
      },
    },
  ];
}
