"""The score: what it orders, its twin, and which pictures it is defined for."""

import importlib.util
import sys
from pathlib import Path

import numpy as np
import pytest

import weftex
from weftex.exemplar import Exemplar
from weftex.quality.figures import FIGURES
from weftex.quality.score import WEIGHTS, Scorer, terms, weigh

ROOT = Path(__file__).parents[2]


def judged():
    """benchmarks/quality/judged/agreement.py as a module."""
    path = ROOT / "benchmarks" / "quality" / "judged" / "agreement.py"
    sys.path.insert(0, str(path.parent))  # it takes its tables from draw.py beside it
    spec = importlib.util.spec_from_file_location("agreement", path)
    module = importlib.util.module_from_spec(spec)
    sys.modules["agreement"] = module
    spec.loader.exec_module(module)
    return module


def scrambled(pixels, side, rng):
    """Blocks of the sample in another order, over twice its size."""
    blocks = [
        pixels[y : y + side, x : x + side]
        for y in range(0, pixels.shape[0] - side + 1, side)
        for x in range(0, pixels.shape[1] - side + 1, side)
    ]
    rows = [[blocks[k] for k in rng.integers(0, len(blocks), 2 * 192 // side)] for _ in range(8)]
    return np.concatenate([np.concatenate(row, axis=1) for row in rows], axis=0)


@pytest.mark.parametrize("name", ["bricks", "pebbles", "weave"])
def test_whole_is_better_than_scrambled(name, rng):
    sample = weftex.load_exemplar(f"sample:{name}").pixels[:192, :192]
    scorer = Scorer(Exemplar(sample))
    whole = weftex.synthesize(sample, 384, method="quilting", seed=1).image
    scores = [scorer.rate(one).score for one in (sample, whole, scrambled(sample, 48, rng))]
    assert scores == sorted(scores) and len(set(scores)) == 3


@pytest.mark.parametrize("name", ["pebbles", "wood"])
def test_variety_is_better_than_tiles(name):
    sample = weftex.load_exemplar(f"sample:{name}").pixels[:128, :128]
    scorer = Scorer(Exemplar(sample))
    tiled = scorer.windows(scorer.view(np.tile(sample[:64, :64], (4, 4, 1))))
    made = weftex.synthesize(sample, 256, method="quilting", seed=1).image
    varied = scorer.windows(scorer.view(made))
    assert varied["alike"] < 0.5 < 1 < tiled["alike"]
    assert varied["uneven"] < tiled["uneven"]


def test_the_nearest_windows_by_definition(rng):
    """The twin: every window of the picture beside every window of the sample."""
    sample = rng.integers(0, 256, (30, 33, 3), np.uint8)
    picture = rng.integers(0, 256, (27, 31, 3), np.uint8)
    picture[5:19, 4:22] = sample[8:22, 10:28]
    scorer, width = Scorer(Exemplar(sample)), 10
    found = scorer.windows(scorer.view(picture))

    def windows(of):
        return [
            ((y, x), (of[y : y + width, x : x + width].astype(int) >> scorer._shift).ravel())
            for y in range(of.shape[0] - width + 1)
            for x in range(of.shape[1] - width + 1)
        ]

    def apart(first, second):
        others = np.array([window for _, window in second])
        return np.array([((window - others) ** 2).mean(axis=1) for _, window in first])

    own, made = windows(sample), windows(picture)
    table = apart(made, own)
    nearest, source = table.min(axis=1), [own[k][0] for k in table.argmin(axis=1)]
    assert nearest[5 * 22 + 4] == 0 and source[5 * 22 + 4] == (8, 10)
    seen = 0.05 * sample.reshape(-1, 3).var(axis=0).mean() / 4**scorer._shift + 0.05
    usual = []
    for axis, side in ((0, 30), (1, 33)):
        first = [one for one in own if one[0][axis] + width <= side // 2]
        second = [one for one in own if one[0][axis] >= side - side // 2]
        halves = apart(first, second)
        usual.append(np.mean([*halves.min(axis=0), *halves.min(axis=1)]))
    nearest = nearest / (max(usual) + seen)
    assert found["worst"] == pytest.approx(np.quantile(nearest, 0.97), rel=1e-5)
    assert found["broken"] == pytest.approx(np.sqrt(nearest).mean(), rel=1e-5)

    def closeness(of):
        table = apart(of, of)
        for i, j in np.ndindex(table.shape):
            if max(abs(a - b) for a, b in zip(of[i][0], of[j][0], strict=True)) < width:
                table[i, j] = np.inf
        return -np.log(table.min(axis=1) + seen / 2).mean()

    assert found["alike"] == pytest.approx(max(0, closeness(made) - closeness(own) - 0.5), rel=1e-4)
    used = np.zeros((4, 4))
    even = np.zeros((4, 4))
    for count, places in ((used, source), (even, [at for at, _ in own])):
        for y, x in places:
            count[y * 4 // 21, x * 4 // 24] += 1 / len(places)
    seen = used > 0
    entropy = (used[seen] * np.log(used[seen] / even[seen])).sum()
    assert found["uneven"] == pytest.approx(entropy)


def test_the_score_is_the_weighted_sum_and_monotone():
    assert all(weight >= 0 for weight in WEIGHTS.values())
    figures = dict.fromkeys(WEIGHTS, 0.25)
    expected = sum(WEIGHTS[name] * value for name, value in terms(figures).items())
    assert weigh(figures) == pytest.approx(expected)
    for name in WEIGHTS:
        worse = {"lattice": 0.1, "seams": 2.0}.get(name, 0.5)
        assert weigh(figures | {name: worse}) > weigh(figures)
    assert weigh({}) is None and weigh({"worst": None}) is None


def test_the_tables_of_the_judged_pictures_belong_together():
    module = judged()
    ordered = module.pairs()
    assert len({(p.surface, one) for p in ordered for one in (p.better, p.worse)}) == 329
    agree = {name: share for name, share, _ in module.judges(ordered)}
    assert agree["all"] == pytest.approx(0.944, abs=1e-3)


def test_weights_and_agreement_are_those_of_the_judged_pictures():
    module = judged()
    ordered, figures = module.pairs(), module.known()
    more = module.sure(figures)
    fitted = module.fitted(figures, ordered + more)
    assert dict(zip(WEIGHTS, fitted, strict=True)) == pytest.approx(WEIGHTS, abs=0.006)
    programs = module.known("programs.csv"), module.pairs(module.table("programs.csv"))
    for name in module.MEASURED:
        agrees = module.agreement(name, *(programs if name == "broken" else (figures, ordered)))[0]
        if name in FIGURES:
            assert FIGURES[name].agrees == pytest.approx(agrees, abs=0.006)
            assert agrees >= 0.6 or name in (
                "seams",
                "sharpness",
            )  # which prove faults by construction
    assert module.share(module.left_out(figures, ordered, more)) > 0.79
    other = module.pairs(module.table("looks.csv"))  # nothing is fitted to these
    said = module.left_out(figures | module.known("looks.csv"), ordered, more, other)
    assert module.share(said) > 0.66 and module.share(said[abs(said) >= 1]) > 0.85
    spoiled = module.steps(figures, more) @ np.array(list(WEIGHTS.values()))
    assert module.share(spoiled) > 0.92
