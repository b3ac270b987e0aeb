// Which parts of the picture are shown; the user's choice is remembered.

import { h } from "../dom";
import { remember, remembered } from "../prefs";

export const LAYERS = [
  { key: "pheromones", label: "Pheromone field", token: "rgb(var(--heat-high))", on: true },
  { key: "plan", label: "Planned path", token: "var(--map-plan)", on: true },
  { key: "trail", label: "Driven path", token: "var(--map-trail)", on: true },
  { key: "preview", label: "Scout preview", token: "var(--map-preview)", on: true },
  { key: "estimate", label: "Estimated pose", token: "var(--map-estimate)", on: true },
  { key: "sonar", label: "Sonar cones", token: "var(--map-sonar-hit)", on: true },
  { key: "bubble", label: "Sensitivity bubble", token: "var(--map-bubble)", on: true },
  { key: "zones", label: "Motion zones", token: "var(--map-zone-on)", on: true },
  { key: "names", label: "Names", token: "var(--map-room)", on: true },
  { key: "grid", label: "Grid, 1 m", token: "var(--map-grid)", on: true },
] as const;

export type LayerKey = (typeof LAYERS)[number]["key"];
export type Layers = Record<LayerKey, boolean>;

export function rememberedLayers(): Layers {
  return Object.fromEntries(LAYERS.map(({ key, on }) => [key, remembered(`layer.${key}`, on as boolean)])) as Layers;
}

/** The list of check boxes that floats over the map. */
export function layersMenu(layers: Layers, changed: () => void): HTMLElement {
  const menu = h("div", { class: "float layers", id: "layers-menu", role: "group", "aria-label": "Layers", hidden: true }, h("h2", {}, "Layers"));
  for (const { key, label, token } of LAYERS) {
    const box = h("input", { type: "checkbox", "data-layer": key });
    box.checked = layers[key];
    box.addEventListener("change", () => {
      layers[key] = box.checked;
      remember(`layer.${key}`, box.checked);
      changed();
    });
    const swatch = h("span", { class: "swatch", "aria-hidden": "true" });
    swatch.style.background = token;
    menu.append(h("label", {}, box, label, swatch));
  }
  return menu;
}
