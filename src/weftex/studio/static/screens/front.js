import { drawSquare, drawText, fill, h, icon, iconButton } from "../dom.js";
import { number, t } from "../strings.js";
import { taskButtons } from "./tasks.js";

/** The first page: drop a picture, choose files, or take one of the samples. */
export function front(app, openState) {
  const files = h("input", { type: "file", multiple: true, accept: "image/*,.exr,.tif,.tiff", hidden: true, onchange: () => files.files.length && app.guard(() => app.openFiles([...files.files])) });
  const error = h("div", { class: "note error", role: "alert", hidden: true });
  const tiles = h("div", { class: "samples" });
  for (const sample of app.about.samples) {
    const canvas = h("canvas", { width: 320, height: 320 });
    tiles.append(
      h(
        "button",
        { type: "button", onclick: () => app.guard(() => app.open([{ sample: sample.name }])) },
        canvas,
        h("span", {}, sample.title, h("span", { class: "hint" }, sample.maps > 1 ? t("front.maps", { n: sample.maps }) : `${sample.width} × ${sample.height}`)),
      ),
    );
    drawThumb(app, canvas, `samples/${sample.name}/picture`);
  }
  const tasks = h("div", {});
  const choose = (task) => {
    app.wish = app.wish === task ? null : task;
    fill(tasks, taskButtons(app.wish, choose));
  };
  app.wish = null;
  fill(tasks, taskButtons(null, choose));
  const works = h("div", { class: "recent" });
  recent(app, works);
  const element = h(
    "div",
    { class: "front" },
    h(
      "div",
      { class: "front-inner" },
      h("div", {}, h("h2", {}, t("front.title")), h("p", { class: "lead" }, t("front.lead"))),
      tasks,
      h(
        "div",
        { class: "drop" },
        h("button", { class: "main large", type: "button", onclick: () => files.click() }, icon("open"), t("front.choose")),
        h("p", { class: "hint" }, t("front.drop")),
        files,
      ),
      error,
      h("h3", {}, t("front.samples")),
      tiles,
      works,
      h("div", { class: "row" }, h("button", { type: "button", onclick: openState }, t("state.open"))),
    ),
  );
  app.addEventListener("fault", ({ detail }) => {
    error.hidden = false;
    fill(error, icon("warn"), h("div", {}, detail.message));
  });
  return element;
}

/** Work of other tabs and days: continue it, or remove it from the disk. */
async function recent(app, box) {
  const found = await app.guard(() => app.api.get("works"));
  if (!found?.works.length) return fill(box);
  const megabytes = (bytes) => number(bytes / 1e6, bytes < 1e7 ? 1 : 0);
  const remove = async (id) => {
    await app.guard(() => app.api.remove(`works/${id}`));
    await recent(app, box);
  };
  const cards = found.works.map((work) => {
    const canvas = h("canvas", { width: 96, height: 96 });
    if (work.thumb) drawText(canvas, work.thumb);
    const day = work.time ? new Date(1000 * work.time).toLocaleString(document.documentElement.lang, { dateStyle: "medium", timeStyle: "short" }) : "";
    return h(
      "div",
      { class: "work" },
      h("button", { type: "button", onclick: () => app.guard(() => app.openWork(work.id)) }, canvas, h("span", {}, work.title, h("span", { class: "hint" }, t("works.steps", { n: work.steps })), h("span", { class: "hint" }, day))),
      iconButton("trash", t("works.remove", { name: work.title }), () => remove(work.id)),
    );
  });
  fill(
    box,
    h("h3", {}, t("works.title")),
    h("div", { class: "works" }, cards),
    h("p", { class: "hint" }, t("works.room", { used: megabytes(found.bytes), most: megabytes(found.most) })),
  );
}

/** A square part of a picture, once it is there. */
async function drawThumb(app, canvas, path, options = {}) {
  try {
    const { bitmap } = await app.api.picture(path, { most: 320, ...options });
    drawSquare(canvas, bitmap);
  } catch {
    // a thumbnail that cannot be had leaves its button, which says why when pressed
  }
}
