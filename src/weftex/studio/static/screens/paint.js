import { drawSquare, fault, field, fill, h, icon, segments, tick } from "../dom.js";
import { parameterForm } from "../form.js";
import { Mask } from "../paint/mask.js";
import { Painter } from "../paint/tools.js";
import { sameJson } from "../shelf.js";
import { number, t } from "../strings.js";

/** Colors of labels in the files that go to the server: the first is what is not painted. */
const LABELS = [[0, 0, 0], [255, 255, 255], [230, 60, 40], [40, 110, 230], [50, 180, 90], [240, 200, 40], [160, 70, 200], [40, 190, 200]];
const TOOLS = ["brush", "erase", "lasso", "wand"];
const PURPOSES = ["hole", "use", "fuse", "guide"];

/** A hole, what may be used of the sample, a map of several materials, a guide: all painted alike. */
export class PaintScreen {
  constructor(app, stage) {
    this.app = app;
    this.stage = stage;
    this.purpose = "hole";
    this.onResult = true; // whether the result that is there is painted on, or the sample
    this.tool = "brush";
    this.radius = 14;
    this.tolerance = 24;
    this.threshold = 128;
    this.label = 1;
    this.masks = new Map();
    this.told = {}; // what was chosen for each task
    this.onSample = true; // of a guide: what is what in the sample, or where it is to be
  }

  enter(panel, { purpose = null, onResult = null } = {}) {
    this.panel = panel;
    if (purpose) this.purpose = purpose;
    if (onResult !== null) this.onResult = onResult;
    this.stage.custom = "paint";
    this.stage.single();
    this.stage.closeExtras(null);
    this.stop?.(); // it may be entered twice
    this.stop = this.app.listen({ result: () => this.begin() }); // the recipe is that of the step by then
    this.begin();
  }

  leave() {
    this.stop();
    this.pressed = false;
    this.painter?.close();
    this.painter = null;
    this.stage.main.element.classList.remove("painting");
    this.stage.custom = null;
    this.stage.title = null;
    this.panel = null;
    this.stage.mode = "picture";
    this.stage.refresh();
  }

  /** Lay out the canvas of the purpose, with what was painted on it before; the panel is drawn `anew`. */
  async begin(anew = true) {
    const { app, stage } = this;
    if (!app.material || !this.panel) return;
    const material = (this.target = this.whatIsPainted());
    this.painter?.close();
    const canvas = this.purpose === "fuse" || (this.purpose === "guide" && !this.onSample);
    if (this.sizeOf !== material.id) {
      this.sizeOf = material.id;
      this.size = material.result ? [...material.size] : [...(app.recipe.size ?? app.usualSize())].reverse();
    }
    const size = canvas ? this.size : material.size;
    const key = [this.purpose, this.onSample, material.id, size].join();
    if (!this.masks.has(key)) this.masks.set(key, new Mask(...size));
    this.mask = this.masks.get(key);
    this.key = key;
    const begun = (this.begun = {});
    const textures = this.purpose === "fuse" ? await this.textures() : null;
    if (!this.panel || this.begun !== begun) return; // left or begun again meanwhile
    this.label = Math.max(1, Math.min(this.label, this.labels() - 1));
    stage.closeExtras(null);
    stage.main.show({ picture: canvas ? blank(size) : material.bitmap, size, repeat: 1, before: null, overlay: null, background: null });
    stage.main.element.classList.add("painting");
    stage.title = t(`paint.${this.purpose}`);
    stage.buildBar();
    this.painter = new Painter(stage.main, this.mask, { tool: this.tool, radius: this.radius, tolerance: this.tolerance, label: this.label, colors: this.colors(canvas), textures });
    this.painter.onstroke = () => this.tellCount();
    this.painter.onradius = (radius) => {
      this.radius = radius;
      this.draw();
    };
    if (anew) this.draw();
    else this.tellCount();
  }

  /** The result that is there, or the sample: {id, bitmap, size, alpha, result}. */
  whatIsPainted() {
    const { material, result } = this.app;
    if (result?.bitmap && this.onResult) return { id: result.id, bitmap: result.bitmap, size: result.size, alpha: result.maps[0]?.alpha, name: t("paint.on.result"), result };
    return { id: material.id, bitmap: material.bitmap, size: material.size, alpha: material.maps[0]?.alpha, name: material.name };
  }

  /** The material that is painted on, as recipes describe it. */
  async spec() {
    return this.target.result ? this.app.asSample(this.target.result) : this.app.recipe.materials[0];
  }

  /** What fusion paints with besides what is painted on: all other materials that are open. */
  get others() {
    const own = this.target.result ? null : this.app.recipe.materials[0];
    return this.app.shelf.filter((spec) => !own || !sameJson(spec, own));
  }

  labels() {
    if (this.purpose === "fuse") return Math.max(2, 1 + this.others.length);
    return this.purpose === "guide" ? LABELS.length : 2;
  }

  /** Labels as they are shown over the picture. */
  colors(canvas) {
    if (this.purpose === "guide") return LABELS.map((color, k) => (k === 0 && !canvas ? [0, 0, 0, 0] : [...color, canvas ? 255 : 150]));
    return [[0, 0, 0, 0], this.purpose === "hole" ? [255, 60, 140, 165] : [20, 20, 22, 185]];
  }

  async textures() {
    this.cards = [{ name: this.target.name, bitmap: this.target.bitmap }, ...(await Promise.all(this.others.map((spec) => this.app.card(spec))))];
    return this.cards.map((card) => card.bitmap);
  }

  set(changes) {
    Object.assign(this, changes);
    for (const key of ["tool", "radius", "tolerance", "label"]) if (this.painter) this.painter[key] = this[key];
  }

  draw() {
    const tools = TOOLS.map((tool) =>
      h("button", { type: "button", "aria-pressed": String(tool === this.tool), onclick: () => { this.set({ tool }); this.draw(); this.focusTool(tool); }, "data-tool": tool }, icon(tool), t(`tool.${tool}`)),
    );
    this.count = h("p", { class: "hint", role: "status" });
    fill(
      this.panel,
      h("h2", {}, t("paint.title")),
      segments(t("paint.purpose"), PURPOSES.map((one) => [one, t(`paint.${one}`)]), this.purpose, (purpose) => { this.purpose = purpose; this.error = null; this.begin(); }),
      h("p", { class: "hint" }, t(`paint.${this.purpose}.help`)),
      this.error,
      this.app.result ? segments(t(this.purpose === "guide" ? "step.sample" : "paint.on"), [["result", t("paint.on.result")], ["sample", t("paint.on.sample")]], this.onResult ? "result" : "sample", (one) => { this.onResult = one === "result"; this.begin(); }) : null,
      this.purpose === "fuse" ? this.materials() : null,
      this.purpose === "guide" ? this.guideChoice() : null,
      h("div", { class: "tool-row", role: "group", "aria-label": t("paint.tools") }, tools),
      this.sliders(),
      h(
        "div",
        { class: "row" },
        h("button", { type: "button", onclick: () => this.mask.undo() }, icon("undo"), t("paint.undo")),
        h("button", { type: "button", onclick: () => this.mask.redo() }, icon("redo"), t("paint.redo")),
        h("button", { type: "button", onclick: () => this.every(() => 0) }, t("paint.clear")),
        this.purpose === "hole" || this.purpose === "use" ? h("button", { type: "button", onclick: () => this.every((one) => 1 - one) }, t("paint.invert")) : null,
      ),
      this.count,
      this.options(),
      this.action(),
      h("p", { class: "hint" }, t("paint.keys")),
    );
    this.tellCount();
  }

  /** What the task itself can be told, as the server describes it. */
  options() {
    const task = { hole: "fill", fuse: "fuse" }[this.purpose];
    if (!task) return null;
    const values = (this.told[task] ??= {});
    const form = parameterForm(this.app.about.tasks[task], values, () => {}, this.fault);
    return h("details", { open: Object.keys(values).length > 0 }, h("summary", {}, t("paint.options")), form);
  }

  focusTool(tool) {
    this.panel.querySelector(`[data-tool="${tool}"]`)?.focus();
  }

  every(rule) {
    this.mask.begin();
    this.mask.labels.forEach((one, index, all) => (all[index] = rule(one)));
    this.mask.touched(0, 0, this.mask.width, this.mask.height);
    this.mask.end();
  }

  sliders() {
    const range = (key, low, high, words) => {
      const shown = h("output", { class: "hint" }, words(this[key]));
      const box = h("input", { type: "range", min: low, max: high, step: 1, value: this[key], oninput: () => { this.set({ [key]: Number(box.value) }); shown.textContent = words(this[key]); } });
      return field(t(`paint.${key}`), box, { value: shown });
    };
    const pixels = (n) => t("sample.px", { n: number(n) });
    const parts = [];
    if (this.tool === "brush" || this.tool === "erase") parts.push(range("radius", 1, 160, pixels));
    if (this.tool === "wand") {
      parts.push(range("tolerance", 1, 128, (n) => number(n)));
      parts.push(tick(t("paint.connected"), this.painter?.connected ?? true, (on) => (this.painter.connected = on)));
    }
    if (this.purpose === "hole" || this.purpose === "use") {
      parts.push(
        h(
          "details",
          {},
          h("summary", {}, t("paint.by")),
          h(
            "div",
            { class: "parameters" },
            range("threshold", 0, 255, (n) => number(n)),
            h("div", { class: "row" }, h("button", { type: "button", onclick: () => this.painter.takeBright(this.threshold) }, t("paint.brighter")), h("button", { type: "button", onclick: () => this.painter.takeBright(this.threshold, true) }, t("paint.darker"))),
            this.target.alpha ? h("button", { type: "button", onclick: () => this.painter.takeClear() }, icon("alpha"), t("paint.clearpart")) : null,
          ),
        ),
      );
    }
    return parts;
  }

  tellCount() {
    if (!this.count) return;
    const share = 1 - this.mask.count(0) / this.mask.labels.length;
    this.count.textContent = t("paint.share", { n: number(100 * share, share < 0.1 ? 1 : 0) });
  }

  /** The materials to be painted with; more of them from the samples. */
  materials() {
    const { app } = this;
    const chips = this.cards.map(({ name, bitmap }, k) => {
      const canvas = h("canvas", { width: 60, height: 60 });
      drawSquare(canvas, bitmap);
      return h("button", { type: "button", "aria-pressed": String(k === this.label), title: k ? "" : t("paint.ground"), onclick: () => { this.set({ label: k }); this.draw(); } }, canvas, name);
    });
    const more = h("select", { "aria-label": t("paint.add"), onchange: () => more.value && this.add([{ sample: more.value }]) }, h("option", { value: "" }, t("paint.add")), app.about.samples.filter((one) => !app.shelf.some((spec) => spec.sample === one.name)).map((one) => h("option", { value: one.name }, one.name)));
    const file = h("input", { type: "file", accept: "image/*", multiple: true, hidden: true, onchange: () => app.guard(() => this.addFiles(file.files)) });
    const side = (k, name) => {
      const box = h("input", { type: "number", min: 16, value: this.size[k], "aria-label": t(name), onchange: () => { this.size = this.size.with(k, (box.value = Math.max(16, Math.trunc(Number(box.value) || 0)))); this.begin(false); } });
      return box;
    };
    return [
      h("div", { class: "shelf", role: "group", "aria-label": t("paint.materials") }, chips),
      chips.length < 2 ? h("p", { class: "hint" }, t("paint.fuse.none")) : null,
      h("div", { class: "row even" }, more, h("button", { type: "button", onclick: () => file.click() }, icon("open"), t("paint.file")), file),
      h("div", { class: "size" }, side(0, "make.width"), h("span", { "aria-hidden": "true" }, "×"), side(1, "make.height")),
    ];
  }

  async addFiles(files) {
    await this.add((await this.app.upload(files)).materials);
  }

  async add(specs) {
    this.app.shelve(specs);
    this.label = this.others.length;
    await this.app.guard(() => this.begin());
  }

  guideChoice() {
    return [
      segments(t("guide.where"), [["sample", t("guide.sample")], ["output", t("guide.output")]], this.onSample ? "sample" : "output", (one) => { this.onSample = one === "sample"; this.begin(); }),
      h(
        "div",
        { class: "shelf", role: "group", "aria-label": t("guide.labels") },
        LABELS.slice(1).map((color, k) => {
          const swatch = h("span", { class: "swatch" });
          swatch.style.background = `rgb(${color.join()})`;
          return h("button", { type: "button", "aria-pressed": String(k + 1 === this.label), "aria-label": t("guide.label", { n: k + 1 }), onclick: () => { this.set({ label: k + 1 }); this.draw(); } }, swatch, String(k + 1));
        }),
      ),
    ];
  }

  /** Do what the painting is for, once, however often the button is pressed before it begins. */
  async go() {
    if (this.pressed) return;
    this.pressed = true;
    const actions = { hole: () => this.fillHole(), use: () => this.restrict(), fuse: () => this.fuse(), guide: () => this.follow() };
    await this.attempt(actions[this.purpose]);
    this.pressed = false;
  }

  action() {
    const { app } = this;
    const masked = this.purpose === "use" && "mask" in app.recipe.materials[0];
    return [h("button", { type: "button", class: "main large", onclick: () => this.go() }, t(`paint.${this.purpose}.go`)), masked ? h("button", { type: "button", onclick: () => app.guard(() => app.mend({ mask: null }, t("paint.use.all"))) }, t("paint.use.all")) : null];
  }

  async attempt(run) {
    this.error = null;
    try {
      await run();
    } catch (error) {
      this.error = error.message ? fault(error.message) : null;
      if (this.panel) this.draw();
    }
  }

  async upload(mask, colors, name) {
    return (await this.app.api.upload(await mask.png(colors), name)).id;
  }

  async fillHole() {
    const { app } = this;
    if (!this.mask.count(1)) throw new Error(t("paint.hole.none"));
    const mask = await this.upload(this.mask, LABELS, "hole.png");
    const spec = await this.spec();
    const tileable = spec.repeats ? { tileable: true } : {};
    await this.done({ task: "fill", materials: [spec], mask, ...tileable, ...this.told.fill, seed: app.recipe.seed }, t("history.filled"));
  }

  async restrict() {
    const mask = await this.upload(this.mask, [[255, 255, 255], [0, 0, 0]], "mask.png");
    if (this.target.result) await this.app.open([{ ...(await this.spec()), mask }]);
    else await this.app.mend({ mask }, t("history.masked"));
    this.app.tell("go", { screen: "sample" });
  }

  async fuse() {
    const { app, mask } = this;
    const all = [null, ...this.others];
    const used = all.map((_, k) => k).filter((k) => mask.count(k));
    if (used.length < 2) throw new Error(t("paint.fuse.none"));
    all[0] = await this.spec();
    const colors = all.map((_, k) => LABELS[k] ?? [k, 255 - k, 128]);
    const map = await this.upload(mask, colors, "map.png");
    await this.done({ task: "fuse", materials: used.map((k) => all[k]), map, colors: used.map((k) => colors[k]), ...this.told.fuse, seed: app.recipe.seed }, t("history.fused"));
  }

  async follow() {
    const { app, target: material } = this;
    const ofSample = this.masks.get(["guide", true, material.id, material.size].join());
    const ofOutput = this.size && this.masks.get(["guide", false, material.id, this.size].join());
    if (!ofSample || !ofOutput || ofOutput.count(0) === ofOutput.labels.length) throw new Error(t("paint.guide.none"));
    const sample_guide = await this.upload(ofSample, LABELS, "sample_guide.png");
    const guide = await this.upload(ofOutput, LABELS, "guide.png");
    const { seed } = app.recipe;
    await this.done({ task: "synth", materials: [await this.spec()], size: [...this.size].reverse(), seed, method: "graphcut", parameters: {}, guide, sample_guide }, t("history.guided"));
  }

  /** Leave the canvas for the picture that grows from it. */
  async done(recipe, label) {
    const { app } = this;
    const before = app.recipe;
    app.recipe = recipe;
    app.tell("go", { screen: "make" });
    try {
      if (!(await app.make(recipe, label)) && app.recipe === recipe) app.edit(before); // it was cancelled
    } catch (error) {
      app.edit(before);
      app.tell("go", { screen: "paint" });
      throw error;
    }
  }
}

function blank([width, height]) {
  const canvas = new OffscreenCanvas(width, height);
  canvas.getContext("2d").fillRect(0, 0, width, height);
  return canvas;
}
