"""What an option of a job is: its help, and how its value is read, checked and written."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from weftex.errors import InvalidInputError, did_you_mean, shown


class Kind(NamedTuple):
    """How values of an option are read and written; what they cannot be is a ValueError."""

    name: str  # for pages that ask for a value
    wanted: str  # what a text must be, in words
    read: Callable[[str], Any]  # a text of the command line as a value of JSON
    check: Callable[[Any], Any]  # a value of JSON as a value of a recipe
    text: Callable[[Any], str] = str  # the text that `read` takes
    in_json: str = ""  # what a value must be, if that is said in other words
    bare: str | None = None  # the text that an option without a value stands for
    values: str = ""  # a pattern of the words that are values of such an option


class Option(NamedTuple):
    """An option of a job: what `help` says is completed with its default where it is printed."""

    name: str  # in JSON and in Python
    kind: Kind
    help: str
    default: Any = None
    default_text: str = ""  # where the default depends on something
    low: int | None = None  # inclusive, as `high`
    high: int | None = None
    unit: str = ""
    choices: tuple[str, ...] = ()
    metavar: str = ""
    heading: str = "options"  # the group in the help of the command line
    given_flag: str = ""  # on the command line, if not called as `name`
    local: bool = False  # set only by who works on this machine, not by pages that ask for jobs

    @property
    def flag(self) -> str:
        """The option on the command line."""
        return self.given_flag or "--" + self.name.replace("_", "-")

    @property
    def dest(self) -> str:
        """The name of the option among the arguments of a command."""
        return self.flag[2:].replace("-", "_")

    def read(self, text: str) -> Any:
        """Return the value of a text of the command line, or raise `InvalidInputError`."""
        try:
            value = self.kind.read(text)
        except (ValueError, OverflowError):
            line = f"{self.flag} is '{text}'; it must be {self.bounds or self.kind.wanted}"
            raise InvalidInputError(line) from None
        return self.checked(value, self.flag, text)

    def checked(self, value: Any, named: str = "", text: str | None = None) -> Any:
        """Return a value of JSON as a recipe has it, or raise `InvalidInputError`.

        Errors call the option `named`, and show `text` if that is where the value comes from.
        """
        name, given = named or self.name, shown(value) if text is None else f"'{text}'"
        try:
            found = self.kind.check(value)
            if isinstance(found, int):
                too_low = self.low is not None and found < self.low
                if too_low or (self.high is not None and found > self.high):
                    raise ValueError
        except (ValueError, TypeError):
            wanted = self.kind.wanted if text is not None else self.kind.in_json or self.kind.wanted
            line = f"{name} is {given}; it must be {self.bounds or wanted}"
            raise InvalidInputError(line) from None
        if self.choices and found not in self.choices:
            raise InvalidInputError(f"{name} is {given}{did_you_mean(found, self.choices)}")
        return found

    @property
    def bounds(self) -> str:
        """The bounds in words, if there are any."""
        if self.low is None:
            return ""
        high = "2**64 - 1" if self.high == 2**64 - 1 else self.high
        return f"{self.low} or more" if high is None else f"from {self.low} to {high}"

    def words(self, value: Any) -> list[str]:
        """Return the words of the command line that give this value."""
        if self.kind is FLAG:
            return [self.flag if value else f"--no-{self.flag[2:]}"]
        text = self.kind.text(value)
        if text == self.kind.bare:
            return [self.flag]
        return [f"{self.flag}={text}"] if text.startswith("-") else [self.flag, text]

    def as_json(self) -> dict[str, Any]:
        """Return what a page needs to ask for a value."""
        names = ("name", "default", "help", "low", "high", "unit", "default_text")
        own = {name: getattr(self, name) for name in names}
        return own | {"type": self.kind.name, "choices": list(self.choices)}


def plain(value: Any) -> Any:
    """Return a value of a recipe as JSON has it."""
    if isinstance(value, tuple):
        return [plain(one) for one in value]
    if isinstance(value, dict):
        return {k if isinstance(k, str) else _color_text(k): plain(v) for k, v in value.items()}
    return value


def _a(*types: type) -> Callable[[Any], Any]:
    """A check for one value of some types; a truth value is no number."""

    def check(value: Any) -> Any:
        if not isinstance(value, types) or (isinstance(value, bool) and bool not in types):
            raise ValueError
        return value

    return check


_whole, _number, _word = _a(int), _a(int, float), _a(str)


def _several(check: Callable[[Any], Any], count: int = 0) -> Callable[[Any], tuple[Any, ...]]:
    """A check for a list of values, of `count` if that is not 0."""

    def check_all(value: Any) -> tuple[Any, ...]:
        if not isinstance(value, (list, tuple)) or (count and len(value) != count):
            raise ValueError
        return tuple(check(one) for one in value)

    return check_all


def _fitting(check: Callable[[Any], Any], fits: Callable[[Any], bool]) -> Callable[[Any], Any]:
    """A check for what another check returns, if it also fits."""

    def check_both(value: Any) -> Any:
        found = check(value)
        if not fits(found):
            raise ValueError
        return found

    return check_both


def _listed(one: Kind, name: str, wanted: str, count: int = 0) -> Kind:
    """The kind of lists of values of one kind, written 'a,b'."""
    return Kind(
        name,
        wanted,
        lambda given: [one.read(word.strip()) for word in given.split(",")],
        _several(one.check, count),
        lambda values: ",".join(map(one.text, values)),
    )


def _named(one: Kind, name: str, wanted: str) -> Kind:
    """The kind of values of one kind by names, written 'a=b,c=d'."""

    def check_all(values: Any) -> dict[str, Any]:
        if not isinstance(values, Mapping) or not all(isinstance(key, str) for key in values):
            raise ValueError
        return {key: one.check(value) for key, value in values.items()}

    return Kind(
        name,
        wanted,
        lambda given: {key: one.read(value) for key, value in _pairs(given).items()},
        check_all,
        lambda values: ",".join(f"{key}={one.text(value)}" for key, value in values.items()),
    )


def _pairs(text: str) -> dict[str, str]:
    """Texts by names, from 'a=b,c=d'."""
    found = [tuple(part.strip() for part in word.partition("=")) for word in text.split(",")]
    pairs = {name: value for name, equals, value in found if name and equals and value}
    if len(pairs) < len(found):
        raise ValueError
    return pairs


def _number_text(value: float) -> str:
    return f"{value:g}" if float(f"{value:g}") == value else repr(value)


WHOLE = Kind("int", "an integer", int, _whole)
NUMBER = Kind("float", "a number", float, _number, _number_text)
TEXT = Kind("text", "a text", str, _word)
_METERS = {"m": 1.0, "cm": 0.01, "mm": 0.001}


def read_length(text: str) -> float:
    """Return the meters of a length such as 0.6m, 60cm or 600mm; raises ValueError."""
    found = re.fullmatch(r"(\d*\.?\d+) ?(m|cm|mm)", text.strip().lower())
    if found is None:
        raise ValueError
    return float(found[1]) * _METERS[found[2]]


def _length(value: Any) -> float:
    if not 0 < _number(value) < 1e6:
        raise ValueError
    return float(value)


LENGTH = Kind(
    "float", "a length above 0, such as 0.6m, 60cm or 600mm", read_length, _length,
    lambda value: f"{_number_text(value)}m", in_json="a number of meters above 0",
)  # fmt: skip
DENSITY = Kind(
    "float", "pixels per meter above 0, such as 1024px/m",
    lambda text: float(text.removesuffix("px/m")), _length,
    lambda value: f"{_number_text(value)}px/m",
)  # fmt: skip
FLAG = Kind("bool", "true or false", str, _a(bool))
PICTURE = Kind("picture", "an image", str, _word)
DEGREE = WHOLE._replace(bare="2", values=r"[-+]?\d+")
NUMBERS = _listed(NUMBER, "numbers", "numbers with commas between them")
WINDOW = _listed(WHOLE, "window", "TOP,LEFT,HEIGHT,WIDTH, such as -100,0,256,256", count=4)


def _read_size(text: str) -> list[int]:
    words = text.lower().split("x")
    sides = [int(one.removesuffix("k")) * (1024 if one.endswith("k") else 1) for one in words]
    width, height = sides * 2 if len(sides) == 1 else sides
    return [height, width]


def _size_text(size: tuple[int, int]) -> str:
    height, width = size
    return str(width) if width == height else f"{width}x{height}"


SIZE = Kind(
    "size", "WxH or N, 1 or more, such as 640x480, 2k or 2mx1.5m (meters)", _read_size,
    _fitting(_several(_whole, 2), lambda sides: min(sides) >= 1), _size_text,
    in_json="a height and a width, each 1 or more",
)  # fmt: skip
AXES = Kind(
    "axes", "x, y or xy", lambda text: text == "xy" or text,
    _fitting(_a(bool, str), lambda axes: axes in (True, False, "x", "y")),
    lambda value: "xy" if value is True else str(value),
    in_json="true, false, 'x' or 'y'", bare="xy", values="x|y|xy",
)  # fmt: skip
STRAIGHTEN = TEXT._replace(
    wanted="four numbers, a lattice, or eight, corners",
    check=_fitting(_word, lambda text: not text or len(NUMBERS.read(text)) in (4, 8)),
    bare="", values=r"[-+.,\deE]*,[-+.,\deE]*",
)  # fmt: skip
WEIGHTS = _named(NUMBER, "weights", "maps and numbers, each once, such as height=3,normal=2")
_LEVEL = Kind(
    "level", "a number or 'flat'",
    lambda text: text if text == "flat" else float(text),
    lambda value: value if value == "flat" else _number(value),
    lambda value: value if value == "flat" else _number_text(value),
)  # fmt: skip
LEVELS = _named(
    _LEVEL, "weights", "maps and their values, each once, such as height=0.5,normal=flat"
)
_MAP_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_ -]{0,39}")  # which files have, too
FILES = _named(TEXT, "files", "maps and their files, each once, such as color=a.png,normal=b.png")
FILES = FILES._replace(check=_fitting(
    FILES.check, lambda files: 0 < len(files) <= 40 and all(map(_MAP_NAME.fullmatch, files))
))  # fmt: skip


def _color(value: Any) -> tuple[int, ...]:
    """A color, or a level of gray; as a text '#rrggbb' or '120'."""
    if isinstance(value, str):
        hexadecimal = value.startswith("#") and len(value) == 7
        return tuple(bytes.fromhex(value[1:])) if hexadecimal else (int(value),)
    return (value,) if type(value) is int else _several(_whole)(value)


def _color_text(color: tuple[int, ...]) -> str:
    return "#" + bytes(color).hex() if len(color) == 3 else ",".join(map(str, color))


_COLOR = Kind("color", "#rrggbb or a gray level", str, _color, _color_text)
COLORS = _listed(_COLOR, "colors", "colors, #rrggbb, or gray levels, with commas between them")


def _read_mixed(text: str) -> dict[str, list[int]]:
    pairs = {color: pair.split("+") for color, pair in _pairs(text).items()}
    return {color: [int(number) - 1 for number in pair] for color, pair in pairs.items()}


#: Pairs of samples, counted from 0, by colors.
MIXED = Kind(
    "mixed", "colors and two samples each, such as #00ff00=1+2", _read_mixed,
    lambda value: {_color(k): _several(_whole, 2)(pair) for k, pair in dict(value).items()},
    lambda mixed: ",".join(f"{_color_text(k)}={a + 1}+{b + 1}" for k, (a, b) in mixed.items()),
)  # fmt: skip
