import { chainOf, replay, tiedBy } from "../chains.js";
import { dialog, fill, h, icon, iconButton } from "../dom.js";
import { t } from "../strings.js";

/** The workflows: the steps of the present result can be saved as one, and each can be applied to the photo. */
export async function showPresets(app) {
  const body = h("div", { class: "parameters" });
  const error = h("p", { class: "note error", role: "alert", hidden: true });
  const { present } = app.history;
  const steps = present?.result ? chainOf(app.history, present) : [];
  const attempt = async (change) => {
    try {
      draw(await change());
      error.hidden = true;
    } catch (fault) {
      error.hidden = false;
      error.textContent = fault.message;
    }
  };
  const ask = (body) => attempt(() => app.api.post("presets", body));
  const draw = (presets) => {
    const name = h("input", { type: "text", maxlength: 60, value: suggested(steps), "aria-label": t("preset.name") });
    const rows = Object.entries(presets).map(([known, chain]) => {
      const input = h("input", { type: "text", maxlength: 60, value: known, "aria-label": t("preset.rename", { name: known }), onchange: () => ask({ name: known, to: input.value }) });
      const apply = h("button", { type: "button", "aria-label": t("preset.apply", { name: known }), title: listed(chain), onclick: () => box.close() ?? app.guard(() => replay(app, chain)) }, icon("repeat"), t("preset.apply_it"));
      return h("div", { class: "preset" }, input, apply, iconButton("trash", t("preset.remove", { name: known }), () => ask({ name: known })));
    });
    fill(
      body,
      h("p", { class: "hint" }, t("preset.lead")),
      error,
      steps.length
        ? [
            h("h3", {}, t("preset.steps")),
            h("ol", {}, steps.map((step) => h("li", {}, step.label, tiedBy(step) ? h("span", { class: "hint" }, ` · ${t("preset.tied", { why: tiedBy(step) })}`) : null))),
            h("div", { class: "preset" }, name, h("button", { type: "button", class: "main", onclick: () => ask({ name: name.value, steps }) }, t("preset.save"))),
          ]
        : null,
      h("h3", {}, t("preset.saved")),
      rows.length ? rows : h("p", { class: "hint" }, t("preset.none")),
      h("div", { class: "row" }, h("button", { type: "button", onclick: () => box.close() }, t("close"))),
    );
  };
  const box = dialog(t("preset.title"), body);
  await attempt(() => app.api.get("presets"));
}

function listed(chain) {
  return chain.map((step, k) => `${k + 1}. ${step.label}`).join("\n");
}

/** What the steps are called until somebody names them. */
function suggested(steps) {
  return steps.map((step) => step.label).join(", ").slice(0, 60);
}
