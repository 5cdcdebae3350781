"""The sampler of the page and of Godot's shader, in WebGL2: the plane of Python, without seams."""

import base64
import re
from pathlib import Path

import numpy as np
import pytest

from weftex.atlas import atlas
from weftex.io.pictures import read_image, write_image

PAGE = Path(__file__).parents[3] / "docs/how-to/atlas.md"
DRAW = """async ({image, code, width, height, down, across, linear}) => {
  const canvas = Object.assign(document.createElement('canvas'), {width, height});
  const gl = canvas.getContext('webgl2', {alpha: false, antialias: false});
  const program = gl.createProgram();
  const compiled = (type, text) => {
    const shader = gl.createShader(type);
    gl.shaderSource(shader, '#version 300 es\\n' + text);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw gl.getShaderInfoLog(shader);
    gl.attachShader(program, shader);
  };
  compiled(gl.VERTEX_SHADER, `void main() {
    gl_Position = vec4(gl_VertexID == 1 ? 3 : -1, gl_VertexID == 2 ? 3 : -1, 0, 1); }`);
  compiled(gl.FRAGMENT_SHADER, `precision highp float; precision highp int;
    uniform highp sampler2D atlas; out vec4 color;
    ${code}
    void main() {
      vec2 at = vec2(gl_FragCoord.x, float(${height}) - gl_FragCoord.y);
      color = sample_atlas(atlas, at / vec2(${across}, ${down}), 5u);
    }`);
  gl.linkProgram(program);
  gl.useProgram(program);
  const picture = new Image();
  picture.src = image;
  await picture.decode();
  gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());
  gl.pixelStorei(gl.UNPACK_COLORSPACE_CONVERSION_WEBGL, gl.NONE);
  gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, gl.RGBA, gl.UNSIGNED_BYTE, picture);
  gl.generateMipmap(gl.TEXTURE_2D);
  const filter = linear ? gl.LINEAR_MIPMAP_LINEAR : gl.NEAREST;
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, filter);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, linear ? gl.LINEAR : gl.NEAREST);
  gl.drawArrays(gl.TRIANGLES, 0, 3);
  return canvas.toDataURL('image/png');
}"""


def code_for(made):
    """The page's sampler, with the sizes of an atlas."""
    code = re.search(r"^```glsl\n(.*?)^```", PAGE.read_text("utf-8"), re.M | re.S)[1]
    index = made.index
    assert f"({', '.join(map(str, index['ids']))})" in code
    (height, width), gutter = made.tile_size, f"GUTTER = {made.gutter}.0"
    code = code.replace("GUTTER = 0.0", gutter).replace("192.0, 192.0", f"{width}.0, {height}.0")
    code = code.replace("768.0, 768.0", f"{index['width']}.0, {index['height']}.0")
    assert code in made.documents("a", "a.png")[".gdshader"]
    return code


def drawn(tab, made, folder, rows, columns, step=1, linear=False):
    """A plane of tiles, `step` pixels of the atlas to a pixel."""
    write_image(folder / "atlas.png", made.image)
    data = base64.b64encode((folder / "atlas.png").read_bytes()).decode("ascii")
    down, across = (side // step for side in made.tile_size)
    given = {"width": columns * across, "height": rows * down}
    given |= {"down": f"{down}.0", "across": f"{across}.0"}
    page = tab().page
    given |= {"image": f"data:image/png;base64,{data}", "code": code_for(made), "linear": linear}
    found = page.evaluate(DRAW, given)
    (folder / "drawn.png").write_bytes(base64.b64decode(found.partition(",")[2]))
    return read_image(folder / "drawn.png").pixels[..., :3]


@pytest.mark.parametrize("gutter", [0, 3])
def test_a_shader_draws_the_plane_of_python(tab, tmp_path, gutter):
    made = atlas("sample:pebbles", tile_size=32, gutter=gutter, seed=7)
    assert np.array_equal(drawn(tab, made, tmp_path, 64, 64), made.plane(64, 64, seed=5))


def test_filtered_tiles_have_no_seams(tab, tmp_path):
    """At half size, by mipmaps, borders differ from means of the plane as little as the inside."""
    made, step = atlas("sample:pebbles", tile_size=64, seed=7), 2
    found = drawn(tab, made, tmp_path, 16, 16, step, linear=True).astype(float)
    plane = made.plane(16, 16, seed=5).astype(float)
    means = plane.reshape(512, step, 512, step, 3).mean(axis=(1, 3))
    off = abs(found - means).mean(axis=2)
    border = np.isin(np.arange(512) % 32, (0, 31))
    assert off[border].mean() < 1.1 * off[~border].mean() + 0.5
    assert off[:, border].mean() < 1.1 * off[:, ~border].mean() + 0.5
    assert off.max() < 3
