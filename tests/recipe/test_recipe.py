"""One job as JSON, as a command, as Python and as a result: all of them say the same."""

import shlex
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from commands import weft_run
from families import noise
from strategies import cases
from weftex.errors import InvalidInputError
from weftex.io.pictures import read_image, write_image
from weftex.recipe import MATERIAL, TASKS, Recipe
from weftex.recipe.command_line import command_of
from weftex.recipe.declared import options_of
from weftex.recipe.opening import open_recipe
from weftex.recipe.script import python_of

SHARES = st.sampled_from([0.25, 0.5, 0.75])
COLOR = st.sampled_from([[255, 0, 9], [0, 7, 120], [4]])
#: Values of options in JSON, by kinds of values.
KINDS = {
    "int": st.integers(2, 8),
    "float": SHARES,
    "bool": st.booleans(),
    "size": st.lists(st.sampled_from([40, 56, 1024]), min_size=2, max_size=2),
    "picture": st.sampled_from(["hole.png", "my photo.png"]),
    "axes": st.sampled_from([True, "x", "y"]),
    "weights": st.sampled_from([{"height": 2.0}, {"ao": 0.5, "roughness": 1.0}]),
    "files": st.just({"color": "a.png", "height": "b.png"}),
    "colors": st.lists(COLOR, min_size=2, max_size=2, unique_by=str),
    "mixed": st.just({"#00ff00": [0, 1], "17": [1, 0]}),
    "map": st.sampled_from(["map.png", {}, {"direction": -90.0}, {"width": 0.25}]),
}  # fmt: skip
#: Of those whose kind allows more than is right.
NAMES = {
    "straighten": st.sampled_from(["", "8,0,0,8", "0,0,30,2,30,30,1,28"]),
    "best_of": st.integers(1, 16),
    "window": st.just([-10, 5, 20, 30]),
}
METHODS = [(None, {}), ("quilting", {"patch_size": 12, "tolerance": 0.2}),
           ("near-regular", {"lattice": [20.0, 0.0, -1.5, 20.25]})]  # fmt: skip


def value_of(option):
    if option.choices:
        return st.sampled_from(option.choices)
    return NAMES[option.name] if option.name in NAMES else KINDS[option.kind.name]


@st.composite
def recipes(draw):
    """JSON of any task; what excludes each other is in it too."""
    task = draw(st.sampled_from([*TASKS]))
    count = {"synth": 1, "tile": 1, "fill": draw(st.integers(1, 2)), "fuse": 2}[task]
    own = {name: draw(value_of(one)) for name, one in TASKS[task].options.items()
           if name == "map" or draw(st.booleans())}  # fmt: skip
    spec = {"path": "my sample.png"}
    for name in TASKS[task].material:
        if draw(st.booleans()) and not (name == "repeats" and task == "fill"):
            spec[name] = True if name == "repeats" else draw(value_of(MATERIAL[name]))
    others = {k: v for k, v in spec.items() if k != "maps"}
    method, parameters = draw(st.sampled_from(METHODS))
    own |= {"task": task, "method": method, "parameters": parameters}
    own["seed"] = draw(st.integers(0, 2**64 - 1))
    return own | {"materials": [spec, others][:count]}


def parsed(words):
    """The recipe of a command that is not run."""
    from weftex.cli.commands import tasks

    found = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(tasks, "run_and_report", lambda *_, **__: None)
        real = tasks.parse_task
        patch.setattr(tasks, "parse_task", lambda *a, **k: found.append(real(*a, **k)) or found[0])
        patch.setattr(tasks, "is_plane", lambda *_: False)
        assert weft_run(*words) == 0
    return found[0][1]


@cases(60)
@given(recipes())
def test_json_and_commands_are_read_again(given):
    try:
        recipe = Recipe.from_json(given, local=True)
    except InvalidInputError as error:
        assert "\n" not in str(error)
        return
    assert Recipe.from_json(recipe.as_json(), local=True) == recipe
    line = command_of(recipe)
    words = shlex.split(line)
    assert words[0] == "weftex" and "&&" not in words
    again = parsed([*words[1:], "--allow-huge"])
    assert again == recipe, line


@pytest.fixture
def pictures(tmp_path, monkeypatch):
    """A folder with samples, a photo, masks and a map of two labels, that is the current one."""
    monkeypatch.chdir(tmp_path)
    sample = noise((64, 72, 3))
    sample[30:38, 40:48] = 0  # a landmark
    write_image("sample.png", sample)
    light = np.linspace(0.2, 1, 96)[:, None]  # tones differ, so there is one to match
    write_image("photo.png", (noise((80, 96, 3), seed=1) * light).astype(np.uint8))
    hole, half = np.zeros((80, 96), np.uint8), np.zeros((64, 72), np.uint8)
    write_image("nothing.png", hole)
    hole[30:50, 40:60] = half[20:] = 255
    write_image("hole.png", hole)
    write_image("half.png", half)
    labels = np.zeros((40, 48, 3), np.uint8)
    labels[:, 20:] = (200, 10, 0)
    write_image("map.png", labels)
    clear = np.dstack([noise((50, 60, 3)), np.full((50, 60), 255, np.uint8)])
    clear[:, :15, 3] = 0
    write_image("clear.png", clear, alpha=True)
    write_image("second.png", noise((64, 72, 3), seed=5))
    return tmp_path


QUILTING = {"method": "quilting", "parameters": {"patch_size": 12}}
SAMPLE, PHOTO = {"path": "sample.png"}, {"path": "photo.png"}
MADE = {
    "several turned": {"materials": [SAMPLE | {"turn": "flip"}, {"path": "second.png",
                       "turn": "flip"}], "size": [40, 50], **QUILTING},
    "twice the sample": {"materials": [SAMPLE | {"straighten": "8,8,40,8,40,50,8,50"}],
                         **QUILTING},
    "part": {"materials": [SAMPLE | {"mask": "half.png", "repeats": True}], "size": [40, 40],
             "tileable": "x", **QUILTING},
    "alpha": {"materials": [{"path": "clear.png", "mask": "alpha"}], "size": [40, 40],
              "tileable": True, **QUILTING},
    "fit": {"materials": [SAMPLE], "size": [40, 50], "tileable": True, "fit": True,
            "method": "near-regular", "parameters": {"lattice": [9.0, 0.0, 0.0, 11.0]}},
    "guide": {"materials": [SAMPLE | {"turn": "half", "sample_width": 0.5}], "guide": "photo.png",
              "sample_guide": "second.png", "method": "ashikhmin"},
    "window": {"materials": [SAMPLE], "window": [60, 50, 30, 40], "period": [200, 300],
               **QUILTING},
    "landmarks": {"materials": [SAMPLE], "landmarks": "thin", "method": "graphcut"},
    "tile": {"task": "tile", "materials": [PHOTO | {"even_light": 1, "sample_width": 0.3,
                                                   "density": 250.0}],
             "axes": "y", "border": 8},
    "fill": {"task": "fill", "materials": [PHOTO, SAMPLE | {"repeats": True}], "mask": "hole.png",
             "overlap": 2, "method": "patch-sampling", "parameters": {"epsilon": 0.1}},
    "merged": {"task": "fuse", "materials": [SAMPLE, {"path": "second.png"}], "map": "map.png",
               "colors": [[0, 0, 0], [200, 10, 0]], "boundary": "merged", "belt_width": 12,
               "parameters": {"matches": 3, "seed_density": 2.0, "iterations": 1}},
}  # fmt: skip


@pytest.mark.parametrize("name", MADE)
def test_command_and_python_make_the_bytes_of_the_recipe(pictures, name):
    recipe = Recipe.from_json({"seed": 3, **MADE[name]}, local=True)
    job = open_recipe(recipe)
    made, commands = job.make(), command_of(recipe, "by_command.png").split(" && ")
    assert job.shape == made.shape
    *before, last = (shlex.split(one)[1:] for one in commands)
    for words in (*before, [*last, "--save-source", "source.npz"]):
        assert weft_run(*words, "--quiet") == 0, words
    assert np.array_equal(read_image("by_command.png").pixels, made.image)
    if recipe.task == "synth" and not recipe.materials[0].get("straighten"):
        maps = [spec["path"] for spec in recipe.materials]
        assert weft_run("replay", "source.npz", *maps, "-o", "replayed.png", "--quiet") == 0
        assert np.array_equal(read_image("replayed.png").pixels, made.image)
    exec(compile(python_of(recipe), "script", "exec"), {})
    assert Path("out.png").read_bytes() == Path("by_command.png").read_bytes(), python_of(recipe)


#: A command of each task, quick, and values that change its result or are refused.
BASE = {
    "synth": "synth sample.png -o OUT --size 40 --method quilting --patch-size 12",
    "tile": "tile photo.png -o OUT --method quilting --patch-size 12",
    "fill": "fill photo.png -o OUT --mask hole.png --method patch-sampling --patch-size 12",
    "fuse": "fuse sample.png second.png -o OUT --map map.png --method ashikhmin",
}
TRIED = {
    "--size": "44", "--tileable": "x", "--guide": "photo.png", "--sample-guide": "second.png",
    "--best-of": "4", "--window": "3,4,20,20", "--period": "300", "--border": "5",
    "--mask": "nothing.png", "--overlap": "3", "--match-tone": "", "--map": "gradient",
    "--colors": "#c80a00,#000000", "--mixed": "#000000=1+2", "--boundary": "merged",
    "--belt-width": "6", "--missing": "ao=1", "--maps": "color=sample.png", "--sample-mask":
    "half.png", "--straighten": "8,8,40,8,40,50,8,50", "--even-light": "3", "--turn": "half",
    "--tileable-sample": "", "--map-weights": "height=2", "--seed": "8", "--direction": "0",
    "--width": "0.5", "--landmarks": "remove", "--fit": "", "--sample-width": "7cm",
    "--density": "200px/m",
}  # fmt: skip


@pytest.mark.parametrize("task", TASKS)
def test_every_option_has_an_effect_or_is_refused(pictures, capsys, task):
    """With every task, those that have it and those that do not."""
    flags = sorted({option.flag for one in TASKS for option in options_of(one)})
    assert flags == sorted(TRIED)
    base = BASE[task].split()
    base[base.index("OUT")] = "a.png"
    assert weft_run(*base, "--seed", "7", "--quiet") == 0
    for flag in flags:
        words = [flag] + [TRIED[flag]] * bool(TRIED[flag])
        seed = [] if flag == "--seed" else ["--seed", "7"]
        base[base.index("-o") + 1] = "b.png"
        before = list(base)
        if flag in before:  # another value
            place = before.index(flag)
            del before[place : place + 2]
        capsys.readouterr()
        code = weft_run(*before, *seed, *words, "--quiet")
        said = capsys.readouterr().err
        if code == 0:
            assert Path("a.png").read_bytes() != Path("b.png").read_bytes(), (task, flag)
        else:
            assert code == 2 and said.count("\n") == 1, (task, flag, said)
            known = flag in [option.flag for option in options_of(task)]
            refused = f"{flag} has no effect on {task}" in said or flag == "--width"
            assert known or refused, said
