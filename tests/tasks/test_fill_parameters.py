"""In a hole a parameter changes what lies there, or it is refused."""

import numpy as np
import pytest

import weftex
from families import refused
from parameters import idle
from weftex.registry import METHODS, supporting

Y, X = np.indices((48, 56))
HOLE = ((Y - 21) / 11) ** 2 + ((X - 27) / 14) ** 2 < 1
PHOTOS = [
    weftex.load_exemplar(f"sample:{name}").pixels[60:108, 60:116].copy()
    for name in ("pebbles", "bricks", "leaves")
]
PHOTOS.append(PHOTOS[-1] // 48 * 48)
#: The parameters beside which each other one is tried.
SETTINGS = {
    "patch-sampling": {"epsilon": 0.5},
    "refinement": {"iterations": 3},
    "wei-levoy": {"window_width": 5, "levels": 2},
}


def made(slug, given, photo):
    """What lies where, and what a method blends."""
    result = weftex.fill(photo, HOLE, method=slug, seed=3, threads=1, **given)
    return result.image.tobytes() + result.source.tobytes()


@pytest.mark.parametrize("slug", supporting("known"))
def test_a_parameter_has_an_effect_or_is_refused(slug):
    given = SETTINGS.get(slug, {})
    plain = [made(slug, given, photo) for photo in PHOTOS]

    def changes(more):
        pairs = zip(PHOTOS, plain, strict=True)
        return any(made(slug, more, photo) != before for photo, before in pairs)

    found = dict(idle(slug, given, changes))
    small = {"exact-matching": "levels", "refinement": "evenness"}  # one level, and little use
    found.pop(small.get(slug, ""), None)
    assert not found


def test_evenness_has_an_effect_in_a_large_hole():
    hole = np.pad(np.ones((72, 72), bool), ((24, 0), (24, 0)))
    photo = weftex.load_exemplar("sample:pebbles").pixels[:96, :96].copy()
    made = [weftex.fill(photo, hole, method="refinement", evenness=e, seed=3) for e in (0.0, 9.0)]
    assert (made[0].source != made[1].source).any()


@pytest.mark.parametrize(
    ("slug", "parameters"),
    [
        ("wei-levoy", {"start": "noise", "levels": 2, "window_width": 5}),
        ("exact-matching", {"init": "random", "repeat_distance": 3}),
    ],
)
def test_what_is_idle_in_a_hole_is_refused_by_task_and_model(slug, parameters):
    """Not where nothing is known, nor where it was settled and not chosen."""
    photo, (name, *_) = PHOTOS[0], parameters
    method = METHODS[slug](**parameters)
    said = f"{name} has no effect with known pixels"
    refused(said, weftex.fill, photo, HOLE, method=method, seed=1)
    canvas = weftex.Canvas(48, 56, known=photo, hole=HOLE)
    exemplar = weftex.Exemplar(photo, mask=~HOLE)
    refused(said, method.fit(exemplar).sample, canvas, seed=1)
    METHODS[slug]().fit(exemplar).sample(canvas, seed=1)
    everything = np.ones((20, 20), bool)
    weftex.fill(photo[:20, :20], everything, sample=photo, method=method, seed=1)
