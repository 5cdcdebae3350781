"""The orders in which patches are laid, and threads."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import weftex
import weftex.methods.patches.orders
from families import noise
from random_cases import AROUND
from weftex.methods.patches.orders import patch_starts, patches_around, spiral, wavefronts


@given(st.integers(1, 300), st.integers(2, 60), st.booleans(), st.data())
def test_patches_cover_an_axis_evenly(length, size, wrap, data):
    size = min(size, length)
    overlap = data.draw(st.integers(0 if size == 1 else 1, max(size // 2, 0)))
    if size - overlap < 1:
        return
    starts = patch_starts(length, size, overlap, wrap)
    assert starts[0] == 0 and starts == sorted(starts)
    if length > 1:
        assert len(set(starts)) == len(starts)
    ends = [*starts[1:], length] if wrap else starts[1:]
    steps = [b - a for a, b in zip(starts, ends, strict=False)]
    assert all(step <= size - overlap for step in steps)  # at least the overlap, so all covered
    assert max(steps, default=0) - min(steps, default=0) <= 1
    if not wrap:
        assert starts[-1] + size == max(length, size)
    fewer = len(starts) - 1
    if wrap and fewer > 1:
        assert fewer * (size - overlap) < length
    elif not wrap and fewer > 0:
        assert (fewer - 1) * (size - overlap) + size < length


@pytest.mark.parametrize("blend", ["feather", "cut"])
@pytest.mark.parametrize(
    "shape, size, overlap",
    [((203, 203), 8, 4), ((500, 203), 8, 2), ((5000, 45), 24, 4), ((45, 5000), 24, 4),
     ((403, 403), 20, 10), ((1800, 35), 12, 6)],
)  # fmt: skip
def test_threads_never_overtake_a_patch_that_overlaps(
    monkeypatch, rng, shape, size, overlap, blend
):
    """What threads may lay at once shares no pixel, and order is kept where patches do."""
    groups = []

    def note(*args, **more):
        for group in wavefronts(*args, **more):
            groups.append(group)
            yield group

    monkeypatch.setattr(weftex.methods.patches.orders, "wavefronts", note)
    method = weftex.PatchSampling(
        patch_size=size, boundary_width=overlap, epsilon=float("inf"), blend=blend
    )
    result = method.fit(weftex.Exemplar(noise((40, 40), rng=rng))).sample(shape, seed=1, threads=2)
    assert groups, "threads were not used"
    at = result.placements[:, :2].astype(int)
    columns = len(np.unique(at[:, 1]))
    when, piece = np.empty(len(at), int), np.empty(len(at), int)
    pieces = [(n, *one) for n, group in enumerate(groups) for one in group]
    for k, (n, row, first, last) in enumerate(pieces):
        when[row * columns + first : row * columns + last] = n
        piece[row * columns + first : row * columns + last] = k
    late = []
    for p in range(len(at)):
        earlier = np.arange(max(0, p - 4 * columns), p)
        touch = earlier[(np.abs(at[earlier] - at[p]) < size).all(axis=1)]
        wrong = (when[touch] > when[p]) | ((when[touch] == when[p]) & (piece[touch] != piece[p]))
        late += [(p, int(q)) for q in touch[wrong]]
    assert late == []


def test_patches_around_are_laid_earlier_under_any_wavefront():
    rows, columns = 20, 21
    around = patches_around(rows, columns)
    assert around.shape[0] == rows * columns
    for n, row in enumerate(around):
        i, j = divmod(n, columns)
        found = [divmod(k, columns) for k in row.tolist() if k >= 0]
        expected = [(i + a, j + b) for a, b in AROUND]
        assert found == [(a, b) for a, b in expected if a >= 0 and 0 <= b < columns]


@given(st.integers(1, 9), st.integers(1, 9), st.integers(0, 2**30))
def test_spirals_visit_each_cell_once_from_the_border_inwards(rows, columns, seed):
    cells = np.random.default_rng(seed).random((rows, columns)) < 0.7
    walked = list(spiral(cells))
    assert sorted(walked) == [tuple(c) for c in np.argwhere(cells).tolist()]
    if cells.all():
        depth = [min(y, x, rows - 1 - y, columns - 1 - x) for y, x in walked]
        assert depth == sorted(depth)
        steps = [abs(a - c) + abs(b - d) for (a, b), (c, d) in itertools.pairwise(walked)]
        assert all(step == 1 for step in steps)


def test_threads_are_really_used(monkeypatch, rng):
    """Or tests of threads would compare one thread with itself."""
    import concurrent.futures
    import threading

    seen = set()

    class Pool(concurrent.futures.ThreadPoolExecutor):
        def submit(self, work, *args, **more):
            def note(*a, **m):
                seen.add(threading.get_ident())
                return work(*a, **m)

            return super().submit(note, *args, **more)

    monkeypatch.setattr(concurrent.futures, "ThreadPoolExecutor", Pool)
    model = weftex.PatchSampling(patch_size=8, boundary_width=2).fit(
        weftex.Exemplar(noise((40, 40), rng=rng))
    )
    model.sample((500, 500), seed=1, threads=4)
    assert len(seen) > 1
    seen.clear()
    model.sample((500, 500), seed=1, threads=1)
    assert not seen
