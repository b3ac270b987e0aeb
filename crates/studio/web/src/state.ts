// What the page knows of the run: the last hello and states, trails, traces, log; and who listens.

import type { ConnectionState } from "./connection";
import type { Hello, History, LogItem, Point, RobotState, ServerMessage, State, TraceItem } from "./protocol";
import { Series } from "./series";
import { Signals } from "./signals";
import { Trail } from "./trail";

export const N_TRACE_MAX = 500;
const N_LOG_MAX = 1000;

/** A state with the wall-clock moment of its arrival, for interpolation. */
export interface Sample {
  state: State;
  arrived_ms: number;
}

interface StoreEvents {
  hello: Hello;
  state: State;
  /** A robot has given up: what to say. */
  failure: string;
  /** A new run begins: forget what belonged to the old one. */
  reset: null;
  trace: TraceItem[];
  log: LogItem[];
  error: string;
  connection: ConnectionState;
}

type Listener<K extends keyof StoreEvents> = (value: StoreEvents[K]) => void;

export class Store {
  hello: Hello | null = null;
  latest: Sample | null = null;
  previous: Sample | null = null;
  connection: ConnectionState = { phase: "connecting" };
  /** Driven paths by robot id: where it was, and where it believed to be. */
  readonly trails = new Map<number, { truth: Trail; estimate: Trail }>();
  readonly trace: TraceItem[] = [];
  /** Number of trace items ever received; tells viewers how far the ring has moved on. */
  n_traced = 0;
  readonly log: LogItem[] = [];
  readonly series = new Series();
  readonly signals = new Signals();

  private run = "";
  private readonly listeners: { [K in keyof StoreEvents]: Listener<K>[] } = {
    hello: [], state: [], failure: [], reset: [], trace: [], log: [], error: [], connection: [],
  };

  on<K extends keyof StoreEvents>(event: K, listener: Listener<K>): void {
    this.listeners[event].push(listener);
  }

  get state(): State | null {
    return this.latest?.state ?? null;
  }

  /** False for recordings and without a connection: the page hides what would be refused. */
  get canIntervene(): boolean {
    return this.connection.phase === "open" && this.hello?.mission.kind === "live";
  }

  setConnection(connection: ConnectionState): void {
    this.connection = connection;
    this.emit("connection", connection);
  }

  accept(message: ServerMessage, now_ms: number): void {
    switch (message.type) {
      case "hello":
        return this.acceptHello(message);
      case "state":
        return this.acceptState(message, now_ms);
      case "history":
        return this.acceptHistory(message);
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
      const before = this.latest?.state.robots.find(({ id }) => id === robot.id);
      if (!robot.failure || !before || before.failure === robot.failure) continue;
      const name = this.hello?.robots.find(({ id }) => id === robot.id)?.name ?? `robot ${robot.id}`;
      this.emit("failure", `${name} gives up: ${robot.failure}.`);
    }
  }

  private acceptState(state: State, now_ms: number): void {
    if (this.latest && state.t_s < this.latest.state.t_s - 1e-9) this.reset();
    this.watchFailures(state);
    this.previous = this.latest;
    this.latest = { state, arrived_ms: now_ms };
    for (const robot of state.robots) this.extendTrails(robot, state.t_s);
    this.series.push(state);
    this.signals.push(state);
    this.emit("state", state);
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
    this.latest = null;
    this.previous = null;
    this.trails.clear();
    this.trace.length = 0;
    this.n_traced = 0;
    this.log.length = 0;
    this.series.clear();
    this.signals.clear();
    this.emit("reset", null);
  }

  private emit<K extends keyof StoreEvents>(event: K, value: StoreEvents[K]): void {
    for (const listener of this.listeners[event]) listener(value);
  }
}

function pair(list: readonly number[], index: number): Point {
  return [list[2 * index] ?? 0, list[2 * index + 1] ?? 0];
}

function xy(pose: readonly [number, number, number]): Point {
  return [pose[0], pose[1]];
}
