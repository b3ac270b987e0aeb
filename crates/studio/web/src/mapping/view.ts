// The map side of the page: one pane, or two side by side with the same window, and the controls that float on them.

import { h, setText } from "../dom";
import { coordinate } from "../format";
import { icon, type IconName } from "../icons";
import { scaleBar } from "../map/camera";
import { onThemeChange } from "../theme";
import { layersMenu, rememberedLayers } from "./layers";
import { Pane } from "./pane";
import { mapRamp, patchRamp } from "./ramp";
import type { Store } from "./store";

const SCALE_BAR_MAX_PX = 110;
/** The window of a growing map is fitted again when the map outgrows it by so much. */
const FIT_SLACK_RATIO = 1.08;

export class View {
  readonly element = h("div", { class: "map-view" });
  readonly layers = rememberedLayers();
  readonly panes: readonly [Pane, Pane];
  follow = false;
  private readonly holder = h("div", { class: "panes" });
  private readonly menu: HTMLElement;
  private readonly layersButton: HTMLButtonElement;
  private readonly followButton: HTMLButtonElement;
  private readonly scale = h("div", { class: "bar" });
  private readonly scaleLabel = h("span");
  private readonly at = h("span", { class: "readout at", hidden: true });
  /** The window fits the map until the user moves it. */
  private isFitted = true;
  private fitted_m: [number, number, number, number] | null = null;

  constructor(private readonly store: Store) {
    const events = {
      moved: (pane: Pane): void => {
        this.isFitted = false;
        this.setFollow(false);
        this.windowChanged(pane);
      },
      hover: (at_m: [number, number] | null, cell: number): void => this.showPointer(at_m, cell),
    };
    this.panes = [new Pane(0, store, this.layers, events), new Pane(1, store, this.layers, events)];
    this.panes[1].element.hidden = true;
    this.holder.append(this.panes[0].element, this.panes[1].element);
    this.menu = layersMenu(this.layers, () => this.panes.forEach((pane) => pane.invalidate()));
    this.followButton = this.viewButton("follow", "Follow the robot (C)", () => this.setFollow(!this.follow));
    this.followButton.setAttribute("aria-pressed", "false");
    this.layersButton = this.viewButton("layers", "Layers (L)", () => this.toggleLayers());
    this.layersButton.setAttribute("aria-expanded", "false");
    this.layersButton.setAttribute("aria-controls", "layers-menu");
    this.element.append(
      this.holder,
      h("div", { class: "readouts" }, h("div", { class: "readout" }, h("div", { class: "scale" }, this.scaleLabel, this.scale), legend()), this.at),
      h("div", { class: "float view-tools", role: "toolbar", "aria-label": "View" },
        this.viewButton("minus", "Zoom out (−)", () => this.zoom(1 / 1.3)),
        this.viewButton("plus", "Zoom in (+)", () => this.zoom(1.3)),
        this.viewButton("fit", "Fit the map (F)", () => this.fit()),
        this.followButton, this.layersButton),
      this.menu,
    );
    document.addEventListener("pointerdown", (event) => {
      const inside = event.target instanceof Element && event.target.closest("#layers-menu, [aria-controls=layers-menu]");
      if (!inside && !this.menu.hidden) this.toggleLayers();
    });
    new ResizeObserver(() => this.resize()).observe(this.holder);
    onThemeChange(() => {
      store.restyle(mapRamp(), patchRamp());
      for (const pane of this.panes) pane.restyle();
    });
    store.on("source", () => {
      if (store.source?.phase === "ready" && store.state?.runs.length === 1) this.isFitted = true;
    });
    store.on("state", () => this.onState());
    store.on("board", () => this.growWindow());
    const frame = (): void => {
      for (const pane of this.panes) pane.frame();
      requestAnimationFrame(frame);
    };
    requestAnimationFrame(frame);
  }

  fit(): void {
    this.isFitted = true;
    this.setFollow(false);
    this.fitted_m = null;
    this.growWindow();
  }

  zoom(factor: number): void {
    const { camera } = this.panes[0];
    camera.zoomAt(camera.width_px / 2, camera.height_px / 2, factor);
    this.isFitted = false;
    this.windowChanged(this.panes[0]);
  }

  pan(dx_px: number, dy_px: number): void {
    this.panes[0].camera.panBy(dx_px, dy_px);
    this.isFitted = false;
    this.setFollow(false);
    this.windowChanged(this.panes[0]);
  }

  setFollow(follow: boolean): void {
    if (this.follow === follow) return;
    this.follow = follow;
    if (follow) this.isFitted = false;
    this.followButton.setAttribute("aria-pressed", String(follow));
    this.onState();
  }

  toggleLayers(): void {
    this.menu.hidden = !this.menu.hidden;
    this.layersButton.setAttribute("aria-expanded", String(!this.menu.hidden));
    if (!this.menu.hidden) this.menu.querySelector("input")?.focus();
    else if (this.menu.contains(document.activeElement)) this.layersButton.focus();
  }

  /** True when there was a menu to close. */
  closeMenus(): boolean {
    if (this.menu.hidden) return false;
    this.toggleLayers();
    this.layersButton.focus();
    return true;
  }

  private onState(): void {
    const isPair = (this.store.state?.runs.length ?? 0) > 1;
    if (this.panes[1].element.hidden === isPair) {
      this.panes[1].element.hidden = !isPair;
      this.holder.classList.toggle("pair", isPair);
      this.resize();
    }
    const pose = this.store.newest?.pose;
    if (this.follow && pose) {
      this.panes[0].camera.centre_m = [pose[0], pose[1]];
      this.windowChanged(this.panes[0]);
    }
  }

  private resize(): void {
    for (const pane of this.panes) if (!pane.element.hidden) pane.resize();
    this.fitted_m = null;
    if (this.isFitted) this.growWindow();
    else this.windowChanged(this.panes[0]);
    for (const pane of this.panes) pane.frame();
  }

  /** Fits the window to both maps, when they have outgrown it or it is not fitted yet. */
  private growWindow(): void {
    if (!this.isFitted) return;
    const bounds = union(this.store.boards.map((board) => board?.bounds_m() ?? null));
    if (!bounds || (this.fitted_m && holds(this.fitted_m, bounds))) return;
    this.fitted_m = widened(bounds, this.fitted_m ? FIT_SLACK_RATIO : 1);
    this.panes[0].fit(this.fitted_m);
    this.windowChanged(this.panes[0]);
  }

  private windowChanged(by: Pane): void {
    for (const pane of this.panes) if (pane !== by) pane.copyWindow(by);
    by.invalidate();
    const { label, length_px } = scaleBar(by.camera.scale_pxpm, SCALE_BAR_MAX_PX);
    this.scale.style.width = `${length_px.toFixed(1)}px`;
    setText(this.scaleLabel, label);
  }

  private showPointer(at_m: [number, number] | null, cell: number): void {
    this.at.hidden = at_m === null || this.store.state === null;
    if (!at_m) return;
    const what = cell === 0 ? "unknown" : `${Math.round(((cell - 1) / 254) * 100)} % occupied`;
    setText(this.at, `${coordinate(at_m[0])}, ${coordinate(at_m[1])} m · ${what}`);
  }

  private viewButton(name: IconName, title: string, act: () => void): HTMLButtonElement {
    return h("button", { class: "button square", type: "button", "aria-label": title.replace(/ \(.*\)$/, ""), title, onclick: act }, icon(name));
  }
}

function legend(): HTMLElement {
  const entry = (name: string, text: string): HTMLElement => h("span", { class: "cell-key" }, h("i", { class: name }), text);
  return h("div", { class: "cell-legend" }, entry("unknown", "unknown"), entry("free", "free"), entry("occupied", "occupied"));
}

type Bounds = [number, number, number, number];

function union(all: (Bounds | null)[]): Bounds | null {
  return all.reduce((a, b) => (a && b ? [Math.min(a[0], b[0]), Math.min(a[1], b[1]), Math.max(a[2], b[2]), Math.max(a[3], b[3])] : (a ?? b)), null);
}

function holds(outer: Bounds, inner: Bounds): boolean {
  return outer[0] <= inner[0] && outer[1] <= inner[1] && outer[2] >= inner[2] && outer[3] >= inner[3];
}

function widened([left, bottom, right, top]: Bounds, ratio: number): Bounds {
  const [dx, dy] = [((right - left) * (ratio - 1)) / 2, ((top - bottom) * (ratio - 1)) / 2];
  return [left - dx, bottom - dy, right + dx, top + dy];
}
