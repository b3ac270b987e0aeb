// What the page knows of the run: the last hello and states, trails, traces, log; and who listens.

import { type SessionEvents, SessionStore } from "./emitter";
import type { Hello, History, LogItem, Past, Point, RobotState, ServerMessage, State, TraceItem } from "./protocol";
import { Series } from "./series";
import { Signals } from "./signals";
import { Trail } from "./trail";

export const N_TRACE_MAX = 500;
const N_LOG_MAX = 1000;
const N_CONTACTS_MAX = 200;

/** A state with the wall-clock moment of its arrival, for interpolation. */
export interface Sample {
  state: State;
  arrived_ms: number;
}

interface StoreEvents extends SessionEvents {
  hello: Hello;
  /** Another state is shown. */
  state: State;
  /** The newest state has come, whether it is shown or the past is. */
  live: State;
  /** A robot has given up: what to say. */
  failure: string;
  /** A new run begins: forget what belonged to the old one. */
  reset: null;
  trace: TraceItem[];
  log: LogItem[];
}

/** Where a robot began to touch something. */
export interface Contact {
  t_s: number;
  at_m: Point;
}

export class Store extends SessionStore<StoreEvents> {
  hello: Hello | null = null;
  /** The newest state and the one before. */
  private newest: Sample | null = null;
  private older: Sample | null = null;
  /** What is looked back on; null when the page shows the present. */
  past: Past | null = null;
  private isLookingBack = false;
  /** Driven paths by robot id: where it was, and where it believed to be. */
  readonly trails = new Map<number, { truth: Trail; estimate: Trail }>();
  readonly contacts: Contact[] = [];
  readonly trace: TraceItem[] = [];
  /** Number of trace items ever received; tells viewers how far the ring has moved on. */
  n_traced = 0;
  readonly log: LogItem[] = [];
  readonly series = new Series();
  readonly signals = new Signals();
  private run = "";

  override get greeting(): Hello | null {
    return this.hello;
  }

  /** The state that is shown, with the moment of its arrival. */
  get latest(): Sample | null {
    return this.past ? { state: this.past.state, arrived_ms: 0 } : this.newest;
  }

  /** The one before, when the picture is on its way between both. */
  get previous(): Sample | null {
    return this.past ? null : this.older;
  }

  /** The present, whatever is shown. */
  get live(): State | null {
    return this.newest?.state ?? null;
  }

  /** Nothing later than this is shown. */
  get until_s(): number {
    return this.past?.state.t_s ?? Infinity;
  }

  get state(): State | null {
    return this.latest?.state ?? null;
  }

  /** False for recordings, in the past and without a connection: the page hides what would be refused. */
  get canIntervene(): boolean {
    return this.isOpen && this.hello?.mission.kind === "live" && !this.isLookingBack;
  }

  /** A robot can be stopped wherever one looks. */
  get canStop(): boolean {
    return this.isOpen && this.hello?.mission.kind === "live";
  }

  /** From now on answers about the past are shown. */
  lookBack(): void {
    this.isLookingBack = true;
  }

  /** The present is shown again. */
  lookAtNow(): void {
    this.isLookingBack = false;
    this.past = null;
    if (this.newest) this.emit("state", this.newest.state);
  }

  accept(message: ServerMessage, now_ms: number): void {
    switch (message.type) {
      case "hello":
        return this.acceptHello(message);
      case "state":
        return this.acceptState(message, now_ms);
      case "history":
        return this.acceptHistory(message);
      case "past":
        if (!this.isLookingBack) return;
        this.past = message;
        return this.emit("state", message.state);
      case "trace":
        this.trace.push(...message.items);
        this.trace.splice(0, this.trace.length - N_TRACE_MAX);
        this.n_traced += message.items.length;
        return this.emit("trace", message.items);
      case "log":
        return this.acceptLog(message.items);
      case "error":
        return this.emit("error", message.text);
    }
  }

  private acceptHello(hello: Hello): void {
    const before = this.hello?.mission;
    this.hello = hello;
    const isOther = this.run !== (hello.run ?? "") || before?.name !== hello.mission.name || before.seed !== hello.mission.seed;
    this.run = hello.run ?? "";
    if (before && isOther) this.reset();
    this.emit("hello", hello);
  }

  /** After a reconnection the program may tell its log again: what is already here is not repeated. */
  private acceptLog(items: LogItem[]): void {
    const last_s = this.log.at(-1)?.t_s ?? -Infinity;
    const news = items.filter((item) => item.t_s > last_s || !this.log.some(({ t_s, text }) => t_s === item.t_s && text === item.text));
    this.log.push(...news);
    this.log.splice(0, this.log.length - N_LOG_MAX);
    if (news.length > 0) this.emit("log", news);
  }

  /** The whole past takes the place of what is here: this page may have been away for a while. */
  private acceptHistory(history: History): void {
    this.series.replace(history);
    this.signals.recall(history.edges);
    for (const { id, truth, estimate } of history.robots) {
      const trails = { truth: new Trail(), estimate: new Trail() };
      history.t_s.forEach((t_s, index) => {
        trails.truth.push(pair(truth, index), t_s);
        trails.estimate.push(pair(estimate, index), t_s);
      });
      this.trails.set(id, trails);
    }
  }

  /** A robot that gives up says so once, with its name. */
  private watchFailures(state: State): void {
    for (const robot of state.robots) {
      const before = this.newest?.state.robots.find(({ id }) => id === robot.id);
      if (!robot.failure || !before || before.failure === robot.failure) continue;
      const name = this.hello?.robots.find(({ id }) => id === robot.id)?.name ?? `robot ${robot.id}`;
      this.emit("failure", `${name} gives up: ${robot.failure}.`);
    }
  }

  private watchContacts(state: State): void {
    for (const robot of state.robots) {
      const before = this.newest?.state.robots.find(({ id }) => id === robot.id);
      if (robot.touching && before && !before.touching) this.contacts.push({ t_s: state.t_s, at_m: xy(robot.truth) });
    }
    this.contacts.splice(0, this.contacts.length - N_CONTACTS_MAX);
  }

  private acceptState(state: State, now_ms: number): void {
    if (this.newest && state.t_s < this.newest.state.t_s - 1e-9) this.reset();
    this.watchFailures(state);
    this.watchContacts(state);
    this.older = this.newest;
    this.newest = { state, arrived_ms: now_ms };
    for (const robot of state.robots) this.extendTrails(robot, state.t_s);
    this.series.push(state, this.hello?.robot_signals ?? []);
    this.signals.push(state);
    this.emit("live", state);
    if (!this.past) this.emit("state", state);
  }

  private extendTrails(robot: RobotState, t_s: number): void {
    let trails = this.trails.get(robot.id);
    if (!trails) {
      trails = { truth: new Trail(), estimate: new Trail() };
      this.trails.set(robot.id, trails);
    }
    trails.truth.push(xy(robot.truth), t_s);
    trails.estimate.push(xy(robot.estimate), t_s);
  }

  private reset(): void {
    this.newest = null;
    this.older = null;
    this.past = null;
    this.isLookingBack = false;
    this.trails.clear();
    this.contacts.length = 0;
    this.trace.length = 0;
    this.n_traced = 0;
    this.log.length = 0;
    this.series.clear();
    this.signals.clear();
    this.emit("reset", null);
  }
}

function pair(list: readonly number[], index: number): Point {
  return [list[2 * index] ?? 0, list[2 * index + 1] ?? 0];
}

function xy(pose: readonly [number, number, number]): Point {
  return [pose[0], pose[1]];
}
