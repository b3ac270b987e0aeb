// The map: owns canvas and camera, draws what stands still once and what moves every frame.

import { h } from "../dom";
import type { ClientMessage, Person } from "../protocol";
import type { Store } from "../state";
import { onThemeChange } from "../theme";
import { Camera } from "./camera";
import { drawCrowd } from "./crowd";
import { drawDevices, drawZones } from "./devices";
import { type FieldImage, paintField } from "./field";
import { attachGestures } from "./gestures";
import { blendFactor, blendPose } from "./interpolate";
import { type Layers, rememberedLayers } from "./layers";
import { readPalette } from "./palette";
import type { Pen } from "./pen";
import { drawPerson } from "./people";
import { drawIntentions, drawRobot, drawSensing, drawTrail, type RobotNow } from "./robots";
import { drawScene, drawThing } from "./scene";
import { Tools, type ToolName } from "./tools";

/** Room for what floats at the map's edges when fitting. */
const FIT_MARGINS_PX = { x: 20, top: 22, bottom: 22 };

export interface MapEvents {
  send(message: ClientMessage): boolean;
  say(text: string): void;
  toolChanged(tool: ToolName): void;
  followChanged(follow: boolean): void;
  /** Camera or pointer moved: scale bar and coordinates are out of date. */
  viewChanged(): void;
}

export class MapView {
  readonly canvas = h("canvas", { id: "map-canvas", tabindex: 0, role: "application", "aria-roledescription": "map", "aria-label": "Map of the house. Arrow keys pan or move the tool, plus and minus zoom, Enter uses the tool." });
  readonly camera = new Camera();
  readonly layers: Layers = rememberedLayers();
  readonly tools: Tools;
  follow = false;
  n_frames = 0;
  field: FieldImage | null = null;

  private readonly context: CanvasRenderingContext2D;
  private readonly still = document.createElement("canvas");
  private palette = readPalette();
  private isStillStale = true;
  private isStale = true;
  /** The window fits the house until the user moves it; then it stays where the user put it. */
  private isFitted = true;
  private missionName = "";

  constructor(
    holder: HTMLElement,
    private readonly store: Store,
    private readonly events: MapEvents,
  ) {
    const context = this.canvas.getContext("2d");
    if (!context) throw new Error("this browser has no canvas 2-D context");
    this.context = context;
    holder.append(this.canvas);
    this.tools = new Tools(store, this.camera, {
      send: (message) => events.send(message),
      say: (text) => events.say(text),
      toolChanged: (tool) => {
        this.canvas.dataset["tool"] = tool;
        events.toolChanged(tool);
      },
      changed: () => {
        this.invalidate();
        this.canvas.classList.toggle("over-thing", this.tools.hoveredDevice !== null);
        events.viewChanged();
      },
    });
    attachGestures(this.canvas, this.camera, {
      press: (at_px) => this.tools.press(at_px),
      drag: (at_px) => this.tools.drag(at_px),
      release: () => this.tools.release(),
      cancel: () => this.tools.cancel(),
      click: (at_px) => this.tools.click(at_px),
      hover: (at_px) => this.tools.hover(at_px),
      moved: () => {
        this.setFollow(false);
        this.cameraMoved();
      },
    });
    new ResizeObserver(() => this.resize()).observe(holder);
    onThemeChange(() => this.restyle());
    store.on("hello", () => this.onHello());
    store.on("state", () => this.invalidate());
    store.on("reset", () => this.invalidate());
    const frame = (now_ms: number): void => {
      this.frame(now_ms);
      requestAnimationFrame(frame);
    };
    requestAnimationFrame(frame);
  }

  invalidate(): void {
    this.isStale = true;
  }

  sceneChanged(): void {
    this.isStillStale = true;
    this.isStale = true;
  }

  fit(): void {
    const hello = this.store.hello;
    if (!hello) return;
    this.camera.fit(hello.world.bounds_m, FIT_MARGINS_PX);
    this.setFollow(false);
    this.cameraMoved();
    this.isFitted = true;
  }

  zoom(factor: number): void {
    this.camera.zoomAt(this.camera.width_px / 2, this.camera.height_px / 2, factor);
    this.cameraMoved();
  }

  pan(dx_px: number, dy_px: number): void {
    this.camera.panBy(dx_px, dy_px);
    this.setFollow(false);
    this.cameraMoved();
  }

  setFollow(follow: boolean): void {
    if (this.follow === follow) return;
    this.follow = follow;
    if (follow) this.isFitted = false;
    this.events.followChanged(follow);
    this.invalidate();
  }

  private cameraMoved(): void {
    this.isFitted = false;
    this.tools.cameraMoved();
    this.sceneChanged();
    this.events.viewChanged();
  }

  private onHello(): void {
    const field = this.store.hello?.pheromones ?? null;
    this.field = field && paintField(field, this.palette);
    const name = this.store.hello?.mission.name ?? "";
    if (this.isFitted || name !== this.missionName) this.fit();
    this.missionName = name;
    this.sceneChanged();
  }

  private restyle(): void {
    this.palette = readPalette();
    const field = this.store.hello?.pheromones ?? null;
    this.field = field && paintField(field, this.palette);
    this.sceneChanged();
  }

  private resize(): void {
    const box = this.canvas.getBoundingClientRect();
    const density = window.devicePixelRatio || 1;
    this.camera.width_px = Math.max(1, box.width);
    this.camera.height_px = Math.max(1, box.height);
    for (const canvas of [this.canvas, this.still]) {
      canvas.width = Math.round(box.width * density);
      canvas.height = Math.round(box.height * density);
    }
    if (this.isFitted) this.fit();
    this.tools.cameraMoved();
    this.sceneChanged();
    this.draw(performance.now());
    this.events.viewChanged();
  }

  private frame(now_ms: number): void {
    if (this.isStale) this.draw(now_ms);
  }

  private draw(now_ms: number): void {
    const { hello, latest, previous } = this.store;
    if (!hello) return;
    const factor = latest ? blendFactor(previous, latest, now_ms) : 1;
    // Keep drawing while the picture is still on its way to the latest state.
    this.isStale = factor < 1;
    this.n_frames += 1;
    const robots = this.robotsNow(factor);
    if (this.follow && robots[0]) {
      this.camera.centre_m = [robots[0].truth[0], robots[0].truth[1]];
      this.isStillStale = true;
      this.tools.cameraMoved();
      this.events.viewChanged();
    }
    if (this.isStillStale) this.drawStill();
    const pen = this.pen(this.context);
    this.context.setTransform(1, 0, 0, 1, 0, 0);
    this.context.drawImage(this.still, 0, 0);
    this.scale(this.context);
    this.drawMoving(pen, robots, factor);
  }

  private drawMoving(pen: Pen, robots: RobotNow[], factor: number): void {
    const { hello, state, previous } = this.store;
    if (!hello) return;
    const { layers } = this;
    if (layers.zones) drawZones(pen, hello.world.devices, state);
    for (const robot of robots) {
      const trails = this.store.trails.get(robot.info.id);
      if (layers.trail && trails) drawTrail(pen, trails.truth, state?.t_s ?? 0, robot.truth);
    }
    if (hello.crowd && state?.crowd) drawCrowd(pen, hello.crowd, state.crowd, previous?.state.crowd, factor);
    for (const robot of robots) drawSensing(pen, robot, layers);
    for (const thing of state?.things ?? []) drawThing(pen, thing, layers.names);
    for (const robot of robots) drawIntentions(pen, robot, layers);
    drawDevices(pen, hello.world.devices, state, this.tools.hoveredDevice);
    for (const person of state?.people ?? []) drawPerson(pen, personNow(person, previous?.state.people, factor), layers.names);
    for (const robot of robots) drawRobot(pen, robot, hello, layers);
    this.tools.draw(pen);
  }

  private drawStill(): void {
    const context = this.still.getContext("2d");
    const hello = this.store.hello;
    if (!context || !hello) return;
    this.isStillStale = false;
    this.scale(context);
    drawScene(this.pen(context), hello, this.layers, this.field);
  }

  private robotsNow(factor: number): RobotNow[] {
    const { hello, state, previous } = this.store;
    const robots: RobotNow[] = [];
    for (const info of hello?.robots ?? []) {
      const now = state?.robots.find(({ id }) => id === info.id);
      if (!now) continue;
      const before = previous?.state.robots.find(({ id }) => id === info.id);
      const truth = blendPose(before?.truth, now.truth, factor);
      robots.push({ info, state: now, truth, estimate: blendPose(before?.estimate, now.estimate, factor) });
    }
    return robots;
  }

  private scale(context: CanvasRenderingContext2D): void {
    const density = this.canvas.width / this.camera.width_px;
    context.setTransform(density, 0, 0, density, 0, 0);
  }

  private pen(context: CanvasRenderingContext2D): Pen {
    return { context, camera: this.camera, palette: this.palette };
  }
}

function personNow(person: Person, before: Person[] | undefined, factor: number): Person {
  const then = before?.find(({ name }) => name === person.name);
  return { ...person, at: blendPose(then?.at, person.at, factor) };
}
