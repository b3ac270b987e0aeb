// What the mapping page knows: greeting, source, state, a board and a registration for each run; and who listens.

import { type SessionEvents, SessionStore } from "../emitter";
import { Board, type Ramp } from "./board";
import { decode } from "./decode";
import { type Hello, parseMessage, type Registration, type RunState, type Slot, type Source, type State } from "./protocol";

interface StoreEvents extends SessionEvents {
  hello: Hello;
  source: Source;
  state: State;
  /** A picture changed in this slot. */
  board: Slot;
  registration: Slot;
}

/** Registrations that are remembered for each run. */
const N_REGISTRATIONS_MAX = 200;

export class Store extends SessionStore<StoreEvents> {
  hello: Hello | null = null;
  source: Source | null = null;
  state: State | null = null;
  readonly boards: [Board | null, Board | null] = [null, null];
  /** The newest last. */
  readonly registrations: [Registration[], Registration[]] = [[], []];

  constructor(private ramp: Ramp, private patchRamp: Ramp) {
    super();
  }

  override get greeting(): Hello | null {
    return this.hello;
  }

  /** The run that plays: B when two are compared. */
  get newest(): RunState | null {
    return this.state?.runs.at(-1) ?? null;
  }

  restyle(ramp: Ramp, patchRamp: Ramp): void {
    this.ramp = ramp;
    this.patchRamp = patchRamp;
    for (const board of this.boards) board?.restyle(ramp, patchRamp);
    for (const slot of [0, 1] as const) this.emit("board", slot);
  }

  acceptText(text: string): void {
    const message = parseMessage(text);
    switch (message?.type) {
      case "hello":
        if (this.hello?.server !== message.server) this.forget();
        this.hello = message;
        return this.emit("hello", message);
      case "source":
        this.source = message;
        return this.emit("source", message);
      case "state":
        return this.acceptState(message);
      case "registration":
        return this.acceptRegistration(message);
      case "error":
        return this.emit("error", message.text);
    }
  }

  acceptBinary(bytes: ArrayBuffer): void {
    const message = decode(bytes);
    if (!message) return;
    this.boardOf(message.slot, message.run).accept(message);
    this.emit("board", message.slot);
  }

  private acceptState(state: State): void {
    this.state = state;
    for (const slot of [0, 1] as const) {
      const run = state.runs[slot];
      if (!run && this.boards[slot]) {
        this.boards[slot] = null;
        this.registrations[slot] = [];
        this.emit("board", slot);
      } else if (run) {
        this.boardOf(slot, run.run);
      }
    }
    this.emit("state", state);
  }

  private acceptRegistration(message: Registration): void {
    if (this.boardOf(message.slot, message.run).run !== message.run || message.number === 0) return;
    const list = this.registrations[message.slot];
    list.push(message);
    list.splice(0, list.length - N_REGISTRATIONS_MAX);
    this.emit("registration", message.slot);
  }

  /** The board of a run; a new one when another run has come into the slot. */
  private boardOf(slot: Slot, run: number): Board {
    const present = this.boards[slot];
    if (present?.run === run) return present;
    // The run that stays moves from B to A with its picture.
    const other = this.boards[slot === 0 ? 1 : 0];
    const board = other?.run === run ? other : new Board(run, this.ramp, this.patchRamp);
    const list = other?.run === run ? this.registrations[slot === 0 ? 1 : 0] : [];
    this.boards[slot] = board;
    this.registrations[slot] = [...list];
    this.emit("registration", slot);
    this.emit("board", slot);
    return board;
  }

  private forget(): void {
    this.source = null;
    this.state = null;
    for (const slot of [0, 1] as const) {
      this.boards[slot] = null;
      this.registrations[slot] = [];
    }
  }
}
