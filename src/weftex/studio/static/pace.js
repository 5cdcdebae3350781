import { sameJson } from "./shelf.js";

/**
 * How far work is that does not say so, such as an analysis: by the seconds that a megapixel took before on this
 * machine. The share comes near to one and never reaches it.
 */
const USUAL = 8; // seconds a megapixel, before anything was measured
const LEAST = 0.4; // seconds

const keyOf = (kind) => `weftex-pace-${kind}`;

export function learn(kind, pixels, seconds) {
  localStorage.setItem(keyOf(kind), String(seconds / (pixels / 1e6)));
}

export function shareOf(kind, pixels, seconds) {
  const pace = Number(localStorage.getItem(keyOf(kind))) || USUAL;
  return 1 - Math.exp((-2 * seconds) / (LEAST + (pace * pixels) / 1e6));
}

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
