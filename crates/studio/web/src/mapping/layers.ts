// Which parts of the picture are shown on the mapping page; remembered, and the same for both runs.

import { h } from "../dom";
import { remember, remembered } from "../prefs";

export const LAYERS = [
  { key: "map", label: "Map", token: "var(--cell-occupied)", on: true },
  { key: "corrected", label: "Corrected way", token: "var(--map-trail)", on: true },
  { key: "odometry", label: "Odometry", token: "var(--map-estimate)", on: true },
  { key: "truth", label: "True way", token: "var(--map-goal)", on: true },
  { key: "scan", label: "Current scan", token: "var(--map-sonar-hit)", on: true },
  { key: "patch", label: "Short-term map", token: "rgb(var(--patch-cell))", on: true },
  { key: "graph", label: "Pose graph", token: "var(--map-zone)", on: true },
  { key: "closures", label: "Loop closures", token: "var(--map-preview)", on: true },
  { key: "grid", label: "Grid, 1 or 10 m", token: "var(--line-strong)", on: false },
] as const;

export type LayerKey = (typeof LAYERS)[number]["key"];
export type Layers = Record<LayerKey, boolean>;

export function rememberedLayers(): Layers {
  return Object.fromEntries(LAYERS.map(({ key, on }) => [key, remembered(`mapping.layer.${key}`, on as boolean)])) as Layers;
}

/** The list of check boxes that floats over the map; it is the legend as well. */
export function layersMenu(layers: Layers, changed: () => void): HTMLElement {
  const menu = h("div", { class: "float layers", id: "layers-menu", role: "group", "aria-label": "Layers", hidden: true }, h("h2", {}, "Layers"));
  for (const { key, label, token } of LAYERS) {
    const box = h("input", { type: "checkbox", "data-layer": key });
    box.checked = layers[key];
    box.addEventListener("change", () => {
      layers[key] = box.checked;
      remember(`mapping.layer.${key}`, box.checked);
      changed();
    });
    const swatch = h("span", { class: "swatch", "aria-hidden": "true" });
    swatch.style.background = token;
    menu.append(h("label", {}, box, label, swatch));
  }
  return menu;
}
