// What a click on the map means: select and press, place a box, remove one, send a goal with a heading.

import type { ClientMessage, Point, Pose, Thing } from "../protocol";
import type { Store } from "../state";
import type { Camera } from "./camera";
import { deviceAt } from "./devices";
import { contains, type Pen, tracePolygon } from "./pen";
import { drawGoal } from "./robots";

export type ToolName = "select" | "place" | "remove" | "goal" | "drive";

/** Side of the box that the place tool puts down. */
export const BOX_M = 0.4;
/** Within this length of the drag the goal keeps the heading from the robot to it. */
const HEADING_DRAG_MIN_M = 0.15;

export interface ToolEvents {
  send(message: ClientMessage): boolean;
  say(text: string): void;
  changed(): void;
  toolChanged(tool: ToolName): void;
}

export class Tools {
  tool: ToolName = "select";
  /** Where the tool points: under the mouse, or where the arrow keys have moved it. */
  cursor_m: Point | null = null;
  /** The cursor is moved by keys and needs a cross to be seen. */
  isKeyboard = false;
  hoveredDevice: string | null = null;
  private goal: Pose | null = null;
  private pointer_px: Point | null = null;

  constructor(
    private readonly store: Store,
    private readonly camera: Camera,
    private readonly events: ToolEvents,
  ) {}

  choose(tool: ToolName): void {
    const allowed = tool === "select" || this.store.canIntervene;
    if (!allowed) this.events.say(this.refusal());
    this.tool = allowed ? tool : "select";
    this.goal = null;
    this.isKeyboard = false;
    this.events.toolChanged(this.tool);
    this.events.changed();
  }

  /** Under a pointer that rests there is another place when the picture moves. */
  cameraMoved(): void {
    if (!this.isKeyboard && this.pointer_px) this.cursor_m = this.camera.toWorld(...this.pointer_px);
  }

  hover(at_px: Point | null): void {
    this.isKeyboard = false;
    this.pointer_px = at_px;
    this.cursor_m = at_px ? this.camera.toWorld(...at_px) : null;
    const devices = this.store.hello?.world.devices ?? [];
    const device = at_px && this.tool === "select" ? deviceAt(this.camera, devices, at_px) : null;
    this.hoveredDevice = device?.name ?? null;
    this.events.changed();
  }

  /** True when the press starts a goal: then a drag turns its heading instead of panning. */
  press(at_px: Point): boolean {
    if (this.tool !== "goal") return false;
    this.startGoal(this.camera.toWorld(...at_px));
    return true;
  }

  drag(at_px: Point): void {
    if (!this.goal) return;
    const [x, y] = this.camera.toWorld(...at_px);
    const [dx, dy] = [x - this.goal[0], y - this.goal[1]];
    if (Math.hypot(dx, dy) >= HEADING_DRAG_MIN_M) this.goal = [this.goal[0], this.goal[1], Math.atan2(dy, dx)];
    this.events.changed();
  }

  release(): void {
    if (this.goal) this.sendGoal(this.goal);
    this.goal = null;
    this.events.changed();
  }

  cancel(): void {
    this.goal = null;
    this.events.changed();
  }

  click(at_px: Point): void {
    this.act(this.camera.toWorld(...at_px), at_px);
  }

  /** Arrow keys while a tool is chosen; false when the tool has no use for them. */
  moveCursor(dx_m: number, dy_m: number): boolean {
    if (this.tool === "select" || this.tool === "drive") return false;
    const [x, y] = this.cursor_m ?? this.camera.centre_m;
    this.cursor_m = [x + dx_m, y + dy_m];
    if (this.goal) this.goal = [this.cursor_m[0], this.cursor_m[1], this.goal[2]];
    this.isKeyboard = true;
    this.events.changed();
    return true;
  }

  turnGoal(by_rad: number): void {
    if (this.tool !== "goal") return;
    if (!this.goal) this.startGoal(this.cursor_m ?? this.camera.centre_m);
    if (this.goal) this.goal = [this.goal[0], this.goal[1], this.goal[2] + by_rad];
    this.isKeyboard = true;
    this.events.changed();
  }

  /** Enter: acts where the cursor is. */
  actAtCursor(): void {
    const at_m = this.cursor_m ?? this.camera.centre_m;
    if (this.tool !== "goal") return this.act(at_m, this.camera.toScreen(...at_m));
    if (!this.goal) this.startGoal(at_m);
    this.release();
  }

  /** The thing that the remove tool points at. */
  thingAt(at_m: Point): Thing | null {
    const things = [...(this.store.state?.things ?? []), ...(this.store.hello?.world.things ?? [])];
    return things.find((thing) => contains(thing.corners_m, at_m)) ?? null;
  }

  /** The ghost of what a click would do. */
  draw(pen: Pen): void {
    const { context, camera, palette } = pen;
    if (this.goal) drawGoal(pen, this.goal, 0.3, 0.75);
    if (!this.cursor_m) return;
    const [x, y] = this.cursor_m;
    if (this.tool === "place") {
      const half = BOX_M / 2;
      tracePolygon(pen, [[x - half, y - half], [x + half, y - half], [x + half, y + half], [x - half, y + half]]);
      context.fillStyle = palette.colour.box;
      context.globalAlpha = 0.55;
      context.fill();
      context.globalAlpha = 1;
      context.strokeStyle = palette.colour["box-line"];
      context.setLineDash([4, 3]);
      context.lineWidth = 1.5;
      context.stroke();
      context.setLineDash([]);
    }
    if (this.tool === "remove") {
      const thing = this.thingAt(this.cursor_m);
      if (thing) {
        tracePolygon(pen, thing.corners_m);
        context.strokeStyle = thing.removable ? palette.bad : palette.muted;
        context.lineWidth = 3;
        context.stroke();
      }
    }
    if (!this.isKeyboard) return;
    const [x_px, y_px] = camera.toScreen(x, y);
    context.strokeStyle = palette.accent;
    context.lineWidth = 2;
    context.beginPath();
    context.moveTo(x_px - 14, y_px);
    context.lineTo(x_px + 14, y_px);
    context.moveTo(x_px, y_px - 14);
    context.lineTo(x_px, y_px + 14);
    context.stroke();
  }

  private act(at_m: Point, at_px: Point): void {
    switch (this.tool) {
      case "select": {
        const device = deviceAt(this.camera, this.store.hello?.world.devices ?? [], at_px);
        if (device?.kind === "button") this.request({ type: "press", device: device.name });
        return;
      }
      case "place":
        return this.request({ type: "place", at_m: rounded(at_m), size_m: BOX_M });
      case "remove": {
        const thing = this.thingAt(at_m);
        if (!thing) return this.events.say("Nothing to remove here: point at a box.");
        if (!thing.removable) return this.events.say(`The ${thing.name} belongs to the house and stays.`);
        return this.request({ type: "remove", id: thing.id });
      }
      case "goal":
      case "drive":
        return;
    }
  }

  private startGoal(at_m: Point): void {
    const robot = this.store.state?.robots[0];
    const yaw_rad = robot ? Math.atan2(at_m[1] - robot.truth[1], at_m[0] - robot.truth[0]) : 0;
    this.goal = [at_m[0], at_m[1], yaw_rad];
    this.events.changed();
  }

  private sendGoal([x, y, yaw]: Pose): void {
    const robot = this.store.hello?.robots[0]?.id ?? 0;
    const wrapped = Math.atan2(Math.sin(yaw), Math.cos(yaw));
    this.request({ type: "goal", robot, pose: [...rounded([x, y]), Math.round(wrapped * 1e4) / 1e4] });
  }

  private request(message: ClientMessage): void {
    if (!this.store.canIntervene) return this.events.say(this.refusal());
    this.events.send(message);
  }

  private refusal(): string {
    if (this.store.past) return "This is the past: it can be watched, not changed. Press Now to come back.";
    if (this.store.hello?.mission.kind === "replay") return "This is a recording: it can be watched, not changed.";
    return "No connection to the program at the moment.";
  }
}

function rounded([x, y]: Point): Point {
  return [Math.round(x * 1000) / 1000, Math.round(y * 1000) / 1000];
}
