/**
 * Pointer, wheel, touch and keys of a view. A tool may take the pointer first: `tool.down(event, place)`
 * returns true if it does, and then gets `move` and `up`. Two fingers and the middle button always pan.
 */
export function addGestures(view) {
  const { element, camera } = view;
  const fingers = new Map();
  let panning = null;
  let pinch = null;
  let tool = null;

  const offset = (event) => {
    const box = element.getBoundingClientRect();
    return [event.clientX - box.left - box.width / 2, event.clientY - box.top - box.height / 2];
  };

  element.addEventListener("pointerdown", (event) => {
    if (event.target.closest("button, input, a")) return;
    fingers.set(event.pointerId, offset(event));
    element.setPointerCapture(event.pointerId);
    if (fingers.size === 2) {
      tool?.cancel?.();
      tool = null;
      panning = null;
      pinch = spread([...fingers.values()]);
      return;
    }
    const tools = event.button === 0 && !view.spaceHeld ? [...view.tools].reverse() : [];
    tool = tools.find((one) => one.down(event, view.place(event))) ?? null;
    if (!tool) {
      panning = offset(event);
      element.classList.add("panning");
    }
  });

  element.addEventListener("pointermove", (event) => {
    if (fingers.has(event.pointerId)) fingers.set(event.pointerId, offset(event));
    if (pinch && fingers.size === 2) {
      const now = spread([...fingers.values()]);
      camera.pan(now.x - pinch.x, now.y - pinch.y);
      camera.zoom(now.size / pinch.size, now.x, now.y);
      pinch = now;
    } else if (tool) {
      tool.move?.(event, view.place(event));
    } else if (panning) {
      const [x, y] = offset(event);
      camera.pan(x - panning[0], y - panning[1]);
      panning = [x, y];
    }
    view.hover(event);
  });

  const end = (event) => {
    fingers.delete(event.pointerId);
    if (fingers.size < 2) pinch = null;
    tool?.up?.(event, view.place(event));
    tool = null;
    panning = null;
    element.classList.remove("panning");
  };
  element.addEventListener("pointerup", end);
  element.addEventListener("pointercancel", end);
  element.addEventListener("pointerleave", () => view.hover(null));

  element.addEventListener(
    "wheel",
    (event) => {
      event.preventDefault();
      const unit = event.deltaMode === 1 ? 30 : 1;
      if (event.shiftKey) camera.pan(-(event.deltaX || event.deltaY) * unit, 0);
      else camera.zoom(Math.exp(-event.deltaY * unit * (event.ctrlKey ? 0.01 : 0.002)), ...offset(event));
    },
    { passive: false },
  );

  element.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || event.target !== element) return;
    if (view.keys?.(event)) event.preventDefault();
    else if (move(view, event.key, event.shiftKey)) event.preventDefault();
  });
  element.addEventListener("keyup", (event) => {
    if (event.key === " ") view.spaceHeld = false;
  });
}

/** What a key does to the camera; true if it did something. */
function move(view, key, far) {
  const step = far ? 240 : 48;
  const moves = {
    ArrowLeft: () => view.camera.pan(step, 0),
    ArrowRight: () => view.camera.pan(-step, 0),
    ArrowUp: () => view.camera.pan(0, step),
    ArrowDown: () => view.camera.pan(0, -step),
    "+": () => view.camera.zoom(Math.SQRT2),
    "=": () => view.camera.zoom(Math.SQRT2),
    "-": () => view.camera.zoom(Math.SQRT1_2),
    0: () => view.fit(),
    1: () => view.camera.set(view.camera.x, view.camera.y, 1 / window.devicePixelRatio),
    " ": () => (view.spaceHeld = true),
  };
  if (!(key in moves)) return false;
  moves[key]();
  return true;
}

function spread([first, second]) {
  return {
    x: (first[0] + second[0]) / 2,
    y: (first[1] + second[1]) / 2,
    size: Math.max(1, Math.hypot(first[0] - second[0], first[1] - second[1])),
  };
}
