import { h, segments } from "../dom.js";
import { t } from "../strings.js";
import { bindTextures, drawSoon, makeProgram, makeTextures } from "./light.js";
import { SOLID_FRAGMENT, SOLID_VERTEX } from "./shaders.js";

const SHAPES = ["sphere", "plane", "box", "cloth"];
const SLIDERS = { displacement: [0, 0.5], relief: [0, 3], openness: [0, 2], roughness: [0, 2], sunAcross: [-1, 1], sunAbove: [-1, 1] };
const FAR = { sphere: 3.6, plane: 3.2, box: 4.2, cloth: 4.2 };
const FLAT = new Set(["plane", "cloth"]); // the whole picture lies on them once

/** A material on a sphere, a plane, a box or a cloth, which turn under the pointer; drawn with WebGL2 over a viewer. */
export class SolidView {
  constructor(view) {
    this.view = view;
    this.values = { displacement: 0.06, relief: 1, openness: 1, roughness: 1, sunAcross: -0.5, sunAbove: 0.6 };
    this.shape = "sphere";
    this.turn = [0.5, 0.35]; // around the vertical axis, and above it, in radians
    this.near = 1;
    this.canvas = h("canvas", { class: "solid", tabindex: 0, role: "application", "aria-label": t("solid.view") });
    this.controls = h("details", { class: "solid-controls" });
    this.gl = this.canvas.getContext("webgl2", { antialias: true });
    this.program = makeProgram(this.gl, SOLID_VERTEX, SOLID_FRAGMENT);
    this.textures = {};
    view.element.append(this.canvas, this.controls);
    this.observer = new ResizeObserver(() => this.draw());
    this.observer.observe(this.canvas);
    this.addGestures();
    this.build();
    this.buildControls();
  }

  close() {
    this.observer.disconnect();
    this.canvas.remove();
    this.controls.remove();
    this.gl.getExtension("WEBGL_lose_context")?.loseContext();
  }

  /** Pictures by role, as `LightView.show` takes them, and the size of the picture in pixels. */
  show(pictures, { directx = false, size }) {
    Object.assign(this, { directx, size });
    this.textures = makeTextures(this.gl, pictures, this.textures);
    this.draw();
  }

  buildControls() {
    const sliders = Object.entries(SLIDERS).map(([name, [low, high]]) => {
      const box = h("input", { type: "range", min: low, max: high, step: 0.01, value: this.values[name], oninput: () => {
        this.values[name] = Number(box.value);
        this.draw();
      } });
      return h("label", {}, h("span", {}, t(`solid.${name}`)), box);
    });
    this.controls.open = window.innerWidth > 760;
    this.controls.append(
      h("summary", {}, t("solid.title")),
      segments(t("solid.shape"), SHAPES.map((one) => [one, t(`solid.${one}`)]), this.shape, (shape) => {
        this.shape = shape;
        this.build();
        this.draw();
      }),
      ...sliders,
    );
    this.controls.addEventListener("pointerdown", (event) => event.stopPropagation());
  }

  addGestures() {
    const { canvas } = this;
    const rotate = (dx, dy) => {
      this.turn = [this.turn[0] - dx, Math.max(-1.4, Math.min(1.4, this.turn[1] + dy))];
      this.draw();
    };
    canvas.addEventListener("pointerdown", (event) => {
      event.stopPropagation();
      canvas.setPointerCapture(event.pointerId);
    });
    canvas.addEventListener("pointermove", (event) => canvas.hasPointerCapture(event.pointerId) && rotate(event.movementX / 150, event.movementY / 150));
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      event.stopPropagation();
      this.near = Math.max(0.5, Math.min(3, this.near * Math.exp(-event.deltaY * 0.001)));
      this.draw();
    });
    canvas.addEventListener("keydown", (event) => {
      const way = { ArrowLeft: [0.1, 0], ArrowRight: [-0.1, 0], ArrowUp: [0, -0.1], ArrowDown: [0, 0.1] }[event.key];
      if (!way) return;
      event.preventDefault();
      event.stopPropagation();
      rotate(...way);
    });
  }

  /** Send the points of the shape to the graphics card. */
  build() {
    const { gl, program } = this;
    const { points, triangles } = SHAPE_OF[this.shape]();
    this.count = triangles.length;
    gl.bindBuffer(gl.ARRAY_BUFFER, (this.buffer ??= gl.createBuffer()));
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(points), gl.STATIC_DRAW);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, (this.indices ??= gl.createBuffer()));
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, new Uint32Array(triangles), gl.STATIC_DRAW);
    ["place", "normal", "tangent", "texture_place"].forEach((name, k) => {
      const where = gl.getAttribLocation(program, name);
      gl.enableVertexAttribArray(where);
      gl.vertexAttribPointer(where, 3, gl.FLOAT, false, 48, 12 * k);
    });
  }

  draw() {
    drawSoon(this);
  }

  paint() {
    const { gl, canvas, program, values } = this;
    gl.enable(gl.DEPTH_TEST);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.useProgram(program);
    const at = (name) => gl.getUniformLocation(program, name);
    bindTextures(gl, at, this.textures, gl.REPEAT);
    const far = FAR[this.shape] / this.near;
    const [around, above] = this.turn;
    const eye = [Math.sin(around) * Math.cos(above), Math.sin(above), Math.cos(around) * Math.cos(above)].map((one) => one * far);
    const wide = this.size[0] / this.size[1];
    const round = this.shape === "sphere" ? 2 : 1;
    const flat = FLAT.has(this.shape);
    const repeat = this.view.repeat;
    gl.uniformMatrix4fv(at("view"), false, looking(eye, canvas.width / canvas.height));
    gl.uniform3f(at("eye"), ...eye);
    gl.uniform3f(at("sun"), ...[2 * values.sunAcross, 2 * values.sunAbove, 1.2]);
    gl.uniform2f(at("times"), (round * repeat) / (flat ? 1 : wide), repeat * (flat ? wide : 1));
    gl.uniform2f(at("size"), ...this.size);
    gl.uniform1f(at("displacement"), values.displacement / repeat);
    gl.uniform1f(at("down"), this.directx ? 1 : -1);
    for (const name of ["relief", "openness", "roughness"]) gl.uniform1f(at(name), values[name]);
    gl.drawElements(gl.TRIANGLES, this.count, gl.UNSIGNED_INT, 0);
  }
}

/** Columns of the matrix of a camera that looks at the middle. */
function looking([x, y, z], wide) {
  const far = Math.hypot(x, y, z);
  const back = [x / far, y / far, z / far];
  const flat = Math.hypot(back[0], back[2]);
  const right = [back[2] / flat, 0, -back[0] / flat];
  const up = [back[1] * right[2], flat, -back[1] * right[0]]; // back x right
  const lens = 2.1 * Math.min(1, wide); // the whole solid is in view, however narrow that is
  const [low, high] = [0.1, 20];
  const deep = (high + low) / (low - high);
  const columns = [0, 1, 2].map((k) => [(right[k] * lens) / wide, up[k] * lens, back[k] * deep, -back[k]]);
  return new Float32Array([...columns.flat(), 0, 0, -far * deep + (2 * high * low) / (low - high), far]);
}

/** A grid of points; `point(u, v)` returns each as [place, normal, tangent, [u, v, fade]]. */
function grid(columns, rows, point, into = { points: [], triangles: [] }) {
  const first = into.points.length / 12;
  for (let row = 0; row <= rows; row++) for (let column = 0; column <= columns; column++) into.points.push(...point(column / columns, row / rows).flat());
  for (let row = 0; row < rows; row++) {
    for (let column = 0; column < columns; column++) {
      const corner = first + row * (columns + 1) + column;
      const below = corner + columns + 1;
      into.triangles.push(corner, below, corner + 1, corner + 1, below, below + 1);
    }
  }
  return into;
}

const SHAPE_OF = {
  sphere: () =>
    grid(384, 192, (u, v) => {
      const [around, down] = [2 * Math.PI * u, Math.PI * v];
      const out = [Math.sin(down) * Math.sin(around), Math.cos(down), Math.sin(down) * Math.cos(around)];
      return [out, out, [Math.cos(around), 0, -Math.sin(around)], [u, v, 1]];
    }),
  plane: () => grid(320, 320, (u, v) => [[2 * u - 1, 1 - 2 * v, 0], [0, 0, 1], [1, 0, 0], [u, v, 1]]),
  box: () => {
    const faces = { points: [], triangles: [] };
    const sides = [[[1, 0, 0], [0, 1, 0]], [[0, 0, -1], [0, 1, 0]], [[-1, 0, 0], [0, 1, 0]], [[0, 0, 1], [0, 1, 0]], [[1, 0, 0], [0, 0, -1]], [[1, 0, 0], [0, 0, 1]]];
    for (const [right, up] of sides) {
      const out = [right[1] * up[2] - right[2] * up[1], right[2] * up[0] - right[0] * up[2], right[0] * up[1] - right[1] * up[0]];
      grid(128, 128, (u, v) => {
        const fade = Math.min(1, 12 * Math.min(u, 1 - u, v, 1 - v));
        return [out.map((one, k) => 0.85 * (one + right[k] * (2 * u - 1) + up[k] * (1 - 2 * v))), out, right, [u, v, fade]];
      }, faces);
    }
    return faces;
  },
  cloth: () =>
    grid(320, 320, (u, v) => {
      const step = 1 / 640;
      const [place, right, below] = [draped(u, v), draped(u + step, v), draped(u, v + step)];
      const along = unit(right.map((one, k) => one - place[k]));
      return [place, unit(cross(below.map((one, k) => one - place[k]), along)), along, [u, v, 1]];
    }),
};

/** A place of a square cloth on a round table: level on top, bent at the edge, in folds that deepen down to the hem. */
function draped(u, v) {
  const [x, z] = [2.7 * (u - 0.5), 2.7 * (v - 0.5)];
  const [far, around] = [Math.hypot(x, z), Math.atan2(z, x)];
  const [table, bend, steep] = [0.6, 0.16, 1.45]; // radius, radius of the bent edge, angle of what hangs
  const over = Math.max(0, far - table);
  const angle = Math.min(over / bend, steep);
  const hung = over - bend * angle;
  const fold = Math.min(0.2, 0.3 * hung) * Math.cos(9 * around + 0.8 * Math.sin(2 * around));
  const out = Math.min(far, table) + bend * Math.sin(angle) + hung * Math.cos(steep) + fold;
  return [out * Math.cos(around), 0.4 - bend * (1 - Math.cos(angle)) - hung * Math.sin(steep), out * Math.sin(around)];
}

const cross = ([a, b, c], [d, e, f]) => [b * f - c * e, c * d - a * f, a * e - b * d];

function unit(vector) {
  const length = Math.hypot(...vector) || 1;
  return vector.map((one) => one / length);
}
