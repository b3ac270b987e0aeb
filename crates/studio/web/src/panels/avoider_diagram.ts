// The nine-state diagram of the avoider (thesis, annex C) as SVG: nodes, arrows, and a handle on each.

import { svg } from "../dom";

export const STATE_NAMES = [
  "idle", "aim at target", "rotating", "control step", "supervise", "obstacle", "rotating away", "control to detour", "supervise detour",
] as const;

/** Centre of each node: normal driving above, evasion below, clockwise. */
const PLACES: readonly (readonly [number, number])[] = [
  [42, 50], [140, 50], [238, 50], [336, 50], [434, 50], [434, 132], [336, 132], [238, 132], [140, 132],
];
const WIDTH = 78;
const HEIGHT = 40;

/** [from, to, path, label, label x, label y] */
const EDGES: readonly (readonly [number, number, string, string?, number?, number?])[] = [
  [0, 1, "M81 50H99"],
  [1, 2, "M179 50H197"],
  [2, 3, "M277 50H295"],
  [3, 4, "M375 44H393"],
  [4, 3, "M395 56H377"],
  [4, 5, "M434 70V110", "obstacle", 440, 95],
  [5, 6, "M395 126H377"],
  [6, 5, "M375 138H393"],
  [6, 7, "M297 132H279"],
  [7, 8, "M199 126H181"],
  [8, 7, "M179 138H197"],
  [8, 1, "M140 112V72", "detour reached", 134, 95],
  [7, 1, "M222 112C212 92 196 82 176 72"],
  [8, 5, "M140 152C150 174 420 174 432 154", "obstacle", 287, 182],
  [3, 1, "M330 30C316 16 164 16 148 28"],
  [4, 0, "M434 30C420 2 60 2 44 28", "arrived", 240, 4],
];

export interface Diagram {
  element: SVGSVGElement;
  nodes: Map<number, SVGGElement>;
  edges: Map<string, SVGGElement>;
}

export function edgeKey(from: number, to: number): string {
  return `${from}>${to}`;
}

export function stateDiagram(): Diagram {
  const nodes = new Map<number, SVGGElement>();
  const edges = new Map<string, SVGGElement>();
  for (const [from, to, path, text, x, y] of EDGES) {
    const group = svg("g", { class: "edge" }, svg("path", { d: path, "marker-end": "url(#arrow)" }));
    if (text && x !== undefined && y !== undefined) {
      const anchor = x === 440 ? "start" : x === 134 ? "end" : "middle";
      group.append(svg("text", { x, y, "text-anchor": anchor }, text));
    }
    edges.set(edgeKey(from, to), group);
  }
  PLACES.forEach(([x, y], state) => {
    const words = (STATE_NAMES[state] ?? "").split(" ");
    const lines = words.length > 1 ? [words.slice(0, Math.ceil(words.length / 2)).join(" "), words.slice(Math.ceil(words.length / 2)).join(" ")] : words;
    const texts = lines.map((line, index) => svg("text", { x: 7, y: index * 13 - (lines.length - 1) * 6.5 + 4 }, line));
    nodes.set(state, svg("g", { class: "node", transform: `translate(${x} ${y})`, "data-state": state },
      svg("rect", { x: -WIDTH / 2, y: -HEIGHT / 2, width: WIDTH, height: HEIGHT, rx: 9 }),
      svg("text", { x: -WIDTH / 2 + 10, y: 5, class: "state-number" }, String(state)), ...texts));
  });
  const marker = svg("marker", { id: "arrow", viewBox: "0 0 8 8", refX: 6.5, refY: 4, markerWidth: 7, markerHeight: 7, orient: "auto", markerUnits: "userSpaceOnUse" }, svg("path", { d: "M0 0.5L7.5 4L0 7.5z", class: "arrow-head" }));
  const element = svg("svg", { viewBox: "0 -8 496 194", class: "diagram", role: "img", "aria-label": "Nine-state avoider" }, svg("defs", {}, marker), ...edges.values(), ...nodes.values());
  return { element, nodes, edges };
}
