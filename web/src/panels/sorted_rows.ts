/** A list of things that can be edited in place, under heads that sort it. */

import { make, setAttribute } from "../dom";

export interface SortedRow {
  readonly root: HTMLElement;
  /** Show the thing as it is now. */
  update(): void;
}

/** A column: its head, and the number or the text that it is sorted by. */
export interface Column<T> {
  readonly name: string;
  readonly title: string;
  value(item: T): number | string;
}

export class SortedRows<T extends { readonly id: string }> {
  readonly root: HTMLElement;
  private readonly list = make("div", { class: "rowlist" });
  private readonly heads: readonly HTMLButtonElement[];
  private readonly rows = new Map<string, SortedRow>();
  private isDownward = false;
  private items: readonly T[] = [];
  /** Which row was brought into view last. */
  private current: string | null = null;

  constructor(
    private readonly columns: readonly Column<T>[],
    private readonly makeRow: (id: string) => SortedRow,
    /** Which column it is sorted by at first. */
    private column = 0,
  ) {
    this.heads = columns.map(({ name, title }, i) => {
      const head = make("button", { type: "button", class: "head", title }, name);
      head.addEventListener("click", () => {
        this.isDownward = i === this.column && !this.isDownward;
        this.column = i;
        this.update(this.items);
      });
      return head;
    });
    this.root = make("div", {}, make("div", { class: "heads" }, ...this.heads), this.list);
  }

  /** Show these; `current` is the one that is chosen elsewhere, which comes into view, once. */
  update(items: readonly T[], current: string | null = this.current): void {
    this.items = items;
    const { rows, list, column, isDownward } = this;
    const ids = new Set(items.map((item) => item.id));
    for (const [id, row] of rows) {
      if (ids.has(id)) continue;
      row.root.remove();
      rows.delete(id);
    }
    for (const { id } of items) if (!rows.has(id)) rows.set(id, this.makeRow(id));
    const by = this.columns[column] as Column<T>;
    const sign = isDownward ? -1 : 1;
    // Whoever edits a row keeps it where it is until the hand is elsewhere.
    if (!list.contains(document.activeElement)) {
      const ordered = [...items].sort((a, b) => sign * order(by.value(a), by.value(b)));
      ordered.forEach(({ id }, i) => {
        const { root } = rows.get(id) as SortedRow;
        if (list.children[i] !== root) list.insertBefore(root, list.children[i] ?? null);
      });
    } else
      for (const { id } of items) if (!rows.get(id)?.root.isConnected) list.append((rows.get(id) as SortedRow).root);
    for (const row of rows.values()) row.update();
    this.root.hidden = items.length === 0;
    if (current !== this.current) {
      this.current = current;
      this.reveal(rows.get(current ?? "")?.root);
    }
    this.heads.forEach((head, i) => {
      const arrow = i === column ? (isDownward ? " ▾" : " ▴") : "";
      if (head.textContent !== `${this.columns[i]?.name}${arrow}`)
        head.textContent = `${this.columns[i]?.name}${arrow}`;
      const how = isDownward ? "the last first" : "the first first";
      setAttribute(head, "aria-label", `Sort by ${this.columns[i]?.name}${i === column ? `, now ${how}` : ""}`);
    });
  }

  /** Scroll the list to a row that is not in view; what the list stands in stays where it is. */
  private reveal(row: HTMLElement | undefined): void {
    if (!row) return;
    const { list } = this;
    const top = row.offsetTop - list.offsetTop;
    const inView = top >= list.scrollTop && top + row.offsetHeight <= list.scrollTop + list.clientHeight;
    if (!inView) list.scrollTop = top - list.clientHeight / 2;
  }
}

function order(a: number | string, b: number | string): number {
  return typeof a === "number" && typeof b === "number" ? a - b : String(a).localeCompare(String(b));
}
