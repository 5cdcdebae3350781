import { fill, h, icon } from "../dom.js";
import { t } from "../strings.js";

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
  const element = h(
    "div",
    { class: "front" },
    h(
      "div",
      { class: "front-inner" },
      h("div", {}, h("h2", {}, t("front.title")), h("p", { class: "lead" }, t("front.lead"))),
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
      h("div", { class: "row" }, h("button", { type: "button", onclick: openState }, t("state.open")), keptButtons(app)),
    ),
  );
  app.addEventListener("fault", ({ detail }) => {
    error.hidden = false;
    fill(error, icon("warn"), h("div", {}, detail.message));
  });
  return element;
}

function keptButtons(app) {
  return app.kept.map((one) => h("button", { type: "button", onclick: () => app.guard(() => app.openRecipe(one.recipe, one.title)) }, icon("picture"), one.title));
}

/** A square part of a picture, once it is there. */
export async function drawThumb(app, canvas, path, options = {}) {
  try {
    const { bitmap } = await app.api.picture(path, { most: 320, ...options });
    drawSquare(canvas, bitmap);
  } catch {
    // a thumbnail that cannot be had leaves its button, which says why when pressed
  }
}

/** Draw the middle of a picture into a square canvas. */
export function drawSquare(canvas, picture) {
  const side = Math.min(picture.width, picture.height);
  const context = canvas.getContext("2d");
  context.imageSmoothingQuality = "high";
  context.clearRect(0, 0, canvas.width, canvas.height);
  context.drawImage(picture, (picture.width - side) / 2, (picture.height - side) / 2, side, side, 0, 0, canvas.width, canvas.height);
}
