"""Sets of maps through every command: read by their names, written as they came or by a scheme."""

import numpy as np
import pytest

import weftex
from commands import fails, read_maps, weft_run
from families import noise
from weftex.io.pictures import read_image, write_image
from weftex.io.presets import read_preset
from weftex.roles import ROLES, role_of

ROCK = {
    "Rock01_1K_Color.png": noise((40, 48, 3)),
    "Rock01_1K_NormalGL.png": noise((80, 96, 3), seed=1),
    "Rock01_1K_Displacement.png": noise((40, 48), np.uint16, seed=2),
    "Rock01_1K_Roughness.png": noise((20, 24), seed=3),
}
MOSS = {
    "moss_basecolor.png": noise((44, 40, 3), seed=4),
    "moss_normal_dx.png": noise((88, 80, 3), seed=5),
    "moss_height.png": noise((44, 40), np.uint16, seed=6),
}


def write_set(folder, pictures):
    folder.mkdir()
    for name, pixels in pictures.items():
        write_image(folder / name, pixels, alpha=pixels.ndim == 3 and pixels.shape[2] == 4)


@pytest.fixture
def sets(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_set(tmp_path / "rock", ROCK)
    write_set(tmp_path / "moss", MOSS)
    (tmp_path / "rock" / "Rock01.mtlx").write_text("x")
    write_image("rock/Rock01.png", noise((30, 30, 3)))
    return tmp_path


def test_maps_that_are_there_and_stay_are_named(sets, capsys):
    assert weft_run("synth", "rock", "-o", "out/", "--size", 60, "--seed", 1) == 0
    assert "also has" not in capsys.readouterr().err
    write_image("out/old_normal.png", noise((9, 9, 3)))
    write_image("out/photo.png", noise((9, 9, 3)))  # of no role
    assert weft_run("synth", "rock", "-o", "out/", "--size", 60, "--seed", 1) == 0
    assert "note: out/ also has old_normal.png, which stay as they are\n" in capsys.readouterr().err


def test_synth_keeps_names_sizes_and_depths(sets, capsys):
    (sets / "out").mkdir()
    (sets / "out" / "notes.txt").write_text("mine")
    assert weft_run("synth", "rock", "-o", "out/", "--size", "60x52", "--seed", 1) == 0
    assert (sets / "out" / "notes.txt").read_text() == "mine"
    made = weftex.synthesize("rock", (52, 60), seed=1)
    out = read_maps("out")
    assert {stem: one.pixels.shape[:2] for stem, one in out.items()} == {
        "Rock01_1K_Color": (52, 60), "Rock01_1K_Displacement": (52, 60),
        "Rock01_1K_NormalGL": (104, 120), "Rock01_1K_Roughness": (26, 30),
    }  # fmt: skip
    assert np.array_equal(out["Rock01_1K_Color"].pixels, made.image)
    for stem, name in (("NormalGL", "normal_gl"), ("Displacement", "height")):
        assert np.array_equal(out[f"Rock01_1K_{stem}"].pixels, made.maps[name])
    err = capsys.readouterr().err
    assert "map: Rock01_1K_Displacement.png is height\n" in err
    assert "map: Rock01.png is ignored: it is a preview\n" in err
    message = fails(capsys, sets, "synth", "rock", "-o", "odd", "--size", "61x52")
    assert "map 'roughness' has a pixel for 2x2" in message and "61x52 must be multiples" in message


@pytest.mark.parametrize("scheme", ["ambientcg", "polyhaven", "substance", "weftex"])
def test_names_of_a_scheme_are_read_again(sets, capsys, scheme):
    words = ["synth", "rock", "-o", "wall", "--size", 40, "--method", "quilting"]
    words += ["--preset", scheme]
    assert weft_run(*words) == 0
    if scheme == "polyhaven":
        assert "map: wall_nor_gl.png holds normal_gl\n" in capsys.readouterr().err
    assert {role_of(stem).name for stem in read_maps("wall")} == {
        "color", "height", "roughness", "normal_gl"
    }  # fmt: skip
    for role in ROLES.values():
        assert role_of(read_preset(scheme).stem("wall", role)) == role


def test_several_sets_of_one_material(sets):
    write_set(sets / "more", {"a_color.png": noise((40, 40, 3)), "a_rough.png": noise((20, 20))})
    words = ["--size", 40, "--method", "quilting", "--patch-size", 10]
    assert weft_run("synth", "rock", "more", "-o", "out", *words) == 0
    assert sorted(read_maps("out")) == ["Rock01_1K_Color", "Rock01_1K_Roughness"]


def test_fuse_pairs_maps_by_role(sets, capsys):
    words = ["fuse", "rock", "moss", "--map", "gradient", "--size", 40, "--seed", 2]
    assert weft_run(*words, "-o", "both", "--save-source", "both.npz") == 0
    err = capsys.readouterr().err
    assert "map of moss: moss_normal_dx.png is normal_dx (y down)\n" in err
    assert "note: roughness is ignored: moss has no such map\n" in err
    out = read_maps("both")
    assert {stem: one.pixels.shape[:2] for stem, one in out.items()} == {
        "Rock01_1K_Color": (40, 40), "Rock01_1K_Displacement": (40, 40),
        "Rock01_1K_NormalGL": (80, 80),
    }  # fmt: skip
    made = weftex.fuse(["rock", "moss"], "gradient", 40, seed=2)
    assert np.array_equal(out["Rock01_1K_NormalGL"].pixels, made.maps["normal_gl"])
    # The green channel of the moss was turned over. (Noise is no normals, so its tones are joined.)
    made.tone_reach = 0.0
    normals = {tuple(v) for v in MOSS["moss_normal_dx.png"].reshape(-1, 3)}
    turned = made.maps["normal_gl"].reshape(-1, 3) * [1, -1, 1] + [0, 255, 0]
    assert sum(tuple(v) in normals for v in turned) > 1000
    assert weft_run("replay", "both.npz", "rock", "moss", "-o", "again") == 0
    assert {k: v.pixels.tobytes() for k, v in read_maps("again").items()} == {
        k: v.pixels.tobytes() for k, v in out.items()
    }


def test_fuse_gives_missing_maps_a_value(sets, capsys):
    words = ["fuse", "rock", "moss", "--map", "gradient", "--size", 40, "--seed", 2, "-o", "both"]
    assert weft_run(*words, "--missing", "roughness=0.8", "--quiet") == 0
    rough = read_maps("both")["Rock01_1K_Roughness"].pixels
    assert rough.shape == (20, 20) and (rough == 204).sum() > 50
    for given, says in (
        ("roughness=2", "from 0 to 1"),
        ("roughness=a", "must be maps and their values"),
        ("roughness=flat", "must be a number from 0 to 1"),
        ("height=0", "no sample lacks it; all samples have it"),
        ("rougness=0", "did you mean 'roughness'"),
    ):
        assert says in fails(capsys, sets, *words[:-1], "new", "--missing", given)
    write_image("moss/moss_roughness.png", noise((44, 40)))
    assert "scale one of them" in fails(capsys, sets, *words[:-1], "new")
    write_image("moss/moss_roughness.png", noise((22, 20), np.uint16))
    assert "save both in the same format" in fails(capsys, sets, *words[:-1], "new")


def test_fill_of_a_set_from_another(sets, capsys):
    mask = np.zeros((40, 48), np.uint8)
    mask[10:30, 12:34] = 255
    write_image("mask.png", mask)
    words = ["fill", "rock", "--mask", "mask.png", "--seed", 1]
    assert weft_run(*words, "-o", "own", "--quiet") == 0
    message = fails(capsys, sets, *words, "-o", "new", "--sample", "moss")
    assert "rock has maps, and the sample moss has no roughness to fill them with" in message
    write_image("moss/moss_rough.png", noise((22, 20)))
    assert weft_run(*words, "-o", "new", "--sample", "moss") == 0
    known, made = mask == 0, read_maps("new")
    for folder in ("own", "new"):
        found = {name: read_image(f"{folder}/{name}").pixels for name in ROCK}
        twice = known.repeat(2, 0).repeat(2, 1)
        half = known.reshape(20, 2, 24, 2).all(axis=(1, 3))
        for name, same in zip(ROCK, (known, twice, known, half), strict=True):
            assert np.array_equal(found[name][same], ROCK[name][same])
    assert made["Rock01_1K_Displacement"].pixels.dtype == np.uint16


def test_best_of_and_prepare_take_sets(sets):
    words = ["synth", "rock", "-o", "best", "--size", 48, "--best-of", 2, "--seed", 5]
    assert weft_run(*words, "--method", "quilting") == 0
    assert sorted(read_maps("best")) == sorted(name.removesuffix(".png") for name in ROCK)
    words = ["--even-light", "rock", "-o", "even", "--preset", "ambientcg"]
    assert weft_run("prepare", *words) == 0  # the folder is no value of the option before it
    normals = read_image("even/even_NormalGL.png").pixels
    assert np.array_equal(normals, ROCK["Rock01_1K_NormalGL.png"])
    assert weft_run("prepare", "rock", "-o", "flat", "--straighten", "30,1,-1,20") == 0
    shapes = {k: v.pixels.shape[:2] for k, v in read_maps("flat").items()}
    height, width = shapes["Rock01_1K_Color"]
    assert shapes["Rock01_1K_NormalGL"] == (2 * height, 2 * width)
    assert shapes["Rock01_1K_Roughness"] == (height // 2, width // 2)


def test_half_stays_half_and_alpha_straight(sets):
    color = noise((40, 48, 4))
    color[..., 3] = np.where(np.arange(48) < 20, 0, 255)
    color[:, :20, :3] = (255, 0, 0)  # red under what is clear
    color[:, 20:, 0] //= 4
    values = np.random.default_rng(1).random((40, 48)).astype(np.float16).astype(np.float32)
    (sets / "leaf").mkdir()
    write_image("leaf/leaf_color.png", color, alpha=True)
    write_image("leaf/leaf_height.exr", values, half=True)
    write_image("leaf/leaf_arm.png", noise((40, 48, 3)))
    words = ["--size", 64, "--seed", 1, "--method", "patch-sampling", "--patch-size", 16]
    assert weft_run("synth", "leaf", "-o", "more", *words) == 0
    made = read_image("more/leaf_height.exr")
    assert made.half and np.array_equal(made.pixels, made.pixels.astype(np.float16))
    out = read_image("more/leaf_color.png")
    assert out.alpha
    seen = out.pixels[..., 3] > 0
    assert seen.any() and (out.pixels[seen][:, 0] <= 64).all()  # no red bled into it


def test_what_has_no_effect_or_cannot_be(sets, capsys):
    write_image("one.png", noise((40, 40, 3)))
    write_set(sets / "dark", {"a_color.png": noise((40, 40, 3))})
    write_image("dark/a_height.exr", np.full((40, 40), np.nan, np.float32))
    (sets / "empty").mkdir()
    write_image("empty/a_color.png", noise((40, 40, 3)))
    (sets / "empty" / "a_height.png").touch()
    write_set(sets / "lods", {f"a_normal_LOD{k}.png": noise((40, 40, 3)) for k in range(3)})
    gradient = ["--map", "gradient", "--size", 40]
    for words, says in (
        (["synth", "one.png", "-o", "x.png", "--preset", "gltf"], "--preset needs a folder"),
        (["synth", "rock", "-o", "x", "--method", "quilting", "--effort", "best"], "--method auto"),
        (["synth", "rock", "-o", "x", "--preset", "unity"], "did you mean 'unity-urp'?"),
        (["synth", "one.png", "-o", "x.png", "--maps", "color=one.png"], "is not a folder"),
        (["synth", "rock", "-o", "x", "--maps", "color=Rock01.png,albedo=Rock01.png"], "two"),
        (["synth", "dark", "-o", "x"], "height contains NaN"),
        (["synth", "empty", "-o", "x"], "the file is empty"),
        (["synth", "lods", "-o", "x"], "two of its files are normal"),
        (["synth", "rock", "-o", "one.png"], "the output has several files; name a folder"),
        (["fuse", "rock", "moss", "-o", "x", *gradient, "--missing", "=1"], "each once"),
        (["replay", "rock", "rock", "-o", "x"], "rock"),
        (["report", "rock", "nowhere", "--json"], "nowhere"),
    ):
        assert says in fails(capsys, sets, *words), words


def test_pictures_of_one_name_are_not_written_over_each_other(sets, capsys):
    write_set(sets / "moss2", {"a.png": noise((40, 40, 3)), "a_ao.png": noise((40, 40))})
    write_image("a_ao.png", noise((40, 40, 3)))
    words = ["fuse", "a_ao.png", "moss2", "-o", "x", "--map", "gradient", "--size", 40]
    message = fails(capsys, sets, *words, "--missing", "ao=1")
    assert "would both be written to a_ao.png" in message


def test_report_of_a_set(sets, capsys):
    large = {
        "a_color.png": noise((64, 64, 3)),
        "a_normal_gl.png": noise((64, 64, 3)),
        "a_height.png": noise((128, 128), np.uint16),
        "a_ao.png": noise((32, 32)),
    }
    write_set(sets / "large", large)
    words = ["--size", 80, "--seed", 1, "--method", "quilting"]
    words += ["--preset", "ambientcg", "--quiet"]
    assert weft_run("synth", "large", "-o", "made", *words) == 0
    (sets / "made" / "made_AmbientOcclusion.png").unlink()
    assert weft_run("report", "large", "made", "-o", "page.html") == 0
    told = capsys.readouterr().out.splitlines()
    assert [line.split(":")[0] for line in told[1:]] == ["height", "normal_gl"]
    page = (sets / "page.html").read_text()
    assert "<h2>height</h2>" in page and "The result has no ao." in page
    found = weftex.pages.report("large", weftex.synthesize("large", 80, seed=1, method="quilting"))
    assert [*found.of_maps] == ["ao", "height", "normal_gl"]
    assert set(found.as_dict()["of_maps"]["ao"]) >= {"seams"}


def test_weights_of_maps(here, capsys):
    words = ["synth", "sample:stone_wall", "--method", "quilting", "--patch-size", "24"]
    words += ["--size", "120", "--seed", "1", "-o"]
    assert weft_run(*words, "b", "--map-weights", "height=9,ao=0") == 0
    sample = weftex.load_exemplar("sample:stone_wall")
    sample = sample.changed(weights={"height": 9, "ao": 0})
    made = weftex.synthesize(sample, 120, method=weftex.Quilting(patch_size=24), seed=1)
    assert np.array_equal(read_image("b/albedo.png").pixels, made.image)
    capsys.readouterr()
    words = ["synth", "sample:stone_wall", "-o", "c", "--map-weights", "heigt=2"]
    assert "did you mean 'height'" in fails(capsys, here, *words)
