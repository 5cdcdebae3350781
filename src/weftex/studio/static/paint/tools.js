/**
 * Tools that paint a mask in a view: brush, eraser, lasso, similar colors. They take the pointer from the
 * view, follow pressure where a pen gives it, and draw the mask and the brush's ring over the picture.
 */
export class Painter {
  constructor(view, mask, { tool = "brush", radius = 12, tolerance = 24, label = 1, colors, textures = null }) {
    this.view = view;
    this.mask = mask;
    this.tool = tool;
    this.radius = radius;
    this.tolerance = tolerance;
    this.connected = true; // similar colors: only what hangs together
    this.label = label;
    this.colors = colors; // of the labels as they are shown, [red, green, blue, alpha]
    this.textures = textures; // pictures that stand for labels instead
    this.outline = null;
    this.ring = null;
    this.shown = new OffscreenCanvas(mask.width, mask.height);
    this.onstroke = () => {};
    this.onradius = () => {};
    this.layer = this.layer.bind(this);
    mask.onchange = (box, whole) => {
      this.update(box);
      if (whole) this.onstroke();
    };
    this.update();
    view.layers.push(this.layer);
    view.tools.push(this);
    view.keys = (event) => this.keys(event);
    view.onhover = (place, event) => {
      if (!place && this.byKeys) return;
      this.ring = place && event.pointerType !== "touch" ? place : null;
      view.draw();
    };
  }

  close() {
    const { view } = this;
    view.layers = view.layers.filter((one) => one !== this.layer);
    view.tools = view.tools.filter((one) => one !== this);
    view.keys = view.onhover = null;
    view.draw();
  }

  update(box = [0, 0, this.mask.width, this.mask.height]) {
    const context = this.shown.getContext("2d");
    if (this.textures) this.updateTextures(context, box);
    else context.putImageData(this.mask.pixels(this.colors, box), box[0], box[1]);
    this.view.draw();
  }

  /** Lay each label's picture, repeated, where the label is. */
  updateTextures(context, box) {
    const [left, top, right, bottom] = box;
    context.clearRect(left, top, right - left, bottom - top);
    this.textures.forEach((picture, label) => {
      const part = new OffscreenCanvas(right - left, bottom - top);
      const cut = part.getContext("2d");
      const only = this.textures.map((_, one) => (one === label ? [0, 0, 0, 255] : [0, 0, 0, 0]));
      cut.putImageData(this.mask.pixels(only, box), 0, 0);
      cut.globalCompositeOperation = "source-in";
      cut.fillStyle = cut.createPattern(picture, "repeat");
      cut.translate(-left, -top);
      cut.fillRect(left, top, right - left, bottom - top);
      context.drawImage(part, left, top);
    });
  }

  down(event, place) {
    if (this.tool === "wand") {
      this.takeSimilar(place);
      return true;
    }
    this.mask.begin();
    if (this.tool === "lasso") this.outline = [place];
    else this.last = place;
    this.move(event, place);
    return true;
  }

  move(event, place) {
    if (this.tool === "lasso") this.outline?.push(place);
    if (this.tool !== "brush" && this.tool !== "erase") return this.view.draw();
    // a fast pen gives several places for one event
    const all = event.getCoalescedEvents?.() ?? [];
    for (const one of all.length ? all : [event]) {
      const next = this.view.place(one);
      const pressed = one.pointerType === "pen" && one.pressure ? one.pressure : 1;
      this.mask.line(this.last, next, Math.max(0.5, this.radius * pressed), this.tool === "erase" ? 0 : this.label);
      this.last = next;
    }
  }

  up() {
    if (this.outline?.length > 2) this.mask.area(this.outline, this.label);
    this.outline = null;
    this.mask.end();
    this.view.draw();
  }

  cancel() {
    this.outline = null;
    this.mask.cancel();
  }

  /** The keys take the brush, in the middle of the view if no pointer has it. */
  hold() {
    this.byKeys = true;
    this.freed = false;
    this.ring ??= [this.view.camera.x, this.view.camera.y];
  }

  /** Paint by keys: arrows move the brush, Enter sets it down and lifts it; Escape gives the keys back. */
  keys(event) {
    const step = event.shiftKey ? 16 : 4;
    const ways = { ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, -step], ArrowDown: [0, step] };
    if (event.key in ways && !this.freed) {
      this.hold();
      const next = this.ring.map((one, k) => one + ways[event.key][k]);
      if (this.pressed) this.mask.line(this.ring, next, this.radius, this.tool === "erase" ? 0 : this.label);
      this.ring = next;
      this.view.draw();
      return true;
    }
    if (event.key === "[" || event.key === "]") {
      this.radius = Math.max(1, Math.min(160, Math.round(this.radius * (event.key === "]" ? 1.25 : 0.8))));
      this.onradius(this.radius);
      this.view.draw();
      return true;
    }
    if (event.key === "Enter") {
      this.hold();
      if (this.tool === "wand") {
        this.takeSimilar(this.ring);
      } else if (this.pressed) {
        this.pressed = false;
        this.mask.end();
      } else {
        this.pressed = true;
        this.mask.begin();
        this.mask.line(this.ring, this.ring, this.radius, this.tool === "erase" ? 0 : this.label);
      }
      return true;
    }
    if (event.key === "Escape" && this.byKeys) {
      if (this.pressed) this.mask.end();
      this.byKeys = this.pressed = false;
      this.freed = true; // arrows pan the view
      this.view.draw();
      return true;
    }
    return false;
  }

  /** What has nearly the color of a place. */
  takeSimilar([x, y]) {
    const { mask, view } = this;
    const [column, row] = [Math.floor(x), Math.floor(y)];
    if (column < 0 || row < 0 || column >= mask.width || row >= mask.height) return;
    const { data } = pixelsOf(view.picture, mask);
    const at = 4 * (row * mask.width + column);
    const most = this.tolerance ** 2 * 3;
    const alike = (index) => {
      let sum = 0;
      for (let k = 0; k < 3; k++) sum += (data[4 * index + k] - data[at + k]) ** 2;
      return sum <= most;
    };
    const reached = this.connected ? mask.connected(column, row, alike) : null;
    mask.begin();
    mask.where(reached ? (index) => reached[index] : alike, this.label);
    mask.end();
  }

  /** Every pixel brighter (or darker) than a threshold, 0 to 255. */
  takeBright(threshold, darker = false) {
    const { data } = pixelsOf(this.view.picture, this.mask);
    const light = (index) => 0.2126 * data[4 * index] + 0.7152 * data[4 * index + 1] + 0.0722 * data[4 * index + 2];
    this.mask.begin();
    this.mask.where((index) => (darker ? light(index) < threshold : light(index) > threshold), this.label);
    this.mask.end();
  }

  /** Every pixel that is clear by the picture's alpha. */
  takeClear() {
    const { data } = pixelsOf(this.view.picture, this.mask);
    this.mask.begin();
    this.mask.where((index) => data[4 * index + 3] < 128, this.label);
    this.mask.end();
  }

  layer(context, view) {
    const ratio = view.ratio;
    view.paintAt(this.shown, 0, 0, this.mask.width, this.mask.height);
    if (this.outline) {
      context.beginPath();
      this.outline.forEach((place, k) => context[k ? "lineTo" : "moveTo"](...view.onCanvas(...place)));
      context.closePath();
      twoLines(context, ratio);
    }
    if (this.ring && (this.tool === "brush" || this.tool === "erase" || this.byKeys)) {
      context.beginPath();
      context.arc(...view.onCanvas(...this.ring), Math.max(2, this.radius * view.camera.scale * ratio), 0, 7);
      twoLines(context, ratio);
    }
  }
}

/** A line that is seen on any picture. */
function twoLines(context, ratio) {
  context.lineWidth = 3 * ratio;
  context.strokeStyle = "rgb(0 0 0 / 60%)";
  context.stroke();
  context.lineWidth = 1.25 * ratio;
  context.strokeStyle = "#fff";
  context.stroke();
}

function pixelsOf(picture, { width, height }) {
  const context = new OffscreenCanvas(width, height).getContext("2d", { willReadFrequently: true });
  context.drawImage(picture, 0, 0, width, height);
  return context.getImageData(0, 0, width, height);
}
