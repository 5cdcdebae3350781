import { Api, StudioError } from "./api.js";
import { drawSquare, h } from "./dom.js";
import { fromAddress, History, toAddress } from "./history.js";
import { paceOf, placed } from "./previews.js";
import { beginTask } from "./screens/tasks.js";
import { sameJson, Shelf } from "./shelf.js";
import { t } from "./strings.js";

const PICTURES_KEPT = 12; // steps whose pictures stay at hand
const PASSING = 1500; // milliseconds after which a preview that was not followed by another is stored
const THUMB = 96; // pixels
const SOON = 2; // seconds in which a preview may be the final picture itself

/**
 * What the person has: materials on the shelf, the recipe as it stands, the result that is seen, the steps
 * so far. Screens read it and call it; it tells them by events: "material", "recipe", "result", "job".
 */
export class App extends Shelf {
  constructor() {
    super();
    this.api = new Api();
    this.history = new History();
    this.about = null;
    this.recipe = null;
    this.result = null;
    this.preview = null; // {bitmap, size, recipe} of something smaller or unfinished
    this.job = null;
    this.stop = null;
    this.wish = null; // the task that was chosen before a photo
    this.pace = new Map(); // seconds a pixel, by method and effort
    this.goOn = false; // work goes on when the page is left
  }

  /** Begin with what the server answered already, if it did; a picture comes first. */
  async begin(begun) {
    const found = await begun.catch(() => this.api.begin());
    this.limits = found.limits;
    this.history.load(found.steps);
    window.addEventListener("pagehide", () => {
      if (this.history.present?.passing) this.save(this.history.present, { keepalive: true });
      this.api.post("leave", {}, { keepalive: true }).catch(() => {});
    });
    window.addEventListener("hashchange", () => this.openAddress(location.hash));
    await this.guard(() => this.first(found)); // what an address names may be gone
    await this.know();
  }

  /** What methods, samples and formats there are: all screens but the sample's need it. */
  async know() {
    this.about = await (this.asking ??= this.api.get("about"));
  }

  /** What the page begins with: work that went on, a shared state, or what the command was given. */
  async first(found) {
    if (found.resumed && (await this.resume())) return;
    const shared = fromAddress(location.hash);
    const step = shared ? this.history.entries.findLast((one) => sameJson(one.state, shared)) : found.opened ? null : this.history.entries.at(-1);
    if (step && (await this.guard(() => this.returnTo(step)))) return;
    if (await this.openAddress(location.hash)) return;
    if (found.opened) await this.open([found.opened]);
  }

  /** Take up work that went on while the page was away; false where there is none. */
  async resume() {
    const jobs = (await this.api.get("jobs")).filter((job) => job.keep && job.state !== "failed" && job.state !== "cancelled");
    const job = jobs.at(-1);
    const recipe = job?.recipe;
    const known = recipe && this.history.entries.findLast((one) => sameJson(one.state, recipe));
    if (!recipe || known?.result) return false; // nothing new
    if (known) await this.returnTo(known);
    else await this.take(recipe, t("history.made"));
    this.tell("go", { screen: "see" });
    const done = await this.watch(job, recipe, new AbortController(), {});
    const result = done?.results[0];
    if (result && !result.error) await this.step(result, t("history.made"));
    return true;
  }

  /** Show a step that the server stored, with the materials of all steps on the shelf. */
  async returnTo(step) {
    for (const { state } of this.history.entries) this.shelve(state.materials);
    this.history.go(step);
    await this.useMaterial(step.state.materials[0]);
    this.recipe = structuredClone(step.state);
    this.tell("go", { screen: step.result ? "make" : "sample" });
    await this.travel(step);
    return true;
  }

  /** Continue the work of another tab, or of another day. */
  async openWork(id) {
    const { steps } = await this.api.post(`works/${id}/open`);
    this.history.load(steps);
    await this.returnTo(this.history.get(steps.at(-1).id));
  }

  /** Follow a state in an address; false where there is none. */
  async openAddress(hash) {
    const recipe = fromAddress(hash);
    if (!recipe || sameJson(recipe, this.history.present?.state)) return false;
    await this.openRecipe(recipe, t("history.shared"), !/[#&]sample&/.test(hash));
    return true;
  }

  method(slug) {
    return this.about.methods.find((one) => one.slug === slug);
  }

  // -- materials

  /** Upload pictures: {materials, notes}, as sets of maps where their names say so. */
  async upload(files) {
    const uploads = [];
    for (const file of files) {
      const [size, most] = [file.size, this.limits.upload_bytes].map((bytes) => Math.ceil(bytes / 1e6));
      if (file.size > this.limits.upload_bytes) throw new StudioError(t("sample.large", { name: file.name, size, most }));
      this.tell("notice", { text: t("sample.uploading", { name: file.name }) });
      uploads.push((await this.api.upload(file)).id);
    }
    return this.api.post("sets", { uploads });
  }

  async openFiles(files) {
    const { materials, notes } = await this.upload(files);
    await this.open(materials, notes);
  }

  async open(specs, notes = []) {
    this.shelve(specs);
    this.notes = notes;
    await this.choose(specs[0]);
    if (this.wish) beginTask(this, this.wish);
    else this.tell("go", { screen: "sample" });
  }

  /** Begin anew with a material of the shelf. */
  async choose(spec) {
    const size = null;
    await this.take({ task: "synth", materials: [spec], size, tileable: false, seed: 1, method: "auto", parameters: {} }, t("history.sample"));
  }

  /** Make a recipe the present one, with what is seen of it so far. */
  async take(recipe, label, origin = {}) {
    await this.useMaterial(recipe.materials[0]);
    recipe = { ...recipe, size: recipe.size ?? (recipe.task === "synth" ? this.usualSize() : undefined) };
    this.history.push(recipe, label, this.material.name);
    this.save(Object.assign(this.history.present, origin));
    this.see(this.history.present);
  }

  /** A recipe from elsewhere: its picture is made again. */
  async openRecipe(recipe, label, make = true) {
    this.shelve(recipe.materials);
    await this.take(recipe, make ? label : t("history.sample"));
    this.tell("go", { screen: make ? "see" : "sample" });
    if (make) await this.make(recipe, label);
  }

  /** The material that a result is; the server stores it as a sample when it is first asked for. */
  async asSample(result) {
    const entry = this.history.entries.find((one) => one.result === result);
    if (!entry.sample) {
      entry.sample = await this.ask(result, (id) => this.api.post(`results/${id}/sample`));
      this.save(entry);
    }
    return entry.sample;
  }

  async useAsSample(result) {
    this.wish = null;
    await this.open([await this.asSample(result)]);
  }

  /** Begin from the sample with estimates of the maps that it lacks, by its brightness. */
  async estimate(inverted) {
    const estimated = this.recipe.materials[0];
    const job = await this.run({ invert: inverted }, { path: `materials/${this.material.id}/estimates` });
    if (!job) return null;
    const [spec] = job.results;
    await this.mend({ ...Object.fromEntries(Object.keys(estimated).map((key) => [key, null])), ...spec }, t("history.estimated"), { estimated, inverted });
    return spec;
  }

  /** Change the sample itself: straighten it, even its light, mask it. `origin` says what it was made from. */
  async mend(changes, label, origin = {}) {
    const spec = { ...this.recipe.materials[0], ...changes };
    for (const key of Object.keys(spec)) if (spec[key] === null) delete spec[key];
    this.shelf = this.shelf.map((one) => (sameJson(one, this.recipe.materials[0]) ? spec : one));
    await this.take({ ...this.recipe, materials: [spec, ...this.recipe.materials.slice(1)] }, label, origin);
  }

  // -- steps

  see(entry, passing = false) {
    this.recipe = structuredClone(entry.state);
    this.result = entry.result;
    this.preview = null;
    history.replaceState(null, "", toAddress(entry.state, Boolean(entry.result)));
    this.tell("recipe");
    this.tell("result", { passing });
  }

  async travel(entry) {
    if (!entry) return;
    this.cancel();
    await this.useMaterial(entry.state.materials[0]);
    if (entry.result && !entry.result.bitmap) Object.assign(entry.result, await this.pictureOf(entry.result));
    if (this.history.present === entry) this.see(entry);
  }

  undo() {
    return this.travel(this.history.go(this.history.before));
  }

  redo() {
    return this.travel(this.history.go(this.history.after));
  }

  /** Have the server store a step, with a thumbnail. */
  save(entry, options = {}) {
    entry.saved = true;
    entry.thumb ??= thumbOf(entry.result?.bitmap ?? this.material.bitmap);
    const { id, parent, label, title, state, thumb, result, sample, estimated, inverted } = entry;
    return this.api.post("steps", { id, parent, label, title, recipe: state, thumb, result: result?.id, sample, estimated, inverted }, options).catch((error) => error.message && this.tell("fault", error));
  }

  /** Change the recipe without a step; `make` or a preview comes after. */
  edit(changes, whole = false) {
    this.recipe = whole ? changes : { ...this.recipe, ...changes };
    this.tell("recipe");
  }

  // -- work

  cancel() {
    this.stop?.abort();
    this.stop = null;
    this.job = null;
    this.tell("job");
  }

  /** Cancel what is running, and show what was there before it. */
  stopWork() {
    this.cancel();
    if (this.preview?.grows) this.showPreview(null);
  }

  /** Run a job and show how it goes; resolves to the job, or to null if it was cancelled. */
  async run(body, { path = "jobs", quiet = false, onresults = () => {} } = {}) {
    this.cancel();
    const control = new AbortController();
    const within = quiet ? "?within=250" : ""; // what is quick is told at once
    const posted = this.api.post(`${path}${within}`, body, { signal: control.signal });
    const many = body.each?.length ?? 1; // pictures
    return this.watch(posted, many === 1 ? body.recipe : null, control, { quiet, many, onresults });
  }

  async watch(posted, recipe, control, { quiet = false, many = 1, onresults = () => {} }) {
    this.stop = control;
    let seen = 0;
    try {
      return await this.api.follow(
        await posted,
        (job) => {
          this.job = { ...job, quiet, many, heard: performance.now() };
          this.tell("job");
          if (job.results.length) onresults(job);
          if (recipe && job.preview && job.preview !== seen && job.state === "running") {
            seen = job.preview;
            this.grow(job, recipe, control.signal);
          }
        },
        control.signal,
      );
    } catch (error) {
      if (error.name === "AbortError") return null;
      throw error;
    } finally {
      if (this.stop === control) {
        this.stop = null;
        this.job = null;
        this.tell("job");
      }
    }
  }

  /** Show the picture of a job as it stands. */
  async grow(job, recipe, signal) {
    if (job.results.length > 0 || this.growing) return;
    this.growing = true;
    try {
      const { bitmap, size } = await this.api.picture(`jobs/${job.id}/preview`, {}, signal);
      if (!signal.aborted && this.job?.id === job.id) this.showPreview({ bitmap, size: recipe.size?.toReversed() ?? size, recipe, grows: true });
    } catch {
      // a preview that has gone is no fault: the picture itself comes
    } finally {
      this.growing = false;
    }
  }

  showPreview(preview) {
    this.preview = preview;
    this.tell("preview");
  }

  /** Make the picture of a recipe, and a step of it. */
  async make(recipe, label) {
    const begun = this.recipe;
    const job = await this.run({ recipe, keep: this.goOn });
    if (!job) return null;
    const [result] = job.results;
    if (result.error) throw new StudioError(result.error, { parameter: result.parameter });
    const changed = this.recipe === begun ? null : this.recipe;
    const step = await this.step(result, label);
    if (changed) this.edit(changed); // what was written while it was made stays written
    return step;
  }

  async pictureOf(result) {
    return this.ask(result, (id) => this.api.picture(`results/${id}/picture`, { map: result.main, most: 4096 }));
  }

  /** Ask about a result; one that the server has forgotten is made again, to the same bytes. */
  async ask(result, question) {
    try {
      return await question(result.id);
    } catch (error) {
      if (error.status !== 410) throw error;
    }
    const job = await this.run({ recipe: result.recipe });
    if (!job) throw new DOMException("cancelled", "AbortError");
    result.id = job.results[0].id;
    return question(result.id);
  }

  /**
   * Make a result the present step. A step of the same recipe gets its picture; one that is `passing`, such as
   * a place of a slider, gives way to the next, unless something was made from it.
   */
  async step(result, label, passing = false) {
    const begun = this.history.present;
    const had = begun?.result;
    const whole = { ...result, ...(await this.pictureOf(result)) };
    this.pace.set(paceOf(result.recipe), result.seconds / (result.width * result.height));
    // something was changed or made meanwhile
    if (passing && (this.history.present !== begun || begun?.result !== had || !sameJson(result.recipe, this.recipe))) return null;
    if (!passing) await this.useMaterial(result.recipe.materials[0]);
    const { history } = this;
    const present = history.present;
    const title = this.material.name;
    if (present && present.label !== t("history.sample") && sameJson(present.state, result.recipe)) history.complete({ label, result: whole, thumb: null });
    else if (present?.passing && !present.sample && !history.children(present).length) history.complete({ state: structuredClone(result.recipe), label, title, result: whole, thumb: null, saved: false, sample: null });
    else history.push(result.recipe, label, title, whole);
    const step = history.present;
    step.passing = passing;
    if (!passing) this.save(step);
    else setTimeout(() => step.result === whole && step.passing && this.save(step), PASSING);
    for (const one of history.entries.slice(0, -PICTURES_KEPT)) {
      if (one === step || !one.result) continue;
      one.result.bitmap?.close();
      for (const key of ["bitmap", "pictures", "overlays"]) delete one.result[key];
    }
    this.see(this.history.present, passing);
    return whole;
  }

  /** A quick look at what the recipe would make; it is no step. */
  async tryOut() {
    const [asked, entry] = [this.recipe, this.history.present];
    const recipe = this.smaller(asked);
    const job = await this.run({ recipe, lane: "preview" }, { quiet: true });
    const result = job?.results[0];
    if (!result) return null;
    if (result.error) throw new StudioError(result.error, { parameter: result.parameter });
    if (this.history.present !== entry) return result; // undone meanwhile
    const still = this.recipe === asked; // else another try follows
    if (still && sameJson(recipe, asked)) return this.step(result, t("history.changed"), true);
    const picture = await this.pictureOf(result);
    if (this.history.present === entry && (this.recipe === asked || !still)) this.showPreview({ ...picture, ...placed(picture, recipe, asked), recipe, result });
    return result;
  }

  /** The recipe itself, if earlier runs say that it is quick; else the same at a size that is quick. */
  smaller(recipe) {
    if (recipe.task !== "synth" || recipe.guide || Math.min(...recipe.size) < 1) return recipe;
    const pace = this.pace.get(paceOf(recipe));
    if (pace * recipe.size[0] * recipe.size[1] < SOON) return recipe;
    const most = this.method(recipe.method).fast ? 512 : 192; // the others go pixel by pixel
    const shrink = Math.min(1, most / Math.max(...recipe.size));
    const parameters = recipe.method === "auto" ? {} : recipe.parameters;
    return { ...recipe, parameters, size: recipe.size.map((side) => Math.max(1, Math.round(side * shrink))) };
  }
}

/** A small square of a picture, as the server stores it. */
function thumbOf(picture) {
  const canvas = h("canvas", { width: THUMB, height: THUMB });
  drawSquare(canvas, picture);
  return canvas.toDataURL("image/webp", 0.8);
}
