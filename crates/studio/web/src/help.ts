// The dialog behind `?`: every shortcut, how to use touch, and which version this is.

import { h } from "./dom";
import { icon } from "./icons";
import type { Shortcut } from "./shortcuts";

const GROUPS: readonly Shortcut["group"][] = ["Playback", "Tools", "Map", "Page"];

export class Help {
  private readonly dialog = h("dialog", { class: "sheet", "aria-labelledby": "help-title" });
  private readonly about = h("p", { class: "sheet-about" });

  constructor(shortcuts: readonly Shortcut[], private readonly hello: () => { cairn: string; protocol: number } | null) {
    const close = h("button", { class: "button bare square", type: "button", "aria-label": "Close", onclick: () => this.dialog.close() }, icon("close"));
    const groups = GROUPS.filter((group) => shortcuts.some((shortcut) => shortcut.group === group)).map((group) => {
      const list = h("dl");
      for (const { shown, what } of shortcuts.filter((shortcut) => shortcut.group === group && shortcut.shown !== "")) {
        list.append(h("dt", {}, ...shown.split(" ").map((key) => h("kbd", {}, key))), h("dd", {}, what));
      }
      return h("section", {}, h("h3", {}, group), list);
    });
    this.dialog.append(h("div", { class: "sheet-head" }, h("h2", { id: "help-title" }, "Shortcuts"), close), h("div", { class: "sheet-body" }, ...groups, this.about));
    this.dialog.addEventListener("click", (event) => {
      if (event.target === this.dialog) this.dialog.close();
    });
    document.body.append(this.dialog);
  }

  open(): void {
    if (this.dialog.open) return;
    const hello = this.hello();
    const version = hello ? `Cairn ${hello.cairn}, protocol ${hello.protocol}. ` : "";
    this.about.textContent = `${version}With fingers: drag pans, two fingers zoom. Licences of the packages inside this page: /assets/third-party.txt`;
    this.dialog.showModal();
  }
}
