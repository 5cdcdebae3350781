import { unpressed } from "./dom.js";

/** The materials that are open, the one that work begins from, and what analysis says about it. */
export class Shelf extends EventTarget {
  constructor() {
    super();
    this.shelf = []; // specs of materials that were opened
    this.cards = new Map(); // their names and pictures
    this.material = null;
    this.look = null;
  }

  tell(type, detail = null) {
    this.dispatchEvent(new CustomEvent(type, { detail }));
  }

  /** Call functions at events, by their types; returns what ends that. */
  listen(listeners) {
    const control = new AbortController();
    for (const [type, listener] of Object.entries(listeners)) this.addEventListener(type, listener, { signal: control.signal });
    return () => control.abort();
  }

  /** Do something that may fail; its one line is then shown. */
  async guard(action) {
    try {
      return await action();
    } catch (error) {
      if (error.message && error.name !== "AbortError") this.tell("fault", error);
      return null;
    }
  }

  shelve(specs) {
    for (const spec of specs) if (!this.shelf.some((one) => sameJson(one, spec))) this.shelf.push(spec);
  }

  /** Twice the sample, but at most 1024 pixels a side, and never less than the sample. */
  usualSize() {
    const twice = [this.material.height, this.material.width].map((side) => Math.max(side, Math.min(1024, 2 * side)));
    return twice.some((side) => side < 512) ? twice.map((side) => Math.max(512, side)) : twice;
  }

  async useMaterial(spec) {
    if (this.material && sameJson(this.material.asked, spec)) return;
    const material = await this.api.post("materials", spec);
    const picture = await this.api.picture(`materials/${material.id}/picture`, { map: material.main, most: 2048 });
    this.material = { ...material, ...picture, asked: spec };
    this.looking?.abort();
    this.look = this.looking = this.lookJob = this.lookError = null;
    this.preview = null;
    this.tell("material");
  }

  /** Have the sample analyzed, once; "looking" is told how far that is, and "look" when it has ended. */
  analyze() {
    if (this.looking) return;
    const asked = this.material;
    const { signal } = (this.looking = new AbortController());
    const set = (type, changes) =>
      unpressed(() => {
        if (this.material !== asked) return;
        Object.assign(this, changes);
        this.tell(type);
      });
    this.api
      .found(`materials/${asked.id}/look`, {}, (lookJob) => set("looking", { lookJob }), signal)
      .then((look) => set("look", { look, lookJob: null }))
      .catch((lookError) => set("look", { lookError, lookJob: null }));
  }

  /** Have the sample analyzed again, after an error or a stop. */
  analyzeAgain() {
    this.looking = this.lookError = null;
    this.analyze();
  }

  /** The name and a picture of a material on the shelf. */
  async card(spec) {
    const key = JSON.stringify(spec);
    if (!this.cards.has(key)) {
      const material = await this.api.post("materials", spec);
      const { bitmap } = await this.api.picture(`materials/${material.id}/picture`, { map: material.main, most: 1024 });
      this.cards.set(key, { name: material.name, bitmap });
    }
    return this.cards.get(key);
  }
}

/** Whether two recipes, or materials, say the same: in any order, and with or without defaults. */
export function sameJson(one, other) {
  return plain(one) === plain(other);
}

function plain(value) {
  return JSON.stringify(value, (_, part) => {
    if (part === null || typeof part !== "object" || Array.isArray(part)) return part;
    const told = Object.entries(part).filter(([, one]) => !DEFAULTS.has(one) && !(typeof one === "object" && Object.keys(one).length === 0));
    return Object.fromEntries(told.sort(([first], [second]) => (first < second ? -1 : 1)));
  });
}

const DEFAULTS = new Set([null, undefined, false, "auto"]);
