import { App } from "./app.js";
import { dialog, drawSquare, drawText, fill, h, icon, iconButton } from "./dom.js";
import { CompareScreen } from "./screens/compare.js";
import { front } from "./screens/front.js";
import { MakeScreen } from "./screens/make.js";
import { PaintScreen } from "./screens/paint.js";
import { showPresets } from "./screens/presets.js";
import { SampleScreen } from "./screens/sample.js";
import { SeeScreen } from "./screens/see.js";
import { openState, TakeScreen } from "./screens/take.js";
import { sameJson } from "./shelf.js";
import { Stage } from "./stage.js";
import { loadStrings, t } from "./strings.js";

const SCREENS = { sample: SampleScreen, make: MakeScreen, see: SeeScreen, paint: PaintScreen, compare: CompareScreen, take: TakeScreen };
const byId = (id) => document.getElementById(id);
const remembered = (key) => localStorage.getItem(`weftex-${key}`);

const app = new App();
let stage, screens, present, opening;

/** Show a screen; `options` are its own. */
function go(name, options = {}) {
  if (!app.material) return;
  if (name !== "sample" && !app.about) return app.guard(() => app.know().then(() => go(name, options)));
  opening?.remove();
  opening = null;
  document.body.classList.remove("empty");
  if (present !== name) {
    screens[present]?.leave();
    present = name;
    byId("panel").scrollTo(0, 0);
  }
  stage.say(null);
  const body = h("div", { class: "panel-body" });
  fill(byId("panel"), body);
  for (const button of document.querySelectorAll(".steps button")) {
    button.disabled = false;
    if (button.dataset.screen === name) {
      button.setAttribute("aria-current", "step");
      button.scrollIntoView({ block: "nearest", inline: "nearest" });
    } else button.removeAttribute("aria-current");
  }
  screens[name].enter(body, options);
  if (document.activeElement === document.body) byId("panel").focus({ preventScroll: true });
}

function buildBar() {
  const steps = Object.keys(SCREENS).map((name) => h("button", { type: "button", disabled: true, "data-screen": name, onclick: () => go(name) }, t(`step.${name}`)));
  const undo = iconButton("undo", t("history.undo"), () => undoStep(), { disabled: true });
  const redo = iconButton("redo", t("history.redo"), () => redoStep(), { disabled: true });
  app.history.listen(() => {
    undo.disabled = !app.history.before;
    redo.disabled = !app.history.after;
    buildStrip();
  });
  fill(
    byId("bar"),
    h("div", { class: "brand" }, mark(), t("brand")),
    h("nav", { class: "steps", "aria-label": t("step.all") }, steps),
    h(
      "div",
      { class: "bar-end" },
      undo,
      redo,
      iconButton("open", t("front.open"), () => showFront()),
      iconButton("theme", t("theme"), turnTheme),
      iconButton("keys", t("keys.title"), showKeys),
    ),
  );
}

/** The sign of the studio: two threads over and under two others. */
function mark() {
  const svg = icon("grid");
  svg.setAttribute("viewBox", "0 0 20 20");
  const path = (kind, d) => {
    const one = svg.firstChild.cloneNode();
    one.setAttribute("class", kind);
    one.setAttribute("d", d);
    return one;
  };
  svg.replaceChildren(path("warp", "M6 2.5V11M6 16v1.5M14 2.5V4M14 9v8.5"), path("weft", "M2.5 6.5h1M9 6.5h8.5M2.5 13.5H11M16.5 13.5h1"));
  return svg;
}

/** All steps; those that are on another branch than the present one are paler. */
function buildStrip() {
  const { entries, present: now } = app.history;
  const strip = byId("strip");
  const path = app.history.path();
  strip.hidden = entries.length === 0;
  fill(
    strip,
    entries.map((entry, k) => {
      const canvas = (entry.canvas ??= h("canvas", { width: 68, height: 68 }));
      const isOfMaterial = entry === now && !entry.result && sameJson(app.material?.asked, entry.state.materials[0]);
      const picture = entry.result?.bitmap ?? (isOfMaterial ? app.material.bitmap : null);
      if (picture && canvas.shows !== picture) drawSquare(canvas, (canvas.shows = picture));
      else if (!canvas.shows && entry.thumb) drawText(canvas, (canvas.shows = entry.thumb));
      const about = entry.result ? `${entry.result.method} · ${entry.state.seed}` : entry.title;
      const branch = entry.parent !== (entries[k - 1]?.id ?? null);
      return h(
        "button",
        { type: "button", class: path.has(entry) ? "" : "aside", "aria-label": `${entry.label}, ${about}`, title: branch ? t("history.branch", { name: app.history.get(entry.parent)?.label ?? "" }) : null, "aria-current": entry === now ? "true" : null, onclick: () => app.guard(() => app.travel(app.history.go(entry))) },
        branch ? icon("branch") : null,
        canvas,
        h("span", { class: "what" }, h("span", {}, entry.label), h("span", {}, about)),
      );
    }),
  );
  strip.querySelector("[aria-current]")?.scrollIntoView({ block: "nearest", inline: "nearest" });
}

function undoStep() {
  if (present === "paint" && screens.paint.mask?.undo()) return;
  app.guard(() => app.undo());
}

function redoStep() {
  if (present === "paint" && screens.paint.mask?.redo()) return;
  app.guard(() => app.redo());
}

function showFront() {
  app.cancel();
  screens[present]?.leave();
  present = null;
  opening?.remove();
  document.body.classList.add("empty");
  for (const button of document.querySelectorAll(".steps button")) {
    button.removeAttribute("aria-current");
    button.disabled = !app.material;
  }
  opening = front(app, showOpenState);
  byId("stage").append(opening);
}

// -- dialogs

function showKeys() {
  const rows = ["steps", "undo", "make", "cancel", "zoom", "pan", "fit", "repeat", "mode", "brush", "paint"].map((one) =>
    h("tr", {}, h("th", { scope: "row" }, t(`keys.${one}.keys`).split(" ").map((key) => [h("kbd", {}, key), " "])), h("td", {}, t(`keys.${one}`))),
  );
  const language = h("select", { onchange: () => { localStorage.setItem("weftex-language", language.value); location.reload(); } }, t("languages").split(" ").map((one) => h("option", { value: one }, new Intl.DisplayNames([one], { type: "language" }).of(one))));
  language.value = document.documentElement.lang;
  const box = dialog(t("keys.title"), h("table", {}, h("tbody", {}, rows)), t("languages").includes(" ") ? h("label", { class: "row" }, t("language"), language) : null, h("p", { class: "row" }, h("button", { type: "button", class: "main", onclick: () => box.close() }, t("close"))));
}

function showOpenState() {
  const text = h("input", { type: "text", "aria-label": t("state.paste"), placeholder: t("state.paste") });
  const file = h("input", { type: "file", accept: ".json", "aria-label": t("state.file"), onchange: async () => load(await file.files[0].text()) });
  const error = h("p", { class: "note error", role: "alert", hidden: true });
  const load = async (content) => {
    try {
      await openState(app, content);
      box.close();
    } catch (fault) {
      error.hidden = false;
      error.textContent = fault.message;
    }
  };
  const box = dialog(t("state.open"), h("div", { class: "parameters" }, file, text, error, h("div", { class: "row" }, h("button", { type: "button", class: "main", onclick: () => load(text.value) }, t("state.go")), h("button", { type: "button", onclick: () => box.close() }, t("close")))));
}

function tellLost(why) {
  if (document.querySelector("dialog.lost")) return;
  const text = h("input", { type: "text", "aria-label": t("lost.paste"), placeholder: "http://127.0.0.1:…/#token=…" });
  const again = () => {
    const found = /[#&]token=([^&\s]+)/.exec(text.value);
    if (found) sessionStorage.setItem("weftex-token", found[1]);
    const other = /^https?:\/\/[^#\s]+/.exec(text.value)?.[0];
    if (other && !other.startsWith(location.origin)) location.href = [text.value, `session=${app.api.session}`, location.hash.slice(1)].filter(Boolean).join("&");
    else location.reload();
  };
  const box = dialog(t("lost.title"), h("div", { class: "parameters" }, h("p", {}, t(`lost.${why}`)), text, h("div", { class: "row" }, h("button", { type: "button", class: "main", onclick: again }, t("lost.again")))));
  box.classList.add("lost");
}

function turnTheme() {
  const dark = getComputedStyle(document.documentElement).colorScheme === "dark" || (document.documentElement.dataset.theme ?? "") === "" && matchMedia("(prefers-color-scheme: dark)").matches;
  setTheme(dark ? "light" : "dark");
}

function setTheme(theme) {
  document.documentElement.dataset.theme = theme;
  localStorage.setItem("weftex-theme", theme);
}

// -- keys and drops

function addKeys() {
  const names = Object.keys(SCREENS);
  document.addEventListener("keydown", (event) => {
    const typing = event.target.closest("input:not([type=range], [type=radio], [type=checkbox]), select, textarea");
    const command = event.ctrlKey || event.metaKey;
    const key = event.key.toLowerCase();
    if (command && key === "z" && !typing) run(event, event.shiftKey ? redoStep : undoStep);
    else if (command && key === "y" && !typing) run(event, redoStep);
    else if (command && key === "enter" && present === "paint") run(event, () => screens.paint.go());
    else if (command && key === "enter") run(event, () => (present === "make" ? screens.make.make() : go("make", { now: true })));
    else if (event.altKey && /^[1-6]$/.test(key)) run(event, () => go(names[key - 1]));
    else if (key === "escape" && app.job) run(event, () => app.stopWork());
    else if (key === "escape" && app.lookJob) run(event, () => app.looking.abort());
    else if (typing || command || event.altKey || event.defaultPrevented) return;
    else if (present === "paint" && "[]".includes(key)) run(event, () => screens.paint.painter?.keys(event));
    else if (stage.mainKeys(key)) event.preventDefault();
  });
}

function run(event, action) {
  event.preventDefault();
  action();
}

/** Open files that were dropped or pasted; materials that are being painted get them as further ones. */
function takeFiles(files) {
  const adds = present === "paint" && screens.paint.purpose === "fuse";
  app.guard(() => (adds ? screens.paint.addFiles(files) : app.openFiles(files)));
}

function addDrops() {
  document.body.dataset.drop = t("front.dropping");
  const carries = (event) => event.dataTransfer?.types.includes("Files");
  document.addEventListener("dragover", (event) => {
    if (!carries(event)) return;
    event.preventDefault();
    document.body.classList.add("dropping");
  });
  document.addEventListener("dragleave", (event) => event.relatedTarget ?? document.body.classList.remove("dropping"));
  document.addEventListener("drop", (event) => {
    if (!carries(event)) return;
    event.preventDefault();
    document.body.classList.remove("dropping");
    takeFiles([...event.dataTransfer.files]);
  });
  document.addEventListener("paste", (event) => {
    const files = [...(event.clipboardData?.files ?? [])];
    if (files.length) takeFiles(files);
  });
}

async function start() {
  if (remembered("theme")) setTheme(remembered("theme"));
  const begun = app.api.begin();
  begun.catch(() => {}); // asked again below, where what is wrong can be told
  await loadStrings(remembered("language"));
  document.querySelector(".skip").textContent = t("skip");
  app.api.onlost = tellLost;
  stage = new Stage(app, byId("stage"));
  screens = Object.fromEntries(Object.entries(SCREENS).map(([name, Screen]) => [name, new Screen(app, stage)]));
  buildBar();
  addKeys();
  addDrops();
  app.addEventListener("go", ({ detail }) => go(detail.screen, detail));
  app.addEventListener("presets", () => app.guard(() => showPresets(app)));
  app.addEventListener("fault", ({ detail }) => stage.say(detail.message));
  app.addEventListener("notice", ({ detail }) => stage.note(detail.text));
  await app.guard(() => app.begin(begun));
  if (!app.material && app.about) showFront();
  document.documentElement.dataset.ready = "true";
}

start();
