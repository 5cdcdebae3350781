"""The best of several seeds: which is kept, what is told, and that it can be made again."""

import math
import re

import numpy as np
import pytest

import weftex
from families import noise
from weftex.cli import main
from weftex.errors import CancelledError
from weftex.io.pictures import read_image, write_image
from weftex.quality.score import MapsScorer, Scorer

SAMPLE = weftex.load_exemplar("sample:pebbles").pixels[:72, :80]
QUILTING = {"method": "quilting", "patch_size": 20}


def test_the_best_by_score_and_broken_things_is_kept_and_can_be_made_again():
    exemplar = weftex.Exemplar(SAMPLE)
    best = weftex.synthesize(exemplar, 90, seed=11, best_of=4, threads=2, **QUILTING)
    each = {s: weftex.synthesize(exemplar, 90, seed=s, **QUILTING) for s in range(11, 15)}
    found = {str(s): weftex.assess(exemplar, made) for s, made in each.items()}
    scores = {seed: one.score for seed, one in found.items()}
    choices = {seed: one.score + 8 * math.log1p(one.broken) for seed, one in found.items()}
    about = best.provenance["best_of"]
    assert about["scores"] == scores and len(set(scores.values())) > 1
    kept = best.provenance["seed"]
    assert choices[str(kept)] == min(choices.values()) and scores[str(kept)] > min(scores.values())
    assert np.array_equal(best.image, each[kept].image)
    assert np.array_equal(best.source, each[kept].source)
    others = sorted(score for seed, score in scores.items() if seed != str(kept))
    assert about["told"] == (
        f"seed {kept} of 11 to 14, by score and broken features: score {scores[str(kept)]:.2f}, "
        f"the others {others[0]:.2f} to {others[-1]:.2f}"
    )


def test_of_equal_ones_the_first_is_kept():
    flat = np.full((40, 40, 3), 77, np.uint8)
    best = weftex.synthesize(flat, 50, seed=2**64 - 2, best_of=3, **QUILTING)
    assert best.provenance["seed"] == 2**64 - 2
    assert set(best.provenance["best_of"]["scores"]) == {str(2**64 - 2), str(2**64 - 1), "0"}


def test_what_cannot_be_judged_is_made_all_the_same(monkeypatch):
    monkeypatch.setattr("weftex.quality.score.weigh", lambda _: None)
    made = weftex.synthesize(noise((30, 30)), 30, seed=3, best_of=2)
    assert made.provenance["seed"] == 3
    assert made.provenance["best_of"]["told"] == "seed 3 of 3 to 4: too small to be judged"


def test_a_large_output_is_judged_by_its_middle():
    made = weftex.synthesize(SAMPLE, (40, 1100), seed=1, method="quilting")
    exemplar = weftex.Exemplar(SAMPLE)
    middle = weftex.assess(exemplar, made.image[:, 38:1062])
    assert MapsScorer(exemplar).rate(made).score == middle.score


def test_the_best_set_is_good_in_all_maps():
    """Of a sample in one color only its height tells what was cut: by the color all are alike."""
    exemplar = weftex.Exemplar(np.full((72, 80, 3), 90, np.uint8), maps={"height": SAMPLE[..., 0]})
    best = weftex.synthesize(exemplar, 90, seed=3, best_of=4, **QUILTING)
    each = [weftex.synthesize(exemplar, 90, seed=s, **QUILTING) for s in range(3, 7)]
    scorer = Scorer(exemplar.map("height"))
    heights = [scorer.rate(made.maps["height"]).score for made in each]
    assert best.provenance["seed"] == 3 + int(np.argmin(heights)) and len(set(heights)) == 4
    assert len({Scorer(exemplar).rate(made.image).score for made in each}) == 1
    left_out = exemplar.changed(weights={"height": 0})
    assert len(set(map(MapsScorer(left_out).rate, each))) == 1


def test_progress_counts_outputs_and_cancels_within_one():
    seen = []

    def callback(done, total, stage, preview):
        if stage == "outputs":
            seen.append((done, total))
            assert preview().shape == (120, 120, 3)
        return len(seen) < 9

    with pytest.raises(CancelledError):
        weftex.synthesize(SAMPLE, 120, seed=1, best_of=5, progress=callback, **QUILTING)
    assert {total for _, total in seen} == {5}


def test_the_command_and_the_pictures_of_debug(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    write_image("s.png", SAMPLE)
    words = ["synth", "s.png", "--size", "90", "--seed", "5", "--method", "quilting"]
    assert main([*words, "-o", "a.png", "--best-of", "2", "--debug", "how"]) == 0
    kept = re.search(
        r"best of: seed (\d) of 5 to 6, by score and broken features:", capsys.readouterr().err
    ).group(1)
    assert main([*words, "-o", "b.png", "--seed", kept, "--quiet"]) == 0
    assert np.array_equal(read_image("a.png").pixels, read_image("b.png").pixels)
    names = ["coordinates", "patches", "seams"]
    assert sorted(p.name for p in (tmp_path / "how").iterdir()) == [f"{n}.png" for n in names]
    made = weftex.synthesize(SAMPLE, 90, seed=int(kept), method="quilting")
    for name, what in zip(names, ["sources", *names[1:]], strict=True):
        assert np.array_equal(read_image(f"how/{name}.png").pixels, made.draw(what))
