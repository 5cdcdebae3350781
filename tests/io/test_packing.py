"""Map sets as engines want them, and back: channels, values, bits, notes, and what is refused."""

import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import weftex
from commands import fails, read_maps, weft_run
from families import noise, refused
from io_sets import DATA, normals, whole_set
from weftex.io.map_files import map_files
from weftex.io.packing import unpack_set, write_preset
from weftex.io.pictures import read_image, write_image
from weftex.io.presets import presets, read_preset
from weftex.raster.levels import to_stored


def written(maps, folder, preset, **how):
    """The pictures that a preset makes of maps, by what follows the material's name; the notes."""
    folder.mkdir(exist_ok=True)
    _, notes = write_preset(maps, folder, preset, name="m", **how)
    return {stem.split("m_", 1)[1]: one.pixels for stem, one in read_maps(folder).items()}, notes


def test_channels_of_every_engine(tmp_path):
    """As the pages of the engines say, which `docs/how-to/presets.md` names."""
    maps = whole_set()
    rough, metal, ao, height, opacity = (maps[name] for name in DATA)
    color, up = maps["color"], maps["normal_gl"]
    down = up * np.array([1, 0, 1], np.uint8) + (255 - up) * np.array([0, 1, 0], np.uint8)
    one, none = np.full_like(rough, 255), np.zeros_like(rough)
    orm, rgba = np.dstack([ao, rough, metal]), np.dstack([color, opacity])
    for preset, expected in {
        "godot": {"albedo": rgba, "normal": up, "orm": orm, "height": height},
        "terrain3d": {"alb_ht": np.dstack([color, height]), "nrm_rgh": np.dstack([up, rough])},
        "unity-urp": {
            "BaseColor": rgba, "Normal": up, "Height": height,
            "MetallicOcclusionSmoothness": np.dstack([metal, ao, none, 255 - rough]),
        },
        "unity-hdrp": {"BaseColor": rgba, "MaskMap": np.dstack([metal, ao, one, 255 - rough])},
        "unreal": {"BaseColor": rgba, "Normal": down, "ORM": orm},
        "gltf": {"baseColor": rgba, "normal": up, "occlusionRoughnessMetallic": orm},
        "threejs": {"color": rgba, "normal": up, "orm": orm, "displacement": height},
        "usd": {"color": rgba, "normal": up, "roughness": rough, "occlusion": ao},
        "blender": {"basecolor": color, "alpha": opacity, "normal": up, "displacement": height},
    }.items():  # fmt: skip
        found, _ = written(maps, tmp_path / preset, preset)
        for name, pixels in expected.items():
            assert np.array_equal(found[name], pixels), (preset, name)


@settings(max_examples=20, deadline=None)
@given(
    preset=st.sampled_from([name for name in sorted(presets()) if not read_preset(name).others]),
    deep=st.booleans(),
    seed=st.integers(0, 999),
    shape=st.tuples(st.integers(1, 7), st.integers(1, 7)),
)
def test_unpacked_maps_are_those_that_were_packed(tmp_path_factory, preset, deep, seed, shape):
    """Of 8 and of 16 bits, where the files of the preset hold these; names say the roles."""
    if read_preset(preset).material.startswith("materialx"):
        pytest.importorskip("MaterialX")
    deep = deep and all(file.bits == 16 for file in read_preset(preset).files)
    maps = whole_set(shape, np.uint16 if deep else np.uint8, seed)
    folder = tmp_path_factory.mktemp("packed")
    write_preset(maps, folder, preset, name="my_wall")
    found, notes = unpack_set(read_preset(preset), map_files(folder)[0])
    listed = {role for file in read_preset(preset).files for role in file.roles}
    wanted = {"gloss": "roughness", "normal_dx": "normal_gl"}
    assert found.keys() - {"detail"} == {wanted.get(role, role) for role in listed} & maps.keys()
    for role in found.keys() & maps.keys():
        assert found[role].pixels.dtype == maps[role].dtype
        assert np.array_equal(found[role].pixels, maps[role]), role
    assert notes == []
    if preset != "terrain3d":  # its names are of no role
        assert weftex.load_exemplar(folder).shape == shape


def test_what_is_filled_in_converted_or_left_out_is_said(tmp_path):
    light = np.linspace(0, 2, 24, dtype=np.float32).reshape(2, 4, 3)
    maps = {
        "color": light, "normal": normals((2, 4)), "gloss": noise((2, 4)),
        "height": noise((2, 4), np.uint16), "cavity": noise((2, 4)),
    }  # fmt: skip
    found, notes = written(maps, tmp_path / "a", "godot")
    stored = to_stored(light.clip(0, 1).astype(float))
    assert np.array_equal(found["albedo"], np.rint(stored * 255))
    assert np.array_equal(found["orm"][..., 1], 255 - maps["gloss"])
    assert (found["orm"][..., 0] == 255).all() and (found["orm"][..., 2] == 0).all()
    assert np.array_equal(found["height"], np.rint(maps["height"] / 257))
    assert notes == [
        "color has values from 0 to 2; values outside 0 to 1 are clipped",
        "color is rounded from floats to 8 bits",
        "normal is read as normals whose y points up; if it points down, name the map normal_dx",
        "ao is missing, so it is 1 everywhere in m_orm",
        "metallic is missing, so it is 0 everywhere in m_orm",
        "height is rounded from 16 to 8 bits",
        "cavity is left out: preset godot has no file for it",
    ]
    arm = noise((2, 4, 3))
    maps = {"height": maps["height"], "arm": arm, "base": noise((2, 4, 4))}
    roles = {"arm": "orm", "base": "color"}
    found, notes = written(maps, tmp_path / "b", "unity-hdrp", roles=roles)
    assert found["Height"].dtype == np.uint16
    assert np.array_equal(found["MaskMap"][..., [1, 3, 0]], arm ^ np.array([0, 255, 0], np.uint8))
    assert np.array_equal(found["BaseColor"], maps["base"])
    assert notes == ["detail is missing, so it is 1 everywhere in m_MaskMap"]
    found, notes = written({"color": maps["base"][..., :3], "height": maps["height"], "orm": arm},
                           tmp_path / "d", "blender")  # fmt: skip
    assert np.array_equal(found["metallic"], arm[..., 2]) and notes == []
    _, notes = written({"orm": arm, "normal_gl": normals((2, 4))}, tmp_path / "e", "terrain3d")
    assert "ao, metallic of orm is left out: preset terrain3d has no file for it" in notes
    signed = normals((2, 4)) / np.float32(127.5) - 1
    found, _ = written({"normal_gl": signed}, tmp_path / "c", "unreal")
    assert np.array_equal(found["Normal"][..., 1] / 257, 255 - normals((2, 4))[..., 1])


def test_maps_that_do_not_fit_are_refused_before_anything_is_written(tmp_path):
    good = whole_set()
    floats = {role: np.zeros((6, 9), np.float32) for role in DATA}
    for changed, preset, says in (
        ({"ao": noise((3, 9))}, "godot", "m_orm packs maps of unequal size (ao 9x3, roughness 9x6"),
        ({"normal_gl": noise((6, 9, 3))}, "unreal", "normal_gl is not a normal map"),
        ({"normal_gl": noise((6, 9))}, "unreal", "normal_gl has 1 channel;"),
        (
            {"ao": None, "orm": noise((6, 9))},
            "unreal",
            "orm has 1 channel, and orm packs ao, rough",
        ),
        ({"roughness": noise((6, 9, 3))}, "gltf", "its 3 channels differ; save it as gray"),
        ({"roughness": None}, "terrain3d", "roughness or gloss for m_nrm_rgh, but m has only"),
        ({"roughness": None}, "unity-urp", "gloss or roughness for m_MetallicOcclusion"),
        (dict.fromkeys(good) | {"cavity": noise((6, 9))}, "godot", "m has only cavity"),
        ({"height": floats["height"] + 2}, "godot", "height has values from 2 to 2"),
        ({"height": np.zeros((6, 9), np.int32)}, "godot", "height has dtype int32"),
        ({"height": np.zeros(6, np.uint8)}, "godot", "height has 1 dimensions"),
        ({"heigth": noise((6, 9))}, "godot", "did you mean 'height'"),
        ({}, "godto", "preset is 'godto'; did you mean 'godot'?"),
        ({}, "godot.tml", "a preset of your own is a .toml file"),
    ):
        maps = {key: one for key, one in (good | changed).items() if one is not None}
        refused(re.escape(says), write_preset, maps, tmp_path, preset, name="m")
    with pytest.raises(weftex.FileError, match="wall_normal.png"):
        (tmp_path / "wall_normal.png").mkdir()
        write_preset(good, tmp_path, "gltf", name="wall")
    assert [path.name for path in tmp_path.iterdir()] == ["wall_normal.png"]


OWN = """
about = "Mine"
bits = 8
[missing]
ao = 0.5
[[file]]
name = "{name}-nah"
format = "tif"
channels = ["ao", "height"]
[[file]]
name = "{name}-gloss"
channels = ["gloss"]
"""


def test_a_preset_of_ones_own(tmp_path):
    (tmp_path / "mine.toml").write_text(OWN)
    (tmp_path / "out").mkdir()
    maps = {"height": noise((4, 4)), "roughness": noise((4, 4), seed=1)}
    files, notes = write_preset(maps, tmp_path / "out", tmp_path / "mine.toml", name="a")
    assert files == ["a-nah.tif", "a-gloss.png"] and "ao is missing, so it is 0.5" in notes[0]
    nah = read_image(tmp_path / "out" / "a-nah.tif")
    assert np.array_equal(nah.pixels[..., 1], maps["height"]) and (nah.pixels[..., 0] == 128).all()


@pytest.mark.parametrize(
    "old, new, says",
    [
        ("bits = 8", "bit = 8", "the preset has the key 'bit'; did you mean 'bits'?"),
        ("bits = 8", "bits = 12", "bits is 12; it must be 8 or 16"),
        ("bits = 8", "bits = '8'", "bits is '8'; it must be a number"),
        ("bits = 8", "material = 'gltf'", 'must have format = "png"'),
        ("bits = 8", "others = '{name}_{role}'", "others is for presets that only rename"),
        ("ao = 0.5", "ao = 2", "missing.ao is 2; it must be a number from 0 to 1"),
        ("ao = 0.5", "aoo = 0", "no map has the role 'aoo'; did you mean 'ao'?"),
        ('"height"]', '"color", "height"]', "a file has 4 at most"),
        ('"gloss"]', '"height"]', "two channels hold 'height'"),
        ("{name}-gloss", "{name}-nah", "two files are named '{name}-nah'"),
        ("{name}-gloss", "../{name}", "it must be a file name without suffix"),
        ('"tif"', '"tga"', "format is 'tga'"),
        ('channels = ["gloss"]', "", "a [[file]] has no channels"),
        ("about", "about about", "is not TOML"),
    ],
)
def test_a_preset_with_a_fault(tmp_path, old, new, says):
    (tmp_path / "mine.toml").write_text(OWN.replace(old, new))
    message = r"mine\.toml: .*" + re.escape(says)
    refused(message, read_preset, tmp_path / "mine.toml", error=weftex.FileError)


def test_commands(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "wall").mkdir()
    maps = whole_set((24, 24))
    for role, pixels in maps.items():
        write_image(f"wall/{role}.png", pixels)
    assert weft_run("pack", "wall", "-o", "packed", "--preset", "unreal") == 0
    assert "map: T_packed_ORM.png holds ao, roughness, metallic\n" in capsys.readouterr().err
    assert weft_run("unpack", "packed", "-o", "again", "--preset", "unreal") == 0
    assert {k: v.pixels.tobytes() for k, v in read_maps("again").items()} == {
        role: pixels.tobytes() for role, pixels in maps.items()
    }
    assert weft_run("unpack", "packed/T_packed_ORM.png", "-o", "few", "--preset", "unreal") == 0
    assert sorted(read_maps("few")) == ["ao", "metallic", "roughness"]
    write_image("T_a_ORM.jpg", maps["color"])
    assert weft_run("unpack", "T_a_ORM.jpg", "-o", "jpeg", "--preset", "unreal") == 0
    orm = read_image("T_a_ORM.jpg").pixels
    assert np.array_equal(read_image("jpeg/roughness.png").pixels, orm[..., 1])
    words = ["--size", 32, "--seed", 1, "--method", "quilting", "--patch-size", 12]
    assert weft_run("synth", "wall", "-o", "more", *words, "--preset", "unity-hdrp") == 0
    made = weftex.synthesize("wall", 32, seed=1, method="quilting", patch_size=12)
    mask = read_maps("more")["more_MaskMap"].pixels
    assert np.array_equal(mask[..., 3], 255 - made.maps["roughness"])
    capsys.readouterr()
    write_image("packed/T_packed_ORM.png", maps["ao"])
    write_image("wall/T_other_ORM.png", maps["color"])
    for bad, says in (
        (["pack", "wall", "-o", "wall", "--preset", "godot"], "is an input; name another file"),
        (["pack", "wall", "-o", "new"], "--preset is missing; known: ambientcg, blender"),
        (["unpack", "packed", "-o", "new"], "--preset is missing"),
        (["unpack", "packed", "-o", "new", "--preset", "godot"], "files named {name}_albedo"),
        (["unpack", "packed", "-o", "new", "--preset", "ambientcg"], "only renames"),
        (["unpack", "pakced", "-o", "new", "--preset", "unreal"], "pakced: cannot read: No such"),
        (["unpack", "packed", "-o", "new", "--preset", "unreal"], "has 1 channels, and T_{name}_"),
        (["unpack", "a/T_a_ORM.png", "b/T_a_ORM.png", "-o", "new", "--preset", "unreal"],
         "two files have the same name"),
        (["unpack", "wall/T_other_ORM.png", "packed/T_packed_Height.png", "-o", "new", "--preset",
          "unreal"], "of several sets (other, packed)"),
        (["synth", "packed", "-o", "x.tif", "--size", "20000x20000", "--preset", "unreal"],
         "written block by block; only presets that rename work there"),
    ):  # fmt: skip
        assert says in fails(capsys, tmp_path, *bad), bad
