"""Samples in a compressed file, as plain values and arrays, beside other plain values."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import numpy as np

from weftex import Exemplar, FileError
from weftex.io.npz import opened
from weftex.io.pictures import atomic
from weftex.raster.turning import gap_of
from weftex.roles import Role

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from numpy.typing import NDArray

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
        flags = {name: getattr(one, name) for name in (*_FLAGS, *_MADE_OF)}
        facts.append(flags | {"role": role})
    return facts, arrays


def unpacked(facts: Iterable[Any], arrays: Mapping[str, NDArray[Any]]) -> list[Exemplar]:
    """Return the samples; what is wrong with the values raises errors of many kinds."""
    found = []
    for k, one in enumerate(facts):
        role = Role(one["role"]["name"], one["role"]["kind"], (), tuple(one["role"]["channels"]))
        texts = (one["name"], role.name, role.kind, *role.channels)
        if not all(isinstance(text, str) for text in texts):
            raise ValueError("a name is no text")
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


def save(path: str, header: dict[str, Any], arrays: Mapping[str, NDArray[Any]]) -> None:
    """Write a file; it appears whole or not at all."""
    about = np.array(json.dumps({"format": _FORMAT, **header}))
    with atomic(path) as temporary, open(temporary, "wb") as file:
        np.savez_compressed(file, about=about, **arrays)  # type: ignore[arg-type]


def load(path: str) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """Return what was written, or raise `FileError`."""
    try:
        with opened(path) as file:
            if file.facts["format"] != _FORMAT or file.size > _MOST_BYTES:
                raise ValueError
            return file.facts, file.read()
    except FileNotFoundError:
        raise FileError(f"{path} does not exist") from None
    except Exception:  # numpy and zipfile raise many kinds, with advice that does not fit here
        raise FileError(f"{path} is not a saved plane of weftex") from None


def is_saved(path: str) -> bool:
    """Whether a file is one that `save` wrote."""
    try:
        with opened(path) as file:
            return bool(file.facts["format"] == _FORMAT)
    except Exception:  # as above
        return False
