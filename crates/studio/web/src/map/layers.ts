// Which parts of the picture are shown: the program says which there are, the user which he wants; that is remembered.

import { h } from "../dom";
import type { LayerInfo } from "../offer";
import { remember, remembered } from "../prefs";

export class Layers {
  /** The list of check boxes that floats over the map; it is the legend as well. */
  readonly menu = h("div", { class: "float layers", id: "layers-menu", role: "group", "aria-label": "Layers", hidden: true });
  private readonly shown = new Map<string, boolean>();
  private offered = "";

  /** `prefix` is before the names under which choices are remembered. */
  constructor(private readonly prefix: string, private readonly changed: () => void) {}

  /** The layers that the session has. */
  offer(layers: readonly LayerInfo[]): void {
    const offered = JSON.stringify(layers);
    if (offered === this.offered) return;
    this.offered = offered;
    this.shown.clear();
    this.menu.replaceChildren(h("h2", {}, "Layers"));
    for (const { key, label, colour, on } of layers) {
      const name = `${this.prefix}layer.${key}`;
      const box = h("input", { type: "checkbox", "data-layer": key });
      box.checked = remembered(name, on);
      this.shown.set(key, box.checked);
      box.addEventListener("change", () => {
        this.shown.set(key, box.checked);
        remember(name, box.checked);
        this.changed();
      });
      const swatch = h("span", { class: "swatch", "aria-hidden": "true" });
      swatch.style.background = colour;
      this.menu.append(h("label", {}, box, label, swatch));
    }
    this.changed();
  }

  /** Whether it is there and wanted. */
  has(key: string): boolean {
    return this.shown.get(key) ?? false;
  }
}
