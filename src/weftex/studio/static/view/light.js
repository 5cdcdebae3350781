import { FRAGMENT, VERTEX } from "./shaders.js";

/**
 * A material under a light that follows the pointer. It lies over a viewer, shares its camera and its
 * repetition, and draws with WebGL2; `LightView.possible()` says whether there is one.
 */
export class LightView {
  static possible() {
    return document.createElement("canvas").getContext("webgl2") !== null;
  }

  constructor(view) {
    this.view = view;
    this.canvas = document.createElement("canvas");
    this.canvas.className = "light";
    this.light = [0.3, -0.35]; // in halves of the view's sides, off its middle
    this.height = 0.6; // of the light over the surface, in the same unit
    this.relief = 1; // strength of the normals
    this.gl = this.canvas.getContext("webgl2", { antialias: false, alpha: true, premultipliedAlpha: true });
    this.program = makeProgram(this.gl, VERTEX, FRAGMENT);
    this.textures = {};
    this.stop = view.camera.listen(() => this.draw());
    this.observer = new ResizeObserver(() => this.draw());
    view.element.append(this.canvas);
    this.observer.observe(this.canvas);
    this.lost = (event) => event.preventDefault();
    this.canvas.addEventListener("webglcontextlost", this.lost);
  }

  close() {
    this.stop();
    this.observer.disconnect();
    this.canvas.remove();
    this.gl.getExtension("WEBGL_lose_context")?.loseContext();
  }

  /** Pictures by role: color, normal, roughness, height, occlusion, metallic; any may be missing. */
  show(pictures, { directx = false } = {}) {
    this.directx = directx;
    this.textures = makeTextures(this.gl, pictures, this.textures);
    this.draw();
  }

  /** Follow the pointer: place of an event in the view. */
  follow(event) {
    const box = this.view.element.getBoundingClientRect();
    this.move(
      (2 * (event.clientX - box.left)) / box.width - 1,
      (2 * (event.clientY - box.top)) / box.height - 1,
    );
  }

  move(x, y) {
    this.light = [x, y].map((one) => Math.max(-1.5, Math.min(1.5, one)));
    this.draw();
  }

  draw() {
    drawSoon(this);
  }

  paint(ratio) {
    const { gl, canvas, view, program } = this;
    gl.useProgram(program);
    const edge = view.repeat > 1 ? gl.REPEAT : gl.CLAMP_TO_EDGE;
    const at = (name) => gl.getUniformLocation(program, name);
    bindTextures(gl, at, this.textures, edge);
    gl.uniform2f(at("screen"), canvas.width, canvas.height);
    gl.uniform2f(at("size"), ...view.size);
    gl.uniform2f(at("middle"), view.camera.x, view.camera.y);
    gl.uniform1f(at("scale"), view.camera.scale * ratio);
    gl.uniform1f(at("repeat"), view.repeat);
    gl.uniform3f(at("light"), this.light[0], this.light[1], this.height);
    gl.uniform1f(at("relief"), this.relief);
    gl.uniform1f(at("down"), this.directx ? 1 : -1);
    gl.uniform1f(at("openness"), 1);
    gl.uniform1f(at("roughness"), 1);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }
}

/** Have a view painted at the next frame, in as many pixels as its canvas has on the screen. */
export function drawSoon(view) {
  if (view.waiting) return;
  view.waiting = true;
  requestAnimationFrame(() => {
    view.waiting = false;
    const { canvas, gl } = view;
    if (!canvas.isConnected || !view.textures.color) return;
    const ratio = window.devicePixelRatio || 1;
    canvas.width = Math.max(1, Math.round(canvas.clientWidth * ratio));
    canvas.height = Math.max(1, Math.round(canvas.clientHeight * ratio));
    gl.viewport(0, 0, canvas.width, canvas.height);
    view.paint(ratio);
  });
}

const ROLES = ["color", "normal", "roughness", "height", "occlusion", "metallic"];

export function makeProgram(gl, vertex, fragment) {
  const program = gl.createProgram();
  for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program));
  return program;
}

/** Textures by role, in place of others. */
export function makeTextures(gl, pictures, old) {
  for (const texture of Object.values(old)) gl.deleteTexture(texture);
  return Object.fromEntries(ROLES.filter((role) => pictures[role]).map((role) => [role, makeTexture(gl, pictures[role], role === "color")]));
}

/** Set the uniforms of the maps; a missing one is the color, which the shader does not read for it. */
export function bindTextures(gl, at, textures, edge) {
  ROLES.forEach((role, unit) => {
    gl.activeTexture(gl.TEXTURE0 + unit);
    gl.bindTexture(gl.TEXTURE_2D, textures[role] ?? textures.color);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, edge);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_T, edge);
    gl.uniform1i(at(`${role}Map`), unit);
    gl.uniform1i(at(`has_${role}`), role in textures ? 1 : 0);
  });
}

function makeTexture(gl, picture, color) {
  const texture = gl.createTexture();
  gl.bindTexture(gl.TEXTURE_2D, texture);
  gl.texImage2D(gl.TEXTURE_2D, 0, color ? gl.SRGB8_ALPHA8 : gl.RGBA8, gl.RGBA, gl.UNSIGNED_BYTE, picture);
  gl.generateMipmap(gl.TEXTURE_2D);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR_MIPMAP_LINEAR);
  return texture;
}
