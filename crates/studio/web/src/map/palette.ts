// The map's colours, read once per theme from styles/tokens.css.

import { token } from "../theme";

const NAMES = [
  "void", "floor", "grid", "wall", "thing", "thing-line", "thing-text", "box", "box-line", "room", "device", "device-on",
  "zone", "zone-on", "person", "robot", "robot-line", "estimate", "trail", "plan", "preview", "goal", "target",
  "sonar-hit", "sonar-none", "bubble", "laser", "tag",
] as const;

type ColourName = (typeof NAMES)[number];

export interface Palette {
  colour: Record<ColourName, string>;
  surface: string;
  ink: string;
  muted: string;
  accent: string;
  onAccent: string;
  bad: string;
  good: string;
  heatLow: [number, number, number];
  heatHigh: [number, number, number];
  font: string;
}

export function readPalette(): Palette {
  const colour = Object.fromEntries(NAMES.map((name) => [name, token(`--map-${name}`)])) as Record<ColourName, string>;
  return {
    colour,
    surface: token("--surface"),
    ink: token("--ink"),
    muted: token("--muted"),
    accent: token("--accent"),
    onAccent: token("--on-accent"),
    bad: token("--bad"),
    good: token("--good"),
    heatLow: rgb(token("--heat-low")),
    heatHigh: rgb(token("--heat-high")),
    font: token("--font"),
  };
}

function rgb(text: string): [number, number, number] {
  const [red = 0, green = 0, blue = 0] = text.split(/\s+/).map(Number);
  return [red, green, blue];
}
