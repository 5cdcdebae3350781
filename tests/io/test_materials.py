"""Materials of presets, judged by the validators of their formats: glTF, USD, MaterialX."""

import json
import shutil
import struct
import subprocess

import numpy as np
import pytest

from families import noise
from io_sets import normals, whole_set
from weftex import UnsupportedError
from weftex.io.packing import write_preset
from weftex.io.pictures import Picture

VALIDATOR = "gltf-validator@2.0.0-dev.3.10"
SCRIPT = """
const { validateBytes } = require("gltf-validator");
const bytes = new Uint8Array(require("fs").readFileSync(process.argv[2]));
validateBytes(bytes).then((found) => console.log(JSON.stringify(found)));
"""
SETS = {"all": whole_set((8, 8)), "few": {"color": noise((8, 8, 3)), "normal_dx": normals((8, 8))}}


@pytest.fixture(scope="module")
def validate(tmp_path_factory):
    """What the Khronos validator finds in a file."""
    if shutil.which("npm") is None:
        pytest.skip("the glTF validator needs npm")
    folder = tmp_path_factory.mktemp("npm")
    install = ["npm", "install", "--no-audit", "--no-fund", "--prefix", str(folder), VALIDATOR]
    done = subprocess.run(install, capture_output=True, text=True, timeout=120, check=False)
    if done.returncode:
        pytest.skip(f"npm cannot install the glTF validator: {done.stderr[-200:]}")
    (folder / "validate.cjs").write_text(SCRIPT)

    def run(file):
        words = ["node", str(folder / "validate.cjs"), str(file)]
        return json.loads(subprocess.run(words, capture_output=True, check=True).stdout)

    return run


@pytest.mark.parametrize("maps", SETS)
def test_gltf(tmp_path, validate, maps):
    files, _ = write_preset(SETS[maps], tmp_path, "gltf", name='a "wall"')
    assert files[-1] == 'a "wall".glb'
    found = validate(tmp_path / files[-1])
    assert found["issues"]["messages"] == []
    assert found["info"]["resources"][0]["mimeType"] == "application/gltf-buffer"
    pictures = found["info"]["resources"][1:]
    assert [one["image"]["width"] for one in pictures] == [8] * (len(files) - 1)
    data = (tmp_path / files[-1]).read_bytes()
    (length,) = struct.unpack("<I", data[12:16])
    (material,) = json.loads(data[20 : 20 + length])["materials"]
    packed = "metallicRoughnessTexture" in material["pbrMetallicRoughness"]
    assert packed == (maps == "all") == ("occlusionTexture" in material)
    assert material.get("alphaMode") == ("BLEND" if maps == "all" else None)


def test_planes_have_the_size_of_the_material(tmp_path):
    """In meters: of the pixels per meter that a file states, else one meter high."""
    wide = Picture(noise((8, 16, 3)), False, None, "a.png", density=32.0)
    for color, size in ((wide, (0.5, 0.25)), (wide.pixels, (2, 1))):
        write_preset({"color": color}, tmp_path, "gltf", name="a")
        data = (tmp_path / "a.glb").read_bytes()
        (length,) = struct.unpack("<I", data[12:16])
        points = json.loads(data[20 : 20 + length])["accessors"][0]
        assert points["max"] == [size[0] / 2, size[1] / 2, 0] == [-k for k in points["min"]]
        write_preset({"color": color}, tmp_path, "usd", name="a")
        low, high = (f"({k * size[0]:g}, {k * size[1]:g}, 0)" for k in (-0.5, 0.5))
        assert f"extent = [{low}, {high}]" in (tmp_path / "a.usda").read_text()


@pytest.mark.parametrize("suffix", ["usda", "usdz"])
@pytest.mark.parametrize("maps", SETS)
def test_usd(tmp_path, maps, suffix):
    pxr = pytest.importorskip("pxr.UsdValidation", reason="needs the extra 'formats'")
    from pxr import Sdr, Usd, UsdShade

    files, _ = write_preset(SETS[maps], tmp_path, "usd", name="2 walls")
    assert files[-2:] == ["2 walls.usda", "2 walls.usdz"]
    stage = Usd.Stage.Open(str(tmp_path / f"2 walls.{suffix}"))
    checks = pxr.ValidationRegistry().GetOrLoadAllValidators()
    assert len(checks) > 10
    found = pxr.ValidationContext(checks).Validate(stage)
    assert [(one.GetName(), one.GetMessage()) for one in found] == []
    material = UsdShade.Material.Get(stage, "/Root/_2_walls")
    surface = material.ComputeSurfaceSource()[0]
    known = Sdr.Registry().GetShaderNodeByIdentifier(surface.GetShaderId())
    assert {one.GetBaseName() for one in surface.GetInputs()} <= {*known.GetShaderInputNames()}
    shown = {}
    for each in surface.GetInputs():
        texture = UsdShade.Shader(each.GetConnectedSources()[0][0].source)
        shown[each.GetBaseName()] = texture.GetInput("file").Get().resolvedPath
    places = {"usda": "{}", "usdz": "2 walls.usdz[{}]"}
    assert {str(tmp_path / places[suffix].format(one)) for one in files[:-2]} == {*shown.values()}
    assert ("opacity" in shown) == (maps == "all") and "normal" in shown
    mesh = stage.GetPrimAtPath("/Root/Plane")
    assert UsdShade.MaterialBindingAPI(mesh).ComputeBoundMaterial()[0].GetPath() == (
        material.GetPath()
    )


@pytest.mark.parametrize("preset", ["materialx", "materialx-hextiled"])
@pytest.mark.parametrize("maps", SETS)
def test_materialx(tmp_path, maps, preset):
    mx = pytest.importorskip("MaterialX")
    light = {"emission": np.ones((8, 8, 3), np.float32), "sheen": noise((8, 8))}
    files, _ = write_preset(SETS[maps] | light, tmp_path, preset, name="2 walls")
    document, library = mx.createDocument(), mx.createDocument()
    mx.readFromXmlFile(document, str(tmp_path / "2 walls.mtlx"))
    mx.loadLibraries(mx.getDefaultDataLibraryFolders(), mx.getDefaultDataSearchPath(), library)
    nodes = document.getNodes()
    document.setDataLibrary(library)
    assert document.validate() == (True, "")
    assert all(node.getNodeDef() is not None for node in nodes)
    shown = {node.getInputValue("file") for node in nodes} - {None}
    assert shown == set(files[:-1]) and len(document.getMaterialNodes()) == 1
    spaces = {
        node.getInputValue("file"): node.getInput("file").getColorSpace()
        for node in nodes
        if node.getInput("file") is not None
    }
    assert spaces["2 walls_color.png"] == "srgb_texture"
    assert spaces["2 walls_emission.exr"] == "lin_rec709"
    assert spaces["2 walls_normal.png"] == spaces["2 walls_sheen.png"] == ""
    kinds = {node.getCategory() for node in nodes}
    assert ("hextiledimage" in kinds) == (preset == "materialx-hextiled") != ("image" in kinds)


def test_materialx_that_is_not_installed(tmp_path, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "MaterialX", None)
    with pytest.raises(UnsupportedError, match="pip install 'MaterialX>="):
        write_preset(SETS["few"], tmp_path, "materialx")
    assert not any(tmp_path.iterdir())
