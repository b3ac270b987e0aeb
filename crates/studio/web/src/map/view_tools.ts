// What stands at the foot of every map: zoom, fit, follow, layers, scale, and where the pointer is.

import { h, setText } from "../dom";
import { coordinate } from "../format";
import { icon, type IconName } from "../icons";
import { scaleBar } from "./camera";
import type { Layers } from "./layers";

const SCALE_BAR_MAX_PX = 110;

export interface ViewActions {
  zoom(factor: number): void;
  fit(): void;
  toggleFollow(): void;
}

interface Menu {
  button: HTMLButtonElement;
  element: HTMLElement;
}

export class ViewTools {
  readonly buttons: HTMLElement;
  readonly scale: HTMLElement;
  private readonly at = h("span", { class: "readout at", hidden: true });
  private readonly bar = h("div", { class: "bar" });
  private readonly label = h("span");
  private readonly follow: HTMLButtonElement;
  private readonly menus: Menu[] = [];

  /** `extra` are more menus behind buttons of their own. */
  constructor(what: string, actions: ViewActions, layers: Layers, extra: readonly { icon: IconName; title: string; menu: HTMLElement }[] = []) {
    this.follow = button("follow", "Follow the robot (C)", () => actions.toggleFollow());
    this.follow.setAttribute("aria-pressed", "false");
    const menus = [{ icon: "layers" as const, title: "Layers (L)", menu: layers.menu }, ...extra];
    this.buttons = h("div", { class: "view-tools", role: "toolbar", "aria-label": "View" },
      button("minus", "Zoom out (−)", () => actions.zoom(1 / 1.3)),
      button("plus", "Zoom in (+)", () => actions.zoom(1.3)),
      button("fit", `Fit the ${what} (F)`, () => actions.fit()),
      this.follow, ...menus.map((menu) => this.menuButton(menu.icon, menu.title, menu.menu)));
    this.scale = h("div", { class: "scale" }, this.at, this.label, this.bar);
    document.addEventListener("pointerdown", (event) => {
      for (const menu of this.menus) {
        const inside = event.target instanceof Node && (menu.element.contains(event.target) || menu.button.contains(event.target));
        if (!inside && !menu.element.hidden) this.toggle(menu);
      }
    });
  }

  toggleLayers(): void {
    const layers = this.menus[0];
    if (layers) this.toggle(layers);
  }

  /** True when there was a menu to close. */
  closeMenus(): boolean {
    const open = this.menus.find(({ element }) => !element.hidden);
    if (!open) return false;
    this.toggle(open);
    open.button.focus();
    return true;
  }

  showFollow(follow: boolean): void {
    this.follow.setAttribute("aria-pressed", String(follow));
  }

  showScale(scale_pxpm: number): void {
    const { label, length_px } = scaleBar(scale_pxpm, SCALE_BAR_MAX_PX);
    this.bar.style.width = `${length_px.toFixed(1)}px`;
    setText(this.label, label);
  }

  /** Where the pointer is, and what is there. */
  showPlace(at_m: readonly [number, number] | null, what = ""): void {
    this.at.hidden = at_m === null;
    setText(this.at, at_m ? `${coordinate(at_m[0])}, ${coordinate(at_m[1])} m${what ? ` · ${what}` : ""}` : "");
  }

  private menuButton(name: IconName, title: string, element: HTMLElement): HTMLButtonElement {
    const menu: Menu = { element, button: button(name, title, () => this.toggle(menu)) };
    menu.button.setAttribute("aria-expanded", "false");
    menu.button.setAttribute("aria-controls", element.id);
    element.addEventListener("click", (event) => {
      // A button in a menu does its work and is done; boxes stay to be ticked.
      if (event.target instanceof Element && event.target.closest("button")) this.toggle(menu);
    });
    this.menus.push(menu);
    return menu.button;
  }

  private toggle({ button, element }: Menu): void {
    element.hidden = !element.hidden;
    button.setAttribute("aria-expanded", String(!element.hidden));
    if (!element.hidden) element.querySelector<HTMLElement>("input, button")?.focus();
    else if (element.contains(document.activeElement)) button.focus();
  }
}

function button(name: IconName, title: string, act: () => void): HTMLButtonElement {
  return h("button", { class: "button square", type: "button", "aria-label": title.replace(/ \(.*\)$/, ""), title, onclick: act }, icon(name));
}
