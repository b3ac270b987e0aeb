// The map side of the page: one pane, or two side by side with the same window, and the controls that float on them.

import { h } from "../dom";
import { Layers } from "../map/layers";
import { ViewTools } from "../map/view_tools";
import { onThemeChange } from "../theme";
import { Pane } from "./pane";
import { mapRamp, patchRamp } from "./ramp";
import type { Store } from "./store";

/** The window of a growing map is fitted again when the map outgrows it by so much. */
const FIT_SLACK_RATIO = 1.08;

export class View {
  readonly layers: Layers = new Layers("mapping.", () => this.panes?.forEach((pane) => pane.invalidate()));
  readonly panes: readonly [Pane, Pane];
  readonly foot: HTMLElement;
  follow = false;
  private readonly holder = h("div", { class: "panes" });
  private readonly tools: ViewTools;
  /** The window fits the map until the user moves it. */
  private isFitted = true;
  private fitted_m: Bounds | null = null;

  constructor(element: HTMLElement, private readonly store: Store) {
    const events = {
      moved: (pane: Pane): void => {
        this.isFitted = false;
        this.setFollow(false);
        this.windowChanged(pane);
      },
      hover: (at_m: [number, number] | null, cell: number): void => this.showPointer(at_m, cell),
      resized: (): void => this.resized(),
    };
    this.panes = [new Pane(0, store, this.layers, events), new Pane(1, store, this.layers, events)];
    this.panes[1].element.hidden = true;
    this.holder.append(this.panes[0].element, this.panes[1].element);
    this.tools = new ViewTools("map", { zoom: (factor) => this.zoom(factor), fit: () => this.fit(), toggleFollow: () => this.setFollow(!this.follow) }, this.layers);
    this.foot = h("div", { class: "map-foot" }, h("div", { class: "readout" }, this.tools.scale, legend()), this.tools.buttons);
    element.append(this.holder, this.layers.menu);
    onThemeChange(() => store.restyle(mapRamp(), patchRamp()));
    store.on("source", () => {
      this.layers.offer(store.source?.layers ?? []);
      if (store.source?.phase === "ready" && store.state?.runs.length === 1) this.isFitted = true;
    });
    store.on("state", () => this.onState());
    store.on("board", () => this.growWindow());
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
    this.tools.showFollow(follow);
    this.onState();
  }

  toggleLayers(): void {
    this.tools.toggleLayers();
  }

  /** True when there was a menu to close. */
  closeMenus(): boolean {
    return this.tools.closeMenus();
  }

  private onState(): void {
    const isPair = (this.store.state?.runs.length ?? 0) > 1;
    if (this.panes[1].element.hidden === isPair) {
      this.panes[1].element.hidden = !isPair;
      this.holder.classList.toggle("pair", isPair);
    }
    const pose = this.store.newest?.pose;
    if (this.follow && pose) {
      this.panes[0].camera.centre_m = [pose[0], pose[1]];
      this.windowChanged(this.panes[0]);
    }
  }

  private resized(): void {
    this.fitted_m = null;
    if (this.isFitted) this.growWindow();
    else this.windowChanged(this.panes[0]);
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
    this.tools.showScale(by.camera.scale_pxpm);
  }

  private showPointer(at_m: [number, number] | null, cell: number): void {
    const what = cell === 0 ? "unknown" : `${Math.round(((cell - 1) / 254) * 100)} % occupied`;
    this.tools.showPlace(this.store.state === null ? null : at_m, what);
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
