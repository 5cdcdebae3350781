"""A folder to run commands in."""

import tempfile

import numpy as np
import pytest

from families import noise
from processes import ENVIRONMENT
from weftex.io.pictures import write_image


@pytest.fixture
def here(tmp_path, monkeypatch):
    """A folder with a sample, a photo and masks, that is the current one."""
    monkeypatch.chdir(tmp_path)
    write_image("sample.png", noise((64, 72, 3)))
    write_image("photo.png", noise((80, 96, 3), seed=1))
    hole = np.zeros((80, 96), np.uint8)
    hole[30:50, 40:60] = 255
    write_image("hole.png", hole)
    write_image("nothing.png", 0 * hole)
    write_image("all.png", 0 * hole + 255)
    write_image("other.png", noise((40, 40)))
    return tmp_path


@pytest.fixture
def temporary_folder(tmp_path_factory, monkeypatch):
    """Where standard input lies meanwhile, which no other test uses."""
    folder = tmp_path_factory.mktemp("temporary")
    monkeypatch.setitem(ENVIRONMENT, "TMPDIR", str(folder))
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    return folder
