import { field, fill, h, icon, iconButton, segments, tick } from "../dom.js";
import { parameterForm } from "../form.js";
import { duration, number, t } from "../strings.js";

const CHANGED = 180; // milliseconds after the last change before a preview is asked for

/** Size, repetition, seed, effort, method and its sliders; the picture as it grows; nine seeds. */
export class MakeScreen {
  constructor(app, stage) {
    this.app = app;
    this.stage = stage;
    this.live = true;
    this.update = () => this.panel && this.draw();
  }

  enter(panel, { now = false } = {}) {
    this.panel = panel;
    this.stage.setSubject("result");
    this.app.addEventListener("result", this.update);
    this.app.addEventListener("look", this.update);
    this.draw();
    if (now) this.make();
  }

  leave() {
    this.app.removeEventListener("result", this.update);
    this.app.removeEventListener("look", this.update);
    clearTimeout(this.waiting);
    if (this.stage.custom === "sheet") this.closeSheet();
    this.panel = null;
  }

  draw() {
    const { app } = this;
    const { recipe, about } = app;
    if (!recipe) return;
    const [height, width] = recipe.size ?? app.usualSize();
    const side = (value, label, set) => {
      const box = h("input", { type: "number", min: 1, step: 1, value, "aria-label": label, inputmode: "numeric", onchange: () => set(Number(box.value)) });
      return box;
    };
    const sizes = h(
      "div",
      { class: "field" },
      h("div", { class: "field-head" }, h("span", {}, h("label", {}, t("make.size")))),
      h("div", { class: "size" }, side(width, t("make.width"), (one) => this.change({ size: [height, one] })), h("span", { "aria-hidden": "true" }, "×"), side(height, t("make.height"), (one) => this.change({ size: [one, width] }))),
      h("div", { class: "row" }, [512, 1024, 2048, 4096].map((one) => h("button", { type: "button", class: "quiet", onclick: () => this.change({ size: [one, one] }, true) }, number(one)))),
    );
    const seed = h("input", { type: "number", min: 0, step: 1, value: recipe.seed, inputmode: "numeric", onchange: () => this.change({ seed: Math.max(0, Math.trunc(Number(seed.value))) }) });
    const method = h(
      "select",
      { onchange: () => this.change({ method: method.value, parameters: {} }, true) },
      about.methods.map((one) => h("option", { value: one.slug }, one.slug === "auto" ? t("make.auto") : `${one.slug} · ${one.title}`)),
    );
    method.value = recipe.method;
    const chosen = app.method(recipe.method);
    const parameters = recipe.parameters ?? {};
    const form = (list) => parameterForm(list, parameters, () => this.change({ parameters: { ...parameters } }));
    const effort = chosen.parameters.find((one) => one.name === "effort" && one.choices.length);
    const others = chosen.parameters.filter((one) => one !== effort);
    const reason = recipe.method === "auto" ? (app.result?.reason ?? app.look?.auto.reason) : chosen.paper;
    fill(
      this.panel,
      h("h2", {}, t("make.title")),
      this.error,
      sizes,
      segments(t("make.tileable"), [["no", t("tileable.no")], ["x", t("tileable.x")], ["y", t("tileable.y")], ["xy", t("tileable.xy")]], recipe.tileable === true ? "xy" : recipe.tileable || "no", (one) =>
        this.change({ tileable: one === "xy" ? true : one === "no" ? false : one }),
      ),
      field(t("make.seed"), seed, { value: iconButton("dice", t("make.dice"), () => this.change({ seed: Math.floor(Math.random() * 1e6) }, true)) }),
      effort
        ? segments(t("make.effort"), effort.choices.map((one) => [one, t(`effort.${one}`)]), parameters.effort ?? effort.default, (one) => this.change({ parameters: { ...parameters, effort: one } }))
        : null,
      field(t("make.method"), method, { help: reason }),
      h(
        "div",
        { class: "row even" },
        h("button", { type: "button", class: "main large", onclick: () => this.make() }, t("make.go")),
        h("button", { type: "button", class: "large", onclick: () => this.sheet() }, icon("grid"), t("make.sheet")),
      ),
      tick(t("make.live"), this.live, (live) => (this.live = live)),
      this.told(),
      others.length ? h("details", { open: this.open, ontoggle: (event) => (this.open = event.target.open) }, h("summary", {}, t("make.parameters", { n: others.length })), h("div", {}, form(others))) : null,
    );
  }

  /** What the picture that is there cost, and what the library has to say about it. */
  told() {
    const { result } = this.app;
    if (!result) return null;
    return [
      result.warnings.map((line) => h("p", { class: "note" }, line)),
      h("p", { class: "hint" }, t("make.made", { method: result.method, time: duration(result.seconds) })),
    ];
  }

  /** Change the recipe; a preview follows when changes pause. */
  change(changes, redraw = false) {
    this.app.edit(changes);
    if (this.stage.custom === "sheet") this.closeSheet();
    if (redraw) this.draw();
    clearTimeout(this.waiting);
    if (this.live) this.waiting = setTimeout(() => this.tryOut(), CHANGED);
  }

  async tryOut() {
    await this.attempt(() => this.app.tryOut());
  }

  async make() {
    clearTimeout(this.waiting);
    if (this.stage.custom === "sheet") this.closeSheet();
    await this.attempt(() => this.app.make(this.app.recipe, t("history.made")));
  }

  /** Run something; the library's line about a wrong value stands beside the field that it names. */
  async attempt(action) {
    const had = this.error;
    this.error = null;
    try {
      await action();
    } catch (error) {
      this.error = error.message ? h("div", { class: "note error", role: "alert" }, icon("warn"), h("div", {}, error.message)) : null;
    }
    if (this.panel && (had || this.error)) this.draw();
    if (this.error) this.panel?.closest(".panel").scrollTo(0, 0);
  }

  /** Nine seeds beside each other; one of them is kept. */
  async sheet() {
    const { app, stage } = this;
    clearTimeout(this.waiting);
    const recipe = structuredClone(app.recipe);
    stage.custom = "sheet";
    let shown = 0;
    const items = Array.from({ length: 9 }, (_, k) => ({ picture: null, size: [...recipe.size].reverse(), title: t("make.seed_n", { n: recipe.seed + k }) }));
    const cells = stage.several(items);
    stage.buildBar();
    const add = async (job) => {
      while (shown < job.results.length) {
        const at = shown++;
        const result = job.results[at];
        const { foot, view } = cells[at];
        if (result.error) {
          foot.querySelector(".cell-note").textContent = result.error;
          continue;
        }
        const { bitmap } = await app.api.picture(`results/${result.id}/picture`, { map: result.main, most: 1024 });
        view.show({ picture: bitmap });
        foot.querySelector(".cell-note").textContent = duration(result.seconds);
        foot.append(h("button", { type: "button", onclick: () => app.guard(() => this.keep(result)) }, t("make.keep")));
      }
    };
    await this.attempt(async () => {
      const job = await app.run({ recipe, count: 9, leave: "cancel" }, { onresults: add });
      if (job) await add(job);
      else if (!shown) this.closeSheet();
    });
  }

  async keep(result) {
    this.closeSheet();
    await this.app.step(result, t("history.seed", { n: result.recipe.seed }));
  }

  closeSheet() {
    this.stage.custom = null;
    this.stage.refresh();
  }
}
