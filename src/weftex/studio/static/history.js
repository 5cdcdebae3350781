/**
 * Steps of a session: a tree, in which work that continues from an earlier step begins a branch. A state is plain
 * JSON that says how a picture is made; it is never changed, only followed by another. The address holds the
 * present one, so that it can be shared and made again.
 */
export class History {
  constructor() {
    this.entries = []; // {id, parent, state, label, title, result, thumb}, the oldest first
    this.present = null;
    this.listeners = new Set();
  }

  listen(listener) {
    this.listeners.add(listener);
  }

  tell() {
    for (const listener of this.listeners) listener(this.present);
  }

  push(state, label, title, result = null) {
    const id = Array.from(crypto.getRandomValues(new Uint8Array(6)), (one) => one.toString(16).padStart(2, "0")).join("");
    this.present = { id, parent: this.present?.id ?? null, state: structuredClone(state), label, title, result };
    this.entries.push(this.present);
    this.tell();
    return this.present;
  }

  /** Change the present step, such as when its picture has come. */
  complete(changes) {
    Object.assign(this.present, changes);
    this.tell();
  }

  /** Add steps that the server stored. */
  load(steps) {
    const known = new Set(this.entries.map((one) => one.id));
    const added = steps.filter((one) => !known.has(one.id)).map(({ recipe, ...one }) => ({ ...one, state: recipe, saved: true }));
    this.entries.push(...added);
    this.tell();
    return added;
  }

  get(id) {
    return this.entries.find((one) => one.id === id) ?? null;
  }

  children(entry) {
    return this.entries.filter((one) => one.parent === entry?.id);
  }

  go(entry) {
    if (!entry || entry === this.present) return null;
    this.present = entry;
    this.tell();
    return entry;
  }

  get before() {
    return this.present && this.get(this.present.parent);
  }

  get after() {
    return this.present && (this.children(this.present).at(-1) ?? null);
  }

  /** The steps that lead to the present one, and those that redo would go through. */
  path() {
    const found = new Set();
    for (let one = this.present; one && !found.has(one); one = this.get(one.parent)) found.add(one);
    for (let one = this.after; one && !found.has(one); one = this.children(one).at(-1)) found.add(one);
    return found;
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
