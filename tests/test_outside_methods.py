"""A method of a package outside is found by its entry point, wherever methods are named."""

import os

import numpy as np
import pytest

from families import noise
from processes import ENVIRONMENT, run
from weftex.io.pictures import read_image, write_image

PACKAGE = '''
"""A texture method that is no part of weftex."""

from dataclasses import dataclass

import numpy as np

from weftex.method import Method, Model
from weftex.parameters import parameter
from weftex.results.synthesis import Synthesis


@dataclass(frozen=True)
class Shifted(Method):
    """The sample over and over, each time a little further to the left."""

    slug = "shifted"
    title = "Shifted repetition"
    paper = "Nobody (2026), Nowhere"
    supports = frozenset()

    shift: int = parameter(3, "how much further", low=0, high=9, unit="pixels")

    def fit_exemplar(self, exemplar):
        return ShiftedModel(self, exemplar)


class ShiftedModel(Model):
    def __init__(self, method, exemplar):
        self.method, self.exemplar = method, exemplar

    def make(self, canvas, seed, threads, progress):
        height, width = self.exemplar.shape
        y, x = np.indices(canvas.shape)
        x = x + y // height * self.method.shift + seed
        source = np.stack([y % height, x % width], axis=2)
        about = self.method.describe() | {"seed": seed}
        return Synthesis.from_source(canvas, source, self.exemplar, about)
'''


@pytest.fixture
def outside(tmp_path):
    """Environment and folder of a process that has the package, as pip would have left it."""
    site = tmp_path / "site"
    (site / "shifted_textures").mkdir(parents=True)
    (site / "shifted_textures" / "__init__.py").write_text(PACKAGE)
    facts = site / "shifted_textures-1.0.dist-info"
    facts.mkdir()
    (facts / "METADATA").write_text("Metadata-Version: 2.1\nName: shifted-textures\nVersion: 1.0\n")
    (facts / "entry_points.txt").write_text(
        "[weftex.methods]\n"
        "shifted = shifted_textures:Shifted\n"
        "quilting = shifted_textures:Shifted\n"  # one of ours, which stays ours
    )
    path = os.pathsep.join([str(site), ENVIRONMENT["PYTHONPATH"]])
    write_image(tmp_path / "sample.png", noise((20, 22, 3)))
    return {"env": ENVIRONMENT | {"PYTHONPATH": path}, "cwd": tmp_path}


def said(code, options):
    return run(code, **options).stdout


def weftex(words, options):
    return said(f"from weftex.cli import main\nassert main({words!r}) == 0", options)


def expected(shift, seed):
    y, x = np.indices((50, 50))
    return noise((20, 22, 3))[y % 20, (x + y // 20 * shift + seed) % 22]


def test_it_is_one_of_the_methods(outside):
    code = """
        import weftex

        assert "shifted" in weftex.METHODS and weftex.METHODS["shifted"].slug == "shifted"
        assert list(weftex.METHODS)[-1] == "shifted" and len(set(weftex.METHODS)) == 11
        print(weftex.METHODS["quilting"].__module__)
        result = weftex.synthesize("sample.png", 50, method="shifted", seed=5, shift=4)
        assert result.provenance["shift"] == 4
        weftex.write_image("out.png", result.image)
        try:
            weftex.synthesize("sample.png", 50, method="shiftet")
        except weftex.InvalidInputError as error:
            print(error)
    """
    ours, unknown = said(code, outside).splitlines()
    assert ours == "weftex.methods.quilting"
    assert "did you mean 'shifted'" in unknown
    made = read_image(outside["cwd"] / "out.png").pixels
    assert np.array_equal(made, expected(4, 5))


def test_the_command_line_has_it(outside):
    assert "Shifted repetition" in weftex(["methods"], outside)
    about = weftex(["methods", "shifted"], outside)
    assert "Nobody (2026), Nowhere" in about and "--shift\n    how much further\n" in about
    assert "--shift" in weftex(["synth", "--help", "--method", "shifted"], outside)
    words = ["synth", "sample.png", "-o", "out.png", "--size", "50", "--seed", "5"]
    weftex([*words, "--method", "shifted", "--shift", "2"], outside)
    made = read_image(outside["cwd"] / "out.png").pixels
    assert np.array_equal(made, expected(2, 5))
