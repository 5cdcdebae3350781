"""The examples in docstrings, run with the package that is installed and not with src/.

pytest's own --doctest-modules imports files by their paths, and would run the kernels' sources
instead of what was compiled from them.
"""

import doctest
import importlib
import pkgutil

import pytest

import weftex

MODULES = [
    module.name
    for module in pkgutil.walk_packages(weftex.__path__, "weftex.")
    if not module.name.startswith("weftex._avx2") and not module.name.endswith("__main__")
]


@pytest.mark.parametrize("name", ["weftex", *MODULES])
def test_examples_in_docstrings(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = doctest.testmod(importlib.import_module(name), optionflags=doctest.ELLIPSIS)
    assert result.failed == 0, "see the output above"


def test_the_main_entry_points_have_examples():
    from weftex.tasks import fill, synthesize

    for module in (weftex, synthesize, fill):
        assert doctest.testmod(module).attempted > 0
