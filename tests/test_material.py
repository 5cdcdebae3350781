"""Folders of maps as libraries and programs write them, and what is made of each file."""

from fractions import Fraction

import numpy as np
import pytest

import weftex
from families import noise, refused
from weftex.exemplar.material import read_material
from weftex.io.pictures import read_image, write_image
from weftex.roles import ROLES, Role

#: Folders by the convention that names their files: the files, and what each is taken for.
FOLDERS = {
    "ambientCG": {
        "Rock01_1K-PNG_Color.png": "color",
        "Rock01_1K-PNG_NormalGL.png": "normal_gl",
        "Rock01_1K-PNG_NormalDX.png": "normal_dx",
        "Rock01_1K-PNG_Displacement.png": "height",
        "Rock01_1K-PNG_AmbientOcclusion.png": "ao",
        "Rock01.png": None,
        "Rock01_PREVIEW.jpg": None,
        "Rock01_1K-PNG.mtlx": None,
        "Rock01_1K-PNG.blend": None,
        "Rock01_1K-PNG.usdc": None,
    },
    "Poly Haven": {
        "rock_wall_diff_4k.jpg": "color",
        "rock_wall_nor_gl_4k.exr": "normal_gl",
        "rock_wall_arm_4k.jpg": "orm",
        "rock_wall_disp_4k.png": "height",
    },
    "Megascans": {
        "tlrkcbjn_4K_Albedo.jpg": "color",
        "tlrkcbjn_4K_Normal.jpg": "normal",
        "tlrkcbjn_4K_Gloss.jpg": "gloss",
        "tlrkcbjn_Preview.png": None,
        "tlrkcbjn.json": None,
    },
    "plain": {"albedo.png": "color", "roughness.png": "roughness", "readme.txt": None},
}


def folder_of(folder, files, shape=(24, 24)):
    """Write small pictures of these names; other files get a word."""
    folder.mkdir()
    for seed, file in enumerate(files):
        if file.endswith((".png", ".jpg", ".exr")):
            dtype = np.float32 if file.endswith(".exr") else np.uint8
            write_image(folder / file, noise((*shape, 3), dtype, seed=seed))
        else:
            (folder / file).write_text("x")
    return folder


@pytest.mark.parametrize("which", FOLDERS)
def test_folders_of_every_convention(tmp_path, which):
    material = read_material(folder_of(tmp_path / "rock", FOLDERS[which]))
    roles = {file: role for file, role in FOLDERS[which].items() if role is not None}
    assert {name: role.name for name, role in material.roles.items()} == {
        name: name for name in roles.values()
    }
    for file, name in roles.items():
        expected = read_image(tmp_path / "rock" / file).pixels
        assert np.array_equal(material.pictures[name].pixels, expected)
    sample = material.exemplar()
    assert sample.name == "rock" and sample.role is ROLES["color"]
    assert set(sample.maps) == set(roles.values()) - {"color"}
    assert sample.roles == {name: ROLES[name] for name in sample.maps}
    told = material.told()
    assert len([line for line in told if "ignored: it is a preview" in line]) == sum(
        role is None and file.endswith(("g",)) for file, role in FOLDERS[which].items()
    )
    assert sum(line.endswith("is color, the main map") for line in told) == 1


def test_the_deeper_of_two_is_taken(tmp_path):
    folder = folder_of(tmp_path / "rock", ["color.png", "normal.jpg", "normal.png", "ao.png"])
    height = noise((24, 24), np.float32)
    for suffix, pixels in ((".png", noise((24, 24))), (".exr", height)):
        write_image(folder / f"height{suffix}", pixels)
    write_image(folder / "ao.exr", height, half=True)  # 11 bits
    write_image(folder / "ao.tif", noise((24, 24), np.uint16))
    material = read_material(folder)
    assert np.array_equal(material.pictures["height"].pixels, height)
    assert material.pictures["ao"].pixels.dtype == np.uint16
    assert [*material.notes] == [
        "ao.png is ignored: ao.exr has more bits",
        "ao.exr is ignored: ao.tif has more bits",
        "height.png is ignored: height.exr has more bits",
        "normal.jpg is ignored: normal.png is not a JPEG",
    ]
    write_image(folder / "color.bmp", noise((24, 24, 3)))
    refused("two images named 'color'; keep one", read_material, folder, error=weftex.FileError)


def test_the_bare_name_is_the_color_where_no_map_is(tmp_path):
    files = ["rock.png", "rock_normal.png", "rock_height.png", "rock_preview.png"]
    material = read_material(folder_of(tmp_path / "rock", files))
    assert material.main == "color" and [*material.roles] == ["color", "height", "normal"]
    assert [*material.notes] == ["rock_preview.png is ignored: it is a preview"]
    with pytest.raises(weftex.InvalidInputError, match=r"no map \(moss\)"):
        read_material(folder_of(tmp_path / "both", ["rock.png", "moss.png", "rock_ao.png"]))
    alone = read_material(folder_of(tmp_path / "one", ["rock_preview.png"]))
    assert [*alone.roles] == ["rock_preview"]


def test_maps_in_a_folder_of_textures(tmp_path):
    (tmp_path / "rock.blend").mkdir()
    (tmp_path / "rock.blend" / "rock.blend").write_text("x")
    folder_of(tmp_path / "rock.blend" / "textures", FOLDERS["Poly Haven"])
    material = read_material(tmp_path / "rock.blend")
    assert [*material.roles] == ["orm", "color", "height", "normal_gl"]
    assert "textures" in material.told()[-1]


def test_pictures_that_are_not_read_are_named(tmp_path):
    folder = folder_of(tmp_path / "rock", ["color.png", "normal.dds", "notes.psd", "a.txt"])
    assert [*read_material(folder).notes] == [
        "normal.dds is ignored: weftex does not read .dds",
        "notes.psd is ignored: weftex does not read .psd",
    ]


def test_maps_of_other_sizes(tmp_path):
    folder = folder_of(tmp_path / "rock", ["color.png"])
    pixels = {"normal": noise((72, 72, 3)), "roughness": noise((12, 12)), "ao": noise((24, 24))}
    for name, value in pixels.items():
        write_image(folder / f"{name}.png", value)
    sample = read_material(folder).exemplar()
    assert [sample.scale_of(name) for name in ("normal", "roughness", "ao")] == [
        Fraction(3), Fraction(1, 2), Fraction(1)
    ]  # fmt: skip
    assert sample.matching().shape == (24, 24, 8)
    blocks = pixels["normal"].reshape(24, 3, 24, 3, 3).mean((1, 3))
    assert np.array_equal(sample.aligned("normal"), np.rint(blocks))
    assert np.array_equal(sample.aligned("roughness")[::2, 1::2], pixels["roughness"])
    for shape in ((36, 36), (48, 24), (25, 24)):
        write_image(folder / "ao.png", noise(shape))
        size = f"map 'ao' is {shape[1]}x{shape[0]}, rock is 24x24"
        refused(size, read_material(folder).exemplar)


def test_packed_maps_have_no_alpha(tmp_path):
    folder = folder_of(tmp_path / "rock", ["color.png"])
    write_image(folder / "rock_MaskMap.png", noise((24, 24, 4)), alpha=True)
    write_image(folder / "emission.png", noise((24, 24, 4)), alpha=True)
    sample = read_material(folder).exemplar()
    assert not sample.map("mask_map").alpha and sample.map("emission").alpha
    plain = weftex.Exemplar(noise((9, 9)), maps={"orm": noise((9, 9, 4)), "x": noise((9, 9, 4))})
    assert not plain.map("orm").alpha and plain.map("x").alpha
    assert plain.roles["x"] == Role("x") and plain.roles["orm"].channels


def test_a_picture_alone_is_a_color_or_a_normal(tmp_path):
    for name, role in {
        "rusty_metal": "color",
        "wall_normal": "normal",
        "h_height": "height",
    }.items():
        write_image(tmp_path / f"{name}.png", noise((9, 9, 3)))
        assert weftex.load_exemplar(tmp_path / f"{name}.png").role.name == role


@pytest.mark.parametrize("method", ["quilting", "efros-leung"])
def test_maps_of_few_pixels_are_laid_at_their_own_size(method):
    ids = noise((16, 16))
    maps = {"id": ids, "roughness": noise((16, 16)), "normal": noise((64, 64, 3))}
    sample = weftex.Exemplar(noise((32, 32, 3)), maps=maps)
    result = weftex.synthesize(sample, (40, 46), method=method, seed=1)
    made = result.maps
    assert {name: pixels.shape[:2] for name, pixels in made.items()} == {
        "id": (20, 23), "roughness": (20, 23), "normal": (80, 92)
    }  # fmt: skip
    assert set(np.unique(made["id"])) <= set(np.unique(ids))
    full = result.render(ids.repeat(2, 0).repeat(2, 1))
    assert np.array_equal(made["id"], full[1::2, 1::2])
    part = result.render(sample.map("roughness"), window=(4, 6, 10, 20))
    assert np.array_equal(part, made["roughness"][2:7, 3:13])
    with pytest.raises(weftex.InvalidInputError, match="'roughness'.*multiples of 2"):
        result.render(sample.map("roughness"), window=(1, 0, 10, 20))
