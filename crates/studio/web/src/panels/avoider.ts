// The obstacle avoider: its nine states with the current one lit, the last transitions, bubble bars.

import { h, setText, svg } from "../dom";
import type { RobotState } from "../protocol";
import type { Store } from "../state";
import { edgeKey, stateDiagram, STATE_NAMES } from "./avoider_diagram";
import { emptyState } from "./empty";

const N_VISITS_MAX = 5;
const BAR_HEIGHT_PX = 62;
const RANGE_SHOWN_M = 5;
const TICKS_M = [0, 0.5, 2, 5];

interface Visit {
  t_s: number;
  /** One state, or the two of a loop that ran several times. */
  states: number[];
  n_rounds: number;
}

export class AvoiderPanel {
  readonly element = h("div", { class: "avoider" });
  private readonly diagram = stateDiagram();
  private readonly visits: Visit[] = [];
  private readonly history = h("ol", { class: "visits", "aria-label": "Last transitions" });
  private readonly bars = h("div", { class: "bubble-bars" });
  private readonly phase = h("div", { class: "phase" });
  private state = -1;
  private n_bars = -1;

  constructor(private readonly store: Store) {
    this.element.append(emptyState("Waiting for the robot", "The avoider's states appear with the first message."));
    store.on("hello", () => this.onHello());
    store.on("state", () => this.onState());
    store.on("reset", () => {
      this.visits.length = 0;
      this.setState(-1, 0);
    });
  }

  private onHello(): void {
    if (this.store.hello?.robots.length === 0) {
      this.element.replaceChildren(emptyState("No robot", "This mission has no robot to show."));
      return;
    }
    this.n_bars = -1;
    this.element.replaceChildren(this.diagram.element, h("div", { class: "avoider-side" }, this.phase, this.history, this.bars));
  }

  private onState(): void {
    const robot = this.store.state?.robots[0];
    if (!robot) return;
    this.setState(robot.avoider.state, this.store.state?.t_s ?? 0);
    setText(this.phase, `Navigator: ${robot.phase}`);
    this.refreshBars(robot);
  }

  private setState(state: number, t_s: number): void {
    if (state === this.state) return;
    const { nodes, edges } = this.diagram;
    nodes.get(this.state)?.classList.remove("lit");
    for (const edge of edges.values()) edge.classList.remove("taken");
    nodes.get(state)?.classList.add("lit");
    edges.get(edgeKey(this.state, state))?.classList.add("taken");
    this.diagram.element.setAttribute("aria-label", state < 0 ? "Nine-state avoider" : `Nine-state avoider, now in state ${state}, ${STATE_NAMES[state] ?? ""}`);
    this.state = state;
    // What is looked back on was noted when it happened.
    if (state >= 0 && !this.store.past) this.note(state, t_s);
    this.showHistory();
  }

  /** Supervising is a loop of two states five times a second: it counts as one visit. */
  private note(state: number, t_s: number): void {
    const last = this.visits.at(-1);
    if (last && last.states.includes(state)) {
      if (state === last.states[0]) last.n_rounds += 1;
      return;
    }
    const other = { 3: 4, 4: 3, 7: 8, 8: 7 }[last?.states[0] ?? -1];
    if (last && last.states.length === 1 && other === state) {
      last.states.push(state);
      return;
    }
    this.visits.push({ t_s, states: [state], n_rounds: 1 });
    if (this.visits.length > N_VISITS_MAX) this.visits.shift();
  }

  private showHistory(): void {
    const items = [...this.visits].reverse().map(({ t_s, states, n_rounds }) => {
      const names = states.map((state) => STATE_NAMES[state] ?? "?").join(" ⇄ ");
      const rounds = n_rounds > 1 ? ` ×${n_rounds}` : "";
      return h("li", {}, h("time", {}, t_s.toFixed(1)), h("b", {}, states.join("⇄")), h("span", {}, `${names}${rounds}`));
    });
    this.history.replaceChildren(...items);
  }

  private refreshBars(robot: RobotState): void {
    if (robot.sonar_m.length !== this.n_bars) this.buildBars(robot.sonar_m.length);
    const scale_m = this.store.hello?.robots[0]?.sonars[0]?.range_max_m ?? RANGE_SHOWN_M;
    robot.sonar_m.forEach((range_m, index) => {
      const column = this.bars.querySelector(`[data-sonar="${index}"]`);
      const limit_m = robot.bubble_m[index];
      if (!column) return;
      const hit = range_m < scale_m - 0.02;
      const inside = limit_m !== undefined && range_m <= limit_m;
      column.setAttribute("class", `sonar-bar${inside ? " inside" : hit ? " hit" : ""}`);
      const height = heightOf(range_m);
      column.querySelector(".range")?.setAttribute("style", `transform: scaleY(${(height / BAR_HEIGHT_PX).toFixed(4)})`);
      const mark = column.querySelector(".limit");
      mark?.setAttribute("visibility", limit_m === undefined ? "hidden" : "visible");
      mark?.setAttribute("transform", `translate(0 ${(-heightOf(limit_m ?? 0)).toFixed(1)})`);
      const title = column.querySelector("title");
      if (title) setText(title, `Sonar ${index}: ${hit ? `${range_m.toFixed(2)} m` : "no echo"}${limit_m === undefined ? "" : `, limit ${limit_m.toFixed(2)} m`}`);
    });
  }

  private buildBars(n: number): void {
    this.n_bars = n;
    const width = 300;
    const step = (width - 26) / Math.max(1, n);
    const grid = TICKS_M.flatMap((tick_m) => {
      const y = -heightOf(tick_m);
      return [svg("path", { d: `M24 ${y}H${width}`, class: "grid" }), svg("text", { x: 20, y: y + 3.5, class: "tick" }, String(tick_m))];
    });
    const columns = Array.from({ length: n }, (_, index) => {
      const x = 26 + index * step;
      return svg("g", { class: "sonar-bar", "data-sonar": index },
        svg("title"),
        svg("rect", { x: x + step * 0.16, y: -BAR_HEIGHT_PX, width: step * 0.68, height: BAR_HEIGHT_PX, class: "range", rx: 2 }),
        svg("path", { d: `M${x + 1} 0H${x + step - 1}`, class: "limit" }),
        svg("text", { x: x + step / 2, y: 14, class: "name" }, String(index)));
    });
    this.bars.replaceChildren(
      h("h3", {}, "Range and bubble limit per sonar, m"),
      svg("svg", { viewBox: `0 ${-BAR_HEIGHT_PX - 6} ${width} ${BAR_HEIGHT_PX + 24}`, role: "img", "aria-label": "Sonar ranges against bubble limits, left to right" }, ...grid, ...columns),
    );
  }
}

/** Square-root scale: bubbles are a few decimetres, ranges go to five metres. */
function heightOf(range_m: number): number {
  return BAR_HEIGHT_PX * Math.sqrt(Math.min(1, Math.max(0, range_m / RANGE_SHOWN_M)));
}
