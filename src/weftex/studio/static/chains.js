import { sameJson } from "./shelf.js";
import { t } from "./strings.js";

/**
 * The steps that made a result, the first of them from the photo: [{label, recipe}, or {label, estimate, invert}].
 * Materials that are the photo, or the result of an earlier step, are the pictures "photo" and "step 1".
 */
export function chainOf(history, last) {
  const [steps, made] = [[], []]; // made: the material of each step, where one became of it
  let photo = null;
  const add = (step, material = null) => {
    steps.push(step);
    made.push(material);
  };
  const sourceOf = (spec) => {
    const entry = history.entries.find((one) => spec.maps && sameJson(one.sample?.maps, spec.maps));
    const estimate = history.entries.find((one) => one.estimated && sameJson(one.state.materials[0].maps, spec.maps));
    if (entry) addEntry(entry);
    else if (estimate) add({ label: estimate.label, estimate: named(estimate.estimated), invert: estimate.inverted }, spec);
    else return "photo";
    return `step ${steps.length}`;
  };
  const named = (spec) => {
    const { sample, maps, name, ...rest } = spec;
    const source = sourceOf(spec);
    if (source === "photo") photo = { sample, maps };
    return { ...rest, maps: { color: source } };
  };
  /** A further material: the photo again, an earlier step, or something else, which stays. */
  const other = (spec) => {
    const { sample, maps, name, ...rest } = spec;
    const number = made.findIndex((one) => one?.maps && sameJson(one.maps, maps));
    if (number < 0 && !sameJson(photo, { sample, maps })) return spec;
    return { ...rest, maps: { color: number < 0 ? "photo" : `step ${number + 1}` } };
  };
  const addEntry = ({ label, state, sample }) => {
    const [first, ...others] = state.materials;
    const recipe = { ...state, materials: [named(first), ...others.map(other)] };
    add({ label, recipe }, sample);
  };
  addEntry(last);
  return steps;
}

/** Why a step cannot be done on another photo, in words; null if it can. */
export function tiedBy({ recipe, estimate }) {
  const [first, ...others] = recipe?.materials ?? [estimate];
  const told = (key) => t(`tied.${key}`);
  if (first.straighten) return told("straighten");
  if (first.mask && first.mask !== "alpha") return told("use");
  if (!recipe) return null;
  if (recipe.mask && recipe.mask !== "alpha") return told("hole");
  if (recipe.guide) return told("guide");
  if (typeof recipe.map === "string") return told("map");
  if (recipe.parameters?.lattice) return told("lattice");
  return others.some((one) => Object.values(one.maps ?? {}).some((id) => ID.test(id))) ? told("material") : null;
}

const ID = /^[0-9a-f]{64}$/;

/** Do the steps of a chain on the present material; those before one that cannot be done stay. */
export async function replay(app, steps) {
  const photo = app.recipe.materials[0];
  const made = [];
  const material = async (spec) => {
    const source = /^step (\d+)$/.exec(spec.maps?.color ?? "");
    if (!source && spec.maps?.color !== "photo") return spec;
    const { maps, ...rest } = spec;
    return { ...(source ? await made[source[1] - 1]() : photo), ...rest };
  };
  app.tell("go", { screen: "make" });
  for (const [k, step] of steps.entries()) {
    const told = { n: k + 1, of: steps.length, label: step.label };
    const why = tiedBy(step);
    if (why) throw new Error(t("preset.stopped", { ...told, why }));
    try {
      if (step.estimate) {
        await app.take({ ...app.recipe, task: "synth", materials: [await material(step.estimate)] }, t("history.sample"));
        const spec = await app.estimate(step.invert);
        if (!spec) return; // it was stopped
        made.push(() => spec);
      } else {
        const materials = [];
        for (const one of step.recipe.materials) materials.push(await material(one));
        const result = await app.make({ ...step.recipe, materials }, step.label);
        if (!result) return; // it was cancelled
        made.push(() => app.asSample(result));
      }
    } catch (error) {
      if (!error.message || error.name === "AbortError") throw error;
      throw new Error(t("preset.failed", { ...told, why: error.message }));
    }
  }
}
