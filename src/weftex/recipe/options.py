"""What an option of a job is: its help, and how its value is read, checked and written."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
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


@dataclass(frozen=True)
class Option:
    """An option of a job.

    Attributes
    ----------
    name : str
        In JSON, and in Python.
    kind : Kind
    help : str
        One line.
    default : object
        Where nothing is said.
    default_text : str
        The default in words, if it depends on something.
    low, high : int, optional
        Inclusive bounds of a number.
    unit : str
    choices : tuple of str
    metavar, heading : str
        The value, and the group of the option, in the help of the command line.
    flag : str
        On the command line; by default the name.
    local : bool
        Whether pages that ask for jobs cannot set it, only who works on this machine.
    """

    name: str
    kind: Kind
    help: str
    default: Any = None
    default_text: str = ""
    low: int | None = None
    high: int | None = None
    unit: str = ""
    choices: tuple[str, ...] = ()
    metavar: str = ""
    heading: str = "options"
    flag: str = field(default="")
    local: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "flag", self.flag or "--" + self.name.replace("_", "-"))

    def read(self, text: str) -> Any:
        """Return the value of a text of the command line, or raise `InvalidInputError`."""
        try:
            value = self.kind.read(text)
        except (ValueError, OverflowError):
            line = f"{self.flag} is '{text}'; it must be {self.wanted or self.kind.wanted}"
            raise InvalidInputError(line) from None
        return self.checked(value, self.flag, text)

    def checked(self, value: Any, named: str = "", text: str | None = None) -> Any:
        """Return a value of JSON as a recipe has it, or raise `InvalidInputError`.

        Errors call the option `named`, and show `text` if that is where the value comes from.
        """
        name, given = named or self.name, shown(value) if text is None else f"'{text}'"
        try:
            found = self.kind.check(value)
            number = isinstance(found, int)
            if number and self.low is not None and found < self.low:
                raise ValueError
            if number and self.high is not None and found > self.high:
                raise ValueError
        except (ValueError, TypeError):
            wanted = self.kind.wanted if text is not None else self.kind.in_json or self.kind.wanted
            line = f"{name} is {given}; it must be {self.wanted or wanted}"
            raise InvalidInputError(line) from None
        if self.choices and found not in self.choices:
            raise InvalidInputError(f"{name} is {given}{did_you_mean(found, self.choices)}")
        return found

    @property
    def wanted(self) -> str:
        """The bounds in words, if there are any."""
        if self.low is None:
            return ""
        high = "2**64 - 1" if self.high == 2**64 - 1 else self.high
        return f"{self.low} or more" if high is None else f"from {self.low} to {high}"

    def words(self, value: Any) -> list[str]:
        """Return the words of the command line that give this value."""
        if isinstance(value, bool) and self.kind is FLAG:
            return [self.flag if value else f"--no-{self.flag[2:]}"]
        text = self.kind.text(value)
        if text == self.kind.bare:
            return [self.flag]
        return [f"{self.flag}={text}"] if text.startswith("-") else [self.flag, text]

    def as_json(self) -> dict[str, Any]:
        """Return what a page needs to ask for a value, as for parameters of methods."""
        own = {key: getattr(self, key) for key in ("name", "default", "help", "low", "high")}
        own |= {"type": self.kind.name, "unit": self.unit, "choices": list(self.choices)}
        own |= {"default_text": self.default_text, "needs": None, "needs_canvas": ""}
        return own | {"idle_canvas": "", "count": 0, "parity": ""}


def _number_text(value: float) -> str:
    return f"{value:g}" if float(f"{value:g}") == value else repr(value)


def _whole(value: Any) -> int:
    if not isinstance(value, int) or isinstance(value, bool):
        raise ValueError
    return value


def _number(value: Any) -> float:
    if not isinstance(value, (int, float)) or isinstance(value, bool):
        raise ValueError
    return value


def _words(value: Any) -> str:
    if not isinstance(value, str):
        raise ValueError
    return value


def _flag(value: Any) -> bool:
    if not isinstance(value, bool):
        raise ValueError
    return value


def _whole_numbers(value: Any) -> tuple[int, ...]:
    if not isinstance(value, (list, tuple)):
        raise ValueError
    return tuple(_whole(one) for one in value)


def _several(value: Any) -> tuple[float, ...]:
    if not isinstance(value, (list, tuple)):
        raise ValueError
    return tuple(_number(one) for one in value)


def _numbers_text(values: Any) -> str:
    return ",".join(map(_number_text, values))


def _read_numbers(text: str) -> list[float]:
    return [float(word) for word in text.split(",")]


def _one_or_several(value: Any) -> float | tuple[float, ...]:
    return _several(value) if isinstance(value, (list, tuple)) else _number(value)


def _read_one_or_several(text: str) -> Any:
    values = _read_numbers(text)
    return values if len(values) > 1 else values[0]


def _size(value: Any) -> tuple[int, int]:
    height, width = _whole_numbers(value)
    if min(height, width) < 1:
        raise ValueError
    return height, width


def _read_size(text: str) -> list[int]:
    sides = [
        int(side.removesuffix("k")) * (1024 if side.endswith("k") else 1)
        for side in text.lower().split("x")
    ]
    width, height = sides * 2 if len(sides) == 1 else sides
    return [height, width]


def _size_text(size: tuple[int, int]) -> str:
    height, width = size
    return str(width) if width == height else f"{width}x{height}"


def _window(value: Any) -> tuple[int, ...]:
    top, left, height, width = _whole_numbers(value)
    return top, left, height, width


def _axes(value: Any) -> bool | str:
    if not isinstance(value, bool) and value not in ("x", "y"):
        raise ValueError
    return value  # type: ignore[no-any-return]


def _read_axes(text: str) -> bool | str:
    return True if text == "xy" else text


def _corners(value: Any) -> str:
    count = len(_read_numbers(_words(value))) if value else 0
    if count not in (0, 4, 8):
        raise ValueError
    return str(value)


def _tries(value: Any) -> int | tuple[str, ...]:
    if isinstance(value, (list, tuple)) and value:
        return tuple(_words(one) for one in value)
    return _whole(value)


def _read_tries(text: str) -> int | list[str]:
    return int(text) if re.fullmatch(r"[-+]?\d+", text) else [w.strip() for w in text.split(",")]


def _pairs(text: str) -> dict[str, str]:
    """Texts by names, from 'a=b,c=d'."""
    found = [tuple(part.strip() for part in word.partition("=")) for word in text.split(",")]
    pairs = {name: value for name, equals, value in found if name and equals and value}
    if len(pairs) < len(found):
        raise ValueError
    return pairs


def _pairs_text(pairs: Mapping[str, Any]) -> str:
    values = {k: v if isinstance(v, str) else _number_text(v) for k, v in pairs.items()}
    return ",".join(f"{name}={value}" for name, value in values.items())


def _named(value: Any, check: Callable[[Any], Any]) -> dict[str, Any]:
    if not isinstance(value, Mapping) or not all(isinstance(name, str) for name in value):
        raise ValueError
    return {name: check(one) for name, one in value.items()}


def _level(value: Any) -> float | str:
    return value if value == "flat" else _number(value)


#: What a map may be called, in files too.
_MAP = re.compile(r"[A-Za-z0-9][A-Za-z0-9_ -]{0,39}")


def _files(value: Any) -> dict[str, str]:
    files = _named(value, _words)
    if not 0 < len(files) <= 40 or not all(map(_MAP.fullmatch, files)):
        raise ValueError
    return files


def _color(value: Any) -> tuple[int, ...]:
    """A color, or a level of gray; as a text '#rrggbb' or '120'."""
    if isinstance(value, str):
        hexadecimal = value.startswith("#") and len(value) == 7
        return tuple(bytes.fromhex(value[1:])) if hexadecimal else (int(value),)
    return (value,) if type(value) is int else _whole_numbers(value)


def _color_text(color: tuple[int, ...]) -> str:
    return "#" + bytes(color).hex() if len(color) == 3 else ",".join(map(str, color))


def _colors(value: Any) -> tuple[tuple[int, ...], ...]:
    if not isinstance(value, (list, tuple)):
        raise ValueError
    return tuple(map(_color, value))


def _mixed(value: Any) -> dict[tuple[int, ...], tuple[int, int]]:
    """Pairs of samples, counted from 0, by colors."""
    found = {}
    for color, pair in value.items():
        first, second = _whole_numbers(pair)
        found[_color(color)] = first, second
    return found


def _read_mixed(text: str) -> dict[str, list[int]]:
    pairs = {color: pair.split("+") for color, pair in _pairs(text).items()}
    return {color: [int(number) - 1 for number in pair] for color, pair in pairs.items()}


def _mixed_text(mixed: Mapping[tuple[int, ...], tuple[int, int]]) -> str:
    return ",".join(f"{_color_text(k)}={a + 1}+{b + 1}" for k, (a, b) in mixed.items())


def plain(value: Any) -> Any:
    """Return a value of a recipe as JSON has it."""
    if isinstance(value, tuple):
        return [plain(one) for one in value]
    if isinstance(value, dict):
        return {k if isinstance(k, str) else _color_text(k): plain(v) for k, v in value.items()}
    return value


WHOLE = Kind("int", "an integer", int, _whole)
NUMBER = Kind("float", "a number", float, _number, _number_text)
TEXT = Kind("text", "a text", str, _words)
FLAG = Kind("bool", "true or false", str, _flag)
PICTURE = Kind("picture", "a picture", str, _words)
NUMBERS = Kind("numbers", "numbers with commas between them", _read_numbers, _several,
               _numbers_text)  # fmt: skip
ONE_OR_SEVERAL = NUMBERS._replace(
    read=_read_one_or_several,
    check=_one_or_several,
    text=lambda value: _numbers_text(value if isinstance(value, tuple) else (value,)),
)
#: Row and column, which the command line has as x and y.
POINT = NUMBERS._replace(
    read=lambda text: _read_numbers(text)[::-1], text=lambda value: _numbers_text(value[::-1])
)
SIZE = Kind("size", "WxH or N, 1 or more, such as 640x480 or 2k", _read_size, _size, _size_text,
            "[height, width], 1 or more")  # fmt: skip
WINDOW = Kind("window", "TOP,LEFT,HEIGHT,WIDTH, such as -100,0,256,256",
              lambda text: [int(word) for word in text.split(",")], _window,
              lambda value: ",".join(map(str, value)))  # fmt: skip
AXES = Kind("axes", "x, y or xy", _read_axes, _axes,
            lambda value: "xy" if value is True else str(value), "true, false, 'x' or 'y'",
            "xy", "x|y|xy")  # fmt: skip
STRAIGHTEN = TEXT._replace(
    wanted="four numbers, a lattice, or eight, corners", check=_corners, bare="",
    values=r"[-+.,\deE]*,[-+.,\deE]*",
)  # fmt: skip
DEGREE = WHOLE._replace(bare="2", values=r"[-+]?\d+")
TRIES = Kind("int", "a number, or names of methods", _read_tries, _tries,
             lambda value: str(value) if isinstance(value, int) else ",".join(value))  # fmt: skip
WEIGHTS = Kind("weights", "maps and numbers, each once, such as height=3,normal=2",
               lambda text: {k: float(v) for k, v in _pairs(text).items()},
               lambda value: _named(value, _number), _pairs_text)  # fmt: skip
LEVELS = WEIGHTS._replace(
    wanted="maps and their values, each once, such as height=0.5,normal=flat",
    read=lambda text: {k: v if v == "flat" else float(v) for k, v in _pairs(text).items()},
    check=lambda value: _named(value, _level),
)
FILES = Kind("files", "maps and their files, each once, such as color=a.png,normal=b.png",
             _pairs, _files, _pairs_text)  # fmt: skip
COLORS = Kind("colors", "colors, #rrggbb, or gray levels, with commas between them",
              lambda text: [word.strip() for word in text.split(",")], _colors,
              lambda value: ",".join(map(_color_text, value)))  # fmt: skip
MIXED = Kind("mixed", "colors and two samples each, such as #00ff00=1+2", _read_mixed, _mixed,
             _mixed_text)  # fmt: skip
