"""Methods that copy single pixels: each step as their papers say it, by a plain search."""

from dataclasses import replace

import numpy as np

import weftex
from random_cases import centers_of, distances, random_canvas, random_cases, random_exemplar
from twins.windows import known_steps
from weftex import reference
from weftex.methods import refinement, wei_levoy
from weftex.methods.ashikhmin import Choice
from weftex.methods.exact_matching.matching import Matching
from weftex.search.pyramid_windows import window_offsets

# Coherent candidates: where the neighbors' sources continue, and the best of them (section 3).


def odd_case(rng):
    """A sample from a pixel on, an output, a window from a pixel on, and any seed."""
    exemplar = weftex.Exemplar(random_exemplar(rng, *rng.integers(1, 24, 2)).pixels)
    width = int(rng.choice([w for w in (1, 3, 5, 7) if w <= min(exemplar.shape)]))
    size, seed = tuple(rng.integers(1, 14, 2).tolist()), int(rng.integers(2**64, dtype="u8"))
    return exemplar, size, width, seed


@random_cases(40)
def test_ashikhmin_is_the_reference(rng):
    exemplar, size, width, seed = odd_case(rng)
    expected = reference.ashikhmin(exemplar.pixels, size, width, replacements=8, seed=seed)
    method = weftex.Ashikhmin(window_width=width, passes=1)
    assert np.array_equal(method.fit(exemplar).sample(size, seed=seed).source, expected.sources)


@random_cases(60)
def test_a_pixel_is_the_best_of_its_candidates(rng, monkeypatch):
    """On wrapped canvases, in holes, in later passes, of samples that tile or are masked."""
    exemplar = random_exemplar(rng, *rng.integers(14, 20, 2))
    canvas = random_canvas(rng, *rng.integers(2, 24, 2))
    half = int(rng.integers(1, 4))
    method = weftex.Ashikhmin(window_width=2 * half + 1, passes=int(rng.integers(1, 4)))
    holes = np.ones(canvas.shape, bool) if canvas.hole is None else canvas.hole
    pixel = tuple(rng.choice(np.argwhere(holes)).tolist())
    allowed, compared = {tuple(c) for c in centers_of(exemplar, half)}, []

    def choose(self, line, number, **how):
        """Choose the pixel alone, and compare it with what might have been chosen."""
        asked = np.flatnonzero(line == pixel[0] * canvas.width + pixel[1])
        if not len(asked):
            whole(self, line, number, **how)
            return
        growth, at = self.growth, int(asked[0])

        def place_of(index):
            return divmod(int(growth.windows.to_sample(index)), exemplar.shape[1])

        whole(self, line[:at], number, **how)
        pixels, done, source = (a.copy() for a in (growth.pixels, growth.done, growth.source))
        self.candidates.fill(-1)
        whole(self, line[at : at + 1], number, **how)
        start = canvas.hole is None and number == 0 and pixel[0] < half < canvas.height / 2
        wrap = canvas.wrap[0] or start, canvas.wrap[1]
        steps = known_steps(done, pixel, half, wrap)
        if canvas.hole is None and number == 0 and not any(canvas.wrap):
            assert (steps @ [100, 1] < 0).all()  # L-shaped
        found = {place_of(source[pixel])} if number > 0 else set()
        for dy, dx in steps:
            index = source[(pixel[0] + dy) % canvas.height, (pixel[1] + dx) % canvas.width]
            if index >= 0:
                v, u = np.subtract(place_of(index), (dy, dx))
                if exemplar.tileable:
                    v, u = v % exemplar.shape[0], u % exemplar.shape[1]
                found.add((int(v), int(u)) if (v, u) in allowed else None)
        places = [place_of(index) for index in self.candidates if index >= 0]
        assert found - {None} <= set(places) <= allowed
        random = 8 if None in found or not found else 0
        assert len(places) == len(found - {None}) + random
        apart = distances(exemplar, places, pixels, pixel, steps)
        chosen = places.index(place_of(growth.source[pixel]))
        assert apart[chosen] == apart.min()
        compared.append(chosen)
        whole(self, line[at + 1 :], number, **how)

    whole = Choice.choose
    monkeypatch.setattr(Choice, "choose", choose)
    method.fit(exemplar).sample(canvas, seed=int(rng.integers(2**32)))
    assert len(compared) >= method.passes


# Non-parametric sampling (section III.A); test_weighted_search.py has the windows drawn from.


@random_cases(20)
def test_efros_leung_is_the_reference(rng):
    exemplar, size, width, seed = odd_case(rng)
    given = {"tolerance": float(rng.choice([0, 0.1, 1]))}
    expected = reference.efros_leung(exemplar.pixels, size, window=width, seed=seed, **given)
    result = weftex.EfrosLeung(window_width=width, **given).fit(exemplar).sample(size, seed=seed)
    assert np.array_equal(result.source, expected.sources)


# Exact matching: the windows in the union of the neighbors' lists, and the best of them (4.2).


@random_cases(40)
def test_a_pixel_is_the_best_of_the_union_of_lists(rng, monkeypatch):
    """On wrapped canvases, in holes, of samples that tile or have unusable pixels."""
    exemplar = random_exemplar(rng, *rng.integers(14, 20, 2))
    canvas = random_canvas(rng, *rng.integers(7, 18, 2))
    half, tolerance = int(rng.integers(1, 4)), float(rng.choice([0, 0.02, 0.1]))
    method = weftex.ExactMatching(
        window_width=2 * half + 1, tolerance=tolerance, candidates=0, repeat_distance=0,
        **({"levels": 1, "init": "random"} if canvas.hole is None else {}),
    )  # fmt: skip
    holes = np.ones(canvas.shape, bool) if canvas.hole is None else canvas.hole
    pixel = tuple(rng.choice(np.argwhere(holes)).tolist())
    centers, compared = centers_of(exemplar, half), []

    def make(self, order, purpose):
        """Make the pixel alone, and compare it with the union."""
        sheet = self.sheet
        at = pixel[0] + sheet.top, pixel[1]
        asked = np.flatnonzero(order == at[0] * sheet.done.shape[1] + at[1])
        if not len(asked):
            whole(self, order, purpose)
            return
        whole(self, order[: asked[0]], purpose)
        steps = known_steps(sheet.done, at, half, sheet.wrap)
        if sheet.lists.causal:
            steps = steps[steps[:, 0] <= 0]  # where rows wrap, a row's end sees its beginning
        picture, latest = sheet.pixels.copy(), self.seen.max()
        whole(self, order[asked], purpose)
        colors, radius = sheet.lists.index.colors, sheet.lists.radius.max()
        union = np.zeros(len(centers), bool)
        for step in steps[abs(steps).max(axis=1) == 1]:
            y, x = (at + step) % picture.shape[:2]
            color = picture[y, x].astype(int)
            listed = (colors == color).all(axis=1).any()  # else the nearest color stands for it
            if not listed or (sheet.lists.causal and tuple(step) == (0, 1)):
                continue
            there = exemplar.pixels[tuple(((centers + step) % exemplar.shape).T)]
            union |= ((there - color) ** 2).sum(axis=1) <= radius
        flat = np.append(np.flatnonzero(self.seen > latest), sheet.source[at]).astype(np.int32)
        places = np.divmod(sheet.lists.windows.to_sample(flat), exemplar.shape[1])
        *listed, chosen = distances(exemplar, np.transpose(places), picture, at, steps).tolist()
        expected = distances(exemplar, centers[union], picture, at, steps).tolist()
        if chosen > 0:  # else the first one that equals the window may be taken
            assert {*expected} <= {*listed}  # of equal windows one stands for all
        assert chosen <= min(expected, default=chosen)
        compared.append(len(expected))
        whole(self, order[asked[0] + 1 :], purpose)

    whole = Matching.make
    monkeypatch.setattr(Matching, "make", make)
    method.fit(exemplar).sample(canvas, seed=int(rng.integers(2**32)))
    assert compared


# Iterative refinement with the nearest of all windows, pixel by pixel (section 3).


def order_of(hole, iteration, cyclic):
    """The pixels of an iteration: in scan order, or a hole's from its four sides (Fig. 12)."""
    pixels = np.argwhere(hole)
    if cyclic and iteration % 2:
        pixels = np.argwhere(hole.T)[:, ::-1]
    return pixels[::-1] if cyclic and iteration % 4 > 1 else pixels


@random_cases(20)
def test_each_pixel_takes_the_nearest_window(rng, monkeypatch):
    """On wrapped canvases, in holes, of samples that tile or have unusable pixels."""
    exemplar = random_exemplar(rng, *rng.integers(14, 20, 2))
    canvas = random_canvas(rng, *rng.integers(6, 12, 2))
    half, cyclic = int(rng.integers(1, 4)), canvas.hole is not None
    method = weftex.Refinement(
        search="nearest", init="seeds", window_width=2 * half + 1, threshold=0, seed_scale=4.0,
        iterations=int(rng.integers(1, 4)),
    )  # fmt: skip
    hole = np.ones(canvas.shape, bool) if canvas.hole is None else canvas.hole
    centers, compared = centers_of(exemplar, half), []

    def sweep_of(prepared, output, *given):
        outputs.append(output)
        return whole_sweep_of(prepared, output, *given)

    def refine_texture(sweep, iteration, progress):
        """Refine all pixels, and compare with a plain search for each."""
        output = outputs[-1]
        picture, done = output.pixels.copy(), output.done.copy()
        changed = whole(sweep, iteration, progress)
        wrap = canvas.wrap if cyclic or iteration == 0 else (True, True)
        for pixel in order_of(hole, iteration, cyclic):
            steps = known_steps(done, pixel, half, wrap)
            nearest = distances(exemplar, centers, picture, pixel, steps).argmin()
            place = centers[nearest] % exemplar.shape
            picture[tuple(pixel)], done[tuple(pixel)] = exemplar.pixels[tuple(place)], True
        compared.append(iteration)
        assert np.array_equal(output.pixels, picture)
        return changed

    outputs, whole_sweep_of, whole = [], refinement.sweep_of, refinement.refine_texture
    monkeypatch.setattr(refinement, "sweep_of", sweep_of)
    monkeypatch.setattr(refinement, "refine_texture", refine_texture)
    method.fit(exemplar).sample(canvas, seed=int(rng.integers(2**32)))
    assert compared


# Wei and Levoy's full search: the pixel with the nearest of all neighborhoods (section 2).


@random_cases(12)
def test_wei_levoy_is_the_reference(rng):
    exemplar = weftex.Exemplar(random_exemplar(rng, *rng.integers(28, 40, 2)).pixels)
    size, seed = tuple(rng.integers(8, 20, 2).tolist()), int(rng.integers(2**32))
    width, levels = int(rng.choice([5, 7])), int(rng.integers(1, 4))
    codewords = int(rng.choice([0, 0, 5, 20]))
    expected = reference.wei_levoy(exemplar.pixels, size, width, levels, 3, codewords, seed)
    several = {"start": "noise", "parent_width": 3} if levels > 1 else {}
    search = {"tree_size": codewords, "leaves": 1} if codewords else {"search": "full"}
    method = weftex.WeiLevoy(window_width=width, levels=levels, **several, **search)
    assert np.array_equal(method.fit(exemplar).sample(size, seed=seed).source, expected.sources)


@random_cases(40)
def test_a_pixel_has_the_nearest_neighborhood(rng, monkeypatch):
    """Causal in the first pass, else to all sides: on wrapped canvases, in holes, of masks."""
    exemplar = random_exemplar(rng, *rng.integers(14, 20, 2))
    canvas = random_canvas(rng, *rng.integers(8, 18, 2))
    half = int(rng.integers(1, 4))
    method = weftex.WeiLevoy(
        window_width=2 * half + 1, levels=1, search="full",
        passes=int(rng.integers(0, 2)),
    )  # fmt: skip
    holes = np.ones(canvas.shape, bool) if canvas.hole is None else canvas.hole
    pixel = tuple(rng.choice(np.argwhere(holes)).tolist())
    centers, compared = centers_of(exemplar, half), []

    def replace_by_nearest(level, step, trees, wrap, progress):
        """Replace the pixel alone, and compare it with all windows."""

        def part(places):
            whole(level, replace(step, places=places), trees, wrap, progress)

        (at,) = np.flatnonzero(step.places == pixel[0] * canvas.width + pixel[1]).tolist() or [-1]
        if at < 0:  # of the border alone
            part(step.places)
            return
        part(step.places[:at])
        steps = known_steps(level.done, pixel, half, wrap)
        own = {tuple(s) for s in window_offsets(2 * half + 1, step.causal).tolist()}
        assert len(own) == (2 * half * (half + 1) if step.causal else (2 * half + 1) ** 2 - 1)
        steps = np.array([s for s in steps.tolist() if tuple(s) in own]).reshape(-1, 2)
        picture = level.pixels.copy()
        part(step.places[at : at + 1])
        place = divmod(int(level.source[pixel]), exemplar.shape[1])
        chosen = distances(exemplar, [place], picture, pixel, steps)[0]
        compared.append(chosen)
        assert chosen <= distances(exemplar, centers, picture, pixel, steps).min()
        part(step.places[at + 1 :])

    whole = wei_levoy.replace_by_nearest
    monkeypatch.setattr(wei_levoy, "replace_by_nearest", replace_by_nearest)
    method.fit(exemplar).sample(canvas, seed=int(rng.integers(2**32)))
    assert compared
