// Figures of the run as a table, and the log of what happened.

import { h, setText } from "../dom";
import { clock, figure } from "../format";
import { icon } from "../icons";
import type { SignalInfo } from "../offer";
import type { LogItem, LogLevel, RobotState } from "../protocol";
import type { Store } from "../state";
import { emptyState } from "./empty";

const LEVEL_ICONS = { info: null, warn: "stop", good: "check", bad: "cross" } as const;
const LEVEL_WORDS: Record<LogLevel, string> = { info: "", warn: "Warning: ", good: "Success: ", bad: "Failure: " };

export class FiguresPanel {
  readonly element = h("div", { class: "figures-log" });
  private readonly robot = h("dl", { class: "figures" });
  private readonly figures = h("dl", { class: "figures" });
  private readonly cells = new Map<string, { value: HTMLElement; unit: HTMLElement }>();
  private readonly log = h("ol", { class: "log", role: "log", "aria-label": "Events", tabindex: 0 });
  private readonly emptyLog = emptyState("Nothing has happened yet", "Press Play; what matters is written down here.");
  /** Whether the newest entry is kept in sight; not while somebody reads further up. */
  private isFollowing = true;
  private until_s = Infinity;
  private alarm = h("p", { class: "alarm", role: "status" });

  constructor(private readonly store: Store) {
    this.element.append(
      h("section", { class: "figures-side", "aria-label": "Figures" }, h("h3", {}, "Run"), this.figures, h("h3", {}, "Robot"), this.robot, this.alarm),
      h("section", { class: "log-side", "aria-label": "Log" }, this.log, this.emptyLog),
    );
    this.log.addEventListener("scroll", () => (this.isFollowing = this.log.scrollTop + this.log.clientHeight >= this.log.scrollHeight - 30));
    // It grows while another tab hides it, too.
    new ResizeObserver(() => this.follow()).observe(this.log);
    store.on("state", () => this.onState());
    store.on("log", (items) => this.append(items));
    store.on("reset", () => {
      this.log.replaceChildren();
      // Nothing of the old run stays until the new one has a figure of its own.
      for (const list of [this.figures, this.robot]) list.replaceChildren();
      this.cells.clear();
      setText(this.alarm, "");
      this.emptyLog.hidden = false;
      this.isFollowing = true;
    });
  }

  private onState(): void {
    const { state, hello } = this.store;
    if (!state || !hello) return;
    const isElsewhere = hello.robots[0]?.is_elsewhere ?? false;
    this.showAll(this.figures, hello.run_signals, state.signals, isElsewhere);
    const robot = state.robots[0];
    if (robot) this.showAll(this.robot, hello.robot_signals, robot.signals, isElsewhere);
    if (robot) this.alert(robot);
    this.showLogUntil(this.store.until_s);
  }

  private alert(robot: RobotState): void {
    const name = this.store.hello?.robots.find(({ id }) => id === robot.id)?.name ?? "The robot";
    const failure = robot.failure ? `${name} gives up: ${robot.failure}` : "";
    setText(this.alarm, robot.touching ? `${name} touches something` : robot.stalled ? `${name}: wheels stalled` : failure);
  }

  /** What nobody can measure is told apart from what does not exist, which is a dash. */
  private showAll(list: HTMLElement, signals: readonly SignalInfo[], values: readonly (number | null)[], isElsewhere: boolean): void {
    signals.forEach(({ id, title, is_figure, is_seen_from_outside }, index) => {
      if (!is_figure) return;
      const raw = values[index] ?? null;
      const { value, unit } = isElsewhere && is_seen_from_outside && raw === null ? { value: "not known", unit: "" } : figure(id, raw);
      let cell = this.cells.get(id);
      if (!cell) {
        cell = { value: h("b", { class: "number" }), unit: h("span", { class: "unit" }) };
        this.cells.set(id, cell);
        list.append(h("div", { "data-figure": id }, h("dt", {}, title), h("dd", {}, cell.value, cell.unit)));
      }
      setText(cell.value, value);
      setText(cell.unit, unit);
    });
  }

  /** Up to the time that is looked back on. */
  private showLogUntil(until_s: number): void {
    if (until_s === this.until_s) return;
    this.until_s = until_s;
    for (const entry of this.log.children) if (entry instanceof HTMLElement) entry.hidden = Number(entry.dataset["time"]) > until_s;
    this.follow();
  }

  private append(items: readonly LogItem[]): void {
    this.emptyLog.hidden = true;
    for (const { t_s, level, text } of items) {
      const name = LEVEL_ICONS[level];
      this.log.append(h("li", { class: level, "data-time": t_s, hidden: t_s > this.until_s }, h("time", {}, clock(t_s)), h("span", { class: "mark" }, name ? icon(name) : null), h("span", {}, h("span", { class: "visually-hidden" }, LEVEL_WORDS[level]), text)));
    }
    while (this.log.children.length > 500) this.log.firstElementChild?.remove();
    this.follow();
  }

  private follow(): void {
    if (this.isFollowing) this.log.scrollTop = this.log.scrollHeight;
  }
}
