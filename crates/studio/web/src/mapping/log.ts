// The panel about the file: what it is, and what was wrong in it with line numbers and what was done.

import { h, setText } from "../dom";
import { clock } from "../format";
import { emptyState } from "../panels/empty";
import type { Store } from "./store";

export class LogPanel {
  readonly element = h("div", { class: "file-log" });
  private readonly empty = emptyState("No recording yet", "What was wrong in a log, at which line, and what was done about it, stands here.");
  private readonly body = h("div", { class: "file-log-body", hidden: true });

  /** How many complaints there are. */
  readonly count = h("span", { class: "tab-count", hidden: true });

  constructor(private readonly store: Store) {
    this.element.append(this.empty, this.body);
    store.on("source", () => this.refresh());
  }

  private refresh(): void {
    const info = this.store.source?.recording;
    this.empty.hidden = info != null;
    this.body.hidden = info == null;
    const n_complaints = info?.n_complaints ?? 0;
    this.count.hidden = n_complaints === 0;
    setText(this.count, String(n_complaints));
    if (!info) return;
    const fact = (name: string, text: string): HTMLElement => h("div", {}, h("dt", {}, name), h("dd", {}, text));
    this.body.replaceChildren(
      h("dl", { class: "facts" },
        fact("Format", info.format), fact("Sensor", info.rig === "laser" ? `laser, ${info.n_readings} beams` : `${info.n_readings} sonars`),
        fact("Scans", String(info.n_scans)), fact("Duration", clock(info.duration_s)), fact("Driven", `${info.path_length_m.toFixed(1)} m by odometry`),
        fact("Truth", info.has_truth ? "in the recording" : "not known")),
      info.n_complaints === 0
        ? h("p", { class: "fine" }, "Nothing was wrong in the file.")
        : h("section", {},
            h("h3", {}, `${info.n_complaints} ${info.n_complaints === 1 ? "thing was" : "things were"} wrong in the file`),
            h("ul", { class: "complaint-counts" }, ...info.complaint_counts.map((text) => h("li", {}, text))),
            h("ol", { class: "complaints" }, ...info.complaints.map((text) => h("li", {}, text))),
            info.n_complaints > info.complaints.length ? h("p", { class: "fine" }, `The first ${info.complaints.length} are shown.`) : null),
    );
  }
}
