import { download, field, fill, h, icon, iconButton, tick } from "../dom.js";
import { t } from "../strings.js";

/** Files in any format, the command and the Python that make the same, the state to share. */
export class TakeScreen {
  constructor(app, stage) {
    this.app = app;
    this.stage = stage;
    this.wanted = { format: "", preset: "", name: "", source: false, report: false, recipe: false, atlas: false };
    this.update = () => this.draw();
  }

  enter(panel) {
    this.panel = panel;
    if (this.stage.mode === "plane") this.stage.setMode("picture"); // it is no part of the result
    this.stage.setSubject("result");
    this.app.addEventListener("result", this.update);
    this.draw();
  }

  leave() {
    this.app.removeEventListener("result", this.update);
    this.panel = null;
  }

  draw() {
    const { app, wanted } = this;
    const { result } = app;
    if (!result || app.preview?.result) {
      fill(this.panel, h("h2", {}, t("take.title")), h("p", {}, t(result ? "see.preview" : "see.nothing")), h("button", { type: "button", class: "main large", onclick: () => app.tell("go", { screen: "make", now: true }) }, t("make.go")));
      return;
    }
    if (this.of !== result.id) {
      this.of = result.id; // what was saved of another result is no concern of this one
      this.saved = this.error = null;
      wanted.name = "";
    }
    const set = result.maps.length > 1;
    const formats = result.formats[result.main];
    const format = h("select", { onchange: () => (wanted.format = format.value) }, h("option", { value: "" }, t("take.same")), formats.map((one) => h("option", { value: one }, one.slice(1).toUpperCase())));
    format.value = wanted.format;
    const preset = h("select", { onchange: () => ((wanted.preset = preset.value), this.draw()) }, h("option", { value: "" }, t("take.preset.none")), app.about.presets.map((one) => h("option", { value: one.name }, one.about || one.name)));
    preset.value = wanted.preset;
    const name = h("input", { type: "text", value: wanted.name || result.file, onchange: () => (wanted.name = name.value.trim()) });
    const box = (key, words) => tick(words, wanted[key], (on) => (wanted[key] = on));
    this.maps ??= null;
    fill(
      this.panel,
      h("div", {}, h("h2", {}, t("take.title")), h("p", { class: "hint" }, `${t("stage.size", { width: result.width, height: result.height })} · ${result.method}`)),
      field(t("take.name"), name),
      field(t("take.preset"), preset),
      wanted.preset ? null : field(t("take.format"), format),
      set ? this.mapBoxes(result) : null,
      h("div", {}, box("source", t("take.source")), box("report", t("take.report")), box("recipe", t("take.recipe")), box("atlas", t("take.atlas"))),
      this.error,
      h("button", { type: "button", class: "main large", onclick: () => this.save() }, icon("take"), t("take.go")),
      this.saved,
      this.handOut(result),
      this.share(result),
      h("section", { class: "section" }, h("h3", {}, t("take.command")), copyable(result.command, t("take.copy.command")), h("h3", {}, "Python"), copyable(result.python, t("take.copy.python"))),
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

  mapBoxes(result) {
    const left = (this.left ??= new Set());
    return h("fieldset", {}, h("legend", {}, t("take.maps")), result.maps.map((one) => tick(one.name, !left.has(one.name), (on) => left[on ? "delete" : "add"](one.name))));
  }

  async save() {
    const { app, wanted } = this;
    const { result } = app;
    const maps = this.left?.size ? result.maps.map((one) => one.name).filter((one) => !this.left.has(one)) : null;
    await this.attempt(async () => {
      const made = await app.ask(result, (id) => app.api.post(`results/${id}/exports`, { ...wanted, maps, ...this.files(), name: wanted.name || result.file }));
      this.saved = [ticket(made), made.notes.map((line) => h("p", { class: "hint" }, line))];
      this.draw();
      this.panel.querySelector("[data-ticket]").click();
    });
  }

  async attempt(action) {
    this.error = null;
    try {
      await action();
    } catch (error) {
      this.error = error.message ? h("div", { class: "note error", role: "alert" }, icon("warn"), h("div", {}, error.message)) : null;
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
        copyButton(location.href, t("share.link")),
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
  return h("button", { type: "button", onclick: (event) => copy(text, event.currentTarget) }, icon("copy"), label);
}

async function copy(text, button) {
  await navigator.clipboard.writeText(text);
  const old = button.querySelector(".icon");
  const done = icon("check");
  old.replaceWith(done);
  setTimeout(() => done.replaceWith(old), 1200);
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
