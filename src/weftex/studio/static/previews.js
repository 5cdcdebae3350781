import { sameJson } from "./shelf.js";

const CROPS = new Set(["near-regular", "best-tile"]); // methods whose smaller pictures are parts of larger ones

/** How a preview is shown: as the part of the final picture that it is, where the method allows that. */
export function placed({ bitmap, size }, recipe, asked) {
  const whole = asked.size && !sameJson(recipe.size, asked.size);
  if (!whole || asked.tileable || !CROPS.has(recipe.method)) return { isPart: false };
  const canvas = new OffscreenCanvas(asked.size[1], asked.size[0]);
  canvas.getContext("2d").drawImage(bitmap, 0, 0, ...size);
  return { bitmap: canvas, size: [asked.size[1], asked.size[0]], isPart: true };
}

/** What the seconds of a recipe depend on, beside its size. */
export function paceOf({ task, method, parameters, materials }) {
  return JSON.stringify([task ?? "synth", method, parameters?.effort, materials]);
}
