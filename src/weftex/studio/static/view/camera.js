/**
 * Where views look: the place of the picture in their middle, and how many pixels of the screen (CSS)
 * one pixel of the picture takes. Views that share a camera move together.
 */
export class Camera {
  static LEAST = 1 / 64;
  static MOST = 96;

  constructor() {
    this.x = 0;
    this.y = 0;
    this.scale = 1;
    this.fitted = true;
    this.least = Camera.LEAST;
    this.listeners = new Set();
  }

  listen(listener) {
    this.listeners.add(listener);
    return () => this.listeners.delete(listener);
  }

  set(x, y, scale, fitted = false) {
    this.x = x;
    this.y = y;
    this.scale = Math.min(Camera.MOST, Math.max(this.least, scale));
    this.fitted = fitted;
    for (const listener of this.listeners) listener();
  }

  /** Move by pixels of the screen. */
  pan(dx, dy) {
    this.set(this.x - dx / this.scale, this.y - dy / this.scale, this.scale);
  }

  /** Zoom by a factor; the place (px, py), in pixels of the screen off the view's middle, stays. */
  zoom(factor, px = 0, py = 0) {
    const scale = Math.min(Camera.MOST, Math.max(this.least, this.scale * factor));
    const x = this.x + px / this.scale - px / scale;
    const y = this.y + py / this.scale - py / scale;
    this.set(x, y, scale);
  }

  /** Show all of a picture; a small one is enlarged by a whole number only. */
  fit(width, height, viewWidth, viewHeight) {
    const margin = Math.min(24, 0.02 * Math.min(viewWidth, viewHeight));
    const room = Math.min((viewWidth - 2 * margin) / width, (viewHeight - 2 * margin) / height);
    const scale = room > 1 ? Math.min(8, Math.floor(room)) : Math.max(room, Camera.LEAST);
    this.set(width / 2, height / 2, scale, true);
  }
}
