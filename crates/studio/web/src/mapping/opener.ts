// How a recording comes to the page: chosen, dropped, or a sample; and what the map's place shows without one.

import { h, setText } from "../dom";
import { icon } from "../icons";
import type { Request, Sample } from "./protocol";
import type { Store } from "./store";

export interface OpenerEvents {
  send(request: Request): boolean;
  say(text: string, tone?: "info" | "bad"): void;
}

interface FileField {
  element: HTMLElement;
  file(): File | null;
  say(text: string): void;
}

export class Opener {
  private readonly dialog = h("dialog", { class: "sheet", "aria-labelledby": "open-title" });
  private readonly log = fileField("log", "Log", "", true);
  private readonly poses = fileField("poses", "Poses", "", false);
  private readonly truth = fileField("truth", "True poses", "lines of t x y yaw, to judge the result by", false);
  private readonly go = h("button", { class: "button primary", type: "submit" }, "Read");
  private readonly samples = h("ul", { class: "samples" });
  private readonly cover = h("div", { class: "cover", hidden: true });
  private readonly drop = h("div", { class: "drop-hint", hidden: true }, icon("open"), h("strong", {}, "Drop the log to map it"));
  /** Bytes are on their way to the program. */
  private sending = "";

  constructor(view: HTMLElement, private readonly store: Store, private readonly events: OpenerEvents) {
    this.buildDialog();
    view.append(this.cover, this.drop);
    this.attachDrop();
    for (const event of ["hello", "source", "connection", "state"] as const) store.on(event, () => this.refresh());
    store.on("hello", ({ formats }) => {
      this.log.say(`${listed(formats.map(({ name }) => name))}, each also as gzip`);
      this.poses.say(`only for formats of two files: ${formats.filter(({ second }) => second).map(({ name }) => name).join(", ")}`);
    });
    store.on("hello", (hello) => this.samples.replaceChildren(...hello.samples.map((sample) => this.sampleItem(sample, () => this.closeDialog()))));
    this.refresh();
  }

  open(): void {
    if (!this.dialog.open) this.dialog.showModal();
  }

  private buildDialog(): void {
    const form = h("form", { class: "open-form", method: "dialog" }, this.log.element, this.poses.element, this.truth.element, h("div", { class: "actions" }, this.go));
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      const file = this.log.file();
      if (!file) return;
      this.closeDialog();
      void this.bring(file, this.poses.file(), this.truth.file());
    });
    const close = h("button", { class: "button bare square", type: "button", "aria-label": "Close", onclick: () => this.dialog.close() }, icon("close"));
    this.dialog.append(
      h("div", { class: "sheet-head" }, h("h2", { id: "open-title" }, "Open a recording"), close),
      h("div", { class: "sheet-body open-body" },
        h("section", {}, h("h3", {}, "A log on this computer"), form),
        h("section", {}, h("h3", {}, "Or a sample, made on the spot"), this.samples)),
    );
    this.dialog.addEventListener("click", (event) => {
      if (event.target === this.dialog) this.dialog.close();
    });
    document.body.append(this.dialog);
  }

  /** What was opened plays: the keys, Space above all, belong to it and not to the button behind the dialog. */
  private closeDialog(): void {
    this.dialog.close();
    if (document.activeElement instanceof HTMLElement) document.activeElement.blur();
  }

  private sampleItem({ name, title, about }: Sample, chosen: () => void): HTMLElement {
    const choose = (): void => {
      chosen();
      this.events.send({ type: "sample", name });
    };
    return h("li", {}, h("button", { class: "sample", type: "button", "data-sample": name, onclick: choose }, h("strong", {}, title), h("span", {}, about)));
  }

  /** Sends the files in one body: the log, then the others. */
  private async bring(log: File, poses: File | null, truth: File | null): Promise<void> {
    const files = [log, poses, truth].filter((file): file is File => file !== null);
    const max_bytes = this.store.hello?.upload_max_bytes ?? Infinity;
    if (files.reduce((sum, { size }) => sum + size, 0) > max_bytes) {
      const limit = Math.floor(max_bytes / 2 ** 20);
      return this.events.say(`${log.name}: the page can bring at most ${limit} MB. Start the program with it instead: cairn map FILE --show`, "bad");
    }
    const query = new URLSearchParams({ name: log.name, poses_bytes: String(poses?.size ?? 0), truth_bytes: String(truth?.size ?? 0) });
    this.sending = log.name;
    this.refresh();
    try {
      const answer = await fetch(`/map/recording?${query}`, { method: "POST", headers: { "content-type": "application/octet-stream" }, body: new Blob(files) });
      // What could not be read stands in the source, for every page; what never got there is said here.
      if (!answer.ok && answer.status !== 422) this.events.say(await answer.text(), "bad");
    } catch {
      this.events.say(`${log.name} could not be sent: no connection to the program.`, "bad");
    } finally {
      this.sending = "";
      this.refresh();
    }
  }

  private attachDrop(): void {
    let n_inside = 0;
    const hasFiles = (event: DragEvent): boolean => event.dataTransfer?.types.includes("Files") ?? false;
    window.addEventListener("dragenter", (event) => {
      if (!hasFiles(event)) return;
      n_inside += 1;
      this.drop.hidden = false;
    });
    window.addEventListener("dragleave", (event) => {
      if (!hasFiles(event)) return;
      n_inside -= 1;
      this.drop.hidden = n_inside <= 0;
    });
    window.addEventListener("dragover", (event) => {
      if (hasFiles(event)) event.preventDefault();
    });
    window.addEventListener("drop", (event) => {
      if (!hasFiles(event)) return;
      event.preventDefault();
      n_inside = 0;
      this.drop.hidden = true;
      const file = event.dataTransfer?.files[0];
      if (file) void this.bring(file, null, null);
    });
  }

  /** The map's place: loading, why a log could not be read, how to begin, or nothing when there is a map. */
  private refresh(): void {
    const { source, hello, state } = this.store;
    const reading = this.sending !== "" || source?.phase === "reading";
    const key = !hello ? "waiting" : reading ? `reading ${this.sending || source?.name}` : source?.problem ? `problem ${source.problem}` : source?.phase === "ready" && state?.runs.length ? "" : "empty";
    if (this.cover.dataset["key"] === key) return;
    this.cover.dataset["key"] = key;
    this.cover.hidden = key === "";
    this.cover.classList.toggle("over-map", (state?.runs.length ?? 0) > 0);
    if (key === "waiting") this.cover.replaceChildren(loading("Waiting for Cairn…"));
    else if (reading) this.cover.replaceChildren(loading(`${this.sending ? "Sending" : "Reading"} ${this.sending || source?.name}…`));
    else if (source?.problem) this.cover.replaceChildren(this.problem(source.problem));
    else if (key === "empty") this.cover.replaceChildren(this.welcome());
  }

  private problem(text: string): HTMLElement {
    const back = h("button", { class: "button", type: "button" }, "Back to the map");
    back.addEventListener("click", () => (this.cover.hidden = true));
    const hasMap = (this.store.state?.runs.length ?? 0) > 0;
    return h("div", { class: "card problem", role: "alert" },
      h("h2", {}, icon("cross"), "This recording cannot be mapped"), h("p", { class: "told" }, text),
      h("div", { class: "actions" }, h("button", { class: "button primary", type: "button", onclick: () => this.open() }, icon("open"), "Open another…"), hasMap ? back : null));
  }

  private welcome(): HTMLElement {
    const list = h("ul", { class: "samples" }, ...(this.store.hello?.samples ?? []).map((sample) => this.sampleItem(sample, () => {})));
    return h("div", { class: "card welcome" },
      h("h2", {}, "From a recording to a map"),
      h("p", {}, "Drop a log of ranges and odometry here, or choose one. It stays on this computer."),
      h("div", { class: "actions" }, h("button", { class: "button primary", type: "button", onclick: () => this.open() }, icon("open"), "Open a log…")),
      h("h3", {}, "No log at hand? Simulated recordings, made on the spot:"), list);
  }
}

function loading(text: string): HTMLElement {
  return h("div", { class: "loading-text", role: "status" }, h("img", { src: "/assets/favicon.svg", alt: "", width: 56, height: 56 }), h("p", {}, text));
}

function fileField(name: string, title: string, about: string, required: boolean): FileField {
  const input = h("input", { type: "file", id: `file-${name}`, name, required, "aria-describedby": `file-${name}-about` });
  const said = h("p", { id: `file-${name}-about` }, about);
  const element = h("div", { class: "file-field" },
    h("label", { for: `file-${name}` }, title, required ? null : h("span", { class: "optional" }, " (if there are)")), input, said);
  return { element, file: () => input.files?.[0] ?? null, say: (text) => setText(said, text) };
}

/** `a, b or c`. */
function listed(words: readonly string[]): string {
  return words.length < 2 ? words.join("") : `${words.slice(0, -1).join(", ")} or ${words.at(-1)}`;
}
