import { field, fill, h, icon, segments } from "../dom.js";
import { parameterForm } from "../form.js";
import { number, said, t } from "../strings.js";
import { meter } from "./sample.js";
import { beginTask } from "./tasks.js";

const SHOWN = 1024; // pixels a side of a picture in the panel

/** A box for a number that may be empty; `set` gets null then. */
function numberBox(value, set, props = {}) {
  const box = h("input", { type: "number", min: 0, step: "any", inputmode: "decimal", value: value ?? "", onchange: () => set(box.value === "" ? null : Number(box.value)), ...props });
  return box;
}

function canvasOf(bitmap, label) {
  const canvas = h("canvas", { class: "shown", width: bitmap.width, height: bitmap.height, role: "img", "aria-label": label });
  canvas.getContext("2d").drawImage(bitmap, 0, 0);
  return canvas;
}

/** How wide what is saved is in meters, and its pixels per meter. */
export class SizeGroup {
  constructor(screen) {
    this.screen = screen;
  }

  draw() {
    const { app, wanted } = this.screen;
    const { width, height, density } = this.screen.source;
    const spec = app.recipe.materials[0];
    const now = density && (wanted.density ?? density);
    const meters = [width, height].map((side) => side / density);
    const wish = [...meters];
    const free = density && app.result && app.recipe.task === "synth" && !app.recipe.guide;
    const make = () => {
      app.edit({ size: [wish[1], wish[0]].map((side) => Math.round(side * density)) });
      app.tell("go", { screen: "make", now: true });
    };
    return [
      h("p", { class: "hint", role: "status" }, density ? t("size.is", { width: number(meters[0], 3), height: number(meters[1], 3), density: number(now, 1) }) : t("size.unknown")),
      field(t("size.sample"), numberBox(spec.sample_width, (value) => this.measure(value)), { help: t("size.sample.help") }),
      density ? field(t("size.density"), numberBox(wanted.density, (value) => ((wanted.density = value), this.screen.draw()), { placeholder: number(density, 1) }), { help: t("size.density.help") }) : null,
      free ? h("div", { class: "field" }, h("span", {}, t("size.make")), h("div", { class: "size" }, [0, 1].map((k) => [k ? h("span", { "aria-hidden": "true" }, "×") : null, numberBox(Number(meters[k].toPrecision(4)), (value) => (wish[k] = value ?? meters[k]), { "aria-label": t(k ? "size.high" : "size.wide") })]))) : null,
      free ? h("button", { type: "button", onclick: make }, t("size.go")) : null,
    ];
  }

  /** Say how wide the sample is; pixels stay, so a result of it is there at once. */
  measure(width) {
    const { app } = this.screen;
    return this.screen.attempt(async () => {
      const [first, ...others] = app.recipe.materials;
      const { sample_width: _, ...spec } = first;
      if (width !== null) spec.sample_width = width;
      await app.api.post("materials", spec); // one that is wrong is refused before anything changes
      if (!app.result) return app.mend({ sample_width: width }, t("history.measured"));
      app.shelve([spec]);
      await app.make({ ...app.recipe, materials: [spec, ...others] }, t("history.measured"));
    }, "size");
  }
}

/** Whether what is saved is tileable, in words and in a picture; a border for upscalers. */
export class BordersGroup {
  constructor(screen) {
    this.screen = screen;
  }

  forget() {
    this.found = this.picture = null;
    this.stop?.abort();
  }

  draw() {
    const { found, picture } = this;
    const good = (both) => both.every((one) => one.good);
    const maps = Object.entries(found?.maps ?? {});
    const bad = maps.filter(([, both]) => !good(both));
    return [
      this.stop ? this.progress.parts : h("button", { type: "button", onclick: () => this.check() }, icon("repeat"), t("borders.check")),
      maps.map(([name, both]) =>
        h(
          "div",
          { class: good(both) ? "note" : "note error", "data-tileable": String(good(both)) },
          icon(good(both) ? "check" : "warn"),
          h("div", {}, h("strong", {}, maps.length > 1 ? `${name}: ${t(good(both) ? "borders.yes" : "borders.no")}` : t(good(both) ? "borders.yes" : "borders.no")), both.map((one, axis) => h("p", {}, this.told(one, axis)))),
        ),
      ),
      picture ? h("figure", {}, canvasOf(picture.bitmap, t("borders.picture", { map: picture.map })), h("figcaption", { class: "hint" }, t("borders.picture", { map: picture.map }))) : null,
      bad.length ? h("button", { type: "button", onclick: () => this.repair() }, t("borders.repair")) : null,
    ];
  }

  told({ steps, seam }, axis) {
    const [mostSteps, mostSeam] = this.found.most;
    const line = t("borders.steps", { way: t(axis ? "borders.x" : "borders.y"), n: number(steps, 1), most: number(mostSteps, 1) });
    return seam === null ? line : `${line} ${t("borders.seam", { n: number(100 * seam), most: number(100 * mostSeam) })}`;
  }

  check() {
    const { screen } = this;
    return screen.attempt(async () => {
      const of = screen.source.id;
      this.forget();
      const control = (this.stop = new AbortController());
      this.progress = meter(() => control.abort());
      screen.draw();
      const found = await screen.ask((path) => screen.app.api.found(`${path}/borders`, {}, this.progress.tell, control.signal)).finally(() => (this.stop = null));
      const badness = ([, both]) => Math.max(...both.map(({ steps, seam }) => Math.max(steps / found.most[0], (seam ?? 0) / found.most[1])));
      const [worst] = Object.entries(found.maps).sort((one, other) => badness(other) - badness(one));
      const isBad = worst[1].some((one) => !one.good);
      const shown = isBad ? await screen.ask((path) => screen.app.api.picture(`${path}/borders/picture`, { map: worst[0], most: SHOWN })) : null;
      if (screen.source.id !== of) return;
      this.found = found;
      this.picture = shown && { bitmap: shown.bitmap, map: worst[0] };
    }, "borders").finally(() => screen.draw());
  }

  repair() {
    const { app } = this.screen;
    return this.screen.attempt(async () => {
      if (app.result) await app.useAsSample(app.result);
      beginTask(app, "tile");
      app.tell("go", { screen: "make", now: true });
    }, "borders");
  }
}

/** Pixels of the opposite sides around what is saved, or such pixels taken off. */
export function wrapGroup({ wanted }) {
  const box = (key) => field(t(`wrap.${key}`), numberBox(wanted[key], (value) => (wanted[key] = value), { step: 1, inputmode: "numeric" }));
  return [h("p", { class: "hint" }, t("wrap.help")), box("pad"), box("crop")];
}

/** Corner tiles of the sample: made with a preview, shown, and saved. */
export class AtlasGroup {
  constructor(screen) {
    this.screen = screen;
    this.values = {};
    this.plane = false;
  }

  forget() {
    this.made = this.saved = this.picture = null;
    this.stop?.abort();
  }

  draw() {
    const { made, picture } = this;
    const { about, material } = this.screen.app;
    const usual = Math.min(512, material.width, material.height);
    const options = about.tasks.atlas.map((one) => ({ ...one, type: "int", low: one.low ?? 32, high: one.high ?? (one.name === "gutter" ? 64 : 1024), usual: one.default ?? usual, unit: one.name === "colors" ? "" : "px", label: t(`atlas.${one.name}`) }));
    const views = [["tiles", t("atlas.tiles")], ["plane", t("atlas.plane")]];
    return [
      h("p", { class: "hint" }, t("atlas.help")),
      parameterForm(options, this.values, () => {}),
      this.stop ? this.progress.parts : h("button", { type: "button", onclick: () => this.make() }, icon("grid"), t("atlas.go")),
      (this.view = h("div", {}, picture ? canvasOf(picture, t("atlas.title")) : null)),
      made
        ? [
            segments(t("atlas.show"), views, this.plane ? "plane" : "tiles", (one) => this.screen.attempt(() => this.show(one === "plane"), "atlas")),
            h("p", { role: "status" }, t("atlas.made", { n: made.tiles, width: made.tile[1], height: made.tile[0] })),
            made.notes.map((line) => h("p", { class: "hint" }, said(line))),
            h("button", { type: "button", onclick: () => this.save() }, icon("take"), t("atlas.save")),
            this.saved,
          ]
        : null,
    ];
  }

  make() {
    const { screen } = this;
    const { api } = screen.app;
    return screen.attempt(async () => {
      this.forget();
      const control = (this.stop = new AbortController());
      this.progress = meter(() => control.abort());
      screen.draw();
      let seen = 0;
      const tell = async (job) => {
        this.progress.tell(job);
        if (job.preview === seen) return;
        seen = job.preview;
        const preview = await api.picture(`jobs/${job.id}/preview`, {}, control.signal).catch(() => null);
        if (!preview || this.made || this.stop !== control) return;
        this.picture = preview.bitmap;
        fill(this.view, canvasOf(preview.bitmap, t("atlas.title")));
      };
      try {
        const made = await screen.ask((path) => api.found(`${path}/atlases`, this.values, tell, control.signal));
        if (this.stop === control) this.made = made;
      } finally {
        if (this.stop === control) this.stop = null;
      }
      if (this.made) await this.show(this.plane);
    }, "atlas").finally(() => screen.draw());
  }

  async show(plane) {
    this.plane = plane;
    const { bitmap } = await this.screen.app.api.picture(`atlases/${this.made.id}/picture`, { most: SHOWN, plane: plane ? 1 : null });
    this.picture = bitmap;
    this.screen.draw();
  }

  save() {
    const { screen } = this;
    return screen.attempt(async () => {
      const ticket = await screen.app.api.post(`atlases/${this.made.id}/exports`, { name: `${screen.name}_tiles` });
      this.saved = screen.ticket(ticket);
      screen.draw();
      this.saved.click();
    }, "atlas");
  }
}
