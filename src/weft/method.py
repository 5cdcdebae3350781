"""What a method is: a frozen dataclass of parameters that knows its ranges and what it supports."""

from __future__ import annotations

import dataclasses
import math
import numbers
import os
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any, ClassVar, Protocol

from weft.errors import InvalidInputError, UnsupportedError, did_you_mean

if TYPE_CHECKING:
    import numpy as np

    from weft.canvas import Canvas
    from weft.exemplar import Exemplar
    from weft.progress import ProgressCallback
    from weft.synthesis import Synthesis

#: Canvas kinds that a method may declare in `supports`, in words for messages.
CANVAS_KINDS = {
    "wrap": "tileable output",
    "known": "hole filling",
    "guide": "following a guide",
    "many": "several samples",
    "random_access": "windows of an endless plane",
}


def parameter(
    default: Any,
    help: str,
    *,
    low: float | None = None,
    high: float | None = None,
    unit: str = "",
    choices: tuple[str, ...] = (),
    default_text: str = "",
    needs: tuple[str, tuple[str, ...]] | None = None,
    count: int = 0,
) -> Any:
    """Declare a field of a method.

    Parameters
    ----------
    default : object
        None means that it follows from the sample; say how in `default_text`.
    help : str
        One line.
    low, high : float, optional
        Inclusive bounds.
    unit : str
        Of the value, for people.
    choices : tuple of str
        The allowed values of a text.
    default_text : str
        What None stands for.
    needs : (field, values), optional
        The parameter does something only while `field` has one of these values; setting it
        otherwise is refused, not ignored.
    count : int
        The value is so many numbers; a text with commas between them is taken too.
    """
    return dataclasses.field(
        default=default,
        metadata={
            "help": help,
            "low": low,
            "high": high,
            "unit": unit,
            "choices": choices,
            "default_text": default_text,
            "needs": needs,
            "count": count,
        },
    )


class Model(Protocol):
    """What `Method.fit` returns: immutable, picklable, good for any number of outputs."""

    @property
    def exemplar(self) -> Exemplar:
        """The sample that was fitted."""
        ...

    @property
    def method(self) -> Method:
        """The method and its parameters."""
        ...

    def sample(
        self,
        size: Canvas | int | tuple[int, int],
        *,
        seed: int | np.random.Generator | None = None,
        tileable: bool | str = False,
        threads: int | None = None,
        progress: ProgressCallback | None = None,
    ) -> Synthesis:
        """Make one output."""
        ...


@dataclasses.dataclass(frozen=True)
class Method:
    """Base of all methods; its fields are declared with `parameter`.

    Raises
    ------
    InvalidInputError
        If a value is of the wrong type, out of its bounds, or without effect.
    """

    slug: ClassVar[str]
    title: ClassVar[str]
    paper: ClassVar[str]
    supports: ClassVar[frozenset[str]] = frozenset()

    def __post_init__(self) -> None:
        for field in dataclasses.fields(self):
            value = getattr(self, field.name)
            if field.metadata["count"] and value is not None:
                object.__setattr__(self, field.name, _numbers(field, value))
            else:
                _check(field, value)
            needs = field.metadata["needs"]
            if needs and getattr(self, field.name) != field.default:
                if getattr(self, needs[0]) not in needs[1]:
                    allowed = " or ".join(f"'{v}'" for v in needs[1])
                    raise InvalidInputError(
                        f"{field.name} has no effect unless {needs[0]} is {allowed}"
                    )

    def fit(self, exemplar: Exemplar) -> Model:
        """Analyse a sample; the result makes any number of outputs from it."""
        raise TypeError(f"{type(self).__name__} does not define fit")

    def settle(self, exemplar: Exemplar) -> Method:
        """Return this method with what it takes from the sample by itself filled in.

        It is the `method` of the model that `fit` returns; where that takes long, a method finds
        it without.
        """
        return self.fit(exemplar).method

    def require(self, canvas: Canvas) -> None:
        """Raise `UnsupportedError` if the canvas is of a kind that the method does not do."""
        if canvas.hole is not None and canvas.known is None:
            raise InvalidInputError("the canvas has a hole but no known pixels around it")
        wanted = {
            "wrap": any(canvas.wrap),
            "known": canvas.known is not None,
            "guide": canvas.guide is not None,
        }
        weight = getattr(type(self), "guide_weight", None)
        if canvas.guide is None and getattr(self, "guide_weight", None) != weight:
            raise InvalidInputError("guide_weight has no effect without a guide")
        for kind, want in wanted.items():
            if want and kind not in self.supports:
                able = [slug for slug in METHODS if kind in METHODS[slug].supports]
                raise UnsupportedError(
                    f"{self.slug} does not do {CANVAS_KINDS[kind]}; these do: {', '.join(able)}"
                )

    def describe(self) -> dict[str, Any]:
        """Return slug and parameters as plain values, for files and messages."""
        return {"method": self.slug, **dataclasses.asdict(self)}


def _check(field: dataclasses.Field[Any], value: Any) -> None:
    meta, name = field.metadata, field.name
    if value is None and field.default is None:
        return
    if meta["choices"]:
        if value not in meta["choices"]:
            known = meta["choices"]
            raise InvalidInputError(f"{name} is {value!r}{did_you_mean(str(value), known)}")
        return
    whole = "int" in str(field.type)
    kind = numbers.Integral if whole else numbers.Real
    if not isinstance(value, kind) or isinstance(value, bool) or math.isnan(value):
        wanted = "an integer" if whole else "a number"
        raise InvalidInputError(f"{name} is {value!r}; it must be {wanted}")
    low, high = meta["low"], meta["high"]
    if (low is not None and value < low) or (high is not None and value > high):
        raise InvalidInputError(f"{name} is {value}; it must be {bounds(field)}")


def _numbers(field: dataclasses.Field[Any], value: Any) -> tuple[float, ...]:
    """The numbers of a field that has several, from a sequence or a text with commas."""
    count = field.metadata["count"]
    try:
        found = tuple(float(v) for v in (value.split(",") if isinstance(value, str) else value))
    except (TypeError, ValueError):
        found = ()
    if len(found) != count or not all(map(math.isfinite, found)):
        raise InvalidInputError(f"{field.name} is {value!r}; it must be {count} numbers")
    return found


def bounds(field: dataclasses.Field[Any]) -> str:
    """The allowed values of a field in words."""
    low, high, choices = (field.metadata[k] for k in ("low", "high", "choices"))
    if field.metadata["count"]:
        return f"{field.metadata['count']} numbers"
    if choices:
        return ", ".join(choices)
    if low is not None and high is not None:
        return f"from {low:g} to {high:g}"
    return (
        f"{low:g} or more" if low is not None else f"at most {high:g}" if high is not None else ""
    )


class _Registry(Mapping[str, type[Method]]):
    """Slug to class; a method's module is imported when it is asked for."""

    def __init__(self, **names: str) -> None:
        self._names = {key.replace("_", "-"): name for key, name in names.items()}

    def __getitem__(self, slug: str) -> type[Method]:
        if slug not in self._names:
            raise InvalidInputError(
                f"unknown method '{slug}'{did_you_mean(slug, [AUTO, *self._names])}"
            )
        from importlib import import_module

        module = import_module("weft.methods." + slug.replace("-", "_"))
        found: type[Method] = getattr(module, self._names[slug])
        return found

    def get(self, slug: str, default: Any = None) -> Any:
        return self[slug] if slug in self._names else default

    def __contains__(self, slug: object) -> bool:
        return slug in self._names

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)


#: The name that stands for the method that suits the sample best.
AUTO = "auto"

#: Every method by its slug.
METHODS: Mapping[str, type[Method]] = _Registry(
    patch_sampling="PatchSampling",
    quilting="Quilting",
    graphcut="GraphCut",
    efros_leung="EfrosLeung",
    wei_levoy="WeiLevoy",
    ashikhmin="Ashikhmin",
    exact_matching="ExactMatching",
    refinement="Refinement",
    best_tile="BestTile",
    near_regular="NearRegular",
)


def thread_count(threads: int | None) -> int:
    """Return how many threads to use: at most `threads`, by default one a processor.

    Raises
    ------
    InvalidInputError
        If it is not an integer of 1 or more.
    """
    if threads is not None and (type(threads) is not int or threads < 1):
        raise InvalidInputError(f"threads is {threads!r}; it must be an integer of 1 or more")
    return threads or os.cpu_count() or 1


def method_class(name: str) -> type[Method]:
    """Return the method of that slug; "auto" too, which is a choice among them and not one of them.

    Raises
    ------
    InvalidInputError
        For an unknown method, with the nearest right name.
    """
    if name == AUTO:
        from importlib import import_module

        auto: type[Method] = import_module("weft.methods.auto").Auto
        return auto
    return METHODS[name]


def owners(parameter: str) -> list[str]:
    """The methods that have a parameter of this name."""
    return [s for s in METHODS if parameter in (f.name for f in dataclasses.fields(METHODS[s]))]


def make_method(method: str | Method, parameters: Mapping[str, Any]) -> Method:
    """Return the method of that slug with these parameters.

    Raises
    ------
    InvalidInputError
        For an unknown method, parameter or value, with the nearest right name.

    Examples
    --------
    >>> make_method("quilting", {"patch_size": 24}).patch_size
    24
    """
    if not isinstance(method, (str, Method)):
        raise InvalidInputError(f"method is {method!r}; it must be a name or a Method")
    cls = method_class(method) if isinstance(method, str) else type(method)
    known = [field.name for field in dataclasses.fields(cls)]
    for name in parameters:
        if name not in known:
            near = did_you_mean(name, known)
            if cls.slug == AUTO and owners(name):
                near = f"; these methods do: {', '.join(owners(name))}"
            raise InvalidInputError(f"{cls.slug} has no parameter '{name}'{near}")
    return (
        cls(**parameters) if isinstance(method, str) else dataclasses.replace(method, **parameters)
    )
