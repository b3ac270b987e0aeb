// Every key of the mapping page and what it does; the help dialog prints this same table.

import type { Shortcut } from "../shortcuts";
import { toggleTheme } from "../theme";
import type { Transport } from "./transport";
import type { View } from "./view";

export interface ShortcutTargets {
  transport: Transport;
  view: View;
  showPanel(key: string): boolean;
  open(): void;
  help(): void;
}

const PAN_PX = 60;
const PANELS = ["now", "candidates", "parameters", "results", "file"] as const;

export function mappingShortcuts({ transport, view, showPanel, open, help }: ShortcutTargets): Shortcut[] {
  const arrow = (event: KeyboardEvent): void => {
    const right = Number(event.key === "ArrowRight") - Number(event.key === "ArrowLeft");
    const up = Number(event.key === "ArrowUp") - Number(event.key === "ArrowDown");
    view.pan(-right * PAN_PX, up * PAN_PX);
  };
  return [
    { keys: [" "], shown: "Space", group: "Playback", what: "Play or pause", act: () => transport.togglePlay() },
    { keys: ["."], shown: ".", group: "Playback", what: "One scan", act: () => transport.oneScan() },
    { keys: ["Home"], needsMap: true, shown: "Home", group: "Playback", what: "From the start", act: () => transport.toStart() },
    { keys: ["End"], needsMap: true, shown: "End", group: "Playback", what: "To the end, as fast as possible", act: () => transport.toEnd() },
    { keys: ["["], shown: "[", group: "Playback", what: "Slower", act: () => transport.nudgeSpeed(-1) },
    { keys: ["]"], shown: "]", group: "Playback", what: "Faster", act: () => transport.nudgeSpeed(1) },
    { keys: ["ArrowLeft", "ArrowRight", "ArrowUp", "ArrowDown"], needsMap: true, shown: "← ↑ → ↓", group: "Map", what: "Pan", act: arrow },
    { keys: ["+", "="], shown: "+", group: "Map", what: "Zoom in", act: () => view.zoom(1.3) },
    { keys: ["-"], shown: "−", group: "Map", what: "Zoom out", act: () => view.zoom(1 / 1.3) },
    { keys: ["f"], shown: "F", group: "Map", what: "Fit the map", act: () => view.fit() },
    { keys: ["c"], shown: "C", group: "Map", what: "Follow the robot", act: () => view.setFollow(!view.follow) },
    { keys: ["l"], shown: "L", group: "Map", what: "Layers", act: () => view.toggleLayers() },
    { keys: ["o"], shown: "O", group: "Page", what: "Open a recording", act: open },
    ...PANELS.map((key, index) => ({
      keys: [String(index + 1)], shown: index === 0 ? "1 – 5" : "", group: "Page" as const, what: index === 0 ? "Panels, from Now to File" : "", act: () => void showPanel(key),
    })),
    { keys: ["t"], shown: "T", group: "Page", what: "Dark or light", act: toggleTheme },
    { keys: ["?"], shown: "?", group: "Page", what: "This help", act: help },
    { keys: ["Escape"], shown: "Esc", group: "Page", what: "Close what is open", act: () => void view.closeMenus() },
  ];
}
