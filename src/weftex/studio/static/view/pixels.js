/**
 * A picture for canvases from what the server sends: a file, or where `shape` ("512x384") says so pixels as
 * a canvas has them.
 */
export function bitmapOf(bytes, shape) {
  const source = shape ? new ImageData(new Uint8ClampedArray(bytes), ...shape.split("x").map(Number)) : new Blob([bytes]);
  return createImageBitmap(source, { premultiplyAlpha: "default", colorSpaceConversion: "none" });
}
