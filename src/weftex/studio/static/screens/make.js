import { fault, field, fill, h, icon, iconButton, segments, tick, unpressed } from "../dom.js";
import { controls, parameterForm } from "../form.js";
import { sameJson } from "../shelf.js";
import { duration, number, said, t } from "../strings.js";
import { beginTask, fittingSize, taskButtons } from "./tasks.js";

const CHANGED = 80; // milliseconds after the last change before a slow preview is asked for again
const QUICK = 400; // milliseconds that a preview takes which follows a slider

/** Size, repetition, seed, effort, method and its sliders; the picture as it grows; nine seeds. */
export class MakeScreen {
  constructor(app, stage) {
    this.app = app;
    this.stage = stage;
    this.live = true;
    this.brightIsDeep = false; // for estimates
    this.took = 0; // milliseconds of the last preview
    this.usual = new Map(); // the values of parameters that are not set, by sample and method
  }

  enter(panel, { now = false } = {}) {
    this.panel = panel;
    this.stage.setSubject("result");
    const soon = (action) => (event) => unpressed(() => this.panel && action(event));
    const update = soon((event) => this.refresh(event.detail?.passing));
    const tell = soon(() => (this.learn(this.app.preview?.result) ? this.refresh() : fill(this.toldBox, this.told() ?? [])));
    panel.oninput = ({ target }) => (this.writing = target.matches("[type=number], [type=text]"));
    panel.onchange = panel.onfocusout = () => (this.writing = false);
    this.stop?.(); // it may be entered twice
    this.stop = this.app.listen({ result: update, look: update, preview: tell, recipe: tell, job: tell });
    this.draw();
    if (now) this.make();
  }

  leave() {
    this.stop();
    this.stopTrying();
    if (this.stage.custom === "sheet") this.closeSheet();
    this.panel = null;
  }

  draw() {
    const { app } = this;
    const { recipe, about } = app;
    this.writing = false;
    if (!recipe) return;
    app.analyze();
    const { task } = recipe;
    const free = task === "synth"; // size and repetition are not given by a photo or a map
    const size = recipe.size ?? app.usualSize();
    const fitting = free ? fittingSize(app.look?.lattice?.vectors, size, recipe.tileable) : null;
    const atSize = ["size", "width", "height"].includes(this.fault?.parameter) && free && !recipe.guide;
    const side = (axis, label) => {
      const box = h("input", { type: "number", min: 1, step: 1, value: size[axis], "aria-label": label, inputmode: "numeric", onchange: () => this.change({ size: app.recipe.size.with(axis, Number(box.value)) }) });
      return box;
    };
    const sizes = h(
      "div",
      { class: "field" },
      h("div", { class: "field-head" }, h("span", {}, h("label", {}, t("make.size")))),
      h("div", { class: "size" }, side(1, t("make.width")), h("span", { "aria-hidden": "true" }, "×"), side(0, t("make.height"))),
      h("div", { class: "row" }, [512, 1024, 2048, 4096].map((one) => h("button", { type: "button", class: "quiet", onclick: () => this.change({ size: [one, one] }, true) }, number(one)))),
      fitting ? h("button", { type: "button", onclick: () => this.change({ size: fitting }, true) }, t("make.fit", { width: fitting[1], height: fitting[0] })) : null,
      atSize ? h("p", { class: "note error", role: "alert" }, this.fault.message) : null,
    );
    const seed = h("input", { type: "number", min: 0, step: 1, value: recipe.seed, inputmode: "numeric", onchange: () => this.change({ seed: Math.max(0, Math.trunc(Number(seed.value))) }) });
    const method = h(
      "select",
      { onchange: () => this.change({ method: free || method.value !== "auto" ? method.value : undefined, parameters: {} }, true) },
      about.methods.map((one) => h("option", { value: one.slug }, one.slug === "auto" ? t("make.auto") : `${one.slug} · ${one.title}`)),
    );
    method.value = recipe.method ?? "auto";
    const chosen = app.method(recipe.method ?? "auto");
    const parameters = recipe.parameters ?? {};
    const form = (list) => parameterForm(list, parameters, () => this.change({ parameters: { ...parameters } }), this.fault);
    const effort = free && chosen.parameters.find((one) => one.name === "effort" && one.choices.length);
    const making = this.making();
    const sliders = making ? controls(app.method(making.method).parameters, making.parameters, Math.floor(0.75 * Math.min(app.material.width, app.material.height)), this.usual.get(this.keyOf(making.method))) : [];
    const others = chosen.parameters.filter((one) => one.name !== "effort" && !(making?.method === chosen.slug && sliders.some(({ name }) => name === one.name)));
    const present = { tile: "tile", fill: "remove", fuse: "blend" }[task] ?? (app.wish === "maps" ? "maps" : "bigger");
    const atSlider = sliders.some((one) => one.name === this.fault?.parameter);
    const beside = others.some((one) => one.name === this.fault?.parameter); // the error stands at its control
    const result = sameJson(app.result?.recipe, recipe) ? app.result : null;
    const reason = chosen.slug === "auto" ? said(result?.reason ?? (free ? app.look?.auto.reason : "")) : chosen.title;
    fill(
      this.panel,
      h("h2", {}, t("make.title")),
      taskButtons(present, (one) => this.changeTask(one)),
      present === "maps" ? this.matching() : null,
      this.fault && !beside && !atSlider && !atSize ? fault(this.fault.message) : null,
      task === "tile" ? this.tiling() : null,
      !free ? null : segments(t("make.tileable"), [["no", t("tileable.no")], ["x", t("tileable.x")], ["y", t("tileable.y")], ["xy", t("tileable.xy")]], recipe.tileable === true ? "xy" : recipe.tileable || "no", (one) =>
        this.change({ tileable: one === "xy" ? true : one === "no" ? false : one }, true),
      ),
      free && !recipe.guide ? sizes : null,
      field(t("make.seed"), seed, { value: iconButton("dice", t("make.dice"), () => this.change({ seed: Math.floor(Math.random() * 1e6) }, true)) }),
      effort
        ? segments(t("make.effort"), effort.choices.map((one) => [one, t(`effort.${one}`)]), parameters.effort ?? effort.default, (one) => this.change({ parameters: { ...parameters, effort: one } }))
        : null,
      field(t("make.method"), method, { help: reason }),
      sliders.length ? parameterForm(sliders, making.parameters, () => this.change(making), this.fault) : null,
      h(
        "div",
        { class: "row even go-row" },
        h("button", { type: "button", class: "main large", onclick: () => this.make() }, t("make.go")),
        h("button", { type: "button", class: "large", onclick: () => this.sheet() }, icon("grid"), t("make.sheet")),
      ),
      (this.toldBox = h("div", { class: "parameters" }, this.told())),
      h(
        "details",
        { open: this.open || beside, ontoggle: (event) => (this.open = event.target.open) },
        h("summary", {}, t("make.advanced")),
        h(
          "div",
          { class: "parameters" },
          tick(t("make.live"), this.live, (live) => (this.live = live)),
          tick(t("make.go_on"), app.goOn, (on) => (app.goOn = on)),
          free ? parameterForm(about.tasks.synth, "landmarks" in recipe ? { landmarks: recipe.landmarks } : {}, (name, value) => this.change({ [name]: value ?? null }), this.fault) : null,
          chosen.paper ? h("p", { class: "hint" }, chosen.paper) : null,
          others.length ? form(others) : null,
        ),
      ),
    );
  }

  /** {method, parameters} of what makes the picture; where weftex chooses, its choice, if that is known. */
  making() {
    const { recipe, result, look } = this.app;
    const { method = "auto", parameters = {} } = recipe;
    if (method !== "auto") return { method, parameters: { ...parameters } };
    if (recipe.task !== "synth") return null;
    const choice = look?.auto;
    const known = sameJson(result?.recipe, recipe) && result.method !== choice?.method ? result : choice;
    return known ? structuredClone({ method: known.method, parameters: known.parameters }) : null;
  }

  keyOf(method) {
    return `${this.app.material.id} ${method} ${this.app.recipe.task}`;
  }

  /** Learn what a method takes by itself; whether that was news. */
  learn(result) {
    if (!result?.parameters || this.usual.has(this.keyOf(result.method))) return false;
    const own = Object.entries(result.parameters).filter(([name]) => !(name in (result.recipe.parameters ?? {})));
    this.usual.set(this.keyOf(result.method), Object.fromEntries(own));
    return true;
  }

  changeTask(task) {
    beginTask(this.app, task);
    if (this.panel) this.change({}, true);
  }

  /** Maps of the same photo, which change as the picture does. */
  matching() {
    const { app } = this;
    const files = h("input", { type: "file", multiple: true, accept: "image/*,.exr,.tif,.tiff", hidden: true, onchange: () => this.attempt(() => addMaps(app, [...files.files])) });
    return [
      h("p", { class: "hint" }, t("do.maps.help")),
      h("p", {}, t("sample.maps", { names: app.material.maps.map((one) => one.name).join(", ") })),
      h(
        "div",
        { class: "row" },
        h("button", { type: "button", onclick: () => files.click() }, icon("open"), t("maps.add")),
        h("button", { type: "button", title: t("maps.estimate.help"), onclick: () => this.attempt(() => app.estimate(this.brightIsDeep)) }, icon("wand"), t("maps.estimate")),
      ),
      tick(t("maps.invert"), this.brightIsDeep, (on) => (this.brightIsDeep = on)),
      files,
    ];
  }

  tiling() {
    const { recipe, about } = this.app;
    const values = "border" in recipe && recipe.border !== null ? { border: recipe.border } : {};
    return [
      h("p", { class: "hint" }, t("task.tile.help")),
      segments(t("make.axes"), [["x", t("tileable.x")], ["y", t("tileable.y")], ["xy", t("tileable.xy")]], [true, undefined].includes(recipe.axes) ? "xy" : recipe.axes, (one) => this.change({ axes: one === "xy" ? true : one })),
      parameterForm(about.tasks.tile, values, (name, value) => this.change({ [name]: value ?? null }), this.fault),
    ];
  }

  /** Draw anew, but not under the hands of who writes or drags. */
  refresh(passing) {
    const held = document.activeElement;
    const news = this.learn(this.app.result);
    if ((passing && !news) || (this.panel.contains(held) && held.matches("input:not([type=radio], [type=checkbox])"))) fill(this.toldBox, this.told() ?? []);
    else this.draw();
  }

  /** What the picture that is there cost, and what the library has to say about it. */
  told() {
    const { app } = this;
    const { result, preview, job } = app;
    if (job && !job.quiet) return null;
    if (preview) return preview.result ? h("p", { class: "hint" }, t("make.preview", { method: preview.result.method })) : null;
    if (!result) return null;
    if (!sameJson(result.recipe, app.recipe)) return h("p", { class: "hint" }, t("make.stale"));
    return [
      result.warnings.map((line) => h("p", { class: "note" }, said(line))),
      h("p", { class: "hint" }, t("make.made", { method: result.method, time: duration(result.seconds) })),
      resultButtons(app),
    ];
  }

  /** Change the recipe; a preview follows when changes pause. */
  change(changes, redraw = false) {
    this.app.edit(changes);
    if (this.stage.custom === "sheet") this.closeSheet();
    if (redraw) this.draw();
    clearTimeout(this.waiting);
    if (!this.live) return;
    if (!this.trying) this.tryOut();
    else if (this.took < QUICK) this.again = true;
    else this.waiting = setTimeout(() => this.tryOut(), CHANGED);
  }

  /** Ask for a preview; quick ones come one after the other while a slider moves, slow ones give way. */
  async tryOut() {
    const begun = performance.now();
    const trying = (this.trying = {});
    this.again = false;
    await this.attempt(() => this.app.tryOut());
    if (this.trying !== trying) return;
    this.trying = null;
    this.took = performance.now() - begun;
    if (this.again) this.tryOut();
  }

  stopTrying() {
    clearTimeout(this.waiting);
    this.trying = null;
    this.again = false;
  }

  async make() {
    this.stopTrying();
    if (this.stage.custom === "sheet") this.closeSheet();
    await this.attempt(() => this.app.make(this.app.recipe, t("history.made")));
  }

  /** Run something; the library's line about a wrong value stands beside the field that it names. */
  async attempt(action) {
    const had = this.fault;
    this.fault = null;
    try {
      await action();
    } catch (error) {
      if (error.message) this.fault = error;
    }
    const draw = () => {
      if (!this.panel) return;
      this.draw();
      this.panel.querySelector("[role=alert]")?.scrollIntoView({ block: "nearest" });
    };
    if (had || this.fault) unpressed(draw, () => this.panel && this.writing); // what is being written would be lost
  }

  /** Nine seeds beside each other; one of them is kept. */
  async sheet() {
    const { app, stage } = this;
    this.stopTrying();
    const recipe = structuredClone(app.recipe);
    stage.custom = "sheet";
    let shown = 0;
    const items = Array.from({ length: 9 }, (_, k) => ({ picture: null, size: recipe.size ? recipe.size.toReversed() : app.material.size, title: t("make.seed_n", { n: recipe.seed + k }) }));
    const cells = stage.several(items);
    stage.buildBar();
    const add = async (job) => {
      while (shown < job.results.length) {
        const at = shown++;
        const result = job.results[at];
        const { foot, view } = cells[at];
        if (result.error) {
          foot.querySelector(".cell-note").textContent = said(result.error);
          continue;
        }
        const { bitmap } = await app.api.picture(`results/${result.id}/picture`, { map: result.main, most: 1024 });
        view.show({ picture: bitmap });
        foot.querySelector(".cell-note").textContent = duration(result.seconds);
        foot.append(h("button", { type: "button", onclick: () => app.guard(() => this.keep(result)) }, t("make.keep")));
      }
    };
    await this.attempt(async () => {
      const job = await app.run({ recipe, each: items.map((_, k) => ({ seed: recipe.seed + k })) }, { onresults: add });
      if (job) await add(job);
      else if (!shown && stage.custom === "sheet") this.closeSheet();
    });
  }

  async keep(result) {
    this.closeSheet();
    await this.app.step(result, t("history.seed", { n: result.recipe.seed }));
  }

  closeSheet() {
    this.app.cancel(); // the seeds that are not there yet
    this.stage.custom = null;
    this.stage.refresh();
  }
}

/** What can be done with a result: go on with it, retouch it, take it. */
export function resultButtons(app) {
  const { result } = app;
  const button = (name, text, onclick) => h("button", { type: "button", onclick }, icon(name), text);
  return h(
    "div",
    { class: "row" },
    button("open", t("result.sample"), () => app.guard(() => app.useAsSample(result))),
    button("brush", t("result.paint"), () => app.tell("go", { screen: "paint", onResult: true })),
    button("take", t("result.export"), () => app.tell("go", { screen: "take" })),
    button("repeat", t("preset.save"), () => app.tell("presets")),
  );
}

/** Add maps of the same photo to the sample; their names say which they are. */
async function addMaps(app, files) {
  const [spec] = app.recipe.materials;
  if (!spec.maps) throw new Error(t("maps.own"));
  const uploads = [];
  for (const file of files) uploads.push((await app.api.upload(file)).id);
  const { materials } = await app.api.post("sets", { uploads: [...Object.values(spec.maps), ...uploads] });
  const named = materials.flatMap((one) => Object.entries(one.maps)).filter(([role, id]) => role !== "color" && uploads.includes(id));
  if (!named.length) throw new Error(t("maps.unnamed"));
  await app.mend({ name: app.material.name.replace(/\.[^.]*$/, ""), maps: { ...spec.maps, ...Object.fromEntries(named) } }, t("history.maps"));
}
