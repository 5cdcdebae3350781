"""Begin a run: continue the plane that exists, or create its files and record that we own them."""

from __future__ import annotations

import os
import secrets
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from weftex.errors import FileError, InvalidInputError, shown
from weftex.planes.plane_file import PlaneFile, Sums
from weftex.planes.record import Record, Run
from weftex.planes.tiff import REPAIR, synced

_NAMES = {"digest": "sample", "wrap": "tiling (y, x)", "version": "version of weftex"}


def done_before(plane: PlaneFile, *, restart: bool = False, repair: bool = False) -> Sums:
    """Return the blocks that a run finds done, with their check sums.

    `FileError` if another file is in the way, `InvalidInputError` if another run began the plane.
    """
    record = Record(plane.path)
    return record.done() if _continued(plane, record, restart, repair) else {}


@contextmanager
def at_work(plane: PlaneFile, *, restart: bool = False, repair: bool = False) -> Iterator[Record]:
    """Hold the plane, which `done_before` has looked at, while the block runs; its files are there.

    Raises as `done_before`, and `FileError` if another process works on the plane.
    """
    part = plane.part
    record = Record(plane.path, f"part-{part[0]}-of-{part[1]}" if part else "done")
    with record.held(part):
        with record.beginning():
            _begin(plane, record, restart, repair)
        try:
            yield record
        except Exception:
            if part is None and not record.done():  # nothing that a run could continue
                with suppress(FileError):
                    _forget(plane, record)
            raise


def _continued(plane: PlaneFile, record: Record, restart: bool, repair: bool) -> Run | None:
    """The run that is continued; None if one begins."""
    # Looked for before the run is read: a file that a run has made since is known to be its own.
    there = [path for path in dict.fromkeys((plane.path, *_roots(plane))) if os.path.lexists(path)]
    for path in there:
        if os.path.islink(path) or not os.path.isfile(path):
            what = "a link" if os.path.islink(path) else "no file"
            raise FileError(f"{path} is {what}; remove it, or name another file")
    record.check_folder()
    run = record.current()
    if run is not None and run.begun and not restart:
        _refuse_other(plane, run)
        if repair or there:
            if not repair and (flaws := plane.flaws()):
                raise FileError(f"{flaws[0]} is missing or damaged; {REPAIR}")
            return run
    if repair:
        raise FileError(f"{plane.path} was not started")
    own = [os.path.abspath(_path(plane, name)) for name in run.files] if run else []
    for path in there:
        if os.path.abspath(path) not in own:
            raise FileError(
                f"{path} exists already, and {record.folder} does not list it as part of this "
                "image; remove it, or name another file"
            )
    return None


def _refuse_other(plane: PlaneFile, run: Run) -> None:
    """Raise `InvalidInputError` unless a run makes the same plane, saying where they differ."""
    for name, wanted in plane.definition.about.items():
        found = run.about.get(name)
        if found != wanted:
            values = f"{shown(found)}, here {shown(wanted)}"
            raise InvalidInputError(
                f"{plane.path} was started with other settings: its {_NAMES.get(name, name)} is "
                f"{'different' if name == 'digest' else values}; --restart starts again, or name "
                "another file"
            )


def _begin(plane: PlaneFile, record: Record, restart: bool, repair: bool) -> None:
    """Make the files, unless a run is continued. A run killed in between starts again."""
    if run := _continued(plane, record, restart, repair):
        record.run = run.name
        if plane.part is None:
            with record.alone():
                record.sweep()
                if repair and plane.flaws():
                    _create(plane)
        return
    old = record.current()
    names = [os.path.basename(path) for path in _roots(plane)]
    # The list of files may be a stranger's: only what this run writes, or its target, is removed.
    past = {os.path.basename(plane.path)}.intersection(old.files if old else ())
    with _taken(plane, record, {*names, *past}) as name:
        record.clear()
        record.begin(Run(name, False, names))  # what was there before is gone
        _create(plane)
        plane.definition.save(record.definition, name)
        synced(record.definition)
        record.begin(Run(name, True, names, plane.definition.about))


@contextmanager
def _taken(plane: PlaneFile, record: Record, owned: Iterable[str]) -> Iterator[str]:
    """Give the name of a new run, which owns these files and has removed them; nobody writes."""
    run = Run(secrets.token_hex(16), False, sorted(owned))
    record.begin(run)
    with record.alone():
        for name in run.files:
            path = Path(_path(plane, name))
            if not path.is_symlink():
                path.unlink(missing_ok=True)
        yield run.name


def _create(plane: PlaneFile) -> None:
    for store in plane.stores.values():
        store.create()


def _forget(plane: PlaneFile, record: Record) -> None:
    """Remove what a run made that has not finished a block."""
    with record.beginning():
        if (run := record.current()) is None or run.name != record.run:
            return  # somebody removed the plane, and another run may have begun it since
        with _taken(plane, record, map(os.path.basename, _roots(plane))):
            pass
        record.remove()


def _roots(plane: PlaneFile) -> list[str]:
    """The files of a plane, all in one folder."""
    return [store.path for store in plane.stores.values()]


def _path(plane: PlaneFile, name: str) -> str:
    return os.path.join(os.path.dirname(plane.path), name)
