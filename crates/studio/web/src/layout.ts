// The page's columns and rows: splitters that remember where they were put, and tabs.

import { h } from "./dom";
import { remember, remembered } from "./prefs";

const KEY_STEP_PX = 24;

export interface SplitterOptions {
  element: HTMLElement;
  label: string;
  /** Name under which the size is remembered. */
  key: string;
  /** True when the splitter lies across a column at this moment (sizes are heights). */
  isHorizontal(): boolean;
  /** Size in pixels that a pointer at this place asks for. */
  sizeAt(x_px: number, y_px: number): number;
  current(): number;
  limits(): [min_px: number, max_px: number];
  apply(size_px: number | null): void;
}

/** Drag, arrow keys, double click to reset. */
export function attachSplitter(options: SplitterOptions): void {
  const { element, key } = options;
  element.setAttribute("role", "separator");
  element.setAttribute("tabindex", "0");
  element.setAttribute("aria-label", options.label);
  const orient = (): void => element.setAttribute("aria-orientation", options.isHorizontal() ? "horizontal" : "vertical");
  const name = (): string => `split.${key}.${options.isHorizontal() ? "rows" : "columns"}`;
  const set = (size_px: number): void => {
    const [min_px, max_px] = options.limits();
    const size = Math.round(Math.min(max_px, Math.max(min_px, size_px)));
    options.apply(size);
    element.setAttribute("aria-valuenow", String(size));
    remember(name(), size);
  };
  const restore = (): void => {
    orient();
    const size_px = remembered(name(), 0);
    const [min_px, max_px] = options.limits();
    options.apply(size_px > 0 ? Math.min(max_px, Math.max(min_px, size_px)) : null);
    element.setAttribute("aria-valuenow", String(Math.round(options.current())));
  };
  element.addEventListener("pointerdown", (event) => {
    event.preventDefault();
    element.setPointerCapture(event.pointerId);
    const move = (moved: PointerEvent): void => set(options.sizeAt(moved.clientX, moved.clientY));
    element.addEventListener("pointermove", move);
    element.addEventListener("lostpointercapture", () => element.removeEventListener("pointermove", move), { once: true });
  });
  element.addEventListener("keydown", (event) => {
    const sign = { ArrowLeft: 1, ArrowUp: 1, ArrowRight: -1, ArrowDown: -1 }[event.key];
    if (sign === undefined) return;
    event.preventDefault();
    const box = element.getBoundingClientRect();
    const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
    const horizontal = options.isHorizontal();
    set(options.sizeAt(horizontal ? x : x - sign * KEY_STEP_PX, horizontal ? y - sign * KEY_STEP_PX : y));
  });
  element.addEventListener("dblclick", () => {
    remember(name(), 0);
    restore();
  });
  window.addEventListener("resize", restore);
  restore();
}

export interface Tab {
  key: string;
  title: string;
  panel: HTMLElement;
  /** Called when the panel comes to the front or goes. */
  shown?(visible: boolean): void;
}

/** A row of tabs with their panels; arrow keys move between tabs, the choice is remembered. */
export class Tabs {
  readonly element: HTMLElement;
  private readonly buttons: HTMLButtonElement[] = [];
  private current = -1;

  constructor(private readonly name: string, label: string, private readonly tabs: readonly Tab[]) {
    const list = h("div", { class: "tabs", role: "tablist", "aria-label": label });
    const body = h("div", { class: "panels" });
    tabs.forEach((tab, index) => {
      const button = h("button", { class: "tab", type: "button", role: "tab", id: `tab-${tab.key}`, "aria-controls": `panel-${tab.key}`, onclick: () => this.select(index) }, tab.title);
      tab.panel.classList.add("panel");
      tab.panel.id = `panel-${tab.key}`;
      tab.panel.setAttribute("role", "tabpanel");
      tab.panel.tabIndex = -1;
      tab.panel.setAttribute("aria-labelledby", button.id);
      tab.panel.hidden = true;
      this.buttons.push(button);
      list.append(button);
      body.append(tab.panel);
    });
    list.addEventListener("keydown", (event) => {
      const by = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
      if (by === undefined) return;
      event.preventDefault();
      this.select((this.current + by + tabs.length) % tabs.length);
      this.buttons[this.current]?.focus();
    });
    this.element = h("div", { class: "slot" }, list, body);
    const wanted = tabs.findIndex(({ key }) => key === remembered(`tab.${name}`, ""));
    this.select(Math.max(0, wanted));
  }

  select(index: number): void {
    if (index === this.current) return;
    this.current = index;
    this.tabs.forEach((tab, at) => {
      const visible = at === index;
      tab.panel.hidden = !visible;
      this.buttons[at]?.setAttribute("aria-selected", String(visible));
      this.buttons[at]?.setAttribute("tabindex", visible ? "0" : "-1");
      tab.shown?.(visible);
    });
    const key = this.tabs[index]?.key;
    if (key) remember(`tab.${this.name}`, key);
  }

  /** True when this row has a panel of that name; it comes to the front. */
  show(key: string): boolean {
    const index = this.tabs.findIndex((tab) => tab.key === key);
    if (index >= 0) {
      this.select(index);
      this.tabs[index]?.panel.focus({ preventScroll: true });
    }
    return index >= 0;
  }
}
