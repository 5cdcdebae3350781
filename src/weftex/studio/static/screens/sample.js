import { drawSquare, field, fill, h, icon, segments, tick } from "../dom.js";
import { sameJson } from "../shelf.js";
import { number, progressOf, said, t } from "../strings.js";
import { LatticeLayer } from "../view/lattice.js";
import { makeButton } from "./tasks.js";

/** What the sample is: its scale, its lattice drawn over it, light and slant, what auto would do. */
export class SampleScreen {
  constructor(app, stage) {
    this.app = app;
    this.stage = stage;
    this.lattice = new LatticeLayer(stage.main, {
      onchange: (vectors) => this.rate(vectors),
      onmove: (vectors) => this.tellVectors(vectors),
    });
    this.shown = true;
  }

  enter(panel) {
    this.panel = panel;
    const begin = () => {
      this.chosen = null; // a lattice of another sample
      this.draw();
    };
    this.stop?.(); // it may be entered twice
    this.stop = this.app.listen({ look: () => this.draw(), looking: () => this.tellLook?.(), material: begin });
    this.stage.mode = "picture";
    this.stage.setSubject("sample");
    this.stage.main.layers.push(this.lattice.paint);
    this.stage.main.tools.push(this.lattice);
    this.draw();
  }

  leave() {
    const { main } = this.stage;
    this.stop();
    main.layers = main.layers.filter((one) => one !== this.lattice.paint);
    main.tools = main.tools.filter((one) => one !== this.lattice);
  }

  draw() {
    const { app } = this;
    const { material, look } = app;
    if (!material) return;
    app.analyze();
    const about = [t("stage.size", { width: material.width, height: material.height })];
    if (material.maps.length > 1) about.push(t("sample.maps", { names: material.maps.map((one) => one.name).join(", ") }));
    fill(
      this.panel,
      h("div", {}, h("h2", {}, material.name), h("p", { class: "hint" }, about.join(" · "))),
      [...(app.notes ?? []), ...material.notes].map((line) => h("p", { class: "note" }, said(line))),
      this.shelf(),
      look ? this.found(look) : this.waiting(),
    );
    if (!look) return this.lattice.set(null);
    const chosen = this.chosen ?? look.lattice;
    this.lattice.set(this.shown && chosen ? chosen.vectors : null, chosen?.lines);
  }

  /** What is being done and how much of it, or what ended it; and how to stop it, or to begin again. */
  waiting() {
    const { app } = this;
    const { lookError: error } = app;
    if (error) return [h("p", { class: `note ${error.name === "AbortError" ? "" : "error"}` }, error.name === "AbortError" ? t("look.stopped") : error.message), h("button", { type: "button", onclick: () => app.analyzeAgain() ?? this.draw() }, t("look.again"))];
    const { tell, parts } = meter(() => app.looking.abort());
    (this.tellLook = () => tell(app.lookJob))();
    return parts;
  }

  shelf() {
    const { app } = this;
    if (app.shelf.length < 2) return null;
    return h(
      "div",
      { class: "shelf" },
      app.shelf.map((spec) => {
        const present = sameJson(spec, app.recipe?.materials[0]);
        const canvas = h("canvas", { width: 60, height: 60 });
        const name = h("span", {}, spec.sample ?? spec.name ?? "…");
        app.guard(async () => {
          const card = await app.card(spec);
          drawSquare(canvas, card.bitmap);
          name.textContent = card.name;
        });
        return h("button", { type: "button", "aria-pressed": String(present), onclick: () => app.guard(() => app.choose(spec)) }, canvas, name);
      }),
    );
  }

  found(look) {
    const { app } = this;
    const spec = app.recipe.materials[0];
    const turns = [["", t("turn.none")], ["flip", t("turn.flip")], ["half", t("turn.half")], ["4", t("turn.4")], ["8", t("turn.8")]];
    return [
      look.mending.map((one) =>
        h("div", { class: "note" }, icon("light"), h("div", {}, h("span", {}, t(`why.${one.what}`)), h("button", { type: "button", onclick: () => app.guard(() => app.mend(one.spec, t(`mend.${one.what}`))) }, t(`mend.${one.what}`)))),
      ),
      this.mended(spec),
      h(
        "dl",
        { class: "facts" },
        h("dt", {}, t("sample.scale")),
        h("dd", {}, t("sample.px", { n: number(look.scale, 1) }), " ", look.confidence === null ? null : h("span", { class: "hint" }, t("sample.from", { what: t(`scale.${look.scale_source}`), n: number(100 * look.confidence) }))),
        look.regularity === null ? null : [h("dt", {}, t("sample.regularity")), h("dd", {}, number(look.regularity, 2))],
        look.tiles === null ? null : [h("dt", {}, t("sample.tiles")), h("dd", {}, tiling(look.tiles))],
        look.colors ? [h("dt", {}, t("sample.colors")), h("dd", {}, number(look.colors))] : null,
      ),
      h(
        "section",
        { class: "section" },
        h("h3", {}, t("sample.auto")),
        h("p", {}, this.chosen ? t("lattice.used", { words: said(this.chosen.words) }) : said(look.auto.reason)),
        look.auto.warnings.map((line) => h("p", { class: "note" }, said(line))),
        makeButton(app),
      ),
      this.latticeSection(look),
      h(
        "section",
        { class: "section" },
        segments(t("sample.turn"), turns, spec.turn ?? "", (turn) => app.guard(() => app.mend({ turn: turn || null }, t("sample.turn")))),
        tick(t("sample.repeats"), Boolean(spec.repeats), (repeats) => app.guard(() => app.mend({ repeats: repeats || null }, t("sample.repeats")))),
        h("button", { type: "button", onclick: () => app.tell("presets") }, icon("repeat"), t("preset.apply_one")),
      ),
      h("details", {}, h("summary", {}, t("sample.more")), h("div", {}, spectrum(look.spectrum), h("pre", { class: "text-block", tabindex: 0 }, look.text))),
    ];
  }

  /** What was done to the photo, and the way back. */
  mended(spec) {
    return ["straighten", "even_light"]
      .filter((what) => what in spec)
      .map((what) =>
        h("div", { class: "note" }, icon("check"), h("div", {}, h("span", {}, t(`mended.${what}`)), h("button", { type: "button", onclick: () => this.app.guard(() => this.app.mend({ [what]: null }, t(`unmend.${what}`))) }, t(`unmend.${what}`)))),
      );
  }

  latticeSection(look) {
    const all = [look.lattice, ...look.runners_up].filter(Boolean);
    const chosen = this.chosen ?? look.lattice;
    if (this.chosen && !all.some((one) => one.numbers === this.chosen.numbers)) all.push({ ...this.chosen, mine: true });
    const option = (one, k) =>
      h(
        "label",
        {},
        h("input", { type: "radio", name: "lattice", checked: one.numbers === chosen?.numbers, onchange: () => this.choose(one) }),
        h("span", {}, said(one.words), h("span", { class: "hint" }, one.mine ? t("lattice.mine") : k === 0 && look.lattice ? t("lattice.found") : t(look.lattice ? "lattice.next" : "lattice.maybe"))),
        h("span", { class: "figure" }, one === look.lattice && one.confidence ? `${number(100 * one.confidence)} %` : ""),
      );
    const inputs = h("div", { class: "row even" });
    this.inputs = [];
    (chosen?.vectors ?? []).forEach((vector, k) =>
      vector.forEach((value, axis) => {
        const input = h("input", { type: "number", step: "any", value, onchange: () => this.typed() });
        this.inputs.push(input);
        inputs.append(field(`${"xy"[axis]}${k + 1}`, input));
      }),
    );
    return h(
      "section",
      { class: "section" },
      h("h3", {}, t("lattice.title")),
      look.lattice ? null : h("p", { class: "hint" }, t("lattice.none")),
      h("div", { class: "choices", role: "radiogroup", "aria-label": t("lattice.title") }, all.map(option)),
      chosen ? [inputs, h("p", { class: "hint" }, t("lattice.drag"))] : h("button", { type: "button", onclick: () => this.rate([[look.scale, 0], [0, look.scale]]) }, t("lattice.draw")),
      h(
        "div",
        { class: "row" },
        tick(t("lattice.show"), this.shown, (shown) => {
          this.shown = shown;
          this.draw();
        }),
        tick(t("lattice.lock"), this.lattice.rowsLocked, (locked) => {
          this.lattice.rowsLocked = locked;
          const vectors = (this.chosen ?? look.lattice)?.vectors;
          if (locked && vectors?.[0][1]) this.rate(level(vectors));
        }),
      ),
    );
  }

  tellVectors(vectors) {
    vectors.flat().forEach((value, k) => {
      if (this.inputs?.[k]) this.inputs[k].value = value;
    });
  }

  typed() {
    const values = this.inputs.map((one) => Number(one.value));
    this.rate(values.length > 2 ? [values.slice(0, 2), values.slice(2)] : [values]);
  }

  /** Have the server say how good vectors of ours are, and go on with them. */
  rate(vectors) {
    this.app.guard(async () => this.choose(await this.app.api.get(`materials/${this.app.material.id}/lattice?vectors=${vectors.flat().join(",")}`)));
  }

  choose(lattice) {
    const { app } = this;
    const found = lattice.numbers === app.look.lattice?.numbers;
    this.chosen = found ? null : lattice;
    app.edit(found ? { method: "auto", parameters: {} } : { method: "near-regular", parameters: { lattice: lattice.numbers } });
    this.draw();
  }
}

/** The parts that say how far a job is, once `tell(job)` is called, and a button that stops it. */
export function meter(stop) {
  const bar = h("span");
  const text = h("p", { class: "hint", role: "status" });
  const tell = (job) => {
    const { text: said, share } = progressOf(job);
    bar.style.width = `${100 * share}%`;
    text.textContent = said;
  };
  tell(null);
  return { tell, parts: [text, h("div", { class: "meter" }, bar), h("button", { type: "button", onclick: stop }, t("job.cancel"))] };
}

/** The same lattice by the vector that is nearest to level, made level, and another; of rows the one there is. */
function level(vectors) {
  const slope = ([x, y]) => Math.abs(y) / (Math.abs(x) || 1e-9);
  if (vectors.length < 2) return [[0, Math.hypot(...vectors[0])]];
  const [[a, b], [c, d]] = vectors;
  const [along] = [[a, b], [c, d], [a + c, b + d], [a - c, b - d]].sort((one, other) => slope(one) - slope(other));
  const across = slope([a, b]) > slope([c, d]) ? [a, b] : [c, d];
  return [[Math.abs(along[0]), 0], across];
}

function tiling([down, right]) {
  return t(down && right ? "tiles.both" : right ? "tiles.x" : down ? "tiles.y" : "tiles.no");
}

/** The power at each period, drawn as bars. */
function spectrum(points) {
  if (!points?.length) return null;
  const canvas = h("canvas", { class: "spectrum", width: 640, height: 144, role: "img", "aria-label": t("sample.spectrum") });
  const context = canvas.getContext("2d");
  const most = Math.max(...points.map((one) => one.power));
  const periods = points.map((one) => Math.log(one.period));
  const [from, to] = [Math.min(...periods), Math.max(...periods)];
  requestAnimationFrame(() => {
    const style = getComputedStyle(canvas);
    context.fillStyle = style.getPropertyValue("--accent") || "#b60";
    points.forEach((one, k) => {
      const x = 6 + ((periods[k] - from) / (to - from || 1)) * 620;
      context.fillRect(x, 140 - (one.power / most) * 134, 6, (one.power / most) * 134);
    });
  });
  return h("figure", {}, canvas, h("figcaption", { class: "hint" }, t("sample.spectrum")));
}
