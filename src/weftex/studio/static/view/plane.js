const COARSEST = 2; // squares of at most 4 times the side

/**
 * The endless plane: windows of one picture without borders, fetched as they come into view and kept
 * while there is room. `fetchWindow({top, left, side}, signal)` resolves to an ImageBitmap of a square; seen
 * from afar squares are larger.
 */

export class Plane {
  constructor(fetchWindow, { side = 256, most = 400, atOnce = 3, onchange = () => {} } = {}) {
    this.fetchWindow = fetchWindow;
    this.side = side;
    this.most = most;
    this.atOnce = atOnce;
    this.onchange = onchange;
    this.windows = new Map(); // "level,column,row" -> {picture, column, row, side}, the longest unused first
    this.running = new Map(); // the same -> AbortController
    this.failed = null;
    this.drawn = 0; // windows made so far
  }

  /** Draw what there is and ask for what is missing; a viewer's `background`. */
  draw(context, view) {
    this.paintKept(view);
    const level = Math.max(0, Math.min(COARSEST, Math.floor(-Math.log2(view.camera.scale * view.ratio))));
    const side = this.side << level;
    const half = [view.canvas.width, view.canvas.height].map((length) => length / view.ratio / 2 / view.camera.scale);
    const first = [(view.camera.x - half[0]) / side, (view.camera.y - half[1]) / side].map(Math.floor);
    const last = [(view.camera.x + half[0]) / side, (view.camera.y + half[1]) / side].map(Math.floor);
    const missing = [];
    for (let row = first[1]; row <= last[1]; row++) {
      for (let column = first[0]; column <= last[0]; column++) {
        const key = `${level},${column},${row}`;
        const kept = this.windows.get(key);
        if (kept) {
          this.windows.delete(key);
          this.windows.set(key, kept);
          view.paintAt(kept.picture, column * side, row * side, side, side);
        } else {
          missing.push({ column, row, side, key });
        }
      }
    }
    this.want(missing, view);
  }

  /** What is kept of other levels stands in for what is not there yet. */
  paintKept(view) {
    for (const { picture, column, row, side } of this.windows.values()) view.paintAt(picture, column * side, row * side, side, side);
  }

  /** Fetch the missing windows nearest to the middle; give up those that are out of view. */
  want(missing, view) {
    const wanted = new Set(missing.map(({ key }) => key));
    for (const [key, control] of this.running) if (!wanted.has(key)) control.abort();
    const distance = ({ column, row, side }) => Math.hypot((column + 0.5) * side - view.camera.x, (row + 0.5) * side - view.camera.y);
    missing.sort((one, other) => distance(one) - distance(other));
    for (const one of missing) {
      if (this.failed || this.running.size >= this.atOnce) break;
      if (!this.running.has(one.key)) this.fetch(one, view);
    }
  }

  async fetch({ column, row, side, key }, view) {
    const control = new AbortController();
    this.running.set(key, control);
    try {
      const picture = await this.fetchWindow({ top: row * side, left: column * side, side }, control.signal);
      this.windows.set(key, { picture, column, row, side });
      this.drawn += 1;
      while (this.windows.size > this.most) {
        const [oldest, { picture: old }] = this.windows.entries().next().value;
        this.windows.delete(oldest);
        old.close?.();
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
    for (const { picture } of this.windows.values()) picture.close?.();
    this.windows.clear();
  }
}
