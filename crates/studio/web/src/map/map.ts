// The map: owns canvas and camera, draws what stands still once and what moves every frame.

import type { ClientMessage, Person } from "../protocol";
import type { Store } from "../state";
import type { Camera } from "./camera";
import { MapCanvas } from "./canvas";
import { drawCrowd } from "./crowd";
import { drawDevices, drawZones } from "./devices";
import { type FieldImage, paintField } from "./field";
import { blendFactor, blendPose } from "./interpolate";
import { Layers } from "./layers";
import { drawContacts } from "./marks";
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
  readonly layers = new Layers("", () => {
    this.sceneChanged();
    this.events.viewChanged();
  });
  readonly tools: Tools;
  follow = false;
  field: FieldImage | null = null;

  private readonly surface: MapCanvas;
  private readonly still = document.createElement("canvas");
  private isStillStale = true;
  /** The window fits the house until the user moves it; then it stays where the user put it. */
  private isFitted = true;
  private missionName = "";

  constructor(
    holder: HTMLElement,
    private readonly store: Store,
    private readonly events: MapEvents,
  ) {
    this.surface = new MapCanvas(holder, "map-canvas", "Map of the house. Arrow keys pan or move the tool, plus and minus zoom, Enter uses the tool.", {
      draw: (now_ms) => this.draw(now_ms),
      changed: () => this.resized(),
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
    store.on("hello", () => this.onHello());
    store.on("state", () => this.invalidate());
    store.on("reset", () => this.invalidate());
  }

  get canvas(): HTMLCanvasElement {
    return this.surface.canvas;
  }

  get camera(): Camera {
    return this.surface.camera;
  }

  get n_frames(): number {
    return this.surface.n_frames;
  }

  invalidate(): void {
    this.surface.invalidate();
  }

  sceneChanged(): void {
    this.isStillStale = true;
    this.invalidate();
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
    this.layers.offer(this.store.hello?.layers ?? []);
    this.paintField();
    const name = this.store.hello?.mission.name ?? "";
    if (this.isFitted || name !== this.missionName) this.fit();
    this.missionName = name;
    this.sceneChanged();
  }

  private paintField(): void {
    const field = this.store.hello?.pheromones ?? null;
    this.field = field && paintField(field, this.surface.palette);
  }

  /** Another size, or other colours. */
  private resized(): void {
    this.paintField();
    this.still.width = this.canvas.width;
    this.still.height = this.canvas.height;
    if (this.isFitted) this.fit();
    this.tools.cameraMoved();
    this.sceneChanged();
    this.events.viewChanged();
  }

  /** True while the picture is still on its way to the latest state. */
  private draw(now_ms: number): boolean {
    const { hello, latest, previous } = this.store;
    if (!hello) return false;
    const factor = latest ? blendFactor(previous, latest, now_ms) : 1;
    const robots = this.robotsNow(factor);
    if (this.follow && robots[0]) {
      this.camera.centre_m = [robots[0].truth[0], robots[0].truth[1]];
      this.isStillStale = true;
      this.tools.cameraMoved();
      this.events.viewChanged();
    }
    if (this.isStillStale) this.drawStill();
    const { context } = this.surface;
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.drawImage(this.still, 0, 0);
    this.drawMoving(this.surface.pen(), robots, factor);
    return factor < 1;
  }

  private drawMoving(pen: Pen, robots: RobotNow[], factor: number): void {
    const { hello, state, previous } = this.store;
    if (!hello) return;
    const { layers } = this;
    if (layers.has("zones")) drawZones(pen, hello.world.devices, state);
    for (const robot of robots) {
      const trails = this.store.trails.get(robot.info.id);
      if (layers.has("trail") && trails) drawTrail(pen, trails.truth, state?.t_s ?? 0, robot.truth);
    }
    if (hello.crowd && state?.crowd) drawCrowd(pen, hello.crowd, state.crowd, previous?.state.crowd, factor);
    for (const robot of robots) drawSensing(pen, robot, layers);
    if (layers.has("contacts")) drawContacts(pen, this.store.contacts, this.store.until_s);
    for (const thing of state?.things ?? []) drawThing(pen, thing, layers.has("names"));
    for (const robot of robots) drawIntentions(pen, robot, layers);
    drawDevices(pen, hello.world.devices, state, this.tools.hoveredDevice);
    for (const person of state?.people ?? []) drawPerson(pen, personNow(person, previous?.state.people, factor), layers.has("names"));
    for (const robot of robots) drawRobot(pen, robot, hello, layers);
    this.tools.draw(pen);
  }

  private drawStill(): void {
    const context = this.still.getContext("2d");
    const hello = this.store.hello;
    if (!context || !hello) return;
    this.isStillStale = false;
    drawScene(this.surface.pen(context), hello, this.layers, this.field);
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
}

function personNow(person: Person, before: Person[] | undefined, factor: number): Person {
  const then = before?.find(({ name }) => name === person.name);
  return { ...person, at: blendPose(then?.at, person.at, factor) };
}
