// Figures of the run as a table, and the log of what happened.

import { h, setText } from "../dom";
import { clock, figure } from "../format";
import { icon } from "../icons";
import type { LogItem, LogLevel, RobotState } from "../protocol";
import type { Store } from "../state";
import { emptyState } from "./empty";

const LEVEL_ICONS = { info: null, warn: "stop", good: "check", bad: "cross" } as const;
const LEVEL_WORDS: Record<LogLevel, string> = { info: "", warn: "Warning: ", good: "Success: ", bad: "Failure: " };

/** Of a robot elsewhere only what it reports is known. */
const NOT_KNOWN_ELSEWHERE: ReadonlySet<string> = new Set(["clearance_min_m", "collisions", "cross_track_rms_m", "cross_track_max_m"]);

export class FiguresPanel {
  readonly element = h("div", { class: "figures-log" });
  private readonly robot = h("dl", { class: "figures" });
  private readonly figures = h("dl", { class: "figures" });
  private readonly cells = new Map<string, { value: HTMLElement; unit: HTMLElement }>();
  private readonly log = h("ol", { class: "log", role: "log", "aria-label": "Events", tabindex: 0 });
  private readonly emptyLog = emptyState("Nothing has happened yet", "Press Play; what matters is written down here.");
  /** Whether the newest entry is kept in sight; not while somebody reads further up. */
  private isFollowing = true;
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
    const { state } = this.store;
    if (!state) return;
    const isElsewhere = this.store.hello?.robots[0]?.is_elsewhere ?? false;
    for (const [name, value] of Object.entries(state.figures)) this.set(this.figures, name, value, isElsewhere && NOT_KNOWN_ELSEWHERE.has(name));
    const robot = state.robots[0];
    if (robot) this.showRobot(robot, isElsewhere);
  }

  private showRobot(robot: RobotState, isElsewhere: boolean): void {
    const error_m = Math.hypot(robot.truth[0] - robot.estimate[0], robot.truth[1] - robot.estimate[1]);
    this.set(this.robot, "speed_mps", (robot.wheels_mps[0] + robot.wheels_mps[1]) / 2);
    this.set(this.robot, "position_error_m", isElsewhere ? null : error_m, isElsewhere);
    this.set(this.robot, "clearance_m", robot.clearance_m, isElsewhere);
    this.set(this.robot, "battery_v", robot.battery_v);
    const name = this.store.hello?.robots.find(({ id }) => id === robot.id)?.name ?? "The robot";
    const failure = robot.failure ? `${name} gives up: ${robot.failure}` : "";
    setText(this.alarm, robot.touching ? `${name} touches something` : robot.stalled ? `${name}: wheels stalled` : failure);
  }

  /** What nobody can measure is told apart from what does not exist, which is a dash. */
  private set(list: HTMLElement, name: string, raw: number | null, isUnknowable = false): void {
    const { label, value, unit } = isUnknowable && raw === null ? { ...figure(name, raw), value: "not known" } : figure(name, raw);
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
    this.emptyLog.hidden = true;
    for (const { t_s, level, text } of items) {
      const name = LEVEL_ICONS[level];
      this.log.append(h("li", { class: level }, h("time", {}, clock(t_s)), h("span", { class: "mark" }, name ? icon(name) : null), h("span", {}, h("span", { class: "visually-hidden" }, LEVEL_WORDS[level]), text)));
    }
    while (this.log.children.length > 500) this.log.firstElementChild?.remove();
    this.follow();
  }

  private follow(): void {
    if (this.isFollowing) this.log.scrollTop = this.log.scrollHeight;
  }
}
