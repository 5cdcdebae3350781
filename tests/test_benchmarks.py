"""The scripts of benchmarks that pages cite do run, small; test_gallery.py has the gallery's."""

import json
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

ROOT = Path(__file__).parent.parent
sys.path[:0] = [str(ROOT / "benchmarks" / name) for name in ("guards", "speed", "quality", "pages")]
import commits  # noqa: E402
import digests  # noqa: E402
import everyday  # noqa: E402
import fusion  # noqa: E402
import lattices  # noqa: E402
import many_threads  # noqa: E402
import pictures  # noqa: E402
import planes_on_disk  # noqa: E402
import repeats  # noqa: E402
import run  # noqa: E402
import soak  # noqa: E402
from shared import papers  # noqa: E402

pytestmark = pytest.mark.pages


@pytest.mark.parametrize("table", run.TABLES)
def test_tables(table, tmp_path, capsys):
    """Each is written into the page, where the others stay."""
    page = tmp_path / "benchmarks.md"
    page.write_text("# Page\n\n## memory\n\nOf before.\n\nkept\n", "utf-8")
    try:
        run.main([table, "--small", "--update", str(page), "--json", str(tmp_path / "found.json")])
    finally:
        papers.make_small(False)
    text = page.read_text("utf-8")
    found = json.loads((tmp_path / "found.json").read_text("utf-8"))
    head, rows = found[table]["head"], found[table]["rows"]
    assert f"\n## {table}\n\n{run.TABLES[table].__doc__}\n" in text and "Measured on: " in text
    assert rows and all(len(row) == len(head) for row in rows)
    assert ("kept" in text) == (table != "memory")
    assert f"## {table}" in capsys.readouterr().out


def test_small_tables_do_not_reach_the_repository(capsys):
    with pytest.raises(SystemExit):
        run.main(["speed", "--small", "--update"])
    assert "--small measures nothing" in capsys.readouterr().err


def test_the_page_has_every_table():
    """As they are headed in the page of the repository; --update writes them there."""
    text = run.PAGE.read_text("utf-8")
    assert [line[3:] for line in text.splitlines() if line.startswith("## ")] == list(run.TABLES)


def test_planes_on_disk(capsys):
    planes_on_disk.main(["speed", "--side", "200", "--workers", "0"])
    assert "times the method" in capsys.readouterr().out


def test_digests_are_compared(monkeypatch, capsys, tmp_path):
    """With a record of its own: whether bytes are the repository's is asked after each change."""
    record = tmp_path / "digests.json"
    monkeypatch.setattr(digests, "RECORD", record)
    words = ["digests.py", "--quick", "--only", "best of"]
    monkeypatch.setattr(sys, "argv", [*words, "--write"])
    assert not digests.main()
    (name,) = json.loads(record.read_text("utf-8"))
    monkeypatch.setattr(sys, "argv", words)
    assert not digests.main() and "1 of 1 equal" in capsys.readouterr().out
    assert name in json.loads((ROOT / "benchmarks" / "data" / "digests.json").read_text("utf-8"))


def test_boundaries_are_measured(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(fusion, "PAIRS", fusion.PAIRS[:1])
    monkeypatch.setattr(fusion, "MAPS", fusion.MAPS[:2])
    monkeypatch.setattr(sys, "argv", ["fusion", "--size", "60", "72", "--pictures", str(tmp_path)])
    fusion.main()
    assert len(capsys.readouterr().out.splitlines()) == 4
    assert len(list(tmp_path.glob("*.png"))) == 2
    file = tmp_path / "sheet.webp"
    monkeypatch.setattr(sys, "argv", ["fusion.py", "--size", "60", "72", "--sheet", str(file)])
    fusion.main()
    with Image.open(file) as made:
        assert made.size == (4 * 72 + 3 * 4, 3 * 60 + 2 * 4)


def test_lattices_are_counted(capsys):
    """A few small surfaces: every table is there, and what is right is never more than all."""
    lattices.main(["--small", "--fit"])
    out = capsys.readouterr().out
    assert "pairs = " in out and "rows = " in out and "| 256 |" in out and "| whole |" in out
    shares = [cell.split(" of ") for line in out.splitlines() for cell in line.split(" | ")]
    counts = [tuple(map(int, one)) for one in shares if len(one) == 2 and one[1].isdigit()]
    assert counts and all(good <= number for good, number in counts)


def test_repeats_are_measured(capsys):
    repeats.main(["80", "graphcut placement=entire", "--crop", "48", "--surfaces", "bark"])
    cells = capsys.readouterr().out.splitlines()[-1].strip("| ").split(" | ")
    assert cells[0] == "`graphcut placement=entire`" and all(float(cell) >= 0 for cell in cells[1:])


def test_figures_of_repeats():
    """Two copies side by side are in line and use all places alike; their seam is a border."""
    sample = np.zeros((32, 32, 1), np.uint8)
    sample[:, :16] = 100
    once = np.stack(np.mgrid[:32, :32], axis=2)
    source = np.hstack([once, once])
    assert repeats.seams(once, sample) == 0 and repeats.use(source, sample.shape) == (0, 0)
    assert repeats.again(source, 32)[0] > 1.5


def test_the_first_picture_of_a_page(monkeypatch, tmp_path):
    (tmp_path / "img").mkdir()
    page = ROOT / "docs" / "how-to" / "analyze.md"
    monkeypatch.setattr(pictures, "DOCS", tmp_path)
    kept = ROOT / "docs" / "img" / "analyze.webp"
    with Image.open(pictures.draw(page)) as made, Image.open(kept) as old:
        assert made.size == old.size


def test_pictures_of_the_landing_page(monkeypatch, tmp_path):
    monkeypatch.setattr(everyday, "ROWS", ("tile",))
    everyday.draw(tmp_path)
    with Image.open(tmp_path / "row_tile.webp") as drawn:
        assert drawn.height == 76 and drawn.width > 150


def test_two_installations_are_compared(monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["commits.py", sys.executable, sys.executable, "--small"])
    commits.main()
    (row,) = capsys.readouterr().out.splitlines()[2:]
    assert row.startswith("| patch-sampling 2048 | 0.")


def test_many_threads_make_the_same_bytes(monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["many_threads.py", "quilting", "best-tile"])
    assert many_threads.main() == 0
    assert "2 methods, 8 threads" in capsys.readouterr().out
    sys.setswitchinterval(0.005)


def test_soak():
    counts, seen = soak.soak(2 * soak.EVERY, 60, seed=2)
    assert counts["done"] and counts["refused"] and counts.total() == 2 * soak.EVERY
    assert {"MiB", "files", "threads"} < soak.growth(seen).keys()
    assert seen[0][1]["left in /tmp"] == seen[1][1]["left in /tmp"] == 0


def test_planes_are_scored_across_blocks_and_inside():
    import planes

    found = planes.scores("quilting", planes.SURFACES / "weave_red.webp", count=1)
    assert len(found) == 3 and all(0 <= score < 30 for score in found)
