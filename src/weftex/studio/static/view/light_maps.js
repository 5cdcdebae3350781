/** Which maps of a material stand for which part of the light: by their roles. */
const PARTS = {
  normal: ["normal_gl", "normal_dx", "normal"],
  roughness: ["roughness", "gloss"],
  height: ["height", "bump", "depth"],
  occlusion: ["ao"],
  metallic: ["metallic"],
};

/** Pictures for `LightView.show`, from maps {name, role} and their pictures; `color` is the main one. */
export function lightMaps(maps, pictures, color) {
  const roles = { color };
  let directx = false;
  for (const [part, names] of Object.entries(PARTS)) {
    const name = names.find((one) => maps.some((map) => map.role === one));
    if (!name) continue;
    const picture = pictures[maps.findIndex((map) => map.role === name)];
    roles[part] = name === "gloss" || name === "depth" ? inverted(picture) : picture;
    if (name === "normal_dx") directx = true;
  }
  return { roles, directx };
}

function inverted(picture) {
  const canvas = new OffscreenCanvas(picture.width, picture.height);
  const context = canvas.getContext("2d");
  context.drawImage(picture, 0, 0);
  context.globalCompositeOperation = "difference";
  context.fillStyle = "#fff";
  context.fillRect(0, 0, picture.width, picture.height);
  return canvas;
}
