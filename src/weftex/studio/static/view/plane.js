/**
 * The endless plane: windows of one picture without borders, fetched as they come into view and kept
 * while there is room. `fetchWindow(column, row, signal)` resolves to an ImageBitmap of `side` pixels.
 */
export class Plane {
  constructor(fetchWindow, { side = 256, most = 400, atOnce = 3, onchange = () => {} } = {}) {
    this.fetchWindow = fetchWindow;
    this.side = side;
    this.most = most;
    this.atOnce = atOnce;
    this.onchange = onchange;
    this.windows = new Map(); // "column,row" -> ImageBitmap, the longest unused first
    this.running = new Map(); // "column,row" -> AbortController
    this.failed = null;
    this.drawn = 0; // windows made so far
  }

  /** Draw what there is and ask for what is missing; a viewer's `background`. */
  draw(context, view) {
    const { side } = this;
    const half = [view.canvas.width, view.canvas.height].map((length) => length / view.ratio / 2 / view.camera.scale);
    const first = [(view.camera.x - half[0]) / side, (view.camera.y - half[1]) / side].map(Math.floor);
    const last = [(view.camera.x + half[0]) / side, (view.camera.y + half[1]) / side].map(Math.floor);
    const missing = [];
    for (let row = first[1]; row <= last[1]; row++) {
      for (let column = first[0]; column <= last[0]; column++) {
        const key = `${column},${row}`;
        const picture = this.windows.get(key);
        if (picture) {
          this.windows.delete(key);
          this.windows.set(key, picture);
          view.paintAt(picture, column * side, row * side, side, side);
        } else {
          missing.push([column, row, key]);
        }
      }
    }
    this.want(missing, view);
  }

  /** Fetch the missing windows nearest to the middle; give up those that are out of view. */
  want(missing, view) {
    const wanted = new Set(missing.map(([, , key]) => key));
    for (const [key, control] of this.running) if (!wanted.has(key)) control.abort();
    const distance = ([column, row]) =>
      Math.hypot((column + 0.5) * this.side - view.camera.x, (row + 0.5) * this.side - view.camera.y);
    missing.sort((one, other) => distance(one) - distance(other));
    for (const [column, row, key] of missing) {
      if (this.failed || this.running.size >= this.atOnce) break;
      if (!this.running.has(key)) this.fetch(column, row, key, view);
    }
  }

  async fetch(column, row, key, view) {
    const control = new AbortController();
    this.running.set(key, control);
    try {
      this.windows.set(key, await this.fetchWindow(column, row, control.signal));
      this.drawn += 1;
      while (this.windows.size > this.most) {
        const [oldest, picture] = this.windows.entries().next().value;
        this.windows.delete(oldest);
        picture.close?.();
      }
    } catch (error) {
      if (error.name !== "AbortError") this.failed = error;
    }
    this.running.delete(key);
    this.onchange(this);
    view.draw();
  }

  close() {
    for (const control of this.running.values()) control.abort();
    for (const picture of this.windows.values()) picture.close?.();
    this.windows.clear();
  }
}
