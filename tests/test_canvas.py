"""The place to fill."""

import numpy as np
import pytest

import weftex
from families import refused
from weftex.canvas import MAX_PIXELS, Canvas, as_canvas
from weftex.errors import InvalidInputError

KNOWN, HOLE = np.zeros((4, 6, 3), np.uint8), np.ones((4, 6), bool)


def test_sizes():
    assert as_canvas(5).shape == (5, 5)
    assert as_canvas(np.int32(5)).shape == (5, 5)
    assert as_canvas((4, 6)).shape == (4, 6)
    assert as_canvas([4, 6]).shape == (4, 6)
    assert as_canvas(np.array([4, 6])).shape == (4, 6)
    assert Canvas(np.int64(4), 6).shape == (4, 6) and type(Canvas(np.int64(4), 6).height) is int
    canvas = Canvas(4, 6)
    assert as_canvas(canvas) is canvas


@pytest.mark.parametrize(
    "tileable, wrap",
    [(False, (False, False)), (True, (True, True)), ("x", (False, True)), ("y", (True, False))],
)
def test_wrapping(tileable, wrap):
    assert as_canvas((4, 6), tileable).wrap == wrap


def test_tileable_beside_a_canvas_is_refused():
    refused("give wrap to the Canvas", as_canvas, Canvas(4, 6), True)


def test_the_message_names_size_and_limit():
    refused(f"1048576x1048576 is more than {MAX_PIXELS}", Canvas, 2**20, 2**20)
    refused("height is -3; it must be an integer of 1 or more", Canvas, -3, 5)


def test_known_pixels_need_a_hole_and_a_method_needs_both():
    refused("known pixels need a hole", Canvas, 4, 6, known=KNOWN)
    model = weftex.PatchSampling(patch_size=2).fit(weftex.Exemplar(KNOWN))
    refused("a hole but no known pixels", model.sample, Canvas(4, 6, hole=HOLE))
    with pytest.raises(InvalidInputError, match="known is 6x4, the canvas is 6x5"):
        Canvas(5, 6, known=KNOWN, hole=np.ones((5, 6), bool))
    refused("leave origin out", Canvas, 4, 6, known=KNOWN, hole=HOLE, origin=(2, 3))
    refused("hole is 5x4", Canvas, 4, 6, known=KNOWN, hole=HOLE[:, :5])
    assert Canvas(4, 6, known=KNOWN, hole=HOLE.astype(np.uint8)).hole.dtype == bool


SAMPLE = np.random.default_rng(0).integers(0, 256, (24, 24, 3), np.uint8)


@pytest.mark.parametrize(
    "more, said",
    [
        ({"known": SAMPLE[:20, :20].astype(np.float32)}, "known pixels are float32"),
        ({"known": SAMPLE[:20, :20, :2]}, r"known pixels are uint8 \(2,\), the sample is"),
        *(({"known_from": at}, "the canvas must lie in the sample") for at in [(-1, 0), (0, 5)]),
    ],
)
def test_known_pixels_are_of_the_samples_kind_and_place(more, said):
    given = {"known": SAMPLE[:20, :20], "hole": np.eye(20, dtype=bool)} | more
    model = weftex.Quilting(patch_size=6).fit(SAMPLE)
    refused(said, model.sample, Canvas(20, 20, **given), seed=1)


def test_a_guide_is_a_picture_of_the_canvas_size():
    guide = np.zeros((4, 6, 3), np.float32)
    assert Canvas(4, 6, guide=guide).guide.shape == (4, 6, 3)
    assert Canvas(4, 6, guide=np.zeros((4, 6), np.uint8)).guide.shape == (4, 6)
    refused("guide is 6x5, the canvas is 6x4", Canvas, 4, 6, guide=np.zeros((5, 6), np.uint8))
    for bad, message in (
        (np.full((4, 6), -1), "guide has labels from -1 to -1; they must be from 0 to 65535"),
        (np.full((4, 6), np.nan), "guide contains NaN"),
        (np.zeros((4, 6), complex), "guide has dtype complex128"),
        (np.zeros((4, 6, 1, 1), np.uint8), "guide has 4 dimensions"),
    ):
        refused(message, Canvas, 4, 6, guide=bad)


def test_labels_may_be_whole_numbers_of_any_type():
    labels = np.array([[0, 300], [7, 0]])
    assert (Canvas(2, 2, guide=labels).guide == labels).all()
    assert Canvas(2, 2, guide=labels > 0).guide.tolist() == [[0, 1], [1, 0]]


def test_a_guide_is_of_the_kind_of_the_samples():
    """Labels by their colors, at any depth; pictures by dtype too."""
    labels = np.indices((8, 8))[0] // 4
    exemplar = weftex.Exemplar(np.zeros((8, 8, 3), np.uint8), guide=labels)
    for dtype in (np.uint8, np.uint16, np.int64, bool):
        Canvas(8, 8, guide=labels.astype(dtype)).check_guide(exemplar)
    for guide, message in (
        (labels + 1, "guide has the color 2, which the guide of sample lacks; .* has 0, 1"),
        (np.stack([labels] * 3, axis=2), r"guide is labels \(3,\), the guide of sample is"),
    ):
        refused(message, Canvas(8, 8, guide=guide).check_guide, exemplar)
    picture = np.arange(64, dtype=np.uint8).reshape(8, 8)
    exemplar = exemplar.changed(guide=picture)
    Canvas(8, 8, guide=picture[::-1]).check_guide(exemplar)
    with pytest.raises(InvalidInputError, match="dtype and channels must be equal"):
        Canvas(8, 8, guide=picture.astype(np.uint16)).check_guide(exemplar)
    refused("the guide of sample is 8x7, sample is 8x8", exemplar.changed, guide=picture[:7])


@pytest.mark.parametrize(
    "dtype, own, fix",
    [
        (np.uint8, np.uint16, "; multiply by 257 and make it uint16"),
        (np.uint16, np.uint8, "; multiply by 0.00389105 and make it uint8"),
        (np.uint8, np.float32, "; multiply by 0.00392157 and make it float32"),
        (np.float32, np.float64, "; multiply by 1 and make it float64"),
        (np.uint8, np.uint8, "$"),
    ],
)
def test_a_guide_of_another_kind_names_the_fix(dtype, own, fix):
    exemplar = weftex.Exemplar(np.zeros((4, 4, 3), own))
    channels = 4 if dtype == own else 3
    canvas = Canvas(4, 6, guide=np.zeros((4, 6, channels), dtype))
    name = np.dtype(dtype).name
    message = rf"guide is {name} \({channels},\), the sample is .*must be equal{fix}"
    refused(message, canvas.check_guide, exemplar)
    Canvas(4, 6, guide=np.zeros((4, 6, 3), own)).check_guide(exemplar)
    Canvas(4, 6).check_guide(exemplar)
