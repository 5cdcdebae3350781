"""Progress: counts, stages, previews and cancelling."""

import itertools

import numpy as np
import pytest

import weftex
from families import canvas_of, every, method_of, refused
from weftex.errors import CancelledError
from weftex.progress import Progress, counted, listening


def test_counts_and_passes_everything_on():
    seen = []
    progress = Progress(lambda *given: seen.append(given), 5, "patches", "preview")
    for steps in (1, 0, 4):
        progress.advance(steps)
    assert seen == [(done, 5, "patches", "preview") for done in (1, 1, 5)]


@pytest.mark.parametrize("answer", [None, True, 0, "", []])
def test_only_false_cancels(answer):
    for callback in (None, lambda *_: answer):
        progress = Progress(callback, 9, "patches", lambda: None)
        progress.advance(3)
        assert progress.done == 3
    progress = Progress(lambda *_: False, 9, "patches", lambda: None)
    refused("cancelled after 3 of 9 patches", progress.advance, 3, error=CancelledError)


SAMPLE = np.random.default_rng(1).integers(0, 256, (40, 40, 3), np.uint8)


@every("method", "kind", "way", kinds=("plain", "xy", "hole"))
def test_every_stage_counts_up_to_its_total(method, kind, way):
    canvas = canvas_of(kind, SAMPLE, (60, 50))
    seen, previews = [], []

    def callback(done, total, stage, preview):
        if stage not in WORK:  # of a part of the fit that waits until it is needed
            seen.append((done, total, stage))
            previews.extend([preview()] * (len(seen) in (1, 3)))

    model = method_of(method, way).fit(weftex.Exemplar(SAMPLE))
    # With more threads a small picture may be whole before it is looked at for the first time.
    result = model.sample(canvas, seed=1, progress=callback, threads=1)
    stages = [list(calls) for _, calls in itertools.groupby(seen, lambda call: call[1:])]
    for calls in stages:
        done = [d for d, _, _ in calls]
        assert done == sorted(done) and done[0] > 0
        assert done[-1] == calls[-1][1]
    for preview in previews:
        assert preview.shape[:2] == canvas.shape
        assert preview.dtype == np.uint8
    if kind != "hole":  # which one patch may fill at once
        assert not np.array_equal(previews[0], result.image)  # it shows a picture in the making
    # Nobody's listening changes nothing.
    assert np.array_equal(model.sample(canvas, seed=1).image, result.image)


@every("method", "way")
def test_each_method_can_be_cancelled(method, way):
    calls = []

    def callback(done, total, stage, preview):
        calls.append(done)
        return len(calls) < 3

    model = method_of(method, way).fit(weftex.Exemplar(SAMPLE))
    refused("cancelled", model.sample, (60, 50), seed=1, progress=callback, error=CancelledError)
    assert len(calls) == 3


def test_an_error_in_the_callback_comes_through_from_the_analysis_too():
    def callback(done, total, stage, preview):
        return 1 / (stage != "analysis")

    with pytest.raises(ZeroDivisionError):
        weftex.synthesize(SAMPLE, 60, seed=1, progress=callback)


def test_work_within_a_step_is_its_share():
    seen = []
    with listening(lambda *given: seen.append(given[:3])), counted(4, "outer") as step:
        step(1)
        with counted(2, "inner") as inner:
            inner(1)
        step(3)
    assert seen == [(percent, 100, "outer") for percent in (0, 25, 25, 37, 100)]
    with counted(1, "nobody listens") as step:
        step(1)


WORK = {
    "analysis": lambda sample: weftex.analyze(sample),
    "trees": lambda sample: weftex.WeiLevoy().fit(sample),
    "colors": lambda sample: weftex.ExactMatching().fit(sample),
    "similar pixels": lambda sample: weftex.Refinement().fit(sample),
}


@pytest.mark.parametrize("stage", WORK)
def test_analyses_and_fits_count_and_can_be_stopped(stage):
    sample = weftex.load_exemplar("sample:pebbles")
    seen = []
    with listening(lambda done, total, now, _: seen.append((now, done))):
        WORK[stage](sample)
    counts = [done for now, done in seen if now == stage]
    assert counts[0] == 0 and max(counts) > 0
    assert stage != "analysis" or counts == sorted(counts)
    sample = weftex.Exemplar(sample.pixels)  # nothing of it is known yet
    stopping = listening(lambda done, total, now, _: done == 0)
    with pytest.raises(CancelledError, match="cancelled after"), stopping:
        WORK[stage](sample)
