import { fill, h } from "./dom.js";
import { Stage } from "./stage.js";
import { number, t, useStrings } from "./strings.js";
import { bitmapOf } from "./view/pixels.js";

/** What the stage asks of the page, answered by the notebook's Python: pictures come as messages. */
class Kernel extends EventTarget {
  constructor(model) {
    super();
    this.model = model;
    this.asked = new Map(); // number -> {resolve, reject} of what was not answered yet
    this.count = 0;
    this.api = { picture: (path, options) => this.picture(path, options) };
    this.hear = (content, buffers) => this.answer(content, buffers);
    model.on("msg:custom", this.hear);
  }

  close() {
    this.model.off("msg:custom", this.hear);
  }

  tell(type, detail = null) {
    this.dispatchEvent(new CustomEvent(type, { detail }));
  }

  /** Whatever the page would do about a result; here it never has to be made again. */
  ask(result, question) {
    return question(result.id);
  }

  call(wanted) {
    return new Promise((resolve, reject) => {
      this.asked.set(++this.count, { resolve, reject });
      this.model.send({ ...wanted, number: this.count });
    });
  }

  answer({ number: which, error, ...found }, buffers) {
    const waiting = this.asked.get(which);
    this.asked.delete(which);
    if (error) waiting?.reject(new Error(error));
    else waiting?.resolve({ ...found, buffers });
  }

  async picture(path, { map = null, draw = null, most = null } = {}) {
    const { pixels, width, height, buffers } = await this.call({ of: path.split("/")[0], map, draw, most });
    const view = buffers[0];
    const bytes = view.buffer ? new Uint8Array(view.buffer, view.byteOffset, view.byteLength) : new Uint8Array(view);
    return { bitmap: await bitmapOf(bytes, pixels), size: [width, height] };
  }
}

/** The widget: the studio's stage, and below it what can be laid over the picture. */
class Notebook {
  constructor(model, element) {
    useStrings(model.get("_words"));
    this.model = model;
    this.kernel = new Kernel(model);
    this.opacity = 0.8;
    element.classList.add("weftex-view");
    element.dataset.lmSuppressShortcuts = "true"; // keys belong to the view while it has the focus
    const box = h("div", { class: "stage", style: { height: `${model.get("height")}px` } });
    this.foot = h("div", { class: "notebook-foot" });
    fill(element, box, this.foot);
    this.stage = new Stage(this.kernel, box, ["picture", "split", "maps", "light"]);
    this.stage.main.onhover = (place) => this.hover(place);
    element.addEventListener("keydown", (event) => this.key(event));
    this.begin();
  }

  close() {
    clearTimeout(this.asking);
    this.stage.close();
    this.kernel.close();
  }

  async begin() {
    const { sample, result } = this.model.get("_seen");
    try {
      for (const [name, one] of Object.entries({ material: sample, result })) {
        if (one) this.kernel[name] = { ...one, ...(await this.kernel.picture(name === "material" ? "materials" : "results", { map: one.main, most: 2048 })) };
      }
    } catch (error) {
      return this.stage.say(error.message);
    }
    this.stage.setSubject(result ? "result" : "sample");
    this.buildFoot();
  }

  buildFoot() {
    const { drawings } = this.model.get("_seen");
    const names = [["", t("overlay.none")], ...drawings.map((one) => [one, t(`overlay.${one}`)])];
    const list = h("select", { onchange: () => this.lay(list.value) }, names.map(([value, text]) => h("option", { value }, text)));
    const strength = h("input", { type: "range", min: 0, max: 1, step: 0.05, value: this.opacity, "aria-label": t("see.opacity"), oninput: () => {
      this.opacity = Number(strength.value);
      this.stage.main.show({ overlayOpacity: this.opacity });
    } });
    this.spot = h("output", { class: "hint" }, t("see.hover"));
    fill(this.foot, drawings.length ? [h("label", {}, t("see.overlay"), list), strength] : null, this.spot);
  }

  async lay(draw) {
    const { stage, kernel } = this;
    this.laid = draw;
    stage.say(null);
    if (!draw) return stage.main.show({ overlay: null });
    try {
      const { bitmap } = await kernel.picture("results", { draw, most: 2048 });
      if (this.laid !== draw) return;
      if (stage.mode !== "picture" && stage.mode !== "split") stage.setMode("picture");
      stage.main.show({ overlay: bitmap, overlayOpacity: this.opacity });
    } catch (error) {
      stage.say(error.message);
    }
  }

  /** The pixel under the pointer, and the place in the sample that it comes from. */
  hover(place) {
    const { result, material } = this.kernel;
    clearTimeout(this.asking);
    const color = place && this.stage.main.colorAt(...place);
    if (!color || !this.spot) return;
    const [width, height] = (result ?? material).size;
    const [x, y] = [Math.floor(place[0]) % width, Math.floor(place[1]) % height];
    const told = `${t("see.place")} ${x}, ${y} · ${t("see.color")} ${[...color].slice(0, color[3] < 255 ? 4 : 3).join(" ")}`;
    this.spot.textContent = told;
    if (!result) return;
    this.asking = setTimeout(async () => {
      const { source } = await this.kernel.call({ of: "source", x, y });
      if (source && this.spot.textContent === told) this.spot.textContent = `${told} · ${t("see.source")} ${source.map((one) => number(one, 1)).join(", ")}`;
    }, 90);
  }

  key(event) {
    const free = !event.target.closest("select, input") && !event.ctrlKey && !event.metaKey && !event.altKey;
    if (free && this.stage.mainKeys(event.key.toLowerCase())) event.preventDefault();
    event.stopPropagation();
  }
}

/** What anywidget calls. */
export const widget = {
  render({ model, el }) {
    const notebook = new Notebook(model, el);
    return () => notebook.close();
  },
};
