/**
 * Steps of a session. A state is plain JSON that says how a picture is made; it is never changed, only
 * followed by another. The address holds the present one, so that it can be shared and made again.
 */
export class History {
  constructor() {
    this.entries = []; // {state, label, result}
    this.index = -1;
    this.listeners = new Set();
  }

  get present() {
    return this.entries[this.index] ?? null;
  }

  listen(listener) {
    this.listeners.add(listener);
  }

  tell() {
    for (const listener of this.listeners) listener(this.present);
  }

  push(state, label, result = null) {
    this.entries = this.entries.slice(0, this.index + 1);
    this.entries.push({ state: structuredClone(state), label, result });
    this.index = this.entries.length - 1;
    this.tell();
    return this.present;
  }

  /** The present step's picture has come. */
  complete(label, result) {
    Object.assign(this.present, { label, result });
    this.tell();
  }

  /** Put another state in the place of the present one. */
  replace(state, label, result) {
    this.entries = this.entries.slice(0, this.index);
    return this.push(state, label, result);
  }

  go(index) {
    if (index < 0 || index >= this.entries.length || index === this.index) return null;
    this.index = index;
    this.tell();
    return this.present;
  }

  undo() {
    return this.go(this.index - 1);
  }

  redo() {
    return this.go(this.index + 1);
  }
}

/** A state as the part of an address behind #, and back; null if it is none. `made`: its picture was made. */
export function toAddress(state, made = true) {
  const bytes = new TextEncoder().encode(JSON.stringify(state));
  return `#${made ? "" : "sample&"}state=${btoa(String.fromCharCode(...bytes)).replaceAll("+", "-").replaceAll("/", "_").replace(/=+$/, "")}`;
}

export function fromAddress(hash) {
  const found = /[#&]state=([\w-]+)/.exec(hash);
  if (!found) return null;
  try {
    const text = atob(found[1].replaceAll("-", "+").replaceAll("_", "/"));
    return JSON.parse(new TextDecoder().decode(Uint8Array.from(text, (one) => one.charCodeAt(0))));
  } catch {
    return null;
  }
}
