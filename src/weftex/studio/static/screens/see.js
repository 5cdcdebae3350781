import { field, fill, h, icon } from "../dom.js";
import { has, number, said, t } from "../strings.js";
import { resultButtons } from "./make.js";
import { meter } from "./sample.js";
import { makeButton } from "./tasks.js";

/** Overlays, figures, what lies under the pointer and where it comes from; the light's own controls. */
export class SeeScreen {
  constructor(app, stage) {
    this.app = app;
    this.stage = stage;
    this.overlay = "";
    this.opacity = 0.8;
  }

  enter(panel) {
    this.panel = panel;
    this.stage.setSubject("result");
    this.stop?.(); // it may be entered twice
    this.stop = this.app.listen({ result: () => this.draw(), light: () => this.drawLight() });
    this.stage.main.onhover = (place) => this.hover(place);
    this.draw();
  }

  leave() {
    this.stop();
    this.stage.main.onhover = null;
    this.stage.main.show({ overlay: null });
    this.overlay = "";
    this.panel = null;
    this.measuring?.abort();
  }

  draw() {
    const { app } = this;
    const { result } = app;
    if (!result || app.preview?.result) {
      const busy = app.job && !app.job.quiet;
      fill(this.panel, h("h2", {}, t("see.title")), h("p", {}, t(busy ? "see.making" : result ? "see.preview" : "see.nothing")), busy ? null : makeButton(app));
      return;
    }
    this.spot = h("dl", { class: "facts" }, h("dd", { class: "hint wide" }, t("see.hover")));
    this.lightBox = h("section", { class: "section", hidden: true });
    this.figures = h("section", { class: "section" });
    const overlays = [["", t("overlay.none")], ...app.about.drawings.map((one) => [one, t(`overlay.${one}`)]), ["fault", t("fault.broken")]];
    this.said = h("p", { class: "note error", role: "alert", hidden: true });
    const strength = h("input", { type: "range", min: 0, max: 1, step: 0.05, value: this.opacity, oninput: () => {
      this.opacity = Number(strength.value);
      this.stage.main.show({ overlayOpacity: this.opacity });
    } });
    fill(
      this.panel,
      h("h2", {}, t("see.title")),
      resultButtons(app),
      this.lightBox,
      h(
        "section",
        { class: "section first" },
        h("h3", {}, t("see.overlay")),
        h("div", { class: "choices", role: "radiogroup", "aria-label": t("see.overlay") }, overlays.map(([key, name]) =>
          h("label", {}, h("input", { type: "radio", name: "overlay", value: key, checked: key === this.overlay, onchange: () => this.lay(key) }), h("span", {}, name, has(`overlay.${key}.help`) ? h("span", { class: "hint" }, t(`overlay.${key}.help`)) : null)),
        )),
        this.said,
        field(t("see.opacity"), strength),
      ),
      h("section", { class: "section" }, h("h3", {}, t("see.spot")), this.spot),
      this.figures,
    );
    if (this.overlay) this.lay(this.overlay);
    this.measure(result);
    this.drawLight();
  }

  async lay(key) {
    const { app, stage } = this;
    this.overlay = key;
    this.said.hidden = true;
    if (!key) return stage.main.show({ overlay: null });
    const { result } = app;
    const what = key === "fault" ? "broken" : `picture?draw=${key}`;
    try {
      const kept = (result.overlays ??= {});
      kept[key] ??= (await app.ask(result, (id) => app.api.picture(`results/${id}/${what}`, { most: 2048 }))).bitmap;
      if (this.overlay === key && app.result === result && this.panel) {
        if (stage.mode === "light" || stage.mode === "plane" || stage.mode === "maps") stage.setMode("picture");
        stage.main.show({ overlay: kept[key], overlayOpacity: this.opacity });
      }
    } catch (error) {
      if (!this.panel) return;
      this.said.hidden = false;
      this.said.textContent = error.message;
      stage.main.show({ overlay: null });
    }
  }

  async measure(result) {
    this.measuring?.abort();
    const control = (this.measuring = new AbortController());
    const { tell, parts } = meter(() => control.abort());
    const show = (...shown) => fill(this.figures, h("h3", {}, t("see.figures")), shown);
    show(parts);
    try {
      result.figures ??= await this.app.ask(result, (id) => this.app.api.found(`results/${id}/figures`, {}, tell, control.signal));
    } catch (error) {
      if (!this.panel || this.measuring !== control) return;
      if (error.name !== "AbortError") show(h("p", { class: "note error" }, error.message));
      else show(h("button", { type: "button", onclick: () => this.measure(result) }, t("see.measure")));
      return;
    }
    if (!this.panel || this.app.result !== result) return;
    const { score, verdict, figures, flags } = result.figures;
    const known = new Map(this.app.about.figures.map((one) => [one.name, one]));
    const rows = Object.entries(figures)
      .filter(([, value]) => value !== null)
      .map(([name, value]) => {
        const about = known.get(name) ?? { title: name, meaning: "" };
        const flagged = flags.includes(name);
        return h("tr", { title: said(about.meaning) }, h("th", { scope: "row" }, said(about.title), flagged ? h("span", { class: "flag" }, ` ${t("see.flag")}`) : null), h("td", { class: "number-cell" }, number(value, 2)), h("td", { class: "number-cell hint" }, about.limit ? t("see.limit", { n: number(about.limit, 2) }) : ""));
      });
    show(
      h("p", {}, said(verdict)),
      score === null ? null : h("p", { class: "hint" }, t("see.score.help", { n: number(score, 1) })),
      h("details", {}, h("summary", {}, t("see.all", { n: rows.length })), h("div", {}, h("table", {}, h("tbody", {}, rows)))),
    );
  }

  /** The pixel under the pointer, and where in the sample it comes from. */
  hover(place) {
    const { result } = this.app;
    if (!place || !result || this.stage.mode === "plane") return;
    const [width, height] = result.size;
    const color = this.stage.main.colorAt(...place);
    if (!color) return;
    const [x, y] = [Math.floor(place[0]) % width, Math.floor(place[1]) % height];
    const tell = (source) =>
      fill(
        this.spot,
        h("dt", {}, t("see.place")),
        h("dd", {}, `${x}, ${y}`),
        h("dt", {}, t("see.color")),
        h("dd", {}, [...color].slice(0, color[3] < 255 ? 4 : 3).join(" ")),
        h("dt", {}, t("see.source")),
        h("dd", {}, source),
      );
    tell("…");
    clearTimeout(this.asking);
    this.asking = setTimeout(async () => {
      try {
        const found = await this.app.api.get(`results/${result.id}/source?x=${x}&y=${y}`);
        if (this.panel) tell(found.x === null ? "–" : `${number(found.x, 1)}, ${number(found.y, 1)}`);
      } catch {
        tell("–");
      }
    }, 90);
  }

  drawLight() {
    const { light } = this.stage;
    if (!this.lightBox) return;
    this.lightBox.hidden = !light;
    if (!light) return;
    const range = (name, value, low, high, set) => {
      const box = h("input", { type: "range", min: low, max: high, step: 0.02, value, oninput: () => {
        set(Number(box.value));
        light.draw();
      } });
      return field(t(name), box);
    };
    const guessed = !light.textures.normal && !light.textures.height;
    fill(
      this.lightBox,
      h("h3", {}, t("light.title")),
      guessed ? h("p", { class: "note" }, icon("light"), t("light.guessed")) : null,
      range("light.x", light.light[0], -1, 1, (one) => (light.light[0] = one)),
      range("light.y", light.light[1], -1, 1, (one) => (light.light[1] = one)),
      range("light.height", light.height, 0.1, 2, (one) => (light.height = one)),
      range("light.relief", light.relief, 0, 3, (one) => (light.relief = one)),
    );
  }
}
