import { Camera } from "./camera.js";
import { addGestures } from "./gestures.js";

/**
 * A picture that can be panned and zoomed to single pixels and out, repeated, split between before and
 * after, and covered by layers. It needs nothing of the rest of the page.
 *
 * `picture` and `before` are ImageBitmaps, canvases or null; `size` is [width, height] of the picture
 * in its own pixels, which may be more than those of a bitmap made for the screen.
 */
export class Viewer {
  constructor({ camera = new Camera(), label = "" } = {}) {
    this.camera = camera;
    this.element = document.createElement("div");
    this.element.className = "viewer";
    this.element.tabIndex = 0;
    this.element.setAttribute("role", "application");
    this.element.setAttribute("aria-label", label);
    this.canvas = document.createElement("canvas");
    this.element.append(this.canvas);
    this.context = this.canvas.getContext("2d");
    this.picture = null;
    this.before = null;
    this.split = 0.5;
    this.size = [1, 1];
    this.repeat = 1;
    this.overlay = null;
    this.overlayOpacity = 0.8;
    this.layers = []; // functions (context, view), drawn on top in pixels of the screen
    this.tools = []; // what may take the pointer, the last first
    this.background = null; // draws in place of the picture: the endless plane
    this.onhover = null;
    this.waiting = false;
    this.stops = [camera.listen(() => this.draw())];
    const observer = new ResizeObserver(() => this.resized());
    observer.observe(this.element);
    this.stops.push(() => observer.disconnect());
    addGestures(this);
  }

  close() {
    for (const stop of this.stops) stop();
    this.element.remove();
  }

  /** Show something else; what is not named stays. A picture of another size is fitted. */
  show(changes) {
    const old = this.size.join();
    Object.assign(this, changes);
    if (changes.picture && !changes.size && this.picture) this.size = [this.picture.width, this.picture.height];
    if (this.size.join() !== old || changes.repeat) this.fit();
    this.draw();
  }

  fit() {
    const [width, height] = this.size;
    const { clientWidth, clientHeight } = this.element;
    if (clientWidth) this.camera.fit(width * this.repeat, height * this.repeat, clientWidth, clientHeight);
  }

  resized() {
    const ratio = window.devicePixelRatio || 1;
    this.canvas.width = Math.round(this.element.clientWidth * ratio);
    this.canvas.height = Math.round(this.element.clientHeight * ratio);
    if (this.camera.fitted) this.fit();
    this.paint();
  }

  /** Draw at the next frame. */
  draw() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => {
      this.waiting = false;
      this.paint();
    });
  }

  /** The place of the picture under an event, in its pixels. */
  place(event) {
    const box = this.element.getBoundingClientRect();
    return [
      this.camera.x + (event.clientX - box.left - box.width / 2) / this.camera.scale,
      this.camera.y + (event.clientY - box.top - box.height / 2) / this.camera.scale,
    ];
  }

  /** Pixels of the canvas in which a place of the picture lies. */
  onCanvas(x, y) {
    const ratio = this.ratio;
    return [
      this.canvas.width / 2 + (x - this.camera.x) * this.camera.scale * ratio,
      this.canvas.height / 2 + (y - this.camera.y) * this.camera.scale * ratio,
    ];
  }

  get ratio() {
    return window.devicePixelRatio || 1;
  }

  hover(event) {
    this.onhover?.(event ? this.place(event) : null, event);
  }

  paint() {
    const { context, canvas } = this;
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.clearRect(0, 0, canvas.width, canvas.height);
    if (this.background) this.background(context, this);
    else if (this.picture) this.paintPicture(this.picture);
    if (this.before && !this.background) this.paintBefore();
    if (this.overlay && !this.background) {
      context.globalAlpha = this.overlayOpacity;
      this.paintPicture(this.overlay);
      context.globalAlpha = 1;
    }
    for (const layer of this.layers) {
      context.save();
      layer(context, this);
      context.restore();
    }
  }

  paintPicture(picture) {
    for (let row = 0; row < this.repeat; row++) {
      for (let column = 0; column < this.repeat; column++) {
        this.paintAt(picture, column * this.size[0], row * this.size[1], ...this.size);
      }
    }
  }

  /** Draw a picture at a place; its borders fall on whole pixels, so that neighbors leave no line. */
  paintAt(picture, x, y, width, height) {
    const [left, top] = this.onCanvas(x, y).map(Math.round);
    const [right, bottom] = this.onCanvas(x + width, y + height).map(Math.round);
    if (right < 0 || bottom < 0 || left > this.canvas.width || top > this.canvas.height) return;
    const { context } = this;
    context.imageSmoothingEnabled = right - left < 2 * picture.width;
    context.imageSmoothingQuality = "high";
    context.drawImage(picture, left, top, Math.max(1, right - left), Math.max(1, bottom - top));
  }

  /** What was before, left of the line. */
  paintBefore() {
    const { context, canvas } = this;
    const middle = Math.round(canvas.width * this.split);
    context.save();
    context.beginPath();
    context.rect(0, 0, middle, canvas.height);
    context.clip();
    context.clearRect(0, 0, middle, canvas.height);
    this.paintPicture(this.before);
    context.restore();
  }

  /** [red, green, blue, alpha] that the view shows at a place of the picture, or null. */
  colorAt(x, y) {
    const [width, height] = this.size;
    const picture = this.picture;
    if (!picture || x < 0 || y < 0 || x >= width * this.repeat || y >= height * this.repeat) return null;
    const column = Math.floor(((x % width) / width) * picture.width);
    const row = Math.floor(((y % height) / height) * picture.height);
    this.probe ??= new OffscreenCanvas(1, 1).getContext("2d", { willReadFrequently: true });
    this.probe.clearRect(0, 0, 1, 1);
    this.probe.drawImage(picture, column, row, 1, 1, 0, 0, 1, 1);
    return this.probe.getImageData(0, 0, 1, 1).data;
  }
}
