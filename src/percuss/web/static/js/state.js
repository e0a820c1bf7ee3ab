// What the page shows, as one value that fits into a link.

/** A value that tells those who watch it when it changes. */
export class Store {
  constructor(value) {
    this.value = value;
    this.watchers = new Set();
  }

  /** Replace parts of the value; `why` names the change for those who watch. */
  set(parts, why = "") {
    this.value = { ...this.value, ...parts };
    for (const watch of this.watchers) watch(this.value, why);
  }

  watch(watcher) {
    this.watchers.add(watcher);
    return () => this.watchers.delete(watcher);
  }
}

/** Return the part of a nested value at a dotted path. */
export function get(tables, path) {
  return path.split(".").reduce((part, name) => part?.[name], tables);
}

/** Return a copy with another value at a dotted path. */
export function put(tables, path, value) {
  const [name, ...rest] = path.split(".");
  const copy = Array.isArray(tables) ? [...tables] : { ...tables };
  copy[name] = rest.length === 0 ? value : put(copy[name] ?? {}, rest.join("."), value);
  return copy;
}

/** Return a state as the text of a link. */
export function encode(state) {
  const bytes = new TextEncoder().encode(JSON.stringify(state));
  let text = "";
  for (const byte of bytes) text += String.fromCharCode(byte);
  return btoa(text).replaceAll("+", "-").replaceAll("/", "_").replace(/=+$/, "");
}

/** Return the state of a link, null if it holds none. */
export function decodeLink(text) {
  try {
    const raw = atob(text.replaceAll("-", "+").replaceAll("_", "/"));
    const bytes = Uint8Array.from(raw, (letter) => letter.charCodeAt(0));
    const state = JSON.parse(new TextDecoder().decode(bytes));
    return state !== null && typeof state === "object" && state.study ? state : null;
  } catch {
    return null;
  }
}
