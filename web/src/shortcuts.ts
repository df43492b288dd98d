/** Keys as in animation tools. One table: what is done by it is what is listed. */

export interface Shortcut {
  /** As `KeyboardEvent.key` names it, with `Ctrl+` and `Shift+` before; several do the same. */
  readonly keys: readonly string[];
  readonly does: string;
  /** Under which heading it is listed. */
  readonly group: string;
  readonly action: () => void;
}

/** How an event's key is written in the table. Command is Control on a Mac. */
export function keyName(event: {
  readonly key: string;
  readonly ctrlKey: boolean;
  readonly metaKey: boolean;
  readonly shiftKey: boolean;
  readonly altKey: boolean;
}): string {
  const key = event.key === " " ? "Space" : event.key.length === 1 ? event.key.toUpperCase() : event.key;
  const control = event.ctrlKey || event.metaKey ? "Ctrl+" : "";
  const alt = event.altKey ? "Alt+" : "";
  // Shift is part of what a key types: ? stays ?, but a letter or an arrow with it is another.
  const shift = event.shiftKey && (key.length > 1 || /[A-Z]/u.test(key)) ? "Shift+" : "";
  return `${control}${alt}${shift}${key}`;
}

/** Whether the element takes the keys itself. */
export function takesText(element: Element | null): boolean {
  if (!element) return false;
  if (element.matches("textarea, select, [contenteditable=true]")) return true;
  return element.matches("input") && !element.matches("[type=range], [type=checkbox]");
}

/** Whether a field lets the page have a key with Control: while something is typed, its undo is the field's own. */
function givesWay(field: Element | null, name: string): boolean {
  if (/^Ctrl\+[ACVX]$/u.test(name)) return false;
  return !/Z$|Y$/u.test(name) || !isTyping(field);
}

function isTyping(field: Element | null): field is HTMLElement {
  return field instanceof HTMLElement && field.dataset.typing === "true";
}

/** Listen on an element; returns what ends it. */
export function listen(
  target: HTMLElement | Window,
  shortcuts: readonly Shortcut[],
  asleep: () => boolean,
): () => void {
  const actions = new Map(shortcuts.flatMap((one) => one.keys.map((key) => [key, one.action] as const)));
  const pressed = (event: Event): void => {
    const key = event as KeyboardEvent;
    const focused = key.target !== null && "matches" in key.target ? (key.target as Element) : null;
    if (key.defaultPrevented || asleep()) return;
    const name = keyName(key);
    const passes = name === "Escape" || (name.startsWith("Ctrl+") && givesWay(focused, name));
    if (takesText(focused) && !passes) return;
    // A button that has the focus is pressed by these.
    if ((name === "Space" || name === "Enter") && focused?.matches("button:not(.handle), summary, [type=checkbox]"))
      return;
    if (focused?.matches("[type=range]") && name.startsWith("Arrow")) return;
    const action = actions.get(name);
    if (!action) return;
    event.preventDefault();
    if (takesText(focused) && isTyping(focused)) {
      // What was typed counts before it is saved, or exported.
      focused.blur();
      focused.focus();
    }
    action();
  };
  target.addEventListener("keydown", pressed);
  return () => target.removeEventListener("keydown", pressed);
}

const SHOWN: Record<string, string> = {
  ArrowLeft: "←",
  ArrowRight: "→",
  ArrowUp: "↑",
  ArrowDown: "↓",
  Delete: "Del",
  Escape: "Esc",
};

/** How a key of the table is shown to a person. */
export function shownKey(key: string): string {
  return key
    .split(/\+(?=.)/u)
    .map((part) => SHOWN[part] ?? part)
    .join("+");
}
