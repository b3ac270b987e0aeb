// What a session's store is made of: who listens to what, and how the connection is.

import type { ConnectionState } from "./connection";

/** What every session tells. */
export interface SessionEvents {
  hello: unknown;
  error: string;
  connection: ConnectionState;
}

/** What the frame around a session needs of it. */
export interface Session {
  readonly connection: ConnectionState;
  /** The greeting: which program this is. */
  readonly greeting: { cairn: string; protocol: number } | null;
  setConnection(connection: ConnectionState): void;
  /** A greeting, or another state of the connection. */
  onSession(listener: () => void): void;
  onError(listener: (text: string) => void): void;
}

export abstract class SessionStore<Events extends SessionEvents> implements Session {
  connection: ConnectionState = { phase: "connecting" };
  private readonly listeners: { [K in keyof Events]?: ((value: Events[K]) => void)[] } = {};

  abstract get greeting(): { cairn: string; protocol: number } | null;

  on<K extends keyof Events>(event: K, listener: (value: Events[K]) => void): void {
    (this.listeners[event] ??= []).push(listener);
  }

  onSession(listener: () => void): void {
    this.on("hello", listener);
    this.on("connection", listener);
  }

  onError(listener: (text: string) => void): void {
    this.on("error", listener as (value: Events["error"]) => void);
  }

  get isOpen(): boolean {
    return this.connection.phase === "open";
  }

  setConnection(connection: ConnectionState): void {
    this.connection = connection;
    this.emit("connection", connection as Events["connection"]);
  }

  protected emit<K extends keyof Events>(event: K, value: Events[K]): void {
    for (const listener of this.listeners[event] ?? []) listener(value);
  }
}
