/** Elements without a framework: `h("button", {onclick, class: "main"}, "Make")`. */

const SVG = "http://www.w3.org/2000/svg";

/** Make an element. Functions are listeners, booleans are attributes that are there or not. */
export function h(tag, props = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(props)) set(element, name, value);
  element.append(...children.flat(Infinity).filter((child) => child !== null && child !== undefined && child !== false));
  return element;
}

/** Set an attribute, a listener ("onclick"), or a property of the style (`style: {width}`). */
export function set(element, name, value) {
  if (name.startsWith("on") && typeof value === "function") {
    element.addEventListener(name.slice(2), value);
  } else if (name === "style") {
    for (const [key, one] of Object.entries(value)) element.style.setProperty(key, one);
  } else if (name === "value" || name === "checked" || name === "disabled" || name === "hidden") {
    element[name] = value;
  } else if (value === true) {
    element.setAttribute(name, "");
  } else if (value !== false && value !== null && value !== undefined) {
    element.setAttribute(name, String(value));
  }
}

/** Replace what an element holds; the focus stays on the control that says the same. */
export function fill(element, ...children) {
  const held = element.contains(document.activeElement) && element !== document.activeElement ? sign(document.activeElement) : null;
  element.replaceChildren(...children.flat(Infinity).filter((child) => child !== null && child !== undefined && child !== false));
  if (held) [...element.querySelectorAll("button, input, select, summary, [tabindex]")].find((one) => sign(one) === held)?.focus({ preventScroll: true });
  return element;
}

/** Do something once nothing is `busy` and no button is pressed: one that is drawn anew before its release gets no click. */
export function unpressed(action, busy = () => false) {
  if (busy() || document.querySelector(":is(button, label, summary):active")) setTimeout(() => unpressed(action, busy), 50);
  else action();
}

/** What tells a control from its neighbors. */
function sign(one) {
  return [one.tagName, one.type, one.ariaLabel ?? one.labels?.[0]?.textContent ?? one.textContent].join();
}

/** A path of each icon, drawn on 16 x 16. */
const ICONS = {
  undo: "M6 3 2.5 6.5 6 10M3 6.5h6.5a3.5 3.5 0 0 1 0 7H6",
  redo: "m10 3 3.5 3.5L10 10m3-3.5H6.5a3.5 3.5 0 0 0 0 7H10",
  plus: "M8 3v10M3 8h10",
  minus: "M3 8h10",
  fit: "M2.5 6V2.5H6M10 2.5h3.5V6M13.5 10v3.5H10M6 13.5H2.5V10",
  close: "m4 4 8 8m0-8-8 8",
  dice: "M2 4.5h2.5l6 7H14M2 11.5h2.5l1.7-2M9 6.5l1.5-2H14M12 2.5l2 2-2 2M12 9.5l2 2-2 2",
  open: "M8 10.5V2.5M5 5.5l3-3 3 3M2.5 10v3.5h11V10",
  take: "M8 2.5v8M5 7.5l3 3 3-3M2.5 10v3.5h11V10",
  copy: "M5.5 5.5h8v8h-8zM10.5 5.5v-3h-8v8h3",
  theme: "M8 2.5a5.5 5.5 0 1 0 0 11zM8 2.5a5.5 5.5 0 0 1 0 11",
  keys: "M1.5 4h13v8h-13zM4 6.5h.01M6.7 6.5h.01M9.3 6.5h.01M12 6.5h.01M5 9.5h6",
  more: "M3.5 8h.01M8 8h.01M12.5 8h.01",
  check: "m3 8.5 3.5 3.5L13 4.5",
  warn: "M8 2.5 14.5 13.5h-13zM8 7v3M8 11.7h.01",
  brush: "M13.5 2.5 7 9M6.5 8.5c-2 0-3 1-3 2.5 0 1-.5 2-1.5 2.5 2.5.5 6.5 0 6.5-3z",
  erase: "m6 13.5-3.5-3.5L9 3.5 13.5 8 8 13.5zM5.5 7l4.5 4.5M8 13.5h5.5",
  lasso: "M8 2.5c3.5 0 6 1.6 6 3.8S11.5 10 8 10 2 8.5 2 6.3 4.5 2.5 8 2.5M4.5 9.3c-1.5 1 0 2 0 4.2",
  wand: "m2.5 13.5 7-7M11.5 1.5v3M10 3h3M13 6.5v2M12 7.5h2M7 2.5v1M6.5 3h1",
  alpha: "M3 3h10v10H3zM3 8h10M8 3v10",
  hand: "M5 8V4a1 1 0 0 1 2 0v3-4a1 1 0 0 1 2 0v4-3a1 1 0 0 1 2 0v5c0 3-1.5 5-4 5s-3-1.5-5-5c-.4-1 1-1.5 1.6-.5z",
  eye: "M1.5 8s2.5-4.5 6.5-4.5S14.5 8 14.5 8s-2.5 4.5-6.5 4.5S1.5 8 1.5 8M8 6.2a1.8 1.8 0 1 0 0 3.6 1.8 1.8 0 0 0 0-3.6",
  grid: "M2.5 2.5h11v11h-11zM2.5 6.2h11M2.5 9.8h11M6.2 2.5v11M9.8 2.5v11",
  light: "M8 5.2a2.8 2.8 0 1 0 0 5.6 2.8 2.8 0 0 0 0-5.6M8 1.5v1.3M8 13.2v1.3M1.5 8h1.3M13.2 8h1.3M3.4 3.4l.9.9M11.7 11.7l.9.9M3.4 12.6l.9-.9M11.7 4.3l.9-.9",
  solid: "M8 1.8 14 5v6l-6 3.2L2 11V5zM2 5l6 3.2L14 5M8 8.2v6",
  plane: "M1.5 10.5 5 5.5h6l3.5 5zM3 8.2h10M8 5.5v5",
  split: "M8 1.5v13M2.5 4h3.5v8H2.5M13.5 4H10M13.5 12H10M13.5 4v8",
  maps: "M2.5 2.5h4.7v4.7H2.5zM8.8 2.5h4.7v4.7H8.8zM2.5 8.8h4.7v4.7H2.5zM8.8 8.8h4.7v4.7H8.8z",
  picture: "M2.5 3h11v10h-11zM2.5 11l3.5-3.5 3 3 2-2 2.5 2.5M10.5 6h.01",
  layers: "m8 2.5 6 3-6 3-6-3zM2 8.5l6 3 6-3M2 11.2l6 3 6-3",
  repeat: "M2.5 2.5h5v5h-5zM8.5 2.5h5v5h-5zM2.5 8.5h5v5h-5zM8.5 8.5h5v5h-5z",
  branch: "M4 2.5v6.5a2 2 0 0 0 2 2h6M9.5 8l3 3-3 3",
  trash: "M3 4.5h10M6.5 4.5v-2h3v2M4.5 4.5l.7 9h5.6l.7-9M6.8 7v4M9.2 7v4",
  lock: "M4 7.5h8v6H4zM5.7 7.5V5a2.3 2.3 0 0 1 4.6 0v2.5",
};

/** An icon; it says nothing to a screen reader, so the button needs a label. */
export function icon(name) {
  const svg = document.createElementNS(SVG, "svg");
  const path = document.createElementNS(SVG, "path");
  svg.setAttribute("viewBox", "0 0 16 16");
  svg.setAttribute("class", "icon");
  svg.setAttribute("aria-hidden", "true");
  path.setAttribute("d", ICONS[name]);
  svg.append(path);
  return svg;
}

/** A button with an icon alone; its label is spoken and shown on hover. */
export function iconButton(name, label, onclick, props = {}) {
  return h("button", { class: "icon-button", type: "button", "aria-label": label, title: label, onclick, ...props }, icon(name));
}

/** What went wrong, in one line. */
export function fault(message) {
  return h("div", { class: "note error", role: "alert" }, icon("warn"), h("div", {}, message));
}

let made = 0;

/** A label above a control, and below it one line of help if there is one. */
export function field(label, control, { help = "", value = null } = {}) {
  const id = control.id || `f${++made}`;
  control.id = id;
  const hint = help ? h("p", { class: "hint", id: `${id}-hint` }, help) : null;
  if (hint) control.setAttribute("aria-describedby", hint.id);
  return h("div", { class: "field" }, h("div", { class: "field-head" }, h("label", { for: id }, label), value), control, hint);
}

/** One of a few: radio buttons in a row. */
export function segments(label, options, value, onchange) {
  const name = `s${++made}`;
  return h(
    "fieldset",
    { class: "segments" },
    h("legend", {}, label),
    h(
      "div",
      { class: "segment-row" },
      options.map(([key, text]) =>
        h("label", {}, h("input", { type: "radio", name, value: key, checked: key === value, onchange: () => onchange(key) }), h("span", {}, text)),
      ),
    ),
  );
}

/** A box to tick. */
export function tick(label, checked, onchange, props = {}) {
  const box = h("input", { type: "checkbox", checked, onchange: () => onchange(box.checked), ...props });
  return h("label", { class: "tick" }, box, h("span", {}, label));
}

/** Open a dialog; it is removed when it is closed. */
export function dialog(title, ...content) {
  const box = h("dialog", { "aria-label": title }, h("h2", {}, title), content);
  box.addEventListener("close", () => box.remove());
  document.body.append(box);
  box.showModal();
  return box;
}

/** Draw the middle of a picture into a square canvas. */
export function drawSquare(canvas, picture) {
  const side = Math.min(picture.width, picture.height);
  const context = canvas.getContext("2d");
  context.imageSmoothingQuality = "high";
  context.clearRect(0, 0, canvas.width, canvas.height);
  context.drawImage(picture, (picture.width - side) / 2, (picture.height - side) / 2, side, side, 0, 0, canvas.width, canvas.height);
}

/** Draw a thumbnail that is text ("data:image/webp;base64,…"). */
export async function drawText(canvas, text) {
  const [kind, data] = text.slice(5).split(";base64,");
  const bytes = Uint8Array.from(atob(data), (one) => one.charCodeAt(0));
  drawSquare(canvas, await createImageBitmap(new Blob([bytes], { type: kind })));
}

/** Save a Blob as a file of this name. */
export function download(file, name) {
  const link = h("a", { href: URL.createObjectURL(file), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}
