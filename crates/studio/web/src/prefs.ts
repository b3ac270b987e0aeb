// What the page remembers between visits, in this browser only; works without storage, too.

const PREFIX = "cairn.";

export function remembered<T extends string | number | boolean>(key: string, otherwise: T): T {
  try {
    const text = localStorage.getItem(PREFIX + key);
    if (text === null) return otherwise;
    const value: unknown = JSON.parse(text);
    return typeof value === typeof otherwise ? (value as T) : otherwise;
  } catch {
    return otherwise;
  }
}

export function remember(key: string, value: string | number | boolean): void {
  try {
    localStorage.setItem(PREFIX + key, JSON.stringify(value));
  } catch {
    // Private browsing: the choice lasts as long as the page.
  }
}
