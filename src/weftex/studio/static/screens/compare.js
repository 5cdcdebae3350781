import { fault, fill, h, tick } from "../dom.js";
import { sameJson } from "../shelf.js";
import { duration, number, said, t } from "../strings.js";

const USUAL = ["patch-sampling", "quilting", "graphcut", "near-regular", "best-tile"];

/** Methods side by side on this sample, with figures and seconds; blind if wanted. */
export class CompareScreen {
  constructor(app, stage) {
    this.app = app;
    this.stage = stage;
    this.chosen = new Set(USUAL);
    this.blind = false;
    this.rows = [];
  }

  enter(panel) {
    this.panel = panel;
    this.draw();
    if (this.rows.length) this.show();
    else this.stage.setSubject("result");
  }

  leave() {
    this.app.cancel();
    this.stage.custom = null;
    this.panel = null;
    this.stage.title = null;
    this.stage.refresh();
  }

  draw() {
    const methods = this.app.about.methods.filter((one) => one.slug !== "auto");
    const [height, width] = this.app.recipe.size ?? this.app.usualSize();
    fill(
      this.panel,
      h("div", {}, h("h2", {}, t("compare.title")), h("p", { class: "hint" }, t("compare.lead", { width: Math.min(width, 512), height: Math.min(height, 512) }))),
      this.error,
      h("div", {}, methods.map((one) => tick(one.slug, this.chosen.has(one.slug), (on) => this.chosen[on ? "add" : "delete"](one.slug), { title: one.title }))),
      tick(t("compare.blind"), this.blind, (blind) => {
        this.blind = blind;
        this.show();
      }),
      h("p", { class: "hint" }, t("compare.blind.help")),
      h("button", { type: "button", class: "main large", onclick: () => this.run() }, t("compare.go")),
      this.table(),
    );
  }

  async run() {
    const { app } = this;
    const { method, parameters, ...given } = app.recipe;
    const recipe = given.task === "synth" ? given : { task: "synth", materials: given.materials.slice(0, 1), seed: given.seed };
    const size = (recipe.size ?? app.usualSize()).map((side) => Math.min(512, side));
    const methods = [...this.chosen];
    this.error = null;
    this.rows = [];
    this.picked = null;
    this.draw();
    try {
      if (!methods.length) throw new Error(t("compare.none"));
      this.order = methods.map((slug) => [Math.random(), slug]).sort().map(([, slug]) => slug);
      const job = await app.run({ recipe: { ...recipe, size }, each: methods.map((one) => ({ method: one })), compare: true }, { onresults: (now) => this.take(now) });
      if (job) await this.take(job);
    } catch (error) {
      if (!error.message) return;
      this.error = fault(error.message);
      if (this.panel) this.draw();
    }
  }

  /** Add what has come of the job since the last look. */
  async take(job) {
    while (this.rows.length < job.results.length) {
      const result = job.results[this.rows.length];
      const row = { ...result };
      this.rows.push(row);
      if (!result.error) Object.assign(row, await this.app.api.picture(`results/${result.id}/picture`, { map: result.main }));
      if (this.panel) this.show();
    }
  }

  hidden() {
    return this.blind && !this.picked;
  }

  show() {
    const { stage } = this;
    const made = this.rows.filter((row) => row.bitmap);
    if (!made.length) return this.panel && this.draw();
    if (this.blind) made.sort((one, other) => this.order.indexOf(one.method) - this.order.indexOf(other.method));
    stage.custom = "compare";
    stage.title = t("compare.title");
    const sample = { picture: this.app.material.bitmap, size: this.app.material.size, title: t("history.sample"), note: this.app.material.name };
    stage.several([
      sample,
      ...made.map((row, k) => ({
        picture: row.bitmap,
        size: row.size,
        title: `${this.hidden() ? t("compare.letter", { letter: String.fromCharCode(65 + k) }) : row.method} · ${row.size.join(" × ")}`,
        note: this.hidden() ? "" : noteOf(row),
        action: h("button", { type: "button", onclick: () => this.pick(row) }, this.hidden() ? t("compare.pick") : t("compare.use")),
      })),
    ]);
    const largest = made[0];
    stage.cells[0].view.fit = () => stage.camera.fit(...largest.size, stage.cells[0].view.element.clientWidth, stage.cells[0].view.element.clientHeight, 8);
    if (stage.camera.fitted) stage.cells[0].view.fit();
    stage.buildBar();
    this.draw();
  }

  /** Blind, the first choice only shows the names; then it is used. */
  pick(row) {
    if (this.hidden()) {
      this.picked = row;
      return this.show();
    }
    this.app.guard(async () => {
      const { recipe } = this.app;
      const same = recipe.task !== "synth" || sameJson(recipe.size, row.recipe.size);
      if (same) await this.app.step(row, row.method);
      else this.app.edit({ method: row.method, parameters: {} });
      this.app.tell("go", { screen: "make", now: !same });
    });
  }

  table() {
    if (!this.rows.length || this.hidden()) return null;
    const best = Math.min(...this.rows.map((row) => row.figures?.score ?? Infinity));
    return h(
      "table",
      {},
      h("thead", {}, h("tr", {}, h("th", { scope: "col" }, t("compare.method")), h("th", { scope: "col", class: "number-cell" }, t("compare.score")), h("th", { scope: "col", class: "number-cell" }, t("compare.time")))),
      h(
        "tbody",
        {},
        this.rows.map((row) =>
          row.error
            ? h("tr", {}, h("th", { scope: "row" }, row.method), h("td", { colspan: 2 }, said(row.error)))
            : h("tr", {}, h("th", { scope: "row" }, row.method, row === this.picked ? ` · ${t("compare.picked")}` : ""), h("td", { class: "number-cell" }, row.figures.score === best ? h("strong", {}, number(best, 1)) : row.figures.score === null ? "–" : number(row.figures.score, 1)), h("td", { class: "number-cell" }, duration(row.seconds))),
        ),
      ),
      h("caption", { class: "hint" }, t("compare.score.help")),
    );
  }
}

function noteOf(row) {
  const { score } = row.figures;
  return [duration(row.seconds), typeof score === "number" && t("see.score", { n: number(score, 1) })].filter(Boolean).join(" · ");
}
