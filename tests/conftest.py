"""Shared by all tests: the import path of `families` and `twins`, and settled hypothesis runs."""

import os
import sys
from pathlib import Path

# Small matrices on a busy machine: threads of BLAS only wait for each other. That their number
# changes no byte is tested where it belongs, in processes of its own.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import hypothesis
import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parent))

# The same examples everywhere and every time, however slow the machine.
hypothesis.settings.register_profile(
    "weftex",
    deadline=None,
    derandomize="WEFTEX_CASES" not in os.environ,
    database=None,
    max_examples=25,
    phases=[phase for phase in hypothesis.Phase if phase.name != "explain"],  # that takes minutes
    suppress_health_check=[hypothesis.HealthCheck.too_slow],
)
hypothesis.settings.load_profile("weftex")


@pytest.fixture
def rng() -> np.random.Generator:
    """Made-up pictures, the same in every run."""
    return np.random.default_rng(20010703)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: object) -> object:
    """Each process takes neighbors, which share what they made; an idle one takes from another."""
    from xdist.scheduler import WorkStealingScheduling

    return WorkStealingScheduling(config, log) if config.getvalue("dist") == "load" else None
