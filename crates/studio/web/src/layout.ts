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
  /** A number beside the title. */
  count?: HTMLElement | undefined;
  /** Called when the panel comes to the front or goes. */
  shown?(visible: boolean): void;
}

/** A row of tabs with their panels; arrow keys move between tabs, the choice is remembered. */
export class Tabs {
  readonly element: HTMLElement;
  private readonly list: HTMLElement;
  private readonly body = h("div", { class: "panels" });
  private tabs: readonly Tab[] = [];
  private buttons: HTMLButtonElement[] = [];
  private current: string | null = null;

  constructor(private readonly name: string, label: string) {
    this.list = h("div", { class: "tabs", role: "tablist", "aria-label": label });
    this.list.addEventListener("keydown", (event) => {
      const by = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
      if (by === undefined || this.tabs.length === 0) return;
      event.preventDefault();
      const now = this.tabs.findIndex(({ key }) => key === this.current);
      const next = (now + by + this.tabs.length) % this.tabs.length;
      this.select(this.tabs[next]?.key ?? "");
      this.buttons[next]?.focus();
    });
    this.element = h("div", { class: "slot" }, this.list, this.body);
  }

  /** These tabs, in this order; the one that was in front stays there if it is among them. */
  offer(tabs: readonly Tab[]): void {
    for (const gone of this.tabs) if (!tabs.includes(gone)) this.leave(gone);
    this.tabs = tabs;
    this.buttons = tabs.map((tab) => {
      const button = h("button", { class: "tab", type: "button", role: "tab", id: `tab-${tab.key}`, "aria-controls": `panel-${tab.key}`, onclick: () => this.select(tab.key) }, tab.title, tab.count);
      tab.panel.classList.add("panel");
      tab.panel.id = `panel-${tab.key}`;
      tab.panel.setAttribute("role", "tabpanel");
      tab.panel.tabIndex = -1;
      tab.panel.setAttribute("aria-labelledby", button.id);
      tab.panel.hidden = tab.key !== this.current;
      return button;
    });
    this.list.replaceChildren(...this.buttons);
    for (const tab of tabs) if (tab.panel.parentElement !== this.body) this.body.append(tab.panel);
    const wanted = remembered(`tab.${this.name}`, "");
    const front = [this.current, wanted].find((key) => tabs.some((tab) => tab.key === key)) ?? tabs[0]?.key;
    this.select(front ?? "", false);
  }

  /** True when this row has a panel of that name; it comes to the front. */
  show(key: string): boolean {
    const tab = this.tabs.find((candidate) => candidate.key === key);
    if (!tab) return false;
    this.select(key);
    tab.panel.focus({ preventScroll: true });
    return true;
  }

  private select(key: string, byHand = true): void {
    const changes = key !== this.current;
    this.current = key;
    this.tabs.forEach((tab, at) => {
      const visible = tab.key === key;
      tab.panel.hidden = !visible;
      this.buttons[at]?.setAttribute("aria-selected", String(visible));
      this.buttons[at]?.setAttribute("tabindex", visible ? "0" : "-1");
      if (changes) tab.shown?.(visible);
    });
    if (byHand) remember(`tab.${this.name}`, key);
  }

  private leave(tab: Tab): void {
    tab.panel.remove();
    tab.shown?.(false);
    if (tab.key === this.current) this.current = null;
  }
}
