"""What a plane is made of, on disk and on other machines: sample, method, seed, size."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, fields, replace
from fractions import Fraction
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

import weftex
from weftex import Exemplar, Method
from weftex.canvas import as_canvas
from weftex.errors import InvalidInputError, whole_pair, wrong_value
from weftex.io.npz import DamageError, one_line_errors, open_npz, write_npz
from weftex.method import Model
from weftex.naming import make_method
from weftex.planes.layout import Layout, Window, check_block
from weftex.planes.tiff import MOST_DENSITY, TiffStore
from weftex.random import seed_number
from weftex.raster.turning import gap_of
from weftex.registry import AUTO
from weftex.roles import Role

BLOCK = 2048
_MOST_SIDE = 2**40
_FORMAT = "weftex plane 1"
_MOST_BYTES = 2**34
_FLAGS = ("tileable", "alpha", "name")
_MADE_OF = ("pieces", "turn", "copy_shape")


def packed(samples: Iterable[Exemplar]) -> tuple[list[dict[str, Any]], dict[str, NDArray[Any]]]:
    """Return plain values of each sample, and the arrays of all."""
    facts, arrays = [], {}
    for k, one in enumerate(samples):
        arrays[f"pixels{k}"] = one.pixels
        if one.mask is not None:
            arrays[f"mask{k}"] = one.mask
        if one.icc is not None:
            arrays[f"icc{k}"] = np.frombuffer(one.icc, np.uint8)
        role = {"name": one.role.name, "kind": one.role.kind, "channels": one.role.channels}
        facts.append({name: getattr(one, name) for name in (*_FLAGS, *_MADE_OF)} | {"role": role})
    return facts, arrays


def unpacked(facts: Iterable[Any], arrays: Mapping[str, NDArray[Any]]) -> list[Exemplar]:
    """Return the samples; what is wrong with the values raises errors of many kinds."""
    found = []
    for k, one in enumerate(facts):
        role = Role(one["role"]["name"], one["role"]["kind"], (), tuple(one["role"]["channels"]))
        texts = (one["name"], role.name, role.kind, *role.channels)
        if not all(isinstance(text, str) for text in texts):
            raise ValueError("a name is not a string")
        given = {name: one[name] for name in _FLAGS}
        given |= {"role": role, "mask": arrays.get(f"mask{k}")}
        if f"icc{k}" in arrays:
            given["icc"] = arrays[f"icc{k}"].tobytes()
        sample = Exemplar(arrays[f"pixels{k}"], **given)
        made_of = {"pieces": bool(one["pieces"]), "turn": one["turn"], "copy_shape": None}
        if one["turn"] is not None:
            made_of["copy_shape"] = tuple(one["copy_shape"])
            if gap_of(sample.shape, one["turn"], made_of["copy_shape"]) is None:
                raise ValueError("its copies do not fit its sample")
        found.append(sample.changed(**made_of))
    return found


@dataclass(frozen=True, eq=False)
class Definition:
    """All that the pixels of a plane depend on, and the size of its blocks.

    `stems` has the file name of each map. `reason` says why "auto" chose the method.
    """

    exemplar: Exemplar
    method: Method
    seed: int
    height: int
    width: int
    wrap: tuple[bool, bool] = (False, False)
    block: int = BLOCK
    stems: Mapping[str, str] = field(default_factory=dict)
    reason: str = ""
    density: float | None = None  # pixels per meter

    def __post_init__(self) -> None:
        check_block(self.block)
        if not (1 <= self.height <= _MOST_SIDE and 1 <= self.width <= _MOST_SIDE):
            size = f"{self.width}x{self.height}"
            raise InvalidInputError(f"size is {size}; a side of a plane is from 1 to 2**40")

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
        own = self.exemplar
        return {own.role.name: own} | {name: own.map(name) for name in own.maps}

    @property
    def base(self) -> Layout:
        """The blocks, in pixels of the sample's size."""
        return Layout(self.height, self.width, self.block)

    @cached_property
    def layouts(self) -> dict[str, Layout]:
        """How each picture is stored; `InvalidInputError` if blocks cannot divide one."""
        return {name: self._layout(name, one) for name, one in self.pictures.items()}

    def _layout(self, name: str, picture: Exemplar) -> Layout:
        scales = [Fraction(*pair) for pair in zip(picture.shape, self.exemplar.shape, strict=True)]
        sides = [k * scales[0] for k in (self.height, self.width, self.block)]
        block = int(sides[2])
        whole = all(side.denominator == 1 for side in sides) and block.bit_count() == 1
        if scales[0] != scales[1] or not whole or block < 16:
            raise InvalidInputError(
                f"map '{name}' cannot be written block by block: maps must be 1, 2 or 4 times as "
                "large as the sample, or 2, 4 or 8 times smaller, and the size must be a "
                "multiple of their scale"
            )
        dtype = "float32" if picture.pixels.dtype.kind == "f" else picture.pixels.dtype.name
        channels = sum(picture.pixels.shape[2:])
        density = self.density and self.density * float(scales[0])
        kind = (dtype, channels, picture.alpha, picture.mixing, picture.icc, density)
        return Layout(int(sides[0]), int(sides[1]), block, *kind)

    def render(self, window: Window, **how: Any) -> dict[str, NDArray[Any]]:
        """Return the pixels of each picture in a window, as they are stored."""
        period = period_of((self.height, self.width), self.wrap)
        made = self.model.window(*window, seed=self.seed, period=period, **how)
        found = {}
        for name, one in self.pictures.items():
            pixels = made.image if one is self.exemplar else made.render(one)
            found[name] = pixels.astype(self.layouts[name].dtype, copy=False)
        return found

    def stores(self, target: str) -> dict[str, TiffStore]:
        """Return the file of each picture: the target, or beside it, named by `stems`."""
        if len(self.layouts) == 1:
            return {name: TiffStore(target, layout) for name, layout in self.layouts.items()}
        folder, own = os.path.split(target)
        stem, suffix = os.path.splitext(own)
        stems = {name: self.stems.get(name) or f"{stem}_{name}" for name in self.layouts}
        paths = {name: os.path.join(folder, one + suffix) for name, one in stems.items()}
        return {name: TiffStore(paths[name], layout) for name, layout in self.layouts.items()}

    def _packed(self) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
        """Plain values and arrays of the samples and the method."""
        own = self.exemplar
        samples, arrays = packed([own, *map(own.map, own.maps)])
        about = {"maps": [*own.maps], "weights": own.weights}
        return {"method": self.method.slug, "samples": samples, **about}, arrays

    @cached_property
    def about(self) -> dict[str, Any]:
        """Plain values that differ wherever pixels or files would."""
        facts, arrays = self._packed()
        for one in facts["samples"]:
            del one["name"]  # of its file, of which no pixel depends
        digest = hashlib.sha256(json.dumps(facts, sort_keys=True).encode())
        for name, value in sorted(arrays.items()):
            digest.update(f"{name} {value.dtype.str} {value.shape}".encode())
            digest.update(np.ascontiguousarray(value).tobytes())
        return {
            "version": weftex.__version__,
            "width": self.width,
            "height": self.height,
            **json.loads(json.dumps(self.method.describe())),
            "seed": self.seed,
            "wrap": list(self.wrap),
            "block": self.block,
            "stems": dict(self.stems),
            "density": self.density,
            "digest": digest.hexdigest(),
        }

    def save(self, path: str, run: str = "") -> None:
        """Write it to an `.npz` file, with the name of the run that it belongs to."""
        facts, arrays = self._packed()
        about = {"about": self.about, "facts": facts, "reason": self.reason, "run": run}
        write_npz(path, {"format": _FORMAT, **about}, arrays)

    @classmethod
    def load(cls, path: str, run: str | None = None) -> Definition:
        """Read what `save` wrote; `FileError` if it is damaged, or belongs to another run."""
        with one_line_errors(path, "a saved plane of weftex"):
            with open_npz(path) as file:
                if file.facts["format"] != _FORMAT or file.size > _MOST_BYTES:
                    raise ValueError
                header, arrays = file.facts, file.read()
            if run is not None and header.get("run") != run:
                raise DamageError("it belongs to another run")
            try:
                return cls._unpacked(header, arrays)
            except (LookupError, TypeError, ValueError, AttributeError) as error:
                raise DamageError(str(error)) from None

    @classmethod
    def _unpacked(cls, header: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]) -> Definition:
        """Return what `save` packed; what is wrong with it raises errors of many kinds."""
        about, facts = header["about"], header["facts"]
        _check_plain(about, [*facts["maps"], *about["stems"].values()])
        own, *samples = unpacked(facts["samples"], arrays)
        maps = dict(zip(facts["maps"], samples, strict=True))
        exemplar = own.changed(maps=maps, weights=facts["weights"])
        names = ("seed", "height", "width", "block", "stems", "density")
        how = {name: about[name] for name in names} | {"reason": header["reason"]}
        return cls(exemplar, _method(facts["method"], about), wrap=tuple(about["wrap"]), **how)


def define(
    sample: Any,
    size: int | tuple[int, int],
    method: str | Method,
    parameters: Mapping[str, Any],
    *,
    seed: Any = None,
    tileable: bool | str = False,
    block: int = BLOCK,
    stems: Mapping[str, str] | None = None,
    density: float | None = None,
) -> Definition:
    """Return what a plane is made of, after a look whether its method makes windows of it."""
    wrap = as_canvas(1, tileable).wrap
    shape = whole_pair(size, 1)
    if shape is None:
        raise wrong_value("size", size, "(height, width), 1 or more")
    number = seed_number(seed)
    chosen, exemplar = make_method(method, parameters), weftex.load_exemplar(sample)
    how: dict[str, Any] = {"stems": dict(stems or {}), "density": density}
    made = Definition(exemplar, chosen, number, *shape, wrap, block, **how)
    period = period_of(shape, made.wrap)
    given = made.model.window(0, 0, 1, 1, seed=number, period=period).provenance
    if chosen.slug != AUTO:
        return made
    reason = "\nnote: ".join([given["reason"], *given.get("warnings", ())])
    return replace(made, method=_method(given["method"], given), reason=reason)


def period_of(shape: tuple[int, int], wrap: tuple[bool, bool]) -> tuple[int, int] | None:
    """After how many pixels a plane repeats: out of sight along an axis that need not."""
    height, width = shape
    return (height * (2 - wrap[0]), width * (2 - wrap[1])) if any(wrap) else None


def _method(slug: str, given: Mapping[str, Any]) -> Method:
    """The method whose parameters are in the description of a result."""
    names = [one.name for one in fields(weftex.METHODS[slug])]
    return make_method(slug, {name: given[name] for name in names if name in given})


def _check_plain(about: Mapping[str, Any], names: Iterable[Any]) -> None:
    """Refuse numbers that are none, and names of files that lead elsewhere."""
    whole = [about[name] for name in ("seed", "height", "width", "block")]
    if {*map(type, whole)} != {int} or not 0 <= about["seed"] < 2**64:
        raise ValueError("its numbers are invalid")
    if [*map(type, about["wrap"])] != [bool, bool]:
        raise ValueError("its period is invalid")
    if not (about["density"] is None or 0 < about["density"] < MOST_DENSITY):
        raise ValueError("its density is invalid")
    for name in names:
        if not isinstance(name, str) or name in ("", ".", "..") or not name.isprintable():
            raise ValueError("a file has no name")
        if "/" in name or "\\" in name:
            raise ValueError("a name leads elsewhere")
