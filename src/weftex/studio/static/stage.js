import { download, fill, h, icon, iconButton } from "./dom.js";
import { duration, has, number, progressOf, t } from "./strings.js";
import { Camera } from "./view/camera.js";
import { LightView } from "./view/light.js";
import { lightMaps } from "./view/light_maps.js";
import { Plane } from "./view/plane.js";
import { SolidView } from "./view/solid.js";
import { Viewer } from "./view/viewer.js";

const MODES = { picture: "picture", split: "split", maps: "maps", light: "light", solid: "solid", plane: "plane" };

/** The picture's part of the page: one view, or several that move together, and the bar below them. */
export class Stage {
  constructor(app, element, modes = Object.keys(MODES)) {
    this.app = app;
    this.modes = modes;
    this.element = element;
    this.camera = new Camera();
    this.views = h("div", { class: "views" });
    this.bar = h("div", { class: "stage-bar", role: "toolbar", "aria-label": t("stage.bar") });
    this.badge = h("div", { class: "caption badge", role: "status", hidden: true });
    this.chip = h("div", { class: "progress", role: "status", hidden: true });
    this.message = h("div", { class: "stage-message", role: "alert", hidden: true });
    element.append(this.views, this.badge, this.chip, this.message, this.bar);
    this.main = new Viewer({ camera: this.camera, label: t("stage.view") });
    this.mode = "picture";
    this.subject = "result";
    this.cells = [];
    this.camera.listen(() => this.tellZoom());
    for (const type of ["material", "result", "preview"]) app.addEventListener(type, () => this.refresh());
    app.addEventListener("job", () => this.tellJob());
    this.single();
    this.buildBar();
  }

  close() {
    this.closeExtras(null);
    for (const cell of this.cells) cell.view.close();
    this.main.close();
  }

  // -- what is seen

  /** {picture, size, title, about} of what the view is to show; null where there is nothing. */
  seen() {
    const { app } = this;
    if (!app.material) return null;
    const sample = { picture: app.material.bitmap, size: app.material.size, title: app.material.name, owner: app.material, path: `materials/${app.material.id}`, isSample: true };
    if (this.subject === "sample") return sample;
    if (app.preview) return { picture: app.preview.bitmap, size: app.preview.size, title: t("stage.preview"), owner: app.preview.result, path: app.preview.result && `results/${app.preview.result.id}` };
    if (app.result) return { picture: app.result.bitmap, size: app.result.size, title: app.result.method, owner: app.result, path: `results/${app.result.id}`, seconds: app.result.seconds };
    return sample;
  }

  setSubject(subject) {
    this.subject = subject;
    this.refresh();
  }

  setMode(mode) {
    if (mode === this.mode) return;
    if (this.mode === "split" || mode === "split") this.main.split = 0.5;
    this.mode = mode;
    this.say(null);
    this.refresh();
  }

  setRepeat(repeat) {
    this.main.show({ repeat });
    for (const cell of this.cells) cell.view.show({ repeat });
    this.camera.fitted = true;
    this.main.fit();
    this.light?.draw();
    this.solid?.draw();
    this.buildBar();
  }

  /** Say on the picture that it is not the final one. */
  tellPreview() {
    const preview = this.custom || this.subject === "sample" || this.mode === "plane" ? null : this.app.preview;
    this.badge.hidden = !preview;
    if (!preview) return;
    const [width, height] = preview.size;
    this.badge.textContent = preview.grows ? t("badge.grows") : preview.isPart ? t("badge.part") : t("badge.other", { width, height });
  }

  /** Draw what the mode says of what is seen. */
  refresh() {
    const seen = this.seen();
    this.tellPreview();
    if (!seen || this.custom) return;
    if (this.mode === "maps" && seen.owner?.maps?.length > 1) return this.showMaps(seen);
    this.single();
    this.main.show({ picture: seen.picture, size: seen.size, before: null });
    this.closeExtras(seen);
    if (this.mode === "split") this.showSplit(seen);
    if (this.mode === "light") this.showLight(seen);
    if (this.mode === "solid") this.showSolid(seen);
    if (this.mode === "plane") this.showPlane();
    this.overlayFor?.(seen);
    this.buildBar();
  }

  single() {
    if (this.views.firstChild === this.main.element && this.views.childElementCount === 1) return;
    for (const cell of this.cells) cell.view.close();
    this.cells = [];
    this.views.className = "views";
    fill(this.views, this.main.element);
  }

  /** Several views that move together: [{picture, size, caption, action}]. */
  several(items) {
    for (const cell of this.cells) cell.view.close();
    this.closeExtras(null);
    this.views.className = "views many";
    this.views.style.setProperty("--count", items.length);
    this.views.style.setProperty("--columns", Math.ceil(Math.sqrt(items.length)));
    this.cells = items.map((item) => {
      const view = new Viewer({ camera: this.camera, label: item.label ?? item.title });
      const foot = h("div", { class: "cell-foot" }, h("span", { class: "cell-title" }, item.title), h("span", { class: "cell-note" }, item.note ?? ""), item.action ?? null);
      return { view, foot, item, frame: h("div", { class: "cell" }, view.element, foot) };
    });
    fill(this.views, this.cells.map((cell) => cell.frame));
    for (const { view, item } of this.cells) view.show({ picture: item.picture, size: item.size, repeat: this.main.repeat });
    return this.cells;
  }

  // -- modes

  showSplit(seen) {
    const { main, app } = this;
    const before = app.material;
    const same = before.size.join() === seen.size.join();
    main.show({ before: seen.isSample ? null : same ? before.bitmap : repeated(before, seen.size) });
    const move = (share) => {
      main.split = Math.max(0, Math.min(1, share));
      line.style.left = `${100 * main.split}%`;
      line.setAttribute("aria-valuenow", Math.round(100 * main.split));
      main.draw();
    };
    const line = h("button", { class: "split-line", type: "button", role: "slider", "aria-label": t("stage.split"), "aria-valuemin": 0, "aria-valuemax": 100 }, h("span", {}, icon("split")));
    line.addEventListener("pointerdown", (event) => line.setPointerCapture(event.pointerId));
    line.addEventListener("pointermove", (event) => {
      if (!line.hasPointerCapture(event.pointerId)) return;
      const box = main.element.getBoundingClientRect();
      move((event.clientX - box.left) / box.width);
    });
    line.addEventListener("keydown", (event) => {
      const step = { ArrowLeft: -0.02, ArrowRight: 0.02 }[event.key];
      if (!step) return;
      event.preventDefault();
      event.stopPropagation();
      move(main.split + step);
    });
    this.extras = [line, h("span", { class: "caption" }, same ? t("stage.before") : t("stage.repeated")), h("span", { class: "caption right" }, t("stage.after"))];
    main.element.append(...this.extras);
    move(main.split);
  }

  closeExtras(seen) {
    for (const extra of this.extras ?? []) extra.remove();
    this.extras = [];
    if (this.mode !== "light" || !seen) this.closeLight();
    if (this.mode !== "solid" || !seen) this.closeSolid();
    if (this.mode !== "plane" || !seen || this.plane?.recipe !== JSON.stringify(this.app.recipe)) this.closePlane();
  }

  async showMaps(seen) {
    const maps = seen.owner.maps;
    const pictures = await this.pictures(seen, maps.map((one) => one.name));
    if (this.mode !== "maps") return;
    this.several(maps.map((one, k) => ({ picture: pictures[k], size: seen.size, title: has(`role.${one.role}`) ? t(`role.${one.role}`) : one.name, note: one.dtype })));
    this.buildBar();
  }

  /** Pictures of maps, kept with what they belong to. */
  async pictures(seen, names) {
    const kept = (seen.owner.pictures ??= { [seen.owner.main]: seen.picture });
    return Promise.all(
      names.map(async (name) => (kept[name] ??= (await this.ask(seen, (path) => this.app.api.picture(`${path}/picture`, { map: name, most: 2048 }))).bitmap)),
    );
  }

  ask(seen, question) {
    return seen.isSample ? question(seen.path) : this.app.ask(seen.owner, (id) => question(`results/${id}`));
  }

  async showLight(seen) {
    if (!LightView.possible()) return this.say(t("stage.nolight"), true);
    if (!this.light) {
      this.light = new LightView(this.main);
      this.main.element.addEventListener("pointermove", (this.follow = (event) => this.light?.follow(event)));
    }
    const { roles, directx } = await this.roles(seen);
    this.light?.show(roles, { directx });
    this.app.tell("light", { guessed: !roles.normal && !roles.height });
  }

  async roles(seen) {
    const maps = seen.owner?.maps ?? [];
    const pictures = seen.owner ? await this.pictures(seen, maps.map((one) => one.name)) : [seen.picture];
    return lightMaps(maps, pictures, seen.picture);
  }

  /** The material on a solid under light; a plain picture where there is no WebGL2. */
  async showSolid(seen) {
    if (!LightView.possible()) return this.say(t("stage.nolight"), true);
    this.solid ??= new SolidView(this.main);
    const { roles, directx } = await this.roles(seen);
    this.solid?.show(roles, { directx, size: seen.size });
  }

  closeSolid() {
    this.solid?.close();
    this.solid = null;
  }

  closeLight() {
    if (!this.light) return;
    this.main.element.removeEventListener("pointermove", this.follow);
    this.light.close();
    this.light = null;
  }

  async showPlane() {
    if (this.plane) return;
    const { app, main } = this;
    const recipe = { ...app.recipe, task: "synth" };
    const plane = { recipe: JSON.stringify(app.recipe) };
    this.plane = plane;
    try {
      const { id, maps, method } = await app.api.post("planes", recipe);
      Object.assign(plane, { id, method });
      const side = 256;
      const get = async ({ top, left, side: length }, signal) =>
        (await app.api.picture(`planes/${id}/window`, { top, left, height: length, width: length, most: side, map: maps[0].name }, signal)).bitmap;
      if (this.plane !== plane) return;
      plane.view = new Plane(get, { side, onchange: (one) => one.failed && this.say(one.failed.message) });
      main.show({ background: (context, view) => plane.view.draw(context, view), repeat: 1 });
      this.camera.least = 0.12;
      this.camera.set(side, side, 1 / window.devicePixelRatio);
      this.buildBar();
    } catch (error) {
      if (this.plane === plane) this.say(error.message);
    }
  }

  /** Save what is in view of the plane, at full size, as a PNG file. */
  async savePlane() {
    const { id } = this.plane ?? {};
    if (!id) return;
    const { camera, main } = this;
    const [width, height] = [main.element.clientWidth, main.element.clientHeight].map((one) => Math.max(1, Math.min(1024, Math.round(one / camera.scale))));
    const query = new URLSearchParams({ top: Math.round(camera.y - height / 2), left: Math.round(camera.x - width / 2), height, width });
    const file = await (await this.app.api.fetch(`planes/${id}/window?${query}`)).blob();
    download(file, `${this.app.material.name.replace(/\.[^.]*$/, "")}_plane_${width}x${height}.png`);
  }

  closePlane() {
    this.plane?.view?.close();
    this.plane = null;
    this.camera.least = Camera.LEAST;
    if (this.main.background) this.main.show({ background: null, repeat: this.main.repeat });
  }

  // -- words

  /** Keys that work wherever the focus is: modes and repetition. */
  mainKeys(key) {
    if (this.custom || !this.seen()) return false;
    const mode = { p: "picture", b: "split", m: "maps", l: "light", d: "solid", e: "plane" }[key];
    if (mode && this.bar.querySelector(`[data-key="${mode}"]`)) this.setMode(this.mode === mode ? "picture" : mode);
    else if (key === "r" && this.mode !== "plane") this.setRepeat((this.main.repeat % 3) + 1);
    else return false;
    return true;
  }

  /** Say in passing what is being done. */
  note(text) {
    this.say(text, true);
    this.passing = setTimeout(() => this.say(null), 2500);
  }

  say(text, calm = false) {
    clearTimeout(this.passing);
    this.message.classList.toggle("passing", calm);
    this.message.hidden = !text;
    fill(this.message, text ? [icon("warn"), h("span", {}, text), iconButton("close", t("close"), () => this.say(null))] : []);
  }

  tellZoom() {
    if (!this.zoomText) return;
    const percent = 100 * this.camera.scale * window.devicePixelRatio;
    this.zoomText.textContent = `${number(percent, percent < 10 ? 1 : 0)} %`;
  }

  tellJob() {
    const { job } = this.app;
    this.element.classList.toggle("busy", Boolean(job));
    const slow = job && (!job.quiet || job.seconds > 0.6);
    this.chip.hidden = !slow;
    if (!slow) return;
    const { text, share } = progressOf(job);
    const picture = job.many > 1 ? t("job.picture", { n: Math.min(job.many, job.results.length + 1), of: job.many }) : "";
    if (!this.chip.firstChild) {
      this.chip.append(
        h("div", { class: "progress-line" }, h("span")),
        h("span", { class: "progress-text" }),
        h("button", { type: "button", onclick: () => this.app.stopWork() }, t("job.cancel")),
      );
    }
    this.chip.querySelector(".progress-line span").style.width = `${100 * share}%`;
    this.chip.querySelector(".progress-text").textContent = [picture, text].filter(Boolean).join(" · ");
  }

  buildBar() {
    const seen = this.seen();
    if (!seen) return fill(this.bar);
    const held = document.activeElement?.closest?.(".stage-bar") && document.activeElement.dataset.key;
    const many = seen.owner?.maps?.length > 1;
    const offered = this.custom ? [] : this.modes.filter((mode) => (mode !== "maps" || many) && (mode !== "split" || !seen.isSample) && (mode !== "plane" || !seen.isSample));
    const modes = offered.map((mode) =>
      h("button", { type: "button", class: "mode", "data-key": mode, "aria-pressed": String(mode === this.mode), title: t(`mode.${mode}.help`), onclick: () => this.setMode(mode) }, icon(MODES[mode]), h("span", {}, t(`mode.${mode}`))),
    );
    const repeats = this.mode === "plane" || this.custom === "paint" ? [] : [1, 2, 3].map((n) =>
      h("button", { type: "button", class: "mode number-mode", "data-key": `repeat${n}`, "aria-pressed": String(n === this.main.repeat), "aria-label": t("stage.repeat", { n }), title: t("stage.repeat", { n }), onclick: () => this.setRepeat(n) }, `${n}×${n}`),
    );
    this.zoomText = h("output", { class: "zoom-text" });
    const [width, height] = this.custom === "paint" ? this.main.size : this.custom ? this.cells.at(-1).item.size : seen.size;
    const plane = !this.custom && this.mode === "plane";
    const size = plane ? "" : `${width} × ${height}`;
    const seconds = !this.custom && !plane && seen.seconds ? h("span", { class: "seconds" }, `· ${duration(seen.seconds)}`) : null;
    fill(
      this.bar,
      h("div", { class: "about" }, h("strong", {}, plane ? t("plane.title", { method: this.plane?.method ?? "…" }) : (this.title ?? seen.title)), h("span", {}, size), seconds),
      h("div", { class: "modes" }, plane ? h("button", { type: "button", class: "mode", title: t("plane.save"), onclick: () => this.app.guard(() => this.savePlane()) }, icon("take"), h("span", {}, t("plane.save"))) : null, modes, repeats.length ? h("span", { class: "gap" }) : null, repeats),
      h("div", { class: "zoom" }, iconButton("minus", t("stage.out"), () => this.camera.zoom(Math.SQRT1_2)), this.zoomText, iconButton("plus", t("stage.in"), () => this.camera.zoom(Math.SQRT2)), iconButton("fit", t("stage.fit"), () => (this.cells[0]?.view ?? this.main).fit())),
    );
    if (held) this.bar.querySelector(`[data-key="${held}"]`)?.focus();
    this.tellZoom();
  }
}

/** The sample laid side by side over a size, as a picture editor would. */
function repeated({ bitmap, size }, [width, height]) {
  const canvas = new OffscreenCanvas(width, height);
  const context = canvas.getContext("2d");
  for (let y = 0; y < height; y += size[1]) for (let x = 0; x < width; x += size[0]) context.drawImage(bitmap, x, y, size[0], size[1]);
  return canvas;
}
