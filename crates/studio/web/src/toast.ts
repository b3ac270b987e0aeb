// Short messages over the map: what the program refused, and why.

import { h } from "./dom";
import { icon } from "./icons";

const SHOWN_MS = 7000;
const N_SHOWN_MAX = 3;

export class Toasts {
  private readonly holder = h("div", { class: "toasts", role: "alert", "aria-live": "assertive" });

  constructor(view: HTMLElement) {
    view.append(this.holder);
  }

  say(text: string, tone: "info" | "bad" = "info"): void {
    for (const old of [...this.holder.children]) if (old.getAttribute("data-text") === text) old.remove();
    const toast = h("div", { class: `toast ${tone}`, "data-text": text }, h("span", {}, text));
    const close = h("button", { class: "button bare small square", type: "button", "aria-label": "Dismiss", onclick: () => toast.remove() }, icon("close"));
    toast.append(close);
    this.holder.append(toast);
    while (this.holder.children.length > N_SHOWN_MAX) this.holder.firstElementChild?.remove();
    window.setTimeout(() => toast.remove(), SHOWN_MS);
  }
}
