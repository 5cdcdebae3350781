/**
 * A painted picture of labels: one byte a pixel, 0 for nothing, or for the first of several materials.
 * Edges are hard: a pixel is in a stroke if its middle is. Every stroke can be taken back.
 */
export class Mask {
  static STROKES_KEPT = 60;

  constructor(width, height) {
    this.width = width;
    this.height = height;
    this.labels = new Uint8Array(width * height);
    this.done = []; // strokes: {x, y, width, height, before, after}
    this.undone = [];
    this.stroke = null;
    this.onchange = () => {};
  }

  /** Begin a stroke; everything until `end` is taken back as one. */
  begin() {
    this.stroke = { before: this.labels.slice(), box: null };
  }

  end() {
    const { before, box } = this.stroke ?? {};
    this.stroke = null;
    if (!box) return;
    const [x, y, right, bottom] = box;
    const part = { x, y, width: right - x, height: bottom - y };
    this.done.push({ ...part, before: cut(before, this.width, part), after: cut(this.labels, this.width, part) });
    if (this.done.length > Mask.STROKES_KEPT) this.done.shift();
    this.undone = [];
    this.onchange(box, true);
  }

  cancel() {
    if (!this.stroke) return;
    this.labels.set(this.stroke.before);
    this.stroke = null;
    this.onchange([0, 0, this.width, this.height], true);
  }

  undo() {
    return this.restore(this.done, this.undone, "before");
  }

  redo() {
    return this.restore(this.undone, this.done, "after");
  }

  restore(from, to, which) {
    const stroke = from.pop();
    if (!stroke) return false;
    to.push(stroke);
    for (let row = 0; row < stroke.height; row++) {
      const line = stroke[which].subarray(row * stroke.width, (row + 1) * stroke.width);
      this.labels.set(line, (stroke.y + row) * this.width + stroke.x);
    }
    this.onchange([stroke.x, stroke.y, stroke.x + stroke.width, stroke.y + stroke.height], true);
    return true;
  }

  touched(left, top, right, bottom) {
    const box = [Math.max(0, left), Math.max(0, top), Math.min(this.width, right), Math.min(this.height, bottom)];
    if (box[2] <= box[0] || box[3] <= box[1]) return;
    const old = this.stroke.box ?? box;
    this.stroke.box = [Math.min(old[0], box[0]), Math.min(old[1], box[1]), Math.max(old[2], box[2]), Math.max(old[3], box[3])];
    this.onchange(box, false);
  }

  /** Set the pixels whose middles lie within `radius` of the way from one place to another. */
  line([x0, y0], [x1, y1], radius, label) {
    const top = Math.max(0, Math.floor(Math.min(y0, y1) - radius));
    const bottom = Math.min(this.height, Math.ceil(Math.max(y0, y1) + radius));
    const left = Math.max(0, Math.floor(Math.min(x0, x1) - radius));
    const right = Math.min(this.width, Math.ceil(Math.max(x0, x1) + radius));
    const [dx, dy] = [x1 - x0, y1 - y0];
    const length = dx * dx + dy * dy || 1;
    for (let y = top; y < bottom; y++) {
      for (let x = left; x < right; x++) {
        const [px, py] = [x + 0.5 - x0, y + 0.5 - y0];
        const share = Math.max(0, Math.min(1, (px * dx + py * dy) / length));
        const [ex, ey] = [px - share * dx, py - share * dy];
        if (ex * ex + ey * ey <= radius * radius) this.labels[y * this.width + x] = label;
      }
    }
    // a brush thinner than a pixel still sets the one that it is in
    const [x, y] = [Math.floor(x1), Math.floor(y1)];
    if (x >= 0 && y >= 0 && x < this.width && y < this.height) this.labels[y * this.width + x] = label;
    this.touched(Math.min(left, x), Math.min(top, y), Math.max(right, x + 1), Math.max(bottom, y + 1));
  }

  /** Set the pixels whose middles lie inside an outline (crossings counted, as in a lasso's loops). */
  area(outline, label) {
    const ys = outline.map(([, y]) => y);
    const top = Math.max(0, Math.floor(Math.min(...ys)));
    const bottom = Math.min(this.height, Math.ceil(Math.max(...ys)));
    for (let row = top; row < bottom; row++) {
      const y = row + 0.5;
      const crossings = [];
      outline.forEach(([x0, y0], k) => {
        const [x1, y1] = outline[(k + 1) % outline.length];
        if (y0 <= y !== y1 <= y) crossings.push(x0 + ((y - y0) * (x1 - x0)) / (y1 - y0));
      });
      crossings.sort((one, other) => one - other);
      for (let k = 0; k + 1 < crossings.length; k += 2) {
        const from = Math.max(0, Math.ceil(crossings[k] - 0.5));
        const to = Math.min(this.width, Math.ceil(crossings[k + 1] - 0.5));
        if (to > from) this.labels.fill(label, row * this.width + from, row * this.width + to);
      }
    }
    this.touched(0, top, this.width, bottom);
  }

  /** Set every pixel for which `test(index)` holds. */
  where(test, label) {
    for (let index = 0; index < this.labels.length; index++) if (test(index)) this.labels[index] = label;
    this.touched(0, 0, this.width, this.height);
  }

  /** Which pixels hang together with (x, y) through pixels that pass a test. */
  connected(x, y, test) {
    const { width, height } = this;
    const seen = new Uint8Array(width * height);
    const open = [y * width + x];
    seen[open[0]] = 1;
    while (open.length) {
      const index = open.pop();
      const column = index % width;
      const row = (index - column) / width;
      for (const [next, inside] of [
        [index - 1, column > 0],
        [index + 1, column + 1 < width],
        [index - width, row > 0],
        [index + width, row + 1 < height],
      ]) {
        if (inside && !seen[next] && test(next)) {
          seen[next] = 1;
          open.push(next);
        }
      }
    }
    return seen;
  }

  /** How many pixels have a label. */
  count(label) {
    let sum = 0;
    for (const one of this.labels) sum += one === label;
    return sum;
  }

  /** An opaque picture of the labels, [red, green, blue] each, as a PNG without half-tones. */
  async png(colors) {
    const canvas = new OffscreenCanvas(this.width, this.height);
    canvas.getContext("2d").putImageData(this.pixels(colors.map((color) => [...color, 255])), 0, 0);
    return canvas.convertToBlob({ type: "image/png" });
  }

  /** ImageData of a part of the labels, in colors [red, green, blue, alpha]. */
  pixels(colors, [left, top, right, bottom] = [0, 0, this.width, this.height]) {
    const data = new ImageData(Math.max(1, right - left), Math.max(1, bottom - top));
    const words = new Uint32Array(data.data.buffer);
    const table = colors.map(([r, g, b, a]) => ((a << 24) | (b << 16) | (g << 8) | r) >>> 0);
    let out = 0;
    for (let y = top; y < bottom; y++) {
      for (let x = left; x < right; x++) words[out++] = table[this.labels[y * this.width + x]] ?? 0;
    }
    return data;
  }

  /** Take over a picture whose colors are those of labels; other colors are the nearest label's. */
  read(picture, colors) {
    const canvas = new OffscreenCanvas(this.width, this.height);
    const context = canvas.getContext("2d", { willReadFrequently: true });
    context.imageSmoothingEnabled = false;
    context.drawImage(picture, 0, 0, this.width, this.height);
    const { data } = context.getImageData(0, 0, this.width, this.height);
    const far = (color, at) => color.reduce((sum, one, k) => sum + (one - data[at + k]) ** 2, 0);
    this.begin();
    this.where(() => false, 0);
    for (let index = 0; index < this.labels.length; index++) {
      const distances = colors.map((color) => far(color, 4 * index));
      this.labels[index] = distances.indexOf(Math.min(...distances));
    }
    this.touched(0, 0, this.width, this.height);
    this.end();
  }
}

function cut(labels, width, part) {
  const cut = new Uint8Array(part.width * part.height);
  for (let row = 0; row < part.height; row++) {
    const start = (part.y + row) * width + part.x;
    cut.set(labels.subarray(start, start + part.width), row * part.width);
  }
  return cut;
}
