// Over the map: loading before the first hello, and "connection lost" until it is back.

import { h, setText } from "./dom";
import { PROTOCOL_VERSION } from "./protocol";
import type { Store } from "./state";

export class Notice {
  private readonly loading = h("div", { class: "loading", role: "status" }, h("img", { src: "/assets/favicon.svg", alt: "", width: 56, height: 56 }), h("p", {}, "Waiting for Cairn…"));
  private readonly text = h("span");
  private readonly lost = h("div", { class: "float notice", role: "alert", hidden: true }, this.text);

  constructor(view: HTMLElement, private readonly store: Store, retry: () => void) {
    this.lost.append(h("button", { class: "button small", type: "button", onclick: retry }, "Try now"));
    view.append(this.loading, this.lost);
    store.on("hello", () => {
      this.loading.hidden = true;
      this.refresh();
    });
    store.on("connection", () => this.refresh());
    window.setInterval(() => this.refresh(), 500);
  }

  private refresh(): void {
    const { connection, hello } = this.store;
    if (connection.phase === "open") {
      const foreign = hello !== null && hello.protocol !== PROTOCOL_VERSION;
      this.lost.hidden = !foreign;
      if (foreign) setText(this.text, `The program speaks protocol ${hello.protocol}, this page ${PROTOCOL_VERSION}: reload the page.`);
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
