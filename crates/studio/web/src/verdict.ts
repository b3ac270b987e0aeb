// The verdict over the map: passed or failed, with every check, until it is dismissed or the run restarts.

import { h, setAttribute } from "./dom";
import { icon } from "./icons";
import type { Verdict } from "./protocol";
import type { Store } from "./state";

export class VerdictBanner {
  private readonly element = h("section", { class: "float verdict", role: "status", "aria-label": "Verdict", hidden: true });
  private shown = "";
  private dismissed = false;

  constructor(view: HTMLElement, store: Store, private readonly restart: () => void) {
    view.append(this.element);
    store.on("state", ({ verdict }) => this.update(verdict));
    store.on("reset", () => {
      this.dismissed = false;
      this.update(null);
    });
  }

  /** True when Escape had something to dismiss. */
  dismiss(): boolean {
    if (this.element.hidden) return false;
    this.dismissed = true;
    this.element.hidden = true;
    return true;
  }

  show(): void {
    this.dismissed = false;
    if (this.shown !== "") this.element.hidden = false;
  }

  private update(verdict: Verdict | null): void {
    const key = verdict ? JSON.stringify(verdict) : "";
    if (key === this.shown) return;
    this.shown = key;
    this.element.hidden = verdict === null || this.dismissed;
    if (verdict) this.fill(verdict);
  }

  private fill(verdict: Verdict): void {
    this.element.classList.toggle("failed", !verdict.passed);
    setAttribute(this.element, "data-verdict", verdict.passed ? "passed" : "failed");
    const checks = verdict.checks.map((check) =>
      h("li", { class: check.passed ? "" : "failed" },
        icon(check.passed ? "check" : "cross"),
        h("div", {}, h("span", { class: "name" }, readable(check.name)), h("span", { class: "visually-hidden" }, check.passed ? " passed: " : " failed: "), " ", h("span", { class: "told" }, check.text))));
    this.element.replaceChildren(
      h("div", { class: "head" },
        icon(verdict.passed ? "check" : "cross"),
        h("h2", {}, verdict.passed ? "Mission passed" : "Mission failed"),
        h("button", { class: "button bare small square", type: "button", "aria-label": "Dismiss the verdict", title: "Dismiss (Esc)", onclick: () => this.dismiss() }, icon("close"))),
      h("p", { class: "text" }, verdict.text),
      h("ul", {}, ...checks),
      h("div", { class: "actions" }, h("button", { class: "button small", type: "button", onclick: this.restart }, icon("restart"), "Run again")),
    );
  }
}

function readable(name: string): string {
  const words = name.replaceAll("_", " ");
  return words.charAt(0).toUpperCase() + words.slice(1);
}
