"""The extension in Blender, as a module without a window: `pip install bpy`, then pytest."""

from __future__ import annotations

import time
from pathlib import Path

import bpy
import numpy as np
import pytest

import weftex
from weftex_blender import images, jobs, materials

_SAMPLES = Path(weftex.__file__).parent / "samples"


@pytest.fixture(autouse=True)
def _empty():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    import weftex_blender

    # Factory settings keep registered classes, so only the data is new.
    assert weftex_blender.OPERATORS


@pytest.fixture
def pebbles():
    return bpy.data.images.load(str(_SAMPLES / "pebbles.png"))


def _cube():
    bpy.ops.mesh.primitive_plane_add()
    return bpy.context.object


def _array(name, pixels):
    """A new image from an array, first row on top."""
    plain = bpy.data.images.new("plain", 2, 2)
    image = images.new_image(name, pixels, plain)
    return image


def _sample(image):
    return weftex.Exemplar(images.picture_of(image).pixels)


def test_pixels_come_back_as_they_were(pebbles):
    picture = images.picture_of(pebbles)
    assert picture.pixels.shape == (192, 192, 3) and picture.pixels.dtype == np.uint8
    again = images.picture_of(images.new_image("again", picture.pixels, pebbles))
    np.testing.assert_array_equal(again.pixels, picture.pixels)


def test_floats_and_transparency_come_back_as_they_were():
    values = np.random.default_rng(1).random((6, 8, 4), np.float32) * 3
    values[..., 3] = np.linspace(0, 1, 8)
    picture = images.picture_of(_array("float", values))
    assert picture.alpha
    np.testing.assert_allclose(picture.pixels[:, 1:], values[:, 1:], rtol=1e-6)


def test_make_more_gives_the_pixels_of_the_same_seed(pebbles):
    done = bpy.ops.weftex.make_more(image=pebbles.name, size=(240, 200), seed=7)
    assert done == {"FINISHED"}
    made = bpy.data.images["pebbles.png more"]
    assert tuple(made.size) == (240, 200) and made.packed_file
    expected = weftex.synthesize(_sample(pebbles), (200, 240), seed=7)
    np.testing.assert_array_equal(images.picture_of(made).pixels, expected.image)


def test_make_tileable_gives_the_pixels_of_the_same_seed(pebbles):
    assert bpy.ops.weftex.make_tileable(image=pebbles.name, seed=3) == {"FINISHED"}
    made = bpy.data.images["pebbles.png tileable"]
    expected = weftex.tile(_sample(pebbles), seed=3)
    np.testing.assert_array_equal(images.picture_of(made).pixels, expected.image)


@pytest.mark.parametrize("by", ["mask", "transparency"])
def test_fill_changes_only_the_hole(pebbles, by):
    pixels = images.picture_of(pebbles).pixels
    hole = np.zeros(pixels.shape[:2], bool)
    hole[60:100, 80:130] = True
    if by == "mask":
        mask = _array("hole", hole.astype(np.uint8) * 255)
        done = bpy.ops.weftex.fill(image=pebbles.name, mask=mask.name, seed=1)
        made = bpy.data.images["pebbles.png filled"]
    else:
        alpha = np.where(hole, 0, 255).astype(np.uint8)
        image = _array("cut", np.dstack([pixels, alpha]))
        done = bpy.ops.weftex.fill(image=image.name, seed=1)
        made = bpy.data.images["cut filled"]
    assert done == {"FINISHED"}
    result = images.picture_of(made).pixels
    np.testing.assert_array_equal(result[~hole], pixels[~hole])
    assert (result[hole] != 0).any()


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: bpy.ops.weftex.make_more(image="nothing"), "there is no image 'nothing'"),
        (lambda: bpy.ops.weftex.make_more(), "open an image in the Image Editor first"),
        (lambda: bpy.ops.weftex.match_maps(), "select an object with a material first"),
        (lambda: bpy.ops.weftex.new_material(), "choose the image files of one material"),
        (lambda: bpy.ops.weftex.make_more(image=_array("dot", np.zeros((1, 1, 3), np.uint8)).name,
                                          size=(64, 64), method="quilting"), "dot"),
    ],
)  # fmt: skip
def test_errors_are_shown_in_one_line(call, message):
    before = set(bpy.data.images.keys())
    with pytest.raises(RuntimeError) as caught:
        call()
    text = str(caught.value).removeprefix("Error: ").strip()
    assert "\n" not in text and "Traceback" not in text
    if message != "dot":
        assert message in text
        assert set(bpy.data.images.keys()) == before


def _material(size=96):
    rng = np.random.default_rng(5)
    height = np.kron(rng.integers(0, 255, (size // 8, size // 8)), np.ones((8, 8))).astype(np.uint8)
    color = np.dstack([height, 255 - height, height // 2])
    maps = {"color": color, "roughness": height, "height": 255 - height}
    found = {name: _array(f"wall_{name}", pixels) for name, pixels in maps.items()}
    return materials.new_material("wall", found)


def test_match_maps_keeps_all_maps_of_a_material_aligned():
    plane, material = _cube(), _material()
    plane.active_material = material
    done = bpy.ops.weftex.match_maps(size=(150, 130), seed=2, method="quilting")
    assert done == {"FINISHED"}
    copy = plane.active_material
    assert copy != material
    made = {name: images.picture_of(one).pixels for name, one in materials.images_of(copy).items()}
    assert set(made) == {"color", "roughness", "height"}
    assert {one.shape[:2] for one in made.values()} == {(130, 150)}
    old = materials.images_of(material)
    pixels = {name: images.picture_of(one).pixels for name, one in old.items()}
    sample = weftex.Exemplar(pixels.pop("color"), maps=pixels)
    expected = weftex.synthesize(sample, (130, 150), method="quilting", seed=2)
    for name, one in {"color": expected.image, **expected.maps}.items():
        np.testing.assert_array_equal(made[name], one)
    assert {tuple(one.size) for one in old.values()} == {(96, 96)}


def test_a_new_material_has_its_maps_where_they_belong(tmp_path):
    plane = _cube()
    files = []
    for name, image in materials.images_of(_material()).items():
        image.filepath_raw, image.file_format = str(tmp_path / f"wall_{name}.png"), "PNG"
        image.save()
        files.append({"name": f"wall_{name}.png"})
    flat = np.full((96, 96, 3), (128, 128, 255), np.uint8)
    flat[:48, :, 1] = 160
    image = _array("wall_normal_dx", flat)
    image.filepath_raw, image.file_format = str(tmp_path / "wall_normal_dx.png"), "PNG"
    image.save()
    files.append({"name": "wall_normal_dx.png"})
    done = bpy.ops.weftex.new_material(directory=str(tmp_path), files=files, seed=1)
    assert done == {"FINISHED"}
    assert plane.active_material.name.split(".")[0] == "wall"
    tree = plane.active_material.node_tree
    spaces = {
        n.label: n.image.colorspace_settings.name for n in tree.nodes if n.type == "TEX_IMAGE"
    }
    assert spaces == {
        "color": "sRGB", "roughness": "Non-Color", "height": "Non-Color", "normal_dx": "Non-Color",
    }  # fmt: skip
    shader = next(node for node in tree.nodes if node.type == "BSDF_PRINCIPLED")
    for socket in ("Base Color", "Roughness", "Normal"):
        assert shader.inputs[socket].is_linked
    green = next(node for node in tree.nodes if node.type == "CURVE_RGB").mapping.curves[1]
    assert [tuple(point.location) for point in green.points] == [(0, 1), (1, 0)]


def test_a_job_reports_progress_and_can_be_cancelled(pebbles):
    sample = _sample(pebbles)
    job = jobs.Job(lambda progress: weftex.synthesize(
        sample, (900, 900), method="efros-leung", seed=1, progress=progress
    ))  # fmt: skip
    job.start()
    while job.running and not job.done:
        time.sleep(0.01)
    assert job.running and job.stage
    job.cancel()
    job.wait()
    assert job.cancelled and job.result is None and not job.error


def test_a_render_of_the_tiled_material_shows_no_seam(pebbles):
    bpy.ops.weftex.make_tileable(image=pebbles.name, seed=3)
    rendered = _render(bpy.data.images["pebbles.png tileable"])
    seam = _seam(rendered)
    raw = _seam(_render(pebbles))
    assert seam < 1.3 < raw


def _render(image):
    """Render a plane that repeats an image twice along both axes with Cycles, 128 px."""
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.device = 4, "CPU"
    scene.render.resolution_x = scene.render.resolution_y = 128
    scene.render.filter_size = 0.01
    plane = _cube()
    for loop in plane.data.uv_layers.active.data:
        loop.uv = tuple(2 * value for value in loop.uv)
    material = materials.new_material("tiled", {"color": image})
    tree = material.node_tree
    shader = next(node for node in tree.nodes if node.type == "BSDF_PRINCIPLED")
    color = shader.inputs["Base Color"].links[0].from_socket
    tree.links.new(color, shader.inputs["Emission Color"])
    shader.inputs["Emission Strength"].default_value = 1
    plane.active_material = material
    bpy.ops.object.camera_add(location=(0, 0, 3))
    camera = bpy.context.object
    camera.data.type, camera.data.ortho_scale = "ORTHO", 2
    scene.camera = camera
    scene.render.filepath = str(Path(bpy.app.tempdir) / "seam.png")
    bpy.ops.render.render(write_still=True)
    found = images.picture_of(bpy.data.images.load(scene.render.filepath)).pixels
    for one in (camera, plane):
        bpy.data.objects.remove(one)
    return found[..., :3].astype(float)


def _seam(pixels):
    """Steps over the middle row and column, relative to those elsewhere."""
    across = np.abs(np.diff(pixels, axis=1)).mean(axis=(0, 2))
    down = np.abs(np.diff(pixels, axis=0)).mean(axis=(1, 2))
    return max(across[63] / np.median(across), down[63] / np.median(down))
