"""The nodes: what ComfyUI asks of them, and that they make what weftex makes."""

from __future__ import annotations

import inspect
import json
import os

import numpy as np
import pytest
import torch
from weftex_comfyui import NODE_CLASS_MAPPINGS, NODE_DISPLAY_NAME_MAPPINGS, images, widgets

import weftex
from conftest import Interrupted
from weftex import cli
from weftex.errors import WeftexError
from weftex.io.pictures import read_image, write_image
from weftex.recipe import TASKS

PEBBLES = weftex.read_image("sample:pebbles").pixels[:96, :96]
EVERY = pytest.mark.parametrize("node", NODE_CLASS_MAPPINGS.values(), ids=NODE_CLASS_MAPPINGS)


@pytest.fixture(autouse=True)
def _host(host):
    """Every test has a host."""


def tensor(*pictures):
    return torch.from_numpy(np.stack(pictures).astype(np.float32) / np.float32(255))


def pixels(image, number=0):
    """8-bit pixels of an image, as ComfyUI's Save Image writes them."""
    return (255.0 * image[number].numpy()).astype(np.uint8)


def run(name, **values):
    """Run a node; inputs that are not given have their defaults."""
    node = NODE_CLASS_MAPPINGS[f"Weftex{name}"]
    given = {}
    for inputs in node.INPUT_TYPES().values():
        for key, (kind, *more) in inputs.items():
            default = kind[0] if isinstance(kind, list) and kind else None
            default = (more[0] if more else {}).get("default", default)
            if default is not None:
                given[key] = default
    return getattr(node(), node.FUNCTION)(**given | values)


@EVERY
def test_every_node_is_as_comfyui_wants_it(node):
    inputs = node.INPUT_TYPES()
    assert json.loads(json.dumps(inputs)) and set(inputs) <= {"required", "optional"}
    names = {name for group in inputs.values() for name in group}
    parameters = inspect.signature(getattr(node, node.FUNCTION)).parameters
    assert "values" in parameters or names <= set(parameters)
    assert set(parameters) - {"self", "values"} <= names
    for group in inputs.values():
        for kind, *more in group.values():
            default = more[0].get("default") if more else None
            if isinstance(kind, list):
                assert kind and (default is None or default in kind)
            elif kind == "INT":
                assert more[0]["min"] <= default <= more[0]["max"]
    assert node.CATEGORY == "weftex" and node.DESCRIPTION
    assert len(node.RETURN_TYPES) == len(getattr(node, "RETURN_NAMES", node.RETURN_TYPES))
    assert node.RETURN_TYPES or node.OUTPUT_NODE
    if hasattr(node, "IS_CHANGED"):
        assert list(inspect.signature(node.IS_CHANGED).parameters) == list(inputs["required"])


def test_names_of_nodes():
    assert set(NODE_CLASS_MAPPINGS) == set(NODE_DISPLAY_NAME_MAPPINGS)
    assert all("weftex" in name for name in NODE_DISPLAY_NAME_MAPPINGS.values())


@pytest.mark.parametrize(("name", "task"), [("Synthesize", "synth"), ("MakeTileable", "tile"),
                                            ("Fill", "fill"), ("Fuse", "fuse")])  # fmt: skip
def test_every_declared_option_is_an_input(name, task):
    inputs = NODE_CLASS_MAPPINGS[f"Weftex{name}"].INPUT_TYPES()
    names = {key for group in inputs.values() for key in group}
    for option in TASKS[task].options.values():
        if not option.local:
            assert {"size": {"width", "height"}}.get(option.name, {option.name}) <= names
            values = widgets.fields_of([option], {})
            assert values.get(option.name) in (None, option.default)


def test_synthesize_makes_the_pixels_of_the_command_line(tmp_path):
    write_image(tmp_path / "a.png", PEBBLES)
    words = ["synth", f"{tmp_path}/a.png", "-o", f"{tmp_path}/b.png", "--size", "160x120"]
    assert cli.main([*words, "--seed", "7", "--quiet"]) == 0
    image, material, _ = run("Synthesize", sample=tensor(PEBBLES), width=160, height=120, seed=7)
    assert image.dtype == torch.float32 and image.shape == (1, 120, 160, 3)
    np.testing.assert_array_equal(pixels(image), read_image(tmp_path / "b.png").pixels)
    assert material.pictures["color"].pixels.dtype == np.uint8


def test_every_image_of_a_batch_is_done_with_the_next_seed():
    other = PEBBLES[::-1].copy()
    image, _, results = run("Synthesize", sample=tensor(PEBBLES, other), width=120, seed=7)
    assert image.shape == (2, 120, 120, 3) and len(results) == 2
    for number, sample in enumerate((PEBBLES, other)):
        expected = weftex.synthesize(sample, 120, seed=7 + number).image
        np.testing.assert_array_equal(pixels(image, number), expected)


def test_method_and_parameters():
    words = {"method": "quilting", "parameters": "patch_size = 24\ntolerance=0.2\n"}
    image, _, results = run("Synthesize", sample=tensor(PEBBLES), width=120, seed=7, **words)
    method = weftex.Quilting(patch_size=24, tolerance=0.2)
    expected = weftex.synthesize(PEBBLES, 120, method=method, seed=7).image
    np.testing.assert_array_equal(pixels(image), expected)
    assert results[0].provenance["patch_size"] == 24


def test_floats_lose_nothing():
    values = np.random.default_rng(1).random((96, 96, 3), np.float32)
    image, material, _ = run("MakeTileable", sample=torch.from_numpy(values[None]), border=8)
    np.testing.assert_array_equal(image[0].numpy()[16:80, 16:80], values[16:80, 16:80])
    # In a set, colors in floats are linear light.
    linear = material.pictures["color"].pixels[20, 20].astype(float)
    np.testing.assert_allclose(linear, images.to_light(values[20, 20].astype(float)), rtol=1e-5)
    back = images.encoded(material).pictures["color"].pixels
    np.testing.assert_allclose(back, image[0].numpy(), atol=2e-7)


@pytest.mark.parametrize("kind", ["gray", "alpha", "set"])
def test_kinds_of_images_stay(kind):
    gray = PEBBLES[..., 0]
    if kind == "set":
        material = run("LoadSet", folder="sample:stone_wall")[0]
        image, made, _ = run("Synthesize", sample=material, width=128, seed=2)
        expected = weftex.synthesize("sample:stone_wall", 128, seed=2)
        np.testing.assert_array_equal(made.pictures["height"].pixels, expected.maps["height"])
        assert made.pictures["height"].pixels.dtype == expected.maps["height"].dtype
        assert list(made.pictures) == list(run("Synthesize", sample=made, width=64)[1].pictures)
        np.testing.assert_array_equal(pixels(image), expected.image)
        return
    sample = np.dstack([gray] * 3) if kind == "gray" else np.dstack([PEBBLES, gray | 1])
    image, _, _ = run("Synthesize", sample=tensor(sample), width=120, method="quilting")
    assert image.shape[3] == sample.shape[2]
    if kind == "gray":
        expected = weftex.synthesize(gray, 120, method="quilting", seed=1).image
        np.testing.assert_array_equal(pixels(image)[..., 0], expected)


def test_fill_changes_only_the_hole():
    hole = np.zeros(PEBBLES.shape[:2], np.float32)
    hole[30:50, 40:70] = 1
    image, _, _ = run("Fill", sample=tensor(PEBBLES), mask=torch.from_numpy(hole[None]), seed=3)
    expected = weftex.fill(PEBBLES, hole > 0.5, seed=3).image
    np.testing.assert_array_equal(pixels(image), expected)
    np.testing.assert_array_equal(pixels(image)[hole == 0], PEBBLES[hole == 0])
    clear = np.dstack([PEBBLES, np.where(hole > 0, 0, 255).astype(np.uint8)])
    image, _, _ = run("Fill", sample=tensor(clear), seed=3)
    filled = pixels(image)
    np.testing.assert_array_equal(filled[hole == 0], clear[hole == 0])
    assert (filled[hole > 0] != clear[hole > 0]).all(axis=-1).any() and (
        filled[..., 3] == 255
    ).all()


def test_fuse_with_a_map_and_with_a_gradient():
    other = 255 - PEBBLES
    samples = {"sample_1": tensor(PEBBLES), "sample_2": tensor(other)}
    areas = np.zeros((80, 90, 3), np.uint8)
    areas[:, 40:] = 255
    image, _, _ = run("Fuse", **samples, map=tensor(areas), seed=5)
    expected = weftex.fuse([PEBBLES, other], areas, seed=5).image
    np.testing.assert_array_equal(pixels(image), expected)
    image, _, _ = run("Fuse", **samples, width=80, gradient_direction="0", seed=5)
    rings = weftex.label_maps.Gradient(direction=0)
    expected = weftex.fuse([PEBBLES, other], rings, 80, seed=5).image
    np.testing.assert_array_equal(pixels(image), expected)
    with pytest.raises(WeftexError, match="no effect beside a map"):
        run("Fuse", **samples, map=tensor(areas), gradient_direction="0")


def test_images_of_different_depth_are_fused_as_floats():
    values = torch.from_numpy(np.random.default_rng(1).random((1, 64, 64, 3), np.float32))
    image, _, _ = run("Fuse", sample_1=tensor(PEBBLES), sample_2=values, width=64)
    assert not images.has_8_bits(image)


def test_prepare():
    image, _ = run("Prepare", sample=tensor(PEBBLES), even_light=2)
    expected = weftex.prepare.even_light(PEBBLES, 2).pixels
    np.testing.assert_array_equal(pixels(image), expected)
    corners = "8,8,56,8,56,40,8,40"
    image, _ = run("Prepare", sample=tensor(PEBBLES), straighten=corners)
    np.testing.assert_array_equal(pixels(image), PEBBLES[8:40, 8:56])
    floats = tensor(PEBBLES) * 0.999
    np.testing.assert_allclose(run("Prepare", sample=floats)[0], floats, atol=2e-7)
    even = run("Prepare", sample=floats, even_light=2)[0][0].numpy()
    assert np.abs(np.clip(even, 0, 1) * 255 - expected).max() < 3  # also evened in linear light


def test_replay_on_another_map():
    *_, result = run("Synthesize", sample=tensor(PEBBLES), width=120, seed=4)
    height = PEBBLES[..., :1].repeat(3, axis=2)
    image, material = run("ReplayOnMap", result=result, map=tensor(height), role="height")
    expected = result[0].render(weftex.Exemplar(height[..., 0], role="height"))
    np.testing.assert_array_equal(pixels(image)[..., 0], expected)
    assert [role.name for role in material.roles.values()] == ["height"]
    with pytest.raises(WeftexError, match="multiple"):
        run("ReplayOnMap", result=result, map=tensor(height[:50]))


def test_maps_of_sets():
    rough = np.full((96, 96, 3), 99, np.uint8)
    (material,) = run("AddMap", image=tensor(PEBBLES))
    (material,) = run("AddMap", image=tensor(rough), role="roughness", set=material)
    (again,) = run("AddMap", image=tensor(rough + 1), role="roughness", set=material)
    assert len(again.pictures) == 2 and again.pictures["roughness"].pixels[0, 0] == 100
    made = run("Synthesize", sample=material, width=120)[1]
    assert pixels(run("GetMap", set=made, role="roughness")[0])[5, 5].tolist() == [99] * 3
    with pytest.raises(WeftexError, match="the set has no normal"):
        run("GetMap", set=material, role="normal")


def test_sets_are_loaded_and_saved_whole(host):
    folder = os.path.join(host.input, "walls", "rock")
    os.makedirs(folder)
    write_image(f"{folder}/rock_color.png", PEBBLES)
    write_image(f"{folder}/rock_height.png", PEBBLES[..., 0].astype(np.uint16) * 257)
    write_image(f"{folder}/rock_emission.exr", np.full((96, 96, 3), 0.5, np.float32))
    load = NODE_CLASS_MAPPINGS["WeftexLoadSet"]
    assert "walls/rock" in load.INPUT_TYPES()["required"]["folder"][0]
    before = load.IS_CHANGED("walls/rock")
    material, image = run("LoadSet", folder="walls/rock")
    np.testing.assert_array_equal(pixels(image), PEBBLES)
    emission = run("GetMap", set=material, role="emission")[0]
    assert abs(emission.max().item() - 0.7354) < 1e-3  # 0.5 of the light
    for _ in range(2):  # into a new folder each time
        shown = run("SaveSet", set=material, filename_prefix="made/wall")["ui"]["images"]
    found = sorted(os.listdir(os.path.join(host.output, "made")))
    assert found == ["wall_00001_", "wall_00002_"]
    out = os.path.join(host.output, "made", "wall_00002_")
    assert sorted(os.listdir(out)) == ["wall_color.png", "wall_emission.exr", "wall_height.png"]
    assert {one["filename"] for one in shown} == {"wall_color.png", "wall_height.png"}
    assert read_image(f"{out}/wall_height.png").pixels.dtype == np.uint16
    assert sorted(weftex.load_exemplar(out).maps) == ["emission", "height"]
    os.utime(f"{folder}/rock_color.png", (1, 1))
    assert load.IS_CHANGED("walls/rock") != before


@pytest.mark.parametrize("name", ["..", "../output", "/etc", "walls/../../output", ""])
def test_nothing_outside_the_input_folder_is_read(host, name):
    write_image(os.path.join(host.output, "a.png"), PEBBLES)
    with pytest.raises(WeftexError, match="is not in ComfyUI's input folder"):
        run("LoadSet", folder=name)


def test_a_set_that_cannot_be_saved_leaves_nothing(host, monkeypatch):
    def fail(*_, **__):
        raise OSError("disk full")

    material, _ = run("LoadSet", folder="sample:stone_wall")
    monkeypatch.setattr("weftex_comfyui.folders.write_preset", fail)
    with pytest.raises(OSError, match="disk full"):
        run("SaveSet", set=material)
    assert os.listdir(os.path.join(host.output, "weftex")) == []


def test_progress_previews_and_interruption(host):
    words = {"sample": tensor(PEBBLES), "width": 160, "method": "efros-leung"}
    run("Synthesize", **words)
    *_, (done, total, _) = host.updates
    assert done == total > 0 and len(host.updates) > 2
    kind, picture, side = next(preview for *_, preview in host.updates if preview)
    assert (kind, picture.size, picture.mode) == ("JPEG", (160, 160), "RGB") and side > 0
    host.interrupt_after = 3
    with pytest.raises(Interrupted):
        run("Synthesize", **words)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"method": "quilting", "parameters": "patchsize=5"}, "patch_size"),
        ({"method": "quilting", "parameters": "patch_size=huge"}, "patch_size"),
        ({"parameters": "patch_size=5"}, "patch_size"),
        ({"map_weights": "height"}, "map_weights is 'height'"),
        ({"sample": torch.full((1, 64, 64, 3), float("nan"))}, "NaN"),
        ({"best_of": 1000}, "best_of is 1000"),
    ],
)
def test_errors_are_those_of_weftex(values, message):
    with pytest.raises(WeftexError, match=message) as caught:
        run("Synthesize", **{"sample": tensor(PEBBLES), "width": 96} | values)
    assert "\n" not in str(caught.value)
