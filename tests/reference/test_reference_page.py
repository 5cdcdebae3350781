"""The page that shows the references."""

import re
from pathlib import Path

from PIL import Image

from weftex import reference

ROOT = Path(__file__).parents[2]


def test_the_page_shows_every_reference():
    page = (ROOT / "docs" / "background" / "reference-algorithms.md").read_text("utf-8")
    shown = re.findall(r"^\[`(\w+)`\]\(\.\./\.\./src/weftex/reference/(\w+)\.py\)$", page, re.M)
    assert sorted(shown) == [(name, name) for name in reference.__all__ if name.islower()]
    pictures = re.findall(r"\(\.\./img/reference_(\w+)\.webp\)", page)
    assert sorted(pictures) == [name for name, _ in sorted(shown)]
    for name, _ in shown:
        assert callable(getattr(reference, name))
        python = (ROOT / "docs" / "reference" / "python" / "papers.md").read_text("utf-8")
        assert f"weftex.reference.{name}.{name}" in python


def test_pictures_are_drawn(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(ROOT / "benchmarks" / "pages")
    import references

    assert sorted(references.PICTURES) == [name for name in reference.__all__ if name.islower()]
    monkeypatch.setattr(references, "IMAGES", tmp_path)

    def small():
        return references.of("leaves", 4, 24, lambda s: reference.ashikhmin(s, (10, 12)))

    monkeypatch.setitem(references.PICTURES, "ashikhmin", small)
    references.main(["ashikhmin"])
    with Image.open(tmp_path / "reference_ashikhmin.webp") as picture:
        assert picture.size == (2 * (24 + 12) + 6, 2 * 24)
