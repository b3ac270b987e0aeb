// The protocol trace: the last 500 packets of every link; only the rows in sight exist as elements.

import { h, setText } from "../dom";
import type { ClientMessage, LinkInfo, TraceItem } from "../protocol";
import type { Store } from "../state";
import { emptyState } from "./empty";

const ROW_PX = 24;
const N_SPARE_ROWS = 6;

export class WirePanel {
  readonly element = h("div", { class: "wire" });
  private readonly filters = h("div", { class: "filters", role: "group", "aria-label": "Links shown" });
  private readonly pause = h("button", { class: "button small", type: "button", "aria-pressed": "false" }, "Hold");
  private readonly counted = h("span", { class: "count number" });
  private readonly scroll = h("div", { class: "wire-scroll", tabindex: 0, role: "table", "aria-label": "Packets" });
  private readonly spacer = h("div", { class: "wire-spacer", role: "rowgroup" });
  private readonly detail = h("div", { class: "wire-detail", hidden: true });
  private readonly empty = emptyState("No packets yet", "Every packet between navigation, robot, pheromone server and decision program appears here when the run plays.");
  private readonly hidden = new Set<number>();
  private held: TraceItem[] | null = null;
  private rows: TraceItem[] = [];
  private selected: TraceItem | null = null;
  private readonly refreshers: (() => void)[] = [];
  private until_s = Infinity;
  private visible = false;
  private isStale = true;
  private scheduled = false;

  constructor(private readonly store: Store, private readonly send: (message: ClientMessage) => boolean) {
    this.pause.addEventListener("click", () => this.toggleHold());
    this.scroll.addEventListener("scroll", () => this.schedule(false));
    this.scroll.append(this.spacer);
    const head = h("div", { class: "wire-row wire-head", "aria-hidden": "true" }, ...["time, s", "link", "to", "meaning", "bytes"].map((text) => h("span", {}, text)));
    this.element.append(h("div", { class: "panel-bar" }, this.filters, this.counted, this.pause), head, h("div", { class: "wire-body" }, this.scroll, this.empty), this.detail);
    this.scroll.addEventListener("click", (event) => this.select(event.target));
    this.scroll.addEventListener("keydown", (event) => this.onKey(event));
    store.on("hello", () => this.onHello());
    store.on("trace", () => this.schedule(true));
    store.on("state", () => {
      for (const refresh of this.refreshers) refresh();
      if (store.until_s === this.until_s) return;
      this.until_s = store.until_s;
      this.schedule(true);
    });
    store.on("reset", () => {
      this.held = null;
      this.showHold();
      this.schedule(true);
    });
    new ResizeObserver(() => this.schedule(false)).observe(this.scroll);
  }

  setVisible(visible: boolean): void {
    this.visible = visible;
    if (visible) this.schedule(true);
  }

  private onHello(): void {
    this.filters.replaceChildren();
    this.refreshers.length = 0;
    for (const link of this.store.hello?.links ?? []) this.filters.append(h("span", { class: "link-chip" }, this.filter(link), this.scissors(link)));
    this.schedule(true);
  }

  private filter(link: LinkInfo): HTMLElement {
    const baud = link.baud === null ? "" : `, ${link.baud} baud`;
    const button = h("button", { class: "chip", type: "button", "aria-pressed": String(!this.hidden.has(link.id)), "data-link": link.id, title: `${link.ends.join(" ↔ ")}${baud}` }, h("i", { class: `dot link-${link.id % 4}` }), link.name);
    button.addEventListener("click", () => {
      if (!this.hidden.delete(link.id)) this.hidden.add(link.id);
      button.setAttribute("aria-pressed", String(!this.hidden.has(link.id)));
      this.schedule(true);
    });
    return button;
  }

  /** Cuts a line and mends it. What is cut is said in the log; a run that begins has whole lines. */
  private scissors(link: LinkInfo): HTMLElement | null {
    const { robot, line } = link;
    if (robot == null || line == null) return null;
    const button = h("button", { class: "chip cut", type: "button", "aria-pressed": "false" }, "Cut");
    const show = (isCut: boolean): void => {
      button.setAttribute("aria-pressed", String(isCut));
      setText(button, isCut ? "Mend" : "Cut");
      button.title = `${isCut ? "Mend" : "Cut"} the line ${link.name}, both ways`;
      button.setAttribute("aria-label", button.title);
    };
    show(false);
    button.addEventListener("click", () => {
      const cut = button.getAttribute("aria-pressed") !== "true";
      if (this.store.canIntervene && this.send({ type: "cut", robot, line, cut })) show(cut);
    });
    const refresh = (): void => void (button.disabled = !this.store.canIntervene);
    refresh();
    this.refreshers.push(refresh);
    return button;
  }

  private toggleHold(): void {
    this.held = this.held ? null : [...this.store.trace];
    this.showHold();
    this.schedule(true);
  }

  private showHold(): void {
    this.pause.setAttribute("aria-pressed", String(this.held !== null));
    setText(this.pause, this.held ? "Go on" : "Hold");
  }

  private schedule(isStale: boolean): void {
    this.isStale ||= isStale;
    if (!this.visible || this.scheduled) return;
    this.scheduled = true;
    requestAnimationFrame(() => {
      this.scheduled = false;
      this.render();
    });
  }

  private render(): void {
    const { scroll } = this;
    // Scrolls along as long as the reader is at the end.
    const atEnd = scroll.scrollTop + scroll.clientHeight >= scroll.scrollHeight - ROW_PX * 1.5;
    if (this.isStale) {
      this.isStale = false;
      const until_s = this.store.until_s;
      const all = (this.held ?? this.store.trace).filter(({ t_s }) => t_s <= until_s);
      this.rows = all.filter(({ link }) => !this.hidden.has(link));
      this.spacer.style.height = `${this.rows.length * ROW_PX}px`;
      setText(this.counted, `${this.rows.length} of the last ${all.length} packets`);
      this.empty.hidden = this.rows.length > 0;
      if (atEnd && !this.held) scroll.scrollTop = scroll.scrollHeight;
    }
    const first = Math.max(0, Math.floor(scroll.scrollTop / ROW_PX) - N_SPARE_ROWS);
    const last = Math.min(this.rows.length, Math.ceil((scroll.scrollTop + scroll.clientHeight) / ROW_PX) + N_SPARE_ROWS);
    const wanted = this.rows.slice(first, last);
    const elements = this.spacer.children;
    while (elements.length > wanted.length) this.spacer.lastElementChild?.remove();
    wanted.forEach((item, index) => {
      const row = (elements[index] as HTMLElement | undefined) ?? this.newRow();
      this.fill(row, item, first + index);
    });
  }

  private newRow(): HTMLElement {
    const row = h("div", { class: "wire-row", role: "row" }, h("span", { role: "cell" }), h("span", { role: "cell" }, h("i"), h("em")), h("span", { role: "cell" }), h("span", { role: "cell" }), h("span", { role: "cell", class: "hex" }));
    this.spacer.append(row);
    return row;
  }

  private fill(row: HTMLElement, item: TraceItem, index: number): void {
    row.dataset["index"] = String(index);
    row.style.transform = `translateY(${index * ROW_PX}px)`;
    row.classList.toggle("selected", item === this.selected);
    const [time, link, to, text, hex] = row.children;
    if (!time || !link || !to || !text || !hex) return;
    setText(time, item.t_s.toFixed(3));
    const [dot, name] = link.children;
    if (dot) dot.className = `dot link-${item.link % 4}`;
    link.setAttribute("title", this.store.hello?.links.find(({ id }) => id === item.link)?.name ?? "");
    if (name) setText(name, this.store.hello?.links.find(({ id }) => id === item.link)?.name ?? String(item.link));
    setText(to, `→ ${item.to}`);
    setText(text, item.text);
    setText(hex, item.hex);
  }

  private select(target: EventTarget | null): void {
    const row = target instanceof Element ? target.closest<HTMLElement>(".wire-row") : null;
    const item = row ? this.rows[Number(row.dataset["index"])] : undefined;
    if (item) this.show(item === this.selected ? null : item);
  }

  /** Up and down move the selection; the first press takes the last row in sight. */
  private onKey(event: KeyboardEvent): void {
    const by = { ArrowUp: -1, ArrowDown: 1 }[event.key];
    if (by === undefined || this.rows.length === 0) return;
    event.preventDefault();
    const { scroll } = this;
    const now = this.selected ? this.rows.indexOf(this.selected) : -1;
    const start = now >= 0 ? now + by : Math.floor((scroll.scrollTop + scroll.clientHeight) / ROW_PX) - 1;
    const index = Math.max(0, Math.min(this.rows.length - 1, start));
    this.show(this.rows[index] ?? null);
    const top = index * ROW_PX;
    if (top < scroll.scrollTop) scroll.scrollTop = top;
    else if (top + ROW_PX > scroll.scrollTop + scroll.clientHeight) scroll.scrollTop = top + ROW_PX - scroll.clientHeight;
  }

  private show(item: TraceItem | null): void {
    this.selected = item;
    this.detail.hidden = this.selected === null;
    if (this.selected) this.detail.replaceChildren(h("p", {}, this.selected.text), h("code", {}, this.selected.hex));
    this.schedule(false);
  }
}
