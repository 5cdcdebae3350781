"""What a plane is made of, on disk and on other machines: sample, method, seed, size."""

from __future__ import annotations

import hashlib
import json
import sys
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.canvas import FAR
from weftex.endless.boxes import A_BLOCK
from weftex.errors import FileError, InvalidInputError
from weftex.exemplar import Exemplar
from weftex.io.formats import show
from weftex.planes.archive import read_archive, write_archive
from weftex.planes.files import open_stores
from weftex.planes.layout import Layout, check_block
from weftex.raster.levels import scale_between
from weftex.roles import Role
from weftex.tasks.method_names import is_auto, make_method

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    from weftex.method import Method, Model
    from weftex.planes.layout import Window
    from weftex.planes.store import Store
    from weftex.progress import ProgressCallback
    from weftex.results.synthesis import Synthesis

BLOCK = 2048
_FLAGS = ("tileable", "alpha", "name", "turn", "pieces")


@dataclass(frozen=True, eq=False)
class Definition:
    """Everything that says what a plane's pixels are.

    Attributes
    ----------
    exemplar : Exemplar
    method : Method
    seed : int
    height, width : int
    wrap : (bool, bool)
        Whether it repeats along y and along x.
    block : int
        Side of the blocks that it is made in, which changes no pixel.
    others : mapping of str to Exemplar
        Maps that are rendered instead of the sample and its own, see `replayed`.
    stems : mapping of str to str
        What files of maps are called, see `weftex.planes.files.open_stores`.
    reason : str
        Why the method was chosen; empty if somebody named it.
    """

    exemplar: Exemplar
    method: Method
    seed: int
    height: int
    width: int
    wrap: tuple[bool, bool] = (False, False)
    block: int = BLOCK
    others: Mapping[str, Exemplar] = field(default_factory=dict)
    stems: Mapping[str, str] = field(default_factory=dict)
    reason: str = ""

    def __post_init__(self) -> None:
        check_block(self.block)
        if not (1 <= self.height <= FAR and 1 <= self.width <= FAR):
            raise InvalidInputError(
                f"size is {self.width}x{self.height}; a side of a plane is from 1 to 2**40"
            )

    def __getstate__(self) -> dict[str, Any]:
        """Without what can be made again: other processes fit the model themselves."""
        return {one.name: getattr(self, one.name) for one in fields(self)}

    @cached_property
    def model(self) -> Model:
        """The sample, fitted."""
        return self.method.fit(self.exemplar)

    @cached_property
    def pictures(self) -> dict[str, Exemplar]:
        """What is rendered, by the names of maps; the sample's own picture first."""
        if self.others:
            return dict(self.others)
        maps = {name: self.exemplar.map(name) for name in self.exemplar.maps}
        return {self.exemplar.role.name: self.exemplar} | maps

    @property
    def base(self) -> Layout:
        """The blocks, in pixels of the sample's size."""
        return Layout(self.height, self.width, self.block, "uint8")

    @cached_property
    def layouts(self) -> dict[str, Layout]:
        """How each picture lies in a store.

        Raises
        ------
        InvalidInputError
            If a map's size does not go with blocks.
        """
        found = {}
        for name, picture in self.pictures.items():
            scale = scale_between(picture.shape, self.exemplar.shape)
            if scale is None:
                raise InvalidInputError(
                    f"map '{name}' is no multiple or fraction of the sample in size"
                )
            found[name] = self.base.scaled(scale, _kind_of(picture), name)
        return found

    def window(
        self,
        window: Window,
        *,
        threads: int | None = None,
        progress: ProgressCallback | None = None,
    ) -> Synthesis:
        """Return the result in a window of the plane."""
        how: dict[str, Any] = {"threads": threads, "progress": progress}
        period = period_of((self.height, self.width), self.wrap)
        return self.model.window(*window, seed=self.seed, period=period, **how)

    def render(
        self, window: Window, only: str | None = None, **how: Any
    ) -> dict[str, NDArray[Any]]:
        """Return the pixels of each picture, or of one, in a window, as they are stored."""
        found = self.window(window, **how)
        return {
            name: _stored(found.image if one is self.exemplar else found.render(one))
            for name, one in self.pictures.items()
            if only in (None, name)
        }

    def stores(self, target: str) -> dict[str, Store]:
        """Return where each picture goes."""
        about = {"seed": self.seed, "method": self.method.describe()}
        return open_stores(target, self.layouts, self.stems, about)

    def replayed(
        self, maps: Mapping[str, Exemplar], stems: Mapping[str, str], block: int | None = None
    ) -> Definition:
        """Return the same plane of other maps of its sample."""
        block = self.block if block is None else block
        return replace(self, others=dict(maps), stems=dict(stems), block=block)

    @cached_property
    def about(self) -> dict[str, Any]:
        """Plain values that differ wherever pixels or files would."""
        facts, arrays = _packed(self)
        for one in facts["samples"]:
            del one["name"]  # of its file, of which no pixel depends
        text = json.dumps(facts, sort_keys=True)
        digest = hashlib.sha256(text.encode())
        for name in sorted(arrays):
            value = arrays[name]
            digest.update(f"{name} {value.dtype.str} {value.shape}".encode())
            digest.update(np.ascontiguousarray(value).tobytes())
        return {
            "version": sys.modules["weftex"].__version__,
            "width": self.width,
            "height": self.height,
            **json.loads(json.dumps(self.method.describe())),
            "seed": self.seed,
            "wrap": list(self.wrap),
            "block": self.block,
            "stems": dict(self.stems),
            "digest": digest.hexdigest(),
        }

    @property
    def digest(self) -> str:
        """A name that no other recipe has."""
        return hashlib.sha256(json.dumps(self.about, sort_keys=True).encode()).hexdigest()

    def save(self, path: str, run: str = "") -> None:
        """Write it to an `.npz` file, with the name of the run that it belongs to."""
        facts, arrays = _packed(self)
        about = {"about": self.about, "facts": facts, "reason": self.reason, "run": run}
        write_archive(path, about, arrays)

    @classmethod
    def load(cls, path: str, run: str | None = None) -> Definition:
        """Read what `save` wrote.

        Raises
        ------
        FileError
            If the file is missing, damaged, or something else, or belongs to another run.
        """
        header, arrays = read_archive(path)
        try:
            if run is not None and header["run"] != run:
                raise ValueError("it belongs to another run")
            return cls._unpacked(header, arrays)
        except (LookupError, TypeError, ValueError, AttributeError) as error:
            raise FileError(f"{show(path)} is damaged: {error}") from None

    @classmethod
    def _unpacked(cls, header: dict[str, Any], arrays: Mapping[str, NDArray[Any]]) -> Definition:
        about, facts = header["about"], header["facts"]
        _check_plain(about, [*facts["maps"], *facts["others"], *about["stems"].values()])
        samples = [_unpacked(k, one, arrays) for k, one in enumerate(facts["samples"])]
        own = 1 + len(facts["maps"])
        maps = dict(zip(facts["maps"], samples[1:own], strict=True))
        return cls(
            samples[0].changed(maps=maps, weights=facts["weights"]),
            make_method(facts["method"], _parameters(facts["method"], about)),
            about["seed"],
            about["height"],
            about["width"],
            tuple(about["wrap"]),
            about["block"],
            dict(zip(facts["others"], samples[own:], strict=True)),
            about["stems"],
            header["reason"],
        )


def _check_plain(about: Mapping[str, Any], names: Sequence[Any]) -> None:
    """Refuse numbers that are none, and names of files that lead elsewhere."""
    numbers = [about[name] for name in ("seed", "height", "width", "block")]
    if {*map(type, numbers)} != {int} or not 0 <= about["seed"] < 2**64:
        raise ValueError("its numbers are none")
    if [*map(type, about["wrap"])] != [bool, bool]:
        raise ValueError("it repeats in no known way")
    for name in names:
        if not isinstance(name, str) or name in ("", ".", "..") or not name.isprintable():
            raise ValueError("a file has no name")
        if "/" in name or "\\" in name:
            raise ValueError("a name leads elsewhere")


def period_of(shape: tuple[int, int], wrap: tuple[bool, bool]) -> tuple[int, int] | None:
    """After how many pixels a plane comes back: out of sight along an axis that need not repeat."""
    height, width = shape
    return (height * (2 - wrap[0]), width * (2 - wrap[1])) if any(wrap) else None


def settled(model: Model, seed: int, period: tuple[int, int] | None) -> dict[str, Any]:
    """Return the method of a plane, and why it was chosen; "auto" says that of any window.

    Raises
    ------
    UnsupportedError, InvalidInputError
        If the method makes no windows, or none that repeat.
    """
    asked = model.asked or model.method
    asked.require(A_BLOCK)
    if not is_auto(asked) and period is None:
        return {"method": asked}
    made = model.window(0, 0, 8, 8, seed=seed, period=period).provenance
    if not is_auto(asked):
        return {"method": asked}
    slug = made["method"]
    return {"method": make_method(slug, _parameters(slug, made)), "reason": made["reason"]}


def _parameters(slug: str, told: Mapping[str, Any]) -> dict[str, Any]:
    """The parameters among what is told of a result."""
    names = [one.name for one in fields(make_method(slug, {}))]
    return {name: told[name] for name in names if name in told}


def _kind_of(picture: Exemplar) -> dict[str, Any]:
    """What a layout says of pixels."""
    stored = "float32" if picture.pixels.dtype.kind == "f" else picture.pixels.dtype.name
    channels = picture.pixels.shape[2] if picture.pixels.ndim == 3 else 0
    about = {"alpha": picture.alpha, "mixing": picture.mixing, "icc": picture.icc}
    return {"dtype": stored, "channels": channels, **about}


def _stored(pixels: NDArray[Any]) -> NDArray[Any]:
    return pixels.astype(np.float32) if pixels.dtype == np.float64 else pixels


def _packed(recipe: Definition) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """Plain values and arrays of everything."""
    own = recipe.exemplar
    samples = [own, *(own.map(name) for name in own.maps), *recipe.others.values()]
    arrays: dict[str, NDArray[Any]] = {}
    facts = []
    for k, one in enumerate(samples):
        arrays[f"pixels{k}"] = one.pixels
        if one.mask is not None:
            arrays[f"mask{k}"] = one.mask
        if one.icc is not None:
            arrays[f"icc{k}"] = np.frombuffer(one.icc, np.uint8)
        role = {"name": one.role.name, "kind": one.role.kind, "channels": one.role.channels}
        flags = {name: getattr(one, name) for name in (*_FLAGS, "copy_shape")}
        facts.append(flags | {"role": role})
    about = {"maps": [*own.maps], "others": [*recipe.others], "weights": own.weights}
    return {"method": recipe.method.slug, "samples": facts, **about}, arrays


def _unpacked(k: int, facts: dict[str, Any], arrays: Mapping[str, NDArray[Any]]) -> Exemplar:
    role = Role(facts["role"]["name"], facts["role"]["kind"], (), tuple(facts["role"]["channels"]))
    if not all(
        isinstance(text, str) for text in (facts["name"], role.name, role.kind, *role.channels)
    ):
        raise ValueError("a name is no text")
    icc = arrays[f"icc{k}"].tobytes() if f"icc{k}" in arrays else None
    flags = {name: facts[name] for name in _FLAGS}
    if flags["turn"] is not None:
        flags["copy_shape"] = tuple(facts["copy_shape"])
    mask = arrays.get(f"mask{k}")
    return Exemplar(arrays[f"pixels{k}"], mask=mask, icc=icc, role=role, **flags)
