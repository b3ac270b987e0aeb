// Figures of the run as a table, and the log of what happened.

import { h, setText } from "../dom";
import { clock, figure } from "../format";
import { icon } from "../icons";
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
  private alarm = h("p", { class: "alarm", role: "status" });

  constructor(private readonly store: Store) {
    this.element.append(
      h("section", { class: "figures-side", "aria-label": "Figures" }, h("h3", {}, "Run"), this.figures, h("h3", {}, "Robot"), this.robot, this.alarm),
      h("section", { class: "log-side", "aria-label": "Log" }, this.log, this.emptyLog),
    );
    store.on("state", () => this.onState());
    store.on("log", (items) => this.append(items));
    store.on("reset", () => {
      this.log.replaceChildren();
      this.emptyLog.hidden = false;
    });
  }

  private onState(): void {
    const { state } = this.store;
    if (!state) return;
    for (const [name, value] of Object.entries(state.figures)) this.set(this.figures, name, value);
    const robot = state.robots[0];
    if (robot) this.showRobot(robot);
  }

  private showRobot(robot: RobotState): void {
    const error_m = Math.hypot(robot.truth[0] - robot.estimate[0], robot.truth[1] - robot.estimate[1]);
    this.set(this.robot, "speed_mps", (robot.wheels_mps[0] + robot.wheels_mps[1]) / 2);
    this.set(this.robot, "position_error_m", error_m);
    this.set(this.robot, "clearance_m", robot.clearance_m);
    this.set(this.robot, "battery_v", robot.battery_v);
    setText(this.alarm, robot.touching ? "Touching something" : robot.stalled ? "Wheels stalled" : "");
  }

  private set(list: HTMLElement, name: string, raw: number | null): void {
    const { label, value, unit } = figure(name, raw);
    const key = `${list === this.robot ? "robot" : "run"}.${name}`;
    let cell = this.cells.get(key);
    if (!cell) {
      cell = { value: h("b", { class: "number" }), unit: h("span", { class: "unit" }) };
      this.cells.set(key, cell);
      list.append(h("div", { "data-figure": name }, h("dt", {}, label), h("dd", {}, cell.value, cell.unit)));
    }
    setText(cell.value, value);
    setText(cell.unit, unit);
  }

  private append(items: readonly LogItem[]): void {
    const atEnd = this.log.scrollTop + this.log.clientHeight >= this.log.scrollHeight - 30;
    this.emptyLog.hidden = true;
    for (const { t_s, level, text } of items) {
      const name = LEVEL_ICONS[level];
      this.log.append(h("li", { class: level }, h("time", {}, clock(t_s)), h("span", { class: "mark" }, name ? icon(name) : null), h("span", {}, h("span", { class: "visually-hidden" }, LEVEL_WORDS[level]), text)));
    }
    while (this.log.children.length > 500) this.log.firstElementChild?.remove();
    if (atEnd) this.log.scrollTop = this.log.scrollHeight;
  }
}
