import { download, fault, field, fill, h, icon, iconButton, tick } from "../dom.js";
import { t } from "../strings.js";
import { AtlasGroup, BordersGroup, SizeGroup, wrapGroup } from "./take_groups.js";
import { makeButton } from "./tasks.js";

/** Files in any format, the command and the Python that make the same, the state to share. */
export class TakeScreen {
  constructor(app, stage) {
    this.app = app;
    this.stage = stage;
    this.wanted = { format: "", preset: "", name: "", source: false, report: false, recipe: false, density: null, pad: null, crop: null };
    this.open = new Set(); // the groups that are
    this.size = new SizeGroup(this);
    this.borders = new BordersGroup(this);
    this.atlas = new AtlasGroup(this);
  }

  enter(panel) {
    this.panel = panel;
    if (this.stage.mode === "plane") this.stage.setMode("picture"); // it is no part of the result
    this.stage.setSubject("result");
    const update = () => this.draw();
    this.stop?.(); // it may be entered twice
    this.stop = this.app.listen({ result: update, material: update });
    this.draw();
  }

  leave() {
    this.stop();
    this.panel = null;
  }

  /** What is checked and saved: the result, or the sample as it is while there is none. */
  get source() {
    return this.app.result ?? this.app.material;
  }

  /** Ask about it, by the start of its address. */
  ask(question) {
    const { app } = this;
    return app.result ? app.ask(app.result, (id) => question(`results/${id}`)) : question(`materials/${app.material.id}`);
  }

  get name() {
    return this.wanted.name || this.source.file;
  }

  ticket(made) {
    return ticket(made);
  }

  draw() {
    if (!this.panel) return;
    const { app, wanted, source } = this;
    const { result } = app;
    if (app.preview?.result) {
      fill(this.panel, h("h2", {}, t("take.title")), h("p", {}, t("take.preview")), makeButton(app));
      return;
    }
    if (this.of !== source.id) {
      this.of = source.id; // what was saved of another result is no concern of this one
      this.saved = this.error = null;
      Object.assign(wanted, { name: "", density: null, pad: null, crop: null });
      this.borders.forget();
      this.atlas.forget();
    }
    const set = source.maps.length > 1;
    const formats = source.formats[source.main];
    const format = h("select", { onchange: () => (wanted.format = format.value) }, h("option", { value: "" }, t("take.same")), formats.map((one) => h("option", { value: one }, one.slice(1).toUpperCase())));
    format.value = wanted.format;
    const preset = h("select", { onchange: () => ((wanted.preset = preset.value), this.draw()) }, h("option", { value: "" }, t("take.preset.none")), app.about.presets.map((one) => h("option", { value: one.name }, one.about || one.name)));
    preset.value = wanted.preset;
    const name = h("input", { type: "text", value: this.name, onchange: () => (wanted.name = name.value.trim()) });
    const box = (key, words) => tick(words, wanted[key], (on) => (wanted[key] = on));
    const group = (key, parts) => h("details", { "data-group": key, open: this.open.has(key), ontoggle: (event) => this.open[event.target.open ? "add" : "delete"](key) }, h("summary", {}, t(`${key}.title`)), h("div", { class: "parameters" }, this.errorIn === key ? this.error : null, parts));
    fill(
      this.panel,
      h("div", {}, h("h2", {}, t("take.title")), h("p", { class: "hint" }, [t("stage.size", { width: source.width, height: source.height }), result?.method ?? source.name].join(" · "))),
      result ? null : h("div", { class: "note" }, icon("picture"), h("div", {}, h("span", {}, t("take.photo")), makeButton(app, ""))),
      field(t("take.name"), name),
      field(t("take.preset"), preset),
      wanted.preset ? null : field(t("take.format"), format),
      set ? this.mapBoxes(source) : null,
      this.errorIn ? null : this.error,
      h("button", { type: "button", class: "main large", onclick: () => this.save() }, icon("take"), t("take.go")),
      this.saved,
      result ? this.handOut(result) : null,
      h(
        "div",
        {},
        group("size", this.size.draw()),
        group("borders", this.borders.draw()),
        group("wrap", wrapGroup(this)),
        group("atlas", this.atlas.draw()),
        result ? group("more", [box("source", t("take.source")), box("report", t("take.report")), box("recipe", t("take.recipe"))]) : null,
      ),
      result ? this.share(result) : null,
      result ? h("section", { class: "section" }, h("h3", {}, t("take.command")), copyable(result.command, t("take.copy.command")), h("h3", {}, "Python"), copyable(result.python, t("take.copy.python"))) : null,
    );
  }

  /** A preset, or a format; both are null where nothing was chosen. */
  files() {
    const { preset, format } = this.wanted;
    return { preset: preset || null, format: (!preset && format) || null };
  }

  /** The picture for other programs: to the clipboard, or dragged there. */
  handOut(result) {
    if (result.bitmap.width < result.width) return null; // the page has a smaller copy of it
    const image = h("img", { class: "drag", alt: t("take.drag"), title: t("take.drag"), draggable: "true" });
    pngOf(result).then((file) => {
      image.src = URL.createObjectURL(file);
      image.addEventListener("load", () => setTimeout(() => image.isConnected || URL.revokeObjectURL(image.src), 1000));
      image.addEventListener("dragstart", (event) => carry(event, "image/png", `${result.file}.png`, image.src));
    });
    const copyIt = h("button", { type: "button", onclick: () => this.attempt(async () => {
      await navigator.clipboard.write([new ClipboardItem({ "image/png": pngOf(result) })]);
      this.app.tell("notice", { text: t("take.copied") });
    }) }, icon("copy"), t("take.copy.picture"));
    return h("div", { class: "hand-out" }, image, h("div", {}, copyIt, h("p", { class: "hint" }, t("take.drag"))));
  }

  mapBoxes(source) {
    const left = (this.left ??= new Set());
    return h("fieldset", {}, h("legend", {}, t("take.maps")), source.maps.map((one) => tick(one.name, !left.has(one.name), (on) => left[on ? "delete" : "add"](one.name))));
  }

  async save() {
    const { app, wanted } = this;
    const maps = this.left?.size ? this.source.maps.map((one) => one.name).filter((one) => !this.left.has(one)) : null;
    await this.attempt(async () => {
      const made = await this.ask((path) => app.api.post(`${path}/exports`, { ...wanted, maps, ...this.files(), name: this.name }));
      this.saved = [ticket(made), made.notes.map((line) => h("p", { class: "hint" }, line))];
      this.draw();
      this.panel.querySelector("[data-ticket]").click();
    });
  }

  /** Do something that may fail; its one line is shown in a group, or at the button that saves. */
  async attempt(action, group = "") {
    this.error = null;
    try {
      await action();
    } catch (error) {
      this.errorIn = group;
      this.error = error.message && error.name !== "AbortError" ? fault(error.message) : null;
      this.draw();
    }
  }

  share(result) {
    const { app } = this;
    return h(
      "section",
      { class: "section" },
      h("h3", {}, t("share.title")),
      h("p", { class: "hint" }, t("share.help")),
      h(
        "div",
        { class: "row" },
        copyButton(app.api.addressOf(location.hash), t("share.link")),
        h("button", { type: "button", onclick: () => app.guard(() => saveState(app, result.recipe)) }, icon("take"), t("share.file")),
      ),
    );
  }
}

/** The picture of a result as a PNG file, as the page has it. */
async function pngOf(result) {
  const canvas = new OffscreenCanvas(result.bitmap.width, result.bitmap.height);
  canvas.getContext("2d").drawImage(result.bitmap, 0, 0);
  return canvas.convertToBlob({ type: "image/png" });
}

/** Let a drag carry a file to folders and other programs; its name has no colon, by which the parts are told apart. */
function carry(event, kind, name, url) {
  event.dataTransfer.setData("DownloadURL", `${kind}:${name}:${url}`);
}

function ticket({ ticket: id, name, bytes }) {
  const ondragstart = (event) => carry(event, "application/octet-stream", name, event.target.href);
  return h("a", { class: "button", href: `/api/downloads/${id}`, download: name, "data-ticket": id, title: t("take.drag_file"), ondragstart }, icon("take"), t("take.ready", { name, size: bytes > 1e6 ? `${(bytes / 1e6).toFixed(1)} MB` : `${Math.ceil(bytes / 1e3)} kB` }));
}

function copyable(text, label) {
  return h("div", { class: "copyable" }, h("pre", { tabindex: 0 }, text), iconButton("copy", label, (event) => copy(text, event.currentTarget)));
}

function copyButton(text, label) {
  return h("button", { type: "button", onclick: (event) => copy(text, event.currentTarget, label) }, icon("copy"), label);
}

/** Copy a text; the button says so for a moment, in words where it has a `label`. */
async function copy(text, button, label = "") {
  await navigator.clipboard.writeText(text);
  fill(button, icon("check"), label && t("share.copied"));
  setTimeout(() => fill(button, icon("copy"), label), 1200);
}

/** A small file that holds a recipe and the pictures that it names, if they are small. */
async function saveState(app, recipe) {
  const pictures = {};
  for (const id of new Set(JSON.stringify(recipe).match(/\b[0-9a-f]{64}\b/g) ?? [])) {
    const bytes = new Uint8Array(await (await app.api.fetch(`uploads/${id}`)).arrayBuffer());
    if (bytes.length > MOST_IN_FILE) continue;
    let text = "";
    for (let k = 0; k < bytes.length; k += 8192) text += String.fromCharCode(...bytes.subarray(k, k + 8192));
    pictures[id] = btoa(text);
  }
  const file = new Blob([JSON.stringify({ weftex: 1, recipe, pictures })], { type: "application/json" });
  download(file, `${app.material.name}.weftex.json`);
}

const MOST_IN_FILE = 8e6;

/** Open such a file, or an address that holds a state. */
export async function openState(app, text) {
  const { fromAddress } = await import("../history.js");
  const recipe = fromAddress(text);
  if (recipe) return app.openRecipe(recipe, t("history.shared"));
  let found;
  try {
    found = JSON.parse(text);
  } catch {
    throw new Error(t("state.unknown"));
  }
  if (!found.recipe?.materials) throw new Error(t("state.unknown"));
  for (const [id, data] of Object.entries(found.pictures ?? {})) {
    const bytes = Uint8Array.from(atob(data), (one) => one.charCodeAt(0));
    await app.api.upload(new Blob([bytes]), `${id.slice(0, 8)}.png`);
  }
  return app.openRecipe(found.recipe, t("history.shared"));
}
