import { h, icon } from "../dom.js";
import { t } from "../strings.js";

/** What people come for, and its icon. */
const TASKS = { bigger: "fit", tile: "repeat", remove: "erase", blend: "layers", maps: "maps" };

/** A button for each task; `chosen` is the present one. */
export function taskButtons(chosen, onchoose) {
  return h(
    "div",
    { class: "tasks", role: "group", "aria-label": t("make.task") },
    Object.entries(TASKS).map(([task, name]) =>
      h("button", { type: "button", "data-task": task, "aria-pressed": String(task === chosen), title: t(`do.${task}.help`), onclick: () => onchoose(task) }, icon(name), h("span", {}, t(`do.${task}`))),
    ),
  );
}

/** A button that makes the picture as the recipe stands. */
export function makeButton(app, kind = "main large") {
  return h("button", { type: "button", class: kind, onclick: () => app.tell("go", { screen: "make", now: true }) }, t("make.go"));
}

/** Go where a task is done. */
export function beginTask(app, task) {
  const { materials, seed } = app.recipe;
  app.wish = task;
  if (task === "remove" || task === "blend") return app.tell("go", { screen: "paint", purpose: task === "remove" ? "hole" : "fuse" });
  if (task === "tile") app.edit({ task, materials, axes: true, seed }, true);
  else if (app.recipe.task !== "synth") app.edit({ task: "synth", materials, size: app.usualSize(), tileable: false, seed, method: "auto", parameters: {} }, true);
  return app.tell("go", { screen: "make" });
}

/** The size nearest to [height, width] in which a lattice, or rows, repeat; null without either. */
export function fittingSize(vectors, size, tileable) {
  if (!vectors?.length || !tileable) return null;
  const found = [...size];
  const few = Math.min(...vectors.map((one) => Math.hypot(...one)));
  const most = Math.ceil((2 * Math.max(...size)) / few);
  for (const axis of [0, 1]) {
    // vectors are (x, y), sizes (height, width)
    if (tileable !== true && tileable !== "yx"[axis]) continue;
    let best = Infinity;
    for (let m = -most; m <= most; m++) {
      for (let n = vectors.length > 1 ? -most : 0; n <= (vectors.length > 1 ? most : 0); n++) {
        const [x, y] = [0, 1].map((k) => m * vectors[0][k] + n * (vectors[1]?.[k] ?? 0));
        const [length, aside] = axis === 0 ? [y, x] : [x, y];
        if (length < few / 2 || Math.abs(aside) > 0.05 * few) continue;
        if (Math.abs(length - size[axis]) < Math.abs(best - size[axis])) best = length;
      }
    }
    if (best < Infinity) found[axis] = Math.round(best);
  }
  return found.join() === size.join() ? null : found;
}
