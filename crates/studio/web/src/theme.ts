// Dark or light: the system's preference until the user chooses, then the choice, remembered.

import { remember, remembered } from "./prefs";

export type Theme = "dark" | "light";

const systemIsDark = window.matchMedia("(prefers-color-scheme: dark)");
const listeners: (() => void)[] = [];

export function currentTheme(): Theme {
  return document.documentElement.dataset["theme"] === "dark" ? "dark" : "light";
}

export function toggleTheme(): void {
  const next: Theme = currentTheme() === "dark" ? "light" : "dark";
  remember("theme", next);
  show(next);
}

/** Calls back at every change, whoever caused it. Canvases must repaint. */
export function onThemeChange(listener: () => void): void {
  listeners.push(listener);
}

/** The value of a colour token of styles/tokens.css in the current theme. */
export function token(name: string): string {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}

systemIsDark.addEventListener("change", () => {
  if (remembered("theme", "") === "") show(systemIsDark.matches ? "dark" : "light");
});

function show(theme: Theme): void {
  document.documentElement.dataset["theme"] = theme;
  for (const listener of listeners) listener();
}
