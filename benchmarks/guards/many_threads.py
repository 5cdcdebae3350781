"""Many threads of Python on one model make the bytes that one makes, with a lock or without.

    python benchmarks/guards/many_threads.py [METHOD ...]

Needs no files, so it runs where OpenImageIO cannot be had: a free-threaded Python. It says whether
the lock is on.
"""

from __future__ import annotations

import sys
import threading

import numpy as np

import weftex

_THREADS = 8
#: Chosen small; patches need more room than pixels.
SIZES = {"patch-sampling": 96, "quilting": 96, "graphcut": 72, "near-regular": 96, "best-tile": 96}


def sample() -> weftex.Exemplar:
    """Bricks of a kind: a lattice, and noise."""
    y, x = np.indices((64, 72))
    lines = (y % 16 < 2) | ((x + 12 * (y // 16 % 2)) % 24 < 2)
    noise = np.random.default_rng(0).integers(0, 60, (64, 72, 3))
    return weftex.Exemplar(
        np.where(lines[..., None], 190, 90).astype(np.uint8) + noise.astype(np.uint8)
    )


def alike(method: str) -> bool:
    """Whether eight threads at once make what each seed makes alone."""
    model = weftex.METHODS[method]().fit(sample())
    size = SIZES.get(method, 40)
    alone = [model.sample(size, seed=seed, threads=1).image for seed in range(_THREADS)]
    fresh, start = weftex.METHODS[method]().fit(sample()), threading.Barrier(_THREADS)
    found: dict[int, np.ndarray] = {}

    def work(seed: int) -> None:
        start.wait()
        found[seed] = fresh.sample(size, seed=seed, threads=2).image

    workers = [threading.Thread(target=work, args=(seed,)) for seed in range(_THREADS)]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
    return all(np.array_equal(alone[seed], found.get(seed)) for seed in range(_THREADS))


def main() -> int:
    sys.setswitchinterval(1e-5)
    methods = sys.argv[1:] or [*weftex.METHODS]
    wrong = [method for method in methods if not alike(method)]
    lock = getattr(sys, "_is_gil_enabled", lambda: True)()
    print(f"{len(methods)} methods, {_THREADS} threads, lock {'on' if lock else 'off'}: ", end="")
    print(f"other bytes from {', '.join(wrong)}" if wrong else "the same bytes")
    return bool(wrong)


if __name__ == "__main__":
    raise SystemExit(main())
