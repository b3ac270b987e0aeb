// Driving by hand: keys, a gamepad or the stick on the map become speeds, ten times a second while something is held.
//
// The program lets a robot go half a second after the last of them, so a page that is closed, hidden or cut off
// stops its robot; letting go of the keys, or leaving the window, says so at once.

import { h, isTyping, setText } from "./dom";
import type { ClientMessage } from "./protocol";
import type { Store } from "./state";

const PERIOD_MS = 100;
/** A stick this near its middle stands. */
const DEAD_ZONE = 0.15;
const SPEED_MAX_MPS = 0.75;
const TURN_RATE_MAX_RADPS = 1.5;
/** Share of the greatest speeds at first. */
const PACE_FIRST = 0.4;

/** By `KeyboardEvent.code`, so that the keys stay where they are on any layout: forwards, to the left. */
const KEYS: Readonly<Record<string, readonly [forwards: number, left: number]>> = {
  KeyW: [1, 0], ArrowUp: [1, 0], KeyS: [-1, 0], ArrowDown: [-1, 0],
  KeyA: [0, 1], ArrowLeft: [0, 1], KeyD: [0, -1], ArrowRight: [0, -1],
};

export class Drive {
  readonly element = h("div", { class: "drive", role: "group", "aria-label": "Drive by hand", hidden: true });
  private readonly knob = h("div", { class: "knob" });
  private readonly stick = h("div", { class: "stick", role: "img", "aria-label": "Stick: hold and drag" }, this.knob);
  private readonly robot = h("select", { class: "field small", "aria-label": "Robot to drive" });
  private readonly pace = h("input", { type: "range", min: 10, max: 100, step: 5, value: 100 * PACE_FIRST, "aria-label": "Greatest speed" });
  private readonly told = h("output", { class: "number" });
  private readonly source = h("p", { class: "source-line" });
  private readonly held = new Set<string>();
  private stickAt: readonly [number, number] = [0, 0];
  private isOn = false;
  private wasMoving = false;

  constructor(private readonly store: Store, private readonly send: (message: ClientMessage) => boolean) {
    this.element.append(
      this.stick,
      h("div", { class: "drive-side" }, this.robot, h("label", {}, "Pace", this.pace), this.told, this.source),
    );
    window.addEventListener("keydown", (event) => this.onKey(event, true), { capture: true });
    window.addEventListener("keyup", (event) => this.onKey(event, false), { capture: true });
    window.addEventListener("blur", () => this.letGo());
    document.addEventListener("visibilitychange", () => this.letGo());
    this.attachStick();
    store.on("hello", () => this.onHello());
    store.on("connection", () => this.letGo());
    window.setInterval(() => this.tick(), PERIOD_MS);
  }

  setActive(on: boolean): void {
    if (!on) this.letGo();
    this.isOn = on;
    this.element.hidden = !on;
    this.refresh([0, 0]);
  }

  private onHello(): void {
    const robots = this.store.hello?.robots ?? [];
    this.robot.replaceChildren(...robots.map(({ id, name }) => h("option", { value: id }, name)));
    this.robot.hidden = robots.length < 2;
    this.letGo();
  }

  private onKey(event: KeyboardEvent, isDown: boolean): void {
    const isOurs = this.isOn && event.code in KEYS && !event.ctrlKey && !event.metaKey && !event.altKey;
    if (!isOurs || isTyping(event.target) || event.target === this.pace) return;
    // These keys mean something else as long as nobody drives.
    event.preventDefault();
    event.stopPropagation();
    if (isDown) this.held.add(event.code);
    else this.held.delete(event.code);
    if (!event.repeat) this.tick();
  }

  private attachStick(): void {
    const move = (event: PointerEvent): void => {
      const box = this.stick.getBoundingClientRect();
      const at = [event.clientX - box.left - box.width / 2, event.clientY - box.top - box.height / 2] as const;
      const reach = Math.max(box.width / 2, Math.hypot(...at));
      this.stickAt = [-at[1] / reach, -at[0] / reach];
      this.tick();
    };
    this.stick.addEventListener("pointerdown", (event) => {
      event.preventDefault();
      this.stick.setPointerCapture(event.pointerId);
      move(event);
      this.stick.addEventListener("pointermove", move);
    });
    this.stick.addEventListener("lostpointercapture", () => {
      this.stick.removeEventListener("pointermove", move);
      this.stickAt = [0, 0];
      this.tick();
    });
  }

  private letGo(): void {
    this.held.clear();
    this.stickAt = [0, 0];
    this.tick();
  }

  /** Forwards and to the left, each from −1 to 1. */
  private wanted(): readonly [number, number] {
    if (!this.isOn || !this.store.canIntervene || document.hidden) return [0, 0];
    const keys = [...this.held].map((code) => KEYS[code] ?? [0, 0]);
    const byKeys = [0, 1].map((axis) => clamp(keys.reduce((sum, key) => sum + (key[axis] ?? 0), 0)));
    if (byKeys.some((value) => value !== 0)) return [byKeys[0] ?? 0, byKeys[1] ?? 0];
    if (Math.hypot(...this.stickAt) > DEAD_ZONE) return this.stickAt;
    return document.hasFocus() ? padNow() : [0, 0];
  }

  private tick(): void {
    const wanted = this.wanted();
    const moves = wanted[0] !== 0 || wanted[1] !== 0;
    if (!moves && !this.wasMoving) return;
    this.wasMoving = moves;
    // Whoever takes the wheel wants to see it turn.
    if (moves && this.store.state && !this.store.state.playing) this.send({ type: "play" });
    const [speed_mps, turn_rate_radps] = this.speeds(wanted);
    this.send({ type: "drive", robot: this.robotId(), speed_mps, turn_rate_radps });
    this.refresh(wanted);
  }

  private robotId(): number {
    return Number(this.robot.value) || (this.store.hello?.robots[0]?.id ?? 0);
  }

  private speeds([forwards, left]: readonly [number, number]): [number, number] {
    const info = this.store.hello?.robots.find(({ id }) => id === this.robotId());
    const share = Number(this.pace.value) / 100;
    const rounded = (value: number): number => Math.round(1000 * share * value) / 1000 + 0;
    return [rounded(forwards * (info?.hand_speed_max_mps ?? SPEED_MAX_MPS)), rounded(left * (info?.hand_turn_rate_max_radps ?? TURN_RATE_MAX_RADPS))];
  }

  private refresh(wanted: readonly [number, number]): void {
    const [speed_mps, turn_rate_radps] = this.speeds(wanted);
    this.knob.style.transform = `translate(${(-26 * wanted[1]).toFixed(1)}px, ${(-26 * wanted[0]).toFixed(1)}px)`;
    setText(this.told, `${speed_mps.toFixed(2)} m/s · ${((turn_rate_radps * 180) / Math.PI).toFixed(0)}°/s`);
    const pad = pads()[0];
    setText(this.source, pad ? `Gamepad: ${pad.id.replace(/ *\(.*/, "")}` : "W A S D, arrows, or drag the stick");
  }
}

function pads(): Gamepad[] {
  return [...(navigator.getGamepads?.() ?? [])].filter((pad) => pad !== null);
}

/** The left stick or the cross of the first gamepad that is moved. */
function padNow(): readonly [number, number] {
  for (const { axes, buttons } of pads()) {
    const at = [-(axes[1] ?? 0), -(axes[0] ?? 0)] as const;
    if (Math.hypot(...at) > DEAD_ZONE) return [clamp(at[0]), clamp(at[1])];
    const pressed = (index: number): number => Number(buttons[index]?.pressed ?? false);
    const cross = [pressed(12) - pressed(13), pressed(14) - pressed(15)] as const;
    if (cross[0] !== 0 || cross[1] !== 0) return cross;
  }
  return [0, 0];
}

function clamp(value: number): number {
  return Math.max(-1, Math.min(1, value));
}
