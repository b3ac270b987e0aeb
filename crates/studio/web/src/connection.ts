// The WebSocket to the program: connects, reconnects by itself with growing pauses, sends requests.

export type ConnectionState =
  | { phase: "connecting" }
  | { phase: "open" }
  /** Broken; the next attempt is at `retry_at_ms` (performance.now()). */
  | { phase: "lost"; retry_at_ms: number };

export interface ConnectionEvents {
  text(text: string): void;
  binary?(bytes: ArrayBuffer): void;
  change(state: ConnectionState): void;
}

const PAUSE_FIRST_MS = 400;
const PAUSE_MAX_MS = 8000;

/** `Request` is what may be sent. */
export class Connection<Request extends { type: string }> {
  private socket: WebSocket | null = null;
  private n_failures = 0;
  private timer = 0;

  constructor(
    private readonly url: string,
    private readonly events: ConnectionEvents,
  ) {
    // A laptop that wakes up should not wait for the rest of a long pause.
    window.addEventListener("online", () => this.retryNow());
    document.addEventListener("visibilitychange", () => {
      if (!document.hidden) this.retryNow();
    });
  }

  open(): void {
    window.clearTimeout(this.timer);
    this.timer = 0;
    this.events.change({ phase: "connecting" });
    const socket = new WebSocket(this.url);
    socket.binaryType = "arraybuffer";
    this.socket = socket;
    socket.addEventListener("open", () => {
      this.n_failures = 0;
      this.events.change({ phase: "open" });
    });
    socket.addEventListener("message", (event: MessageEvent<unknown>) => {
      if (typeof event.data === "string") this.events.text(event.data);
      else if (event.data instanceof ArrayBuffer) this.events.binary?.(event.data);
    });
    socket.addEventListener("close", () => this.onClose(socket));
  }

  /** False when there is no connection: the request is dropped, never queued for a later world. */
  send(message: Request): boolean {
    if (this.socket?.readyState !== WebSocket.OPEN) return false;
    this.socket.send(JSON.stringify(message));
    return true;
  }

  retryNow(): void {
    if (this.timer !== 0) this.open();
  }

  private onClose(socket: WebSocket): void {
    if (socket !== this.socket) return;
    const pause_ms = Math.min(PAUSE_FIRST_MS * 2 ** this.n_failures, PAUSE_MAX_MS);
    this.n_failures += 1;
    this.events.change({ phase: "lost", retry_at_ms: performance.now() + pause_ms });
    this.timer = window.setTimeout(() => this.open(), pause_ms);
  }
}
