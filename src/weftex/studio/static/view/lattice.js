/**
 * The lattice over a sample: its lines, and two arrows whose ends can be dragged. Vectors are
 * [[x1, y1], [x2, y2]] in pixels, x to the right and y downwards; of rows only the first one is used.
 */
export class LatticeLayer {
  constructor(view, { onchange, onmove = () => {}, color = "#ffb02e" }) {
    this.view = view;
    this.vectors = null;
    this.rowsLocked = false; // the first vector stays level
    this.onchange = onchange;
    this.onmove = onmove;
    this.color = color;
    this.held = null;
    this.paint = this.paint.bind(this);
  }

  /** Show vectors; `lines` [{across, phase}] say where the lattice's own lines lie, if anything does. */
  set(vectors, lines = null) {
    this.vectors = vectors && vectors.map((one) => [...one]);
    if (vectors) this.origin = this.middlePoint(lines ?? []);
    this.view.draw();
  }

  /** The lattice's point nearest to the middle of the sample: there the arrows begin. */
  middlePoint(lines) {
    const middle = this.view.size.map((length) => length / 2);
    if (this.vectors.length < 2) {
      const [{ across: [ax, ay], phase } = { across: [0, 0], phase: 0 }] = lines;
      const power = ax * ax + ay * ay || 1;
      const off = ax * middle[0] + ay * middle[1] - phase;
      const back = (off - Math.round(off)) / power;
      return [middle[0] - ax * back + 0.5, middle[1] - ay * back + 0.5];
    }
    const start = lines.length === 2 ? crossing(lines) : [0, 0];
    const [[a, b], [c, d]] = this.vectors;
    const det = a * d - b * c;
    const [x, y] = [middle[0] - start[0], middle[1] - start[1]];
    const i = Math.round((x * d - y * c) / det);
    const j = Math.round((y * a - x * b) / det);
    return [start[0] + i * a + j * c + 0.5, start[1] + i * b + j * d + 0.5];
  }

  paint(context, view) {
    if (!this.vectors) return;
    const ratio = view.ratio;
    const corner = view.onCanvas(0, 0);
    const far = view.onCanvas(...view.size);
    context.save();
    context.beginPath();
    context.rect(corner[0], corner[1], far[0] - corner[0], far[1] - corner[1]);
    context.clip();
    context.beginPath();
    for (const [from, to] of this.lines()) {
      context.moveTo(...view.onCanvas(...from));
      context.lineTo(...view.onCanvas(...to));
    }
    context.lineWidth = 3 * ratio;
    context.strokeStyle = "rgb(0 0 0 / 35%)";
    context.stroke();
    context.lineWidth = 1.25 * ratio;
    context.strokeStyle = this.color;
    context.stroke();
    context.restore();
    for (const vector of this.vectors) this.paintArrow(context, view, vector);
  }

  /** Ends of the lattice's lines, far enough to cross the sample. */
  lines() {
    const [width, height] = this.view.size;
    const reach = width + height;
    const [first, second] = this.vectors;
    const ways = second ? [[first, second], [second, first]] : [[first, [-first[1], first[0]]]];
    const [ox, oy] = this.origin;
    return ways.flatMap(([step, along]) => {
      const length = Math.hypot(...along);
      const across = Math.abs(step[0] * along[1] - step[1] * along[0]) / length;
      const count = across < 1.5 ? 0 : Math.ceil(reach / across);
      const [ux, uy] = along.map((one) => (one / length) * 2 * reach);
      return Array.from({ length: 2 * count + 1 }, (_, k) => {
        const [x, y] = [ox + (k - count) * step[0], oy + (k - count) * step[1]];
        return [[x - ux, y - uy], [x + ux, y + uy]];
      });
    });
  }

  paintArrow(context, view, vector) {
    const ratio = view.ratio;
    const [x, y] = view.onCanvas(...this.origin);
    const [tx, ty] = view.onCanvas(this.origin[0] + vector[0], this.origin[1] + vector[1]);
    context.lineCap = "round";
    for (const [color, width] of [["#000c", 6], ["#fff", 2.5]]) {
      context.strokeStyle = color;
      context.lineWidth = width * ratio;
      context.beginPath();
      context.moveTo(x, y);
      context.lineTo(tx, ty);
      context.stroke();
    }
    context.beginPath();
    context.arc(tx, ty, 6 * ratio, 0, 7);
    context.fillStyle = this.color;
    context.strokeStyle = "#000";
    context.lineWidth = 1.5 * ratio;
    context.fill();
    context.stroke();
  }

  /** As a tool of the view: takes the pointer where it is near an arrow's end. */
  down(event, place) {
    if (!this.vectors) return false;
    const reach = (event.pointerType === "touch" ? 26 : 14) / this.view.camera.scale;
    const [ox, oy] = this.origin;
    const near = this.vectors.map(([x, y]) => Math.hypot(ox + x - place[0], oy + y - place[1]));
    const best = near.indexOf(Math.min(...near));
    if (near[best] > reach) return false;
    this.held = { which: best, before: this.vectors.map((one) => [...one]) };
    return true;
  }

  move(event, place) {
    const { which } = this.held;
    const vector = [place[0] - this.origin[0], place[1] - this.origin[1]];
    if (this.rowsLocked && which === 0) vector[1] = 0;
    const other = this.held.before[1 - which];
    const area = other ? Math.abs(vector[0] * other[1] - vector[1] * other[0]) : Math.hypot(...vector) ** 2;
    if (area < 16) return; // the vectors would lie on one line
    this.vectors = this.held.before.map((one, k) => (k === which ? vector.map((v) => Math.round(v * 100) / 100) : one));
    this.view.draw();
    this.onmove(this.vectors);
  }

  up() {
    const changed = this.held && this.vectors.join() !== this.held.before.join();
    this.held = null;
    if (changed) this.onchange(this.vectors);
  }

  cancel() {
    if (this.held) this.vectors = this.held.before;
    this.view.draw();
    this.held = null;
  }
}

/** Where the first lines of both families cross; pixel centers are whole numbers there. */
function crossing([one, other]) {
  const [a, b] = one.across;
  const [c, d] = other.across;
  const det = a * d - b * c;
  return [(one.phase * d - other.phase * b) / det, (other.phase * a - one.phase * c) / det];
}
