// The keys of the page, in one table: what they do, and what the help dialog says about them.

import { isTyping } from "./dom";

export interface Shortcut {
  /** `KeyboardEvent.key`, lower case for letters. */
  keys: readonly string[];
  /** How the help writes it. */
  shown: string;
  group: "Playback" | "Map" | "Tools" | "Page";
  what: string;
  /** Keys that also scroll or choose: they belong to the map only while nothing else has the focus. */
  needsMap?: boolean;
  /** Keys that mean something else where nothing is recorded. */
  needsReplay?: boolean;
  act(event: KeyboardEvent): void;
}

export function attachShortcuts(shortcuts: readonly Shortcut[], isReplay: () => boolean = () => false): void {
  window.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || event.defaultPrevented) return;
    if (isTyping(event.target)) return;
    // Space on a focused button presses that button: the browser does it.
    if ((event.key === " " || event.key === "Enter") && isPressable(event.target)) return;
    const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
    const found = shortcuts.find(({ keys, needsReplay }) => keys.includes(key) && (!needsReplay || isReplay()));
    if (!found || (found.needsMap && !isOnMap(event.target))) return;
    event.preventDefault();
    found.act(event);
  });
  // A clicked button gives the keyboard back: Space must keep meaning play and pause.
  document.addEventListener("click", (event) => {
    if (event.detail === 0 || !(event.target instanceof Element)) return;
    const button = event.target.closest("button");
    if (button && button.getAttribute("role") !== "tab") button.blur();
  });
}

function isOnMap(target: EventTarget | null): boolean {
  return target === document.body || (target instanceof Element && target.closest("#map") !== null);
}

function isPressable(target: EventTarget | null): boolean {
  // Tabs follow the arrow keys and have no use for Space.
  return target instanceof Element && target.closest("button:not([role=tab]), a, summary, input") !== null;
}
