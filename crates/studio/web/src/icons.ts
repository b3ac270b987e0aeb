// The icons of the page, drawn as 20 × 20 strokes so that they take the colour of their text.

import { svg } from "./dom";

export const PATHS = {
  play: "M6.5 4.2v11.6l9-5.8z",
  pause: "M6.5 4.5v11M13.5 4.5v11",
  step: "M5 4.5v11l7.5-5.5zM15.5 4.5v11",
  restart: "M4.5 10a5.5 5.5 0 1 0 1.8-4.1M4.2 3.6v3.2h3.2",
  pan: "M4 3.5l4.6 12.2 1.9-5.2 5.2-1.9z",
  box: "M10 3l6 3.2v7.4L10 17l-6-3.4V6.2zM4 6.2l6 3.4 6-3.4M10 9.6V17",
  remove: "M5 6h10M8.2 6V4.4h3.6V6M6 6l.7 9.6h6.6L14 6M8.6 8.8v4M11.4 8.8v4",
  goal: "M5.5 17V3.5M5.5 4h9l-2.3 3 2.3 3h-9",
  bell: "M5 14h10l-1.3-2V9a3.7 3.7 0 0 0-7.4 0v3zM8.6 16a1.6 1.6 0 0 0 2.8 0",
  motion: "M10 15.5a1.2 1.2 0 1 0 0-.1M6.8 11.6a4.6 4.6 0 0 1 6.4 0M4.4 8.6a8 8 0 0 1 11.2 0",
  latch: "M5.5 9h9v7h-9zM7.3 9V6.6a2.7 2.7 0 0 1 5.4 0V9",
  lamp: "M7.6 13.2a4.6 4.6 0 1 1 4.8 0v1.6H7.6zM8.4 17h3.2",
  fit: "M4 8V4h4M12 4h4v4M16 12v4h-4M8 16H4v-4",
  follow: "M10 6.5a3.5 3.5 0 1 0 .01 0M10 2.5v3M10 14.5v3M2.5 10h3M14.5 10h3",
  layers: "M10 3.5l7 3.6-7 3.6-7-3.6zM3.4 10.4l6.6 3.4 6.6-3.4M3.4 13.4l6.6 3.4 6.6-3.4",
  moon: "M15.5 11.8A6 6 0 0 1 8.2 4.5a6 6 0 1 0 7.3 7.3z",
  sun: "M10 7a3 3 0 1 0 .01 0M10 2.5v1.6M10 15.9v1.6M2.5 10h1.6M15.9 10h1.6M4.7 4.7l1.1 1.1M14.2 14.2l1.1 1.1M4.7 15.3l1.1-1.1M14.2 5.8l1.1-1.1",
  help: "M7.4 7.6A2.6 2.6 0 1 1 10 10.4v1.8M10 14.9v.3",
  close: "M5.5 5.5l9 9M14.5 5.5l-9 9",
  check: "M4.5 10.5l3.6 3.6 7.4-8",
  cross: "M6 6l8 8M14 6l-8 8",
  stop: "M5.5 5.5h9v9h-9z",
  open: "M3.5 15.5v-10h4.6l1.6 2h6.8v8z",
  start: "M5 4.5v11M15 4.5v11l-7.5-5.5z",
  end: "M16 4.5v11M3.5 4.8v10.4l5.2-5.2zM9.5 4.8v10.4l5.2-5.2z",
  pin: "M7 3.5h6l-.8 5 2.3 2.5h-9l2.3-2.5zM10 11v5.5",
  compare: "M3.5 4.5h5.5v11H3.5zM11 4.5h5.5v11H11z",
  robot: "M5 8h10v7H5zM10 8V5M8 4.5h4M8 11.5h.1M12 11.5h.1",
  drive: "M5.5 6.5h9a3 3 0 0 1 3 3.2l-.4 3.4a2 2 0 0 1-3.6.9l-.9-1.3H7.4l-.9 1.3a2 2 0 0 1-3.6-.9l-.4-3.4a3 3 0 0 1 3-3.2zM6.5 8.4v3M5 9.9h3M13.2 9h.1M14.6 10.6h.1",
  download: "M10 3.5v9M6.2 9l3.8 3.8L13.8 9M4 16.5h12",
  info: "M10 3.4a6.6 6.6 0 1 0 .01 0M10 9.2v4.4M10 6.4v.2",
  plus: "M10 4.5v11M4.5 10h11",
  minus: "M4.5 10h11",
} as const;

export type IconName = keyof typeof PATHS;

const FILLED: ReadonlySet<IconName> = new Set<IconName>(["play", "stop"]);

/** A decorative icon: the control around it must carry the label. */
export function icon(name: IconName): SVGSVGElement {
  const path = svg("path", { d: PATHS[name], fill: FILLED.has(name) ? "currentColor" : "none" });
  return svg("svg", { viewBox: "0 0 20 20", class: "icon", "aria-hidden": "true", focusable: "false" }, path);
}

/** Replaces the icon inside a control. */
export function swapIcon(holder: Element, name: IconName): void {
  if (holder.getAttribute("data-icon") === name) return;
  holder.setAttribute("data-icon", name);
  holder.querySelector("svg.icon")?.replaceWith(icon(name));
}
