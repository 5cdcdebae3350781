"""The command that prepares photos; without options, what it says."""

import numpy as np

import weftex
from weftex.cli import main


def test_rows_of_bricks_that_are_not_level_are_told(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    wall = weftex.synthesize("sample:bricks", 400, seed=1).image
    y, x = np.indices((300, 300))  # by four degrees: their shortest vectors lead to the next row
    turned = wall[np.rint(y - 0.07 * x + 30).astype(int), np.rint(x + 0.07 * y).astype(int)]
    for pixels, said in ((turned, "the rows are not level"), (wall, "its rows are level")):
        weftex.write_image("wall.png", pixels)
        assert main(["prepare", "wall.png"]) == 0
        assert said in capsys.readouterr().out


def test_without_options_it_says_what_the_photo_needs(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    bricks = weftex.load_exemplar("sample:bricks").pixels
    light = np.linspace(0.4, 1, bricks.shape[1])[:, None]
    weftex.write_image("dim.png", (bricks * light).astype(np.uint8))
    assert main(["prepare", "dim.png"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert "levels across the sample" in lines[0]
    command = lines[-1].split()
    assert command[:5] == ["weftex", "prepare", "dim.png", "-o", "OUT"]
    assert main([*command[1:4], "even.png", *command[5:]]) == 0
    assert main(["prepare", "even.png"]) == 0
    assert "needs no preparation" in capsys.readouterr().out
    assert main(["prepare", "dim.png", "--even-light"]) == 2
    assert "-o OUT is missing" in capsys.readouterr().err
