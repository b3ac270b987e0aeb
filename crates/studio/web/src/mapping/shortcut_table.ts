// Every key of the mapping page and what it does; the help dialog prints this same table.

import type { Shortcut } from "../shortcuts";
import type { SurveyTransport } from "./transport";
import type { View } from "./view";

export interface ShortcutTargets {
  transport: SurveyTransport;
  view: View;
  showDigit(digit: number): void;
  open(): void;
}

const PAN_PX = 60;
const DIGITS = ["1", "2", "3", "4", "5", "6", "7", "8", "9"] as const;

export function mappingShortcuts({ transport, view, showDigit, open }: ShortcutTargets): Shortcut[] {
  const arrow = (event: KeyboardEvent): void => {
    const right = Number(event.key === "ArrowRight") - Number(event.key === "ArrowLeft");
    const up = Number(event.key === "ArrowUp") - Number(event.key === "ArrowDown");
    view.pan(-right * PAN_PX, up * PAN_PX);
  };
  return [
    { keys: [" "], shown: "Space", group: "Playback", what: "Play or pause", act: () => transport.bar.togglePlay() },
    { keys: ["."], shown: ".", group: "Playback", what: "One scan", act: () => transport.bar.oneStep() },
    { keys: ["Home"], needsMap: true, shown: "Home", group: "Playback", what: "From the start", act: () => transport.toStart() },
    { keys: ["End"], needsMap: true, shown: "End", group: "Playback", what: "To the end, as fast as possible", act: () => transport.toEnd() },
    { keys: ["["], shown: "[", group: "Playback", what: "Slower", act: () => transport.bar.nudgeSpeed(-1) },
    { keys: ["]"], shown: "]", group: "Playback", what: "Faster", act: () => transport.bar.nudgeSpeed(1) },
    { keys: ["ArrowLeft", "ArrowRight", "ArrowUp", "ArrowDown"], needsMap: true, shown: "← ↑ → ↓", group: "Map", what: "Pan", act: arrow },
    { keys: ["+", "="], shown: "+", group: "Map", what: "Zoom in", act: () => view.zoom(1.3) },
    { keys: ["-"], shown: "−", group: "Map", what: "Zoom out", act: () => view.zoom(1 / 1.3) },
    { keys: ["f"], shown: "F", group: "Map", what: "Fit the map", act: () => view.fit() },
    { keys: ["c"], shown: "C", group: "Map", what: "Follow the robot", act: () => view.setFollow(!view.follow) },
    { keys: ["l"], shown: "L", group: "Map", what: "Layers", act: () => view.toggleLayers() },
    { keys: ["o"], shown: "O", group: "Page", what: "Open a recording", act: open },
    { keys: DIGITS, shown: "1 – 5", group: "Page", what: "Panels, as far as the recording has them", act: (event) => showDigit(Number(event.key)) },
    { keys: ["Escape"], shown: "Esc", group: "Page", what: "Close what is open", act: () => void view.closeMenus() },
  ];
}
