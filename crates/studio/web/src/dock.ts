// The panels beside the map, in rows of tabs: which there are the program says, what is in them the page knows.

import { h } from "./dom";
import { attachSplitter, type Tab, Tabs } from "./layout";
import type { PanelInfo } from "./offer";

/** What a page has for a panel: its element, and who is told when it is in sight. */
export interface PanelView {
  element: HTMLElement;
  /** A number beside the title. */
  count?: HTMLElement;
  setVisible?(visible: boolean): void;
}

const ROW_LABELS = ["Panels", "More panels"];
const UPPER_MIN_PX = 120;
/** What the lower row and the splitter need. */
const LOWER_MIN_PX = 309;

export class Dock {
  private readonly rows: Tabs[];
  private readonly tabs = new Map<string, Tab>();
  private readonly split = h("div", { class: "split rows" });
  private offered: readonly PanelInfo[] = [];
  private shown = "";

  /** `name` is that under which choices are remembered. */
  constructor(readonly holder: HTMLElement, name: string, private readonly views: Readonly<Record<string, PanelView>>) {
    this.rows = ROW_LABELS.map((label, row) => new Tabs(row === 0 ? name : `${name}.${row}`, label));
    holder.append(this.rows[0]?.element ?? "", this.split, this.rows[1]?.element ?? "");
    attachSplitter({
      element: this.split, label: "Size of the upper panel", key: "dock", isHorizontal: () => true,
      sizeAt: (_x_px, y_px) => y_px - holder.getBoundingClientRect().top,
      current: () => this.rows[0]?.element.clientHeight ?? 0,
      limits: () => [UPPER_MIN_PX, Math.max(UPPER_MIN_PX, holder.clientHeight - LOWER_MIN_PX)],
      apply: (size_px) => (size_px === null ? holder.style.removeProperty("--dock-split") : holder.style.setProperty("--dock-split", `${size_px}px`)),
    });
  }

  /** The panels that the session has. */
  offer(panels: readonly PanelInfo[]): void {
    const shown = JSON.stringify(panels);
    if (shown === this.shown) return;
    this.shown = shown;
    this.offered = panels.filter(({ key }) => this.views[key] !== undefined);
    const rows = new Set(this.offered.map(({ row }) => row));
    this.rows.forEach((tabs, row) => {
      const mine = this.offered.filter((panel) => panel.row === row);
      tabs.offer(mine.map((panel) => this.tab(panel)));
      tabs.element.hidden = mine.length === 0;
    });
    this.split.hidden = rows.size < 2;
    this.holder.classList.toggle("one", rows.size < 2);
  }

  show(key: string): boolean {
    return this.rows.some((row) => row.show(key));
  }

  /** The panel of a digit on the keyboard. */
  showDigit(digit: number): void {
    const panel = this.offered.find((candidate) => candidate.digit === digit);
    if (panel) this.show(panel.key);
  }

  private tab({ key, title }: PanelInfo): Tab {
    const known = this.tabs.get(key);
    if (known) return known;
    const view = this.views[key];
    if (!view) throw new Error(`this page has no panel ${key}`);
    const tab: Tab = { key, title, panel: view.element, count: view.count, shown: (visible) => view.setVisible?.(visible) };
    this.tabs.set(key, tab);
    return tab;
  }
}
