// What a panel shows when it has nothing to show, and why.

import { h } from "../dom";

export function emptyState(title: string, text: string): HTMLElement {
  return h("div", { class: "empty" }, h("strong", {}, title), h("p", {}, text));
}
