"""Parameters of methods: their bounds, units and help, and how values of them are checked."""

from __future__ import annotations

import dataclasses
import math
import numbers
from collections.abc import Sequence
from typing import Any

from weftex.errors import InvalidInputError, did_you_mean, shown, wrong_value

__all__ = ["kind_of", "parameter"]

_MOST_WHOLE = 2**63 - 1  # what an integer of a parameter may be; arrays hold no more


def parameter(
    default: Any,
    help: str,
    *,
    low: float | None = None,
    high: float | None = None,
    unit: str = "",
    choices: Sequence[str] = (),
    default_text: str = "",
    hole_text: str = "",
    needs: tuple[str, Sequence[str]] | None = None,
    needs_canvas: str = "",
    idle_canvas: str = "",
    count: int = 0,
    parity: str = "",
    control: str = "",
) -> Any:
    """Declare a field of a method.

    Parameters
    ----------
    default : object
        Default value. None means that it depends on the sample; say how in `default_text`.
    help : str
        One line that says what the parameter does.
    low, high : float, optional
        Smallest allowed value; largest allowed value.
    unit : str
        Unit of the value, such as "px".
    choices : sequence of str
        The allowed values of a text.
    default_text, hole_text : str
        The default in words, if `default` is None; the default in holes, if it is another one.
    needs : (field, values), optional
        The parameter has an effect only if `field` has one of these values. It is an error to set
        it otherwise.
    needs_canvas : str
        The parameter has an effect only for this kind of canvas, such as "known" (holes).
    idle_canvas : str
        A kind of canvas on which the parameter has no effect.
    count : int
        Number of numbers, if the value is a tuple, or a text with commas.
    parity : str
        "odd" or "even". 0 is always allowed if `low` allows it.
    control : str
        Slider of the studio that sets it: "size" of features, "variety", or "softness" of seams.
    """
    about = {**locals()}  # everything but the default is metadata, under its own name
    return dataclasses.field(default=about.pop("default"), metadata=about)


def length_parameter(help: str, default_text: str, **more: Any) -> Any:
    """Declare a number of pixels, or several, that the sample decides by default."""
    return parameter(None, help, default_text=default_text, unit="px", **more)


def window_parameter(help: str, default_text: str, high: int | None = None) -> Any:
    """Declare the odd width of a square window, which the sample decides by default."""
    return length_parameter(help, default_text, low=1, high=high, parity="odd", control="size")


def levels_parameter(default_text: str, high: int) -> Any:
    """Declare the number of pyramid levels, which the sample decides by default."""
    text = "number of pyramid levels; more keep larger shapes, 1 is a single resolution"
    return parameter(None, text, low=1, high=high, default_text=default_text)


def guide_parameter(help: str, default: float = 0.3) -> Any:
    """Declare the weight of the guide against what is made."""
    return parameter(default, help, low=0.01, high=100.0, needs_canvas="guide")


def checked_value(field: dataclasses.Field[Any], value: Any) -> Any:
    """A value of a parameter as int, float or str; raises `InvalidInputError` for others."""
    meta, name = field.metadata, field.name
    if value is None and field.default is None:
        return None
    if meta["choices"]:
        known = meta["choices"]
        if not isinstance(value, str) or value not in known:
            raise InvalidInputError(f"{name} is {shown(value)}{did_you_mean(str(value), known)}")
        return str(value)
    whole = "int" in str(field.type)
    kind = numbers.Integral if whole else numbers.Real
    if not isinstance(value, kind) or isinstance(value, bool) or value != value:
        wanted = "an integer" if whole else "a number"
        raise wrong_value(name, value, wanted)
    low, high = meta["low"], meta["high"]
    if (low is not None and value < low) or (high is not None and value > high):
        raise wrong_value(name, value, bounds(field))
    if isinstance(value, numbers.Integral) and abs(int(value)) > _MOST_WHOLE:
        raise wrong_value(name, value, "at most 2**63 - 1")
    if meta["parity"] and value and value % 2 != (meta["parity"] == "odd"):
        raise wrong_value(name, value, meta["parity"])
    return int(value) if whole and isinstance(value, numbers.Integral) else float(value)


def numbers_of(name: str, value: Any, count: int) -> tuple[float, ...]:
    """A tuple of `count` finite numbers from a sequence or a text with commas; raises otherwise."""
    try:
        found = tuple(float(v) for v in (value.split(",") if isinstance(value, str) else value))
    except (TypeError, ValueError, OverflowError):
        found = ()
    if len(found) != count or not all(map(math.isfinite, found)):
        raise wrong_value(name, value, f"{count} numbers")
    return found


def bounds(field: dataclasses.Field[Any]) -> str:
    """The allowed values of a field in words."""
    low, high, choices = (field.metadata[k] for k in ("low", "high", "choices"))
    if field.metadata["count"]:
        return f"{field.metadata['count']} numbers"
    if choices:
        return ", ".join(choices)
    if low is not None and high is not None:
        return f"from {low:g} to {high if isinstance(high, int) else f'{high:g}'}"
    return (
        f"{low:g} or more" if low is not None else f"at most {high:g}" if high is not None else ""
    )


def kind_of(field: dataclasses.Field[Any]) -> type[int] | type[float] | type[str]:
    """Return what the text of a parameter is read as."""
    # A class where the method's module does not postpone its annotations, as ours do.
    wanted = getattr(field.type, "__name__", str(field.type)).split(" ")[0]
    return int if wanted == "int" else float if wanted == "float" else str
