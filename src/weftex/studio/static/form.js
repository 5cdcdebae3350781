import { field, h, iconButton } from "./dom.js";
import { number, said, t } from "./strings.js";

/**
 * Controls for parameters as the server describes them: {name, type, low, high, unit, choices, default,
 * default_text, help, count, parity}. What is not set is not sent; the method then decides.
 */
/** The parameters of a method that artists know by other words, with a range around what is `usual`, by names; no size is above `largest`. */
export function controls(parameters, values, largest, usualValues = {}) {
  return parameters
    .filter(({ control, needs }) => control && (!needs || needs[1].includes(values[needs[0]] ?? parameters.find((one) => one.name === needs[0]).default)))
    .map((one) => {
      const usual = one.default ?? usualValues[one.name];
      const most = Math.min(one.high ?? Infinity, one.control === "size" ? largest : Infinity, usual ? usual * 8 : 64);
      const range = { low: usual ? Math.max(one.low ?? 0, usual / 8) : one.low, high: Math.max(most, usual ?? 0) };
      return { ...one, ...range, usual, label: t(`control.${one.control}`), title: `${one.name}: ${said(one.help)}`, help: t(`control.${one.control}.help`) };
    });
}

export function parameterForm(parameters, values, onchange, error = null) {
  return h("div", { class: "parameters" }, parameters.map((one) => control(one, values, onchange, error)));
}

function control(parameter, values, onchange, error) {
  const { name } = parameter;
  const set = (value) => {
    if (value === null || value === "") delete values[name];
    else values[name] = value;
    row.classList.toggle("set", name in values);
    reset.hidden = !(name in values);
    onchange(name, values[name]);
  };
  const reset = iconButton("undo", t("form.reset", { name: title(parameter) }), () => {
    set(null);
    row.replaceWith(control(parameter, values, onchange, null));
  });
  reset.hidden = !(name in values);
  const kind = parameter.choices?.length ? choice : parameter.type === "bool" ? flag : isNumber(parameter) ? slider : text;
  const row = field(title(parameter), kind(parameter, values[name], set), { help: said(parameter.help), value: reset });
  if (parameter.title) row.title = parameter.title;
  row.classList.add("parameter");
  if (error?.parameter === name) row.append(h("p", { class: "note error", role: "alert" }, error.message));
  row.classList.toggle("set", name in values);
  return row;
}

/** "patch_size" as "Patch size". */
export function title({ name, label }) {
  if (label) return label;
  const words = name.replaceAll("_", " ").replaceAll("-", " ");
  return words[0].toUpperCase() + words.slice(1);
}

const isNumber = ({ type, count }) => (type === "int" || type === "float") && !(count > 1);

function choice(parameter, value, set) {
  const automatic = parameter.default === null ? [["", parameter.default_text || t("form.auto")]] : [];
  const select = h(
    "select",
    { onchange: () => set(select.value) },
    [...automatic, ...parameter.choices.map((one) => [one, one])].map(([key, label]) => h("option", { value: key }, label)),
  );
  select.value = value ?? parameter.default ?? "";
  return select;
}

function flag(parameter, value, set) {
  const box = h("input", { type: "checkbox", class: "switch", checked: value ?? parameter.default ?? false, onchange: () => set(box.checked) });
  return box;
}

function text(parameter, value, set) {
  const shown = Array.isArray(value) ? value.join(", ") : (value ?? "");
  const box = h("input", { type: "text", value: shown, placeholder: placeholder(parameter), onchange: () => set(box.value.trim()) });
  return box;
}

/** A number with a slider below, which is logarithmic where the range is wide. */
function slider(parameter, value, set) {
  const { low, high, unit, type } = parameter;
  const start = value ?? parameter.default ?? parameter.usual;
  const box = h("input", {
    type: "number",
    value: value ?? "",
    placeholder: placeholder(parameter),
    min: low,
    max: high,
    step: type === "int" ? (parameter.parity ? 2 : 1) : "any",
    inputmode: type === "int" ? "numeric" : "decimal",
  });
  const from = low ?? 0;
  const to = high !== null && high !== undefined && high <= 1e6 ? high : Math.max(8 * (start || 16), from + 64);
  const wide = parameter.usual > 0 || to / Math.max(from, type === "int" ? 1 : to / 1e3) > 60;
  const least = Math.max(from, type === "int" ? 1 : to / 1e3);
  const toShare = (number) =>
    wide ? (number < least ? 0 : Math.log(number / least) / Math.log(to / least)) : (number - from) / (to - from);
  const fromShare = (share) => tidy(wide ? (share === 0 ? from : least * (to / least) ** share) : from + share * (to - from), parameter);
  const range = h("input", { type: "range", min: 0, max: 1, step: 0.001, value: start === null || start === undefined ? 0 : toShare(start), "aria-label": title(parameter) });
  range.classList.toggle("unset", value === undefined);
  range.addEventListener("input", () => {
    box.value = fromShare(Number(range.value));
    range.classList.remove("unset");
    set(Number(box.value));
  });
  range.addEventListener("keydown", (event) => event.stopPropagation());
  box.addEventListener("change", () => {
    range.classList.toggle("unset", box.value === "");
    if (box.value !== "") range.value = toShare(Number(box.value));
    set(box.value === "" ? null : Number(box.value));
  });
  const group = h("div", { class: "number" }, range, h("span", { class: "with-unit" }, box, unit ? h("span", { class: "unit" }, unit) : null));
  // the label belongs to the box, which has the value
  Object.defineProperty(group, "id", { get: () => box.id, set: (id) => (box.id = id) });
  return group;
}

function tidy(value, { type, parity }) {
  if (type === "int") {
    const whole = Math.round(value);
    if (!parity || whole === 0) return whole;
    return whole % 2 === (parity === "odd" ? 1 : 0) ? whole : whole + 1;
  }
  return Number(value.toPrecision(3));
}

function placeholder({ default: value, default_text: words, count }) {
  if (value !== null && value !== undefined) return typeof value === "number" ? number(value, 4) : String(value);
  return words ? t("form.auto") : count > 1 ? t("form.numbers", { n: count }) : t("form.auto");
}
