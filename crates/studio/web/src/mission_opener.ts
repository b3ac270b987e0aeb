// Opens a mission of one's own: a file is chosen (or dropped), the program reads it, and the list keeps it.

import { h } from "./dom";

const BYTES_MAX = 256 * 1024;
const HEAD_BYTES = 4096;

export class MissionOpener {
  private readonly input = h("input", { type: "file", accept: ".toml,text/plain", hidden: true, "aria-hidden": "true", id: "mission-file" });
  private readonly dialog = h("dialog", { class: "sheet mission-sheet", "aria-labelledby": "refused-title" });

  constructor(private readonly say: (text: string) => void) {
    document.body.append(this.input, this.dialog);
    this.input.addEventListener("change", () => {
      const file = this.input.files?.[0];
      this.input.value = "";
      if (file) void this.bring(file);
    });
    this.dialog.addEventListener("click", (event) => {
      if (event.target === this.dialog) this.dialog.close();
    });
    window.addEventListener("dragover", (event) => event.preventDefault());
    window.addEventListener("drop", (event) => {
      event.preventDefault();
      const file = event.dataTransfer?.files[0];
      if (file) void this.bring(file);
    });
  }

  choose(): void {
    this.input.click();
  }

  private async bring(file: File): Promise<void> {
    // Of a file that is too large the beginning tells the program what it is.
    const isLarge = file.size > BYTES_MAX;
    const query = `name=${encodeURIComponent(file.name)}${isLarge ? `&bytes=${file.size}` : ""}`;
    try {
      const answer = await fetch(`/api/mission?${query}`, { method: "POST", body: await file.slice(0, isLarge ? HEAD_BYTES : BYTES_MAX).arrayBuffer() });
      if (!answer.ok) this.refuse(file.name, await answer.text());
    } catch {
      this.say("No connection to the program: the mission was not opened.");
    }
  }

  /** The program's words as they are: with the line and a mark under what it found there. */
  private refuse(name: string, words: string): void {
    const close = h("button", { class: "button", type: "button", onclick: () => this.dialog.close() }, "Close");
    this.dialog.replaceChildren(
      h("div", { class: "sheet-head" }, h("h2", { id: "refused-title" }, `${name} cannot be opened`)),
      h("div", { class: "mission-about" }, h("pre", { class: "refusal" }, words), h("div", {}, close)),
    );
    if (!this.dialog.open) this.dialog.showModal();
  }
}
