"""What a method is: a frozen dataclass of parameters that knows its ranges and what it supports."""

from __future__ import annotations

import dataclasses
import itertools
from abc import ABC, abstractmethod
from collections.abc import Iterator
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from weftex.canvas import CANVAS_KINDS, CANVAS_NAMES, Canvas, as_canvas
from weftex.endless.boxes import A_BLOCK, Box, PlaneRequest, as_period, box_of, canvas_of
from weftex.endless.grid import Sizes
from weftex.errors import InvalidInputError, UnsupportedError, did_you_mean, is_whole, wrong_value
from weftex.exemplar import Exemplar, Sample, load_exemplar
from weftex.parameters import checked_value, numbers_of
from weftex.progress import ProgressCallback, listening
from weftex.random import seed_number
from weftex.raster.arrays import Mask
from weftex.registry import supporting
from weftex.results.synthesis import Synthesis
from weftex.threads import in_turn, thread_count

__all__ = ["Method", "Model"]


class Model(ABC):
    """A fitted method, as `Method.fit` returns it. It never changes; threads can share it.

    Attributes
    ----------
    exemplar : Exemplar
        The sample that was fitted.
    method : Method
        The method with every parameter chosen; see `Method.resolved`.
    asked : Method or None
        The method on which `fit` was called.
    """

    exemplar: Exemplar
    method: Method
    asked: Method | None = None

    def __repr__(self) -> str:
        return f"<{type(self).__name__} of {self.exemplar!r} for {self.method!r}>"

    def sample(
        self,
        size: Canvas | int | tuple[int, int],
        *,
        seed: int | np.random.Generator | None = None,
        tileable: bool | str = False,
        threads: int | None = None,
        progress: ProgressCallback | None = None,
    ) -> Synthesis:
        """Make an output.

        Parameters
        ----------
        size : Canvas, int or (int, int)
            Height and width of the output, or a Canvas.
        seed : int, numpy Generator or None
            The same seed gives the same bytes, with any number of threads.
        tileable : bool or {"x", "y"}
            Axes along which the output repeats without a seam.
        threads : int, optional
            Maximum number of threads; one for each processor by default.
        progress : callable, optional
            See `weftex.progress.ProgressCallback`.

        Raises
        ------
        UnsupportedError, InvalidInputError
            If the method cannot make such an output; if a parameter has no effect on it.
        CancelledError
            If `progress` returned False.
        """
        canvas = as_canvas(size, tileable)
        self.require(canvas)
        with listening(progress):
            return self.make(canvas, seed_number(seed), thread_count(threads), progress)

    @abstractmethod
    def make(
        self, canvas: Canvas, seed: int, threads: int, progress: ProgressCallback | None
    ) -> Synthesis:
        """Make one output, such as by `Synthesis.from_source`; arguments are already checked."""

    def require(self, canvas: Canvas) -> None:
        """Refuse a canvas that the method does not do, or on which a chosen parameter is idle."""
        (self.asked or self.method).require(canvas)

    def samples(
        self,
        count: int | None,
        size: int | tuple[int, int],
        *,
        seed: int | np.random.Generator | None = None,
        tileable: bool | str = False,
        channels_first: bool = False,
        threads: int | None = None,
    ) -> Iterator[NDArray[Any]]:
        """Yield many images, such as for training.

        Parameters
        ----------
        count : int or None
            Number of images; None for no end.
        size, tileable
            As for `sample`.
        seed : int, numpy Generator or None
            Image k equals that of `sample` with `seed` + k.
        channels_first : bool
            Yield (C, H, W), as PyTorch takes images, instead of (H, W, C); gray images are
            (1, H, W) then.
        threads : int, optional
            Maximum number of images made at the same time, each in one thread.

        Yields
        ------
        array
            In the sample's dtype, contiguous.

        Examples
        --------
        >>> import weftex
        >>> model = weftex.PatchSampling().fit("sample:pebbles")
        >>> [one.shape for one in model.samples(2, 64, seed=1, channels_first=True)]
        [(3, 64, 64), (3, 64, 64)]
        """
        if count is not None and not is_whole(count, 0):
            raise wrong_value("count", count, "0 or more, or None")
        first, at_once = seed_number(seed), thread_count(threads)
        canvas = as_canvas(size, tileable)

        def one(k: int) -> NDArray[Any]:
            image = self.sample(canvas, seed=(first + k) % 2**64, threads=1).image
            planes = np.moveaxis(np.atleast_3d(image), -1, 0)
            return np.ascontiguousarray(planes) if channels_first else image

        return in_turn(one, range(count) if count is not None else itertools.count(), at_once)

    def window(
        self,
        top: int,
        left: int,
        height: int,
        width: int,
        *,
        seed: int | np.random.Generator | None = None,
        period: int | tuple[int, int] | None = None,
        threads: int | None = None,
        progress: ProgressCallback | None = None,
    ) -> Synthesis:
        """Make a part of an endless plane.

        Every pixel depends only on the sample, the parameters, the seed and its position.

        Parameters
        ----------
        top, left : int
            First row of the part, from -2**40 to 2**40; first column, in the same range.
        height, width : int
            Number of rows of the part; number of columns.
        seed : int, numpy Generator or None
            Seed of the plane: give the same one for each part.
        period : int or (int, int), optional
            Number of pixels after which the plane repeats, down and across, up to 2**40.
        threads, progress
            As for `sample`.

        Raises
        ------
        UnsupportedError
            If the method cannot make parts of a plane, or not with a period.
        InvalidInputError
            If the period is too short for the method.

        Examples
        --------
        >>> import weftex
        >>> model = weftex.GraphCut().fit("sample:pebbles")
        >>> far = model.window(2**39, -7, 60, 80, seed=7).image
        >>> bool((model.window(2**39 + 9, 3, 40, 50, seed=7).image == far[9:49, 10:60]).all())
        True
        """
        if "known" in self.method.supports:  # blocks fill what is between others
            self.require(A_BLOCK)
        else:
            self.method.require_kind("random_access")
        canvas = Canvas(height, width, origin=(top, left))
        asked = PlaneRequest(seed_number(seed), as_period(period), thread_count(threads))
        with listening(progress):
            return self.make_window(box_of(*canvas.origin, *canvas.shape), asked, progress)

    def make_window(self, box: Box, asked: PlaneRequest, progress: Any = None) -> Synthesis:
        """Make what `window` asks for, in a way of the method's own or as here: by blocks."""
        from weftex.endless.plane import Plane  # threads and futures: only when needed

        return Plane(self, asked).window(box, canvas_of(box), progress)

    def block_sizes(self) -> Sizes:
        """Return the sizes of the blocks that a plane is made of, by the method's window."""
        belt = 2 * max(self.method.window_for(0), 24)
        return Sizes(pitch=4 * belt, belt=belt)

    def start_of(self, box: Box, asked: PlaneRequest) -> NDArray[np.int32] | None:
        """Return what blocks of a plane begin with, as flat indices (H, W); None for nothing."""
        return None


@dataclasses.dataclass(frozen=True)
class Method(ABC):
    """Base of all methods: a frozen dataclass whose fields are parameters.

    A method of your own sets `slug`, its name; `title`; and `paper`, its reference. `supports`, by
    default empty, may contain "wrap" (tileable output) and "guide". Methods of weftex also have
    "known" (holes), "many" (several samples) and "random_access" (parts of planes).

    Raises
    ------
    InvalidInputError
        If a parameter is unknown, or a value of the wrong type, out of its bounds, or without
        effect.
    """

    slug: ClassVar[str]
    title: ClassVar[str]
    paper: ClassVar[str]
    supports: ClassVar[frozenset[str]] = frozenset()
    cuts_known: ClassVar[bool] = False  # whether it can cut its patches into a covered canvas
    #: Parameters of `for_belt`, which have an effect on belts even where regions take none.
    belt_parameters: ClassVar[frozenset[str]] = frozenset()

    def __new__(cls, /, *values: Any, **named: Any) -> Self:
        """Refuse what is no parameter; `__init__` would raise a TypeError.

        Examples
        --------
        >>> import weftex
        >>> weftex.EfrosLeung(window=5)
        Traceback (most recent call last):
        ...
        weftex.errors.InvalidInputError: efros-leung has no parameter 'window'; did you mean \
'window_width'?
        """
        known = [field.name for field in dataclasses.fields(cls)]
        for name in named:
            if name not in known:
                raise InvalidInputError(
                    f"{cls.slug} has no parameter '{name}'{did_you_mean(name, known)}"
                )
        if len(values) > len(known):
            raise InvalidInputError(f"{cls.slug} has {len(known)} parameters, not {len(values)}")
        return super().__new__(cls)

    def __post_init__(self) -> None:
        for field in dataclasses.fields(self):
            value = getattr(self, field.name)
            count = field.metadata["count"] if value is not None else 0
            value = numbers_of(field.name, value, count) if count else checked_value(field, value)
            object.__setattr__(self, field.name, value)
            if value != field.default and not self.takes(field.name):
                other, values = field.metadata["needs"]
                allowed, found = " or ".join(f"'{v}'" for v in values), self.meant(other)
                here = "" if found == getattr(self, other) else f"; here it is '{found}'"
                raise InvalidInputError(
                    f"{field.name} has no effect unless {other} is {allowed}{here}"
                )

    def fit(self, sample: Sample) -> Model:
        """Analyze a sample; the result makes any number of outputs from it.

        Parameters
        ----------
        sample : path, array, PIL image or Exemplar
            The material; see `weftex.load_exemplar`.

        Raises
        ------
        FileError
            If the sample cannot be read.
        InvalidInputError
            If its pixels cannot be used, or a parameter does not go with it.
        """
        model = self.fit_exemplar(load_exemplar(sample))
        object.__setattr__(model, "asked", self)  # models may be frozen
        return model

    def meant(self, name: str) -> Any:
        """Return the value of a parameter; where that leaves it to another one, what follows."""
        return getattr(self, name)

    def takes(self, name: str, canvas: Canvas | None = None) -> bool:
        """Whether a parameter has an effect beside what the others are, and on this canvas."""
        meta = self.__dataclass_fields__[name].metadata
        if canvas is not None and meta["idle_canvas"] in canvas.kinds:
            return False
        return not meta["needs"] or self.meant(meta["needs"][0]) in meta["needs"][1]

    @abstractmethod
    def fit_exemplar(self, exemplar: Exemplar) -> Model:
        """Return the model of a sample: `fit` loads it and calls this. A method defines it."""

    def resolved(self, exemplar: Exemplar) -> Self:
        """Return this method with every parameter that was left open (None) chosen for a sample.

        It equals the `method` of the model that `fit` returns. A method whose `fit` takes long
        overrides this to choose the parameters alone.
        """
        method = self.fit_exemplar(exemplar).method
        assert isinstance(method, type(self))
        return method

    @property
    def hole_reach(self) -> int:
        """How far around a hole the method must look, in pixels; 0 if any distance will do."""
        return 0

    def for_hole(self, hole: Mask, usable: Mask, given: frozenset[str] | None) -> Self:
        """Return this method with what suits a hole where its parameters leave that open.

        `usable` are the exemplar's pixels that may be copied; `given` names the parameters that
        somebody chose, None if all values were, so that only None is open.
        """
        return self

    def window_for(self, proposed: int) -> int:
        """Return the width of the window that is compared, in pixels, if this one is proposed."""
        return proposed

    def for_belt(self, width: int, **parameters: Any) -> Self:
        """Return this method for a belt between two materials, whose windows are so wide.

        Belts lie between known pixels; what is idle there is left out.
        """
        idle = {
            field.name: field.default
            for field in dataclasses.fields(self)
            if field.metadata["idle_canvas"] == "known"
        }
        return dataclasses.replace(self, **idle | parameters)

    def window_of(self, exemplar: Exemplar) -> int:
        """Return the width of the window that the method chooses; 0 if it compares none.

        Raises
        ------
        InvalidInputError
            If no window fits the exemplar.
        """
        return 0

    def require(self, canvas: Canvas) -> None:
        """Refuse a canvas of a kind that the method does not do, or on which a parameter is idle.

        Raises
        ------
        UnsupportedError
            If the method does not do the kind.
        InvalidInputError
            If a parameter that is not at its default has no effect on it.
        """
        if canvas.hole is not None and canvas.known is None:
            raise InvalidInputError("the canvas has a hole but no known pixels around it")
        for kind in ["known"] * (canvas.known is not None) + list(canvas.kinds):
            self.require_kind(kind)
        for field in dataclasses.fields(self):
            if getattr(self, field.name) == field.default:
                continue
            needed, idle = (field.metadata[key] for key in ("needs_canvas", "idle_canvas"))
            if needed and needed not in canvas.kinds:
                raise InvalidInputError(
                    f"{field.name} has no effect without {CANVAS_NAMES[needed]}"
                )
            if idle in canvas.kinds:
                raise InvalidInputError(f"{field.name} has no effect with {CANVAS_NAMES[idle]}")

    def require_kind(self, kind: str) -> None:
        """Raise `UnsupportedError` unless the method supports this kind of canvas."""
        if kind not in self.supports:
            able = ", ".join(supporting(kind))
            raise UnsupportedError(
                f"{self.slug} does not support {CANVAS_KINDS[kind]}; these methods do: {able}"
            )

    def describe(self) -> dict[str, Any]:
        """Return the method's name and parameters as plain values, for files and messages.

        In a resolved method only parameters without effect are None; they are left out.
        """
        values = dataclasses.asdict(self)
        return {"method": self.slug} | {k: v for k, v in values.items() if v is not None}
