// What can be taken along: the map as a picture or a drawing, the curves as numbers, all of it on one sheet.

import { h } from "./dom";
import { clock } from "./format";
import type { Hello, Point, State } from "./protocol";
import type { Store } from "./state";
import { token } from "./theme";
import type { Trail } from "./trail";

export interface Picture {
  title: string;
  canvas: HTMLCanvasElement;
}

export interface DownloadSources {
  map(): HTMLCanvasElement;
  plots(): Picture[];
  say(text: string): void;
}

/** The menu of things to download. */
export function downloadMenu(store: Store, sources: DownloadSources): HTMLElement {
  const stem = (): string => `${(store.hello?.mission.name ?? "cairn").replace(/[^\w-]+/g, "-")}-seed${store.hello?.mission.seed ?? 0}`;
  const items: readonly [string, string, () => void][] = [
    ["Map", "PNG", () => savePicture(`${stem()}-map.png`, sources.map())],
    ["Map", "SVG", () => store.hello && save(`${stem()}-map.svg`, mapSvg(store.hello, store.state, store.trails), "image/svg+xml")],
    ["Plots", "PNG", () => {
      const plots = sources.plots();
      if (plots.length === 0) sources.say("Open the panel Plots first: there is no picture of it yet.");
      else savePicture(`${stem()}-plots.png`, sheet("", plots, 2));
    }],
    ["Plots", "CSV", () => save(`${stem()}-plots.csv`, seriesCsv(store), "text/csv")],
    ["Way driven", "CSV", () => save(`${stem()}-way.csv`, wayCsv(store), "text/csv")],
    ["Screenshot of map and plots", "PNG", () => savePicture(`${stem()}.png`, sheet(heading(store), [{ title: "", canvas: sources.map() }, ...sources.plots()], 2))],
  ];
  const menu = h("div", { class: "float layers downloads", id: "downloads-menu", role: "group", "aria-label": "Downloads", hidden: true }, h("h2", {}, "Download"));
  for (const [what, kind, act] of items) menu.append(h("button", { class: "button bare small", type: "button", onclick: act }, what, h("span", { class: "unit" }, kind)));
  return menu;
}

function save(name: string, text: string, type: string): void {
  saveBlob(name, new Blob([text], { type }));
}

function savePicture(name: string, canvas: HTMLCanvasElement): void {
  canvas.toBlob((blob) => blob && saveBlob(name, blob), "image/png");
}

function saveBlob(name: string, blob: Blob): void {
  const url = URL.createObjectURL(blob);
  h("a", { href: url, download: name }).click();
  window.setTimeout(() => URL.revokeObjectURL(url), 10_000);
}

function heading(store: Store): string {
  const { hello, state } = store;
  const verdict = state?.verdict ? `, ${state.verdict.passed ? "passed" : `failed: ${state.verdict.text}`}` : "";
  return hello && state ? `${hello.mission.title}, seed ${hello.mission.seed}, ${clock(state.t_s)}${verdict}` : "";
}

/** Pictures on one sheet: the first as it is, the others beside it, in a column if there are many. */
function sheet(title: string, pictures: readonly Picture[], n_columns: number): HTMLCanvasElement {
  const canvas = document.createElement("canvas");
  const density = window.devicePixelRatio || 1;
  const first = title === "" ? undefined : pictures[0];
  const rest = first ? pictures.slice(1) : [...pictures];
  const [gap, head, caption] = [12 * density, title === "" ? 0 : 34 * density, 20 * density];
  const cell = { width: Math.max(0, ...rest.map((p) => p.canvas.width)), height: Math.max(0, ...rest.map((p) => p.canvas.height)) + caption };
  const columns = first ? 1 : Math.min(n_columns, rest.length);
  const rows = Math.ceil(rest.length / Math.max(1, columns));
  const left = first ? first.canvas.width + 2 * gap : gap;
  canvas.width = left + (rest.length > 0 ? columns * (cell.width + gap) : 0);
  canvas.height = head + gap + Math.max(first?.canvas.height ?? 0, rows * (cell.height + gap)) + gap;
  const context = canvas.getContext("2d");
  if (!context) return canvas;
  context.fillStyle = token("--surface");
  context.fillRect(0, 0, canvas.width, canvas.height);
  context.fillStyle = token("--ink");
  context.textBaseline = "middle";
  context.font = `600 ${16 * density}px ${token("--font")}`;
  context.fillText(title, gap, head / 2 + gap / 2);
  if (first) context.drawImage(first.canvas, gap, head + gap);
  context.font = `600 ${12 * density}px ${token("--font")}`;
  rest.forEach((picture, index) => {
    const x = left + (index % columns) * (cell.width + gap);
    const y = head + gap + Math.floor(index / columns) * (cell.height + gap);
    context.fillText(picture.title, x + 6 * density, y + caption / 2);
    context.drawImage(picture.canvas, x, y + caption);
  });
  return canvas;
}

function seriesCsv({ series, hello }: Store): string {
  const ids = (hello?.robot_signals ?? []).filter(({ curve }) => curve).map(({ id }) => id);
  const rows = series.t_s.map((t_s, row) => [t_s.toFixed(2), ...ids.map((id) => series.columns.get(id)?.[row]?.toFixed(4) ?? "")]);
  return csv([["t_s", ...ids], ...rows]);
}

function wayCsv(store: Store): string {
  const rows: string[][] = [["robot", "t_s", "x_m", "y_m"]];
  for (const [id, { truth }] of store.trails) {
    const name = store.hello?.robots.find((robot) => robot.id === id)?.name ?? String(id);
    for (const { t_s, x_m, y_m } of truth.points) rows.push([quoted(name), t_s.toFixed(2), x_m.toFixed(3), y_m.toFixed(3)]);
  }
  return csv(rows);
}

function quoted(text: string): string {
  return /[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
}

function csv(rows: readonly (readonly string[])[]): string {
  return rows.map((row) => `${row.join(",")}\n`).join("");
}

const DRAWING_PX_PER_M = 60;

/** The map as a drawing to scale: 1 m is 60 units, and metres stand in its comment. */
export function mapSvg(hello: Hello, state: State | null, trails: ReadonlyMap<number, { truth: Trail }>): string {
  const [x0, y0, x1, y1] = hello.world.bounds_m;
  const k = DRAWING_PX_PER_M;
  const at = ([x, y]: readonly [number, number]): string => `${((x - x0) * k).toFixed(1)},${((y1 - y) * k).toFixed(1)}`;
  const line = (points: readonly Point[], style: string): string => (points.length > 1 ? `<polyline points="${points.map(at).join(" ")}" fill="none" ${style}/>` : "");
  const area = (points: readonly Point[], style: string): string => `<polygon points="${points.map(at).join(" ")}" ${style}/>`;
  const parts = [
    `<rect width="${(x1 - x0) * k}" height="${(y1 - y0) * k}" fill="#fff"/>`,
    ...[...hello.world.things, ...(state?.things ?? [])].map(({ corners_m, kind }) => area(corners_m, `fill="${kind === "box" ? "#d9a566" : "#e3e6ea"}" stroke="#8b939c"`)),
    ...hello.world.walls.map(([ax, ay, bx, by]) => line([[ax, ay], [bx, by]], 'stroke="#22272e" stroke-width="4" stroke-linecap="round"')),
    ...hello.world.points.map((point) => `<circle cx="${at(point).split(",")[0]}" cy="${at(point).split(",")[1]}" r="1.5" fill="#22272e"/>`),
    ...hello.world.rooms.map(({ name, at_m }) => text(at(at_m), name)),
    line(hello.planned_path_m, 'stroke="#1a7f4b" stroke-width="2" stroke-dasharray="2 7"'),
    ...[...trails.values()].map(({ truth }) => line(truth.points.map(({ x_m, y_m }): Point => [x_m, y_m]), 'stroke="#c62828" stroke-width="2.5"')),
  ];
  for (const robot of state?.robots ?? []) {
    const info = hello.robots.find(({ id }) => id === robot.id);
    if (!info) continue;
    const [x, y, yaw] = robot.truth;
    const [c, s] = [Math.cos(yaw), Math.sin(yaw)];
    parts.push(area(info.footprint_m.map(([px, py]): Point => [x + c * px - s * py, y + s * px + c * py]), 'fill="#e8710a" stroke="#5c2d00"'));
    parts.push(line([[x, y], [x + 0.35 * c, y + 0.35 * s]], 'stroke="#5c2d00" stroke-width="3"'));
    if (robot.goal) parts.push(`<circle cx="${at([robot.goal[0], robot.goal[1]]).split(",")[0]}" cy="${at([robot.goal[0], robot.goal[1]]).split(",")[1]}" r="${((robot.goal_tolerance_m ?? 0.3) * k).toFixed(1)}" fill="none" stroke="#1a7f4b" stroke-width="2"/>`);
  }
  const size = `width="${((x1 - x0) * k).toFixed(0)}" height="${((y1 - y0) * k).toFixed(0)}" viewBox="0 0 ${((x1 - x0) * k).toFixed(1)} ${((y1 - y0) * k).toFixed(1)}"`;
  return `<svg xmlns="http://www.w3.org/2000/svg" ${size}>\n<!-- ${k} units are a metre; the lower left corner is (${x0}, ${y0}) m -->\n${parts.filter((part) => part !== "").join("\n")}\n</svg>\n`;
}

function text(at: string, words: string): string {
  const escaped = words.replaceAll("&", "&amp;").replaceAll("<", "&lt;");
  const [x, y] = at.split(",");
  return `<text x="${x}" y="${y}" font-family="sans-serif" font-size="15" fill="#5a626b" text-anchor="middle">${escaped}</text>`;
}
