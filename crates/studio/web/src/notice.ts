// Over the map: loading before the first greeting, and "connection lost" until it is back.

import { h, setText } from "./dom";
import type { Session } from "./emitter";

export class Notice {
  private readonly loading = h("div", { class: "loading", role: "status" }, h("img", { src: "/assets/favicon.svg", alt: "", width: 56, height: 56 }), h("p", {}, "Waiting for Cairn…"));
  private readonly text = h("span");
  private readonly lost = h("div", { class: "float notice", role: "alert", hidden: true }, this.text);

  constructor(view: HTMLElement, private readonly store: Session, private readonly protocol: number, retry: () => void) {
    this.lost.append(h("button", { class: "button small", type: "button", onclick: retry }, "Try now"));
    view.append(this.loading, this.lost);
    store.onSession(() => {
      this.loading.hidden = store.greeting !== null;
      this.refresh();
    });
    window.setInterval(() => this.refresh(), 500);
  }

  private refresh(): void {
    const { connection, greeting } = this.store;
    if (connection.phase === "open") {
      const foreign = greeting !== null && greeting.protocol !== this.protocol;
      this.lost.hidden = !foreign;
      if (foreign) setText(this.text, `The program speaks protocol ${greeting.protocol}, this page ${this.protocol}: reload the page.`);
      return;
    }
    // The very first attempt is no loss.
    if (connection.phase === "connecting") {
      if (!this.lost.hidden) setText(this.text, "Connection lost, trying again…");
      return;
    }
    this.lost.hidden = false;
    const wait_s = Math.ceil((connection.retry_at_ms - performance.now()) / 1000);
    setText(this.text, wait_s > 1 ? `Connection lost, trying again in ${wait_s} s` : "Connection lost, trying again…");
  }
}
