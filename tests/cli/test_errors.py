"""Bad input is one line, and leaves every file as it was."""

import re

import numpy as np
import pytest

import weftex
from commands import fails
from families import noise
from picture_files import bomb
from weftex.io.pictures import write_image

#: What S, F and P stand for in commands: a picture, one of two samples, and a plane on disk.
STARTS = {
    "S": "synth sample.png -o x.png",
    "F": "fuse sample.png photo.png -o x.png --map",
    "P": "synth sample.png --method best-tile --lattice 20,0,0,20 --seed 4 --block 64 -o",
}
#: Commands, and a part of their messages.
WRONG = [
    ("", "a command is missing"),
    ("snyth", "unknown command 'snyth'; did you mean 'synth'"),
    ("photo.png", "before 'photo.png'; try: weftex synth photo.png -o out.png"),
    ("S --seamless", "did you mean '--tileable'"),
    ("synth", "required: SAMPLE"),
    ("synth sample.png", "-o/--output"),
    ("synth nowhere.png -o x.png", "nowhere.png: cannot read"),
    ("synth sample:brick -o x.png", "did you mean 'bricks'"),
    ("synth sample.png -o x.pngg", "did you mean '.png'"),
    ("synth sample.png -o ./sample.png", "sample.png is an input; name another file"),
    ("synth sample.png -o linked.png", "linked.png is an input"),
    ("synth sample.png -o twin.png", "twin.png is an input"),
    ("S --save-source sample.png", "sample.png is an input"),
    ("synth sample:grass -o other.png --sample-mask other.png", "other.png is an input"),
    ("fill photo.png --mask hole.png -o hole.png", "hole.png is an input"),
    ("synth uneven -o uneven", "uneven is an input"),
    ("analyze sample.png --overlay sample.png", "sample.png is an input"),
    ("analyze uneven --overlay uneven/a.png", "uneven/a.png is an input"),
    ("S --debug d.png", "d.png: the output has several files; name a folder"),
    ("estimate sample.png -o foo.png", "foo.png: the output has several files"),
    ("batch uneven -o foo.tif", "foo.tif: the output has several files"),
    ("S --sample-mask hole.png", "scale or crop the mask"),
    ("S --size -5", "1 or more"),
    ("S --size 5x7x9", "WxH"),
    ("S --size 99999999", "--allow-huge"),
    ("S --size 99999999 --allow-huge", "pixels at once"),
    ("S --method quiltin", "did you mean 'quilting'"),
    ("S --method patch-sampling --patchsize 9", "did you mean '--patch-size'"),
    ("S --patch-size 9", "--method patch-sampling or"),
    ("fill photo.png -o x.png --placement entire", "so name one: --method graphcut"),
    ("S --threads 0", "--threads is 0"),
    ("synth cut.png -o old.png", "cut short"),
    ("synth bomb.png -o old.png", "--allow-huge accepts it"),
    ("synth nan.tif -o x.tif", "NaN or infinity"),
    ("synth void -o x", "has no images"),
    ("synth uneven -o x", "\\(a, b\\)"),
    ("fill uneven --mask other.png -o x", "\\(a, b\\)"),
    ("analyze uneven", "\\(a, b\\)"),
    ("compare uneven -o x.html", "\\(a, b\\)"),
    ("report uneven other.png -o x.html", "\\(a, b\\)"),
    ("synth uneven -o x --maps color=a.png,height=b.png", "multiple or fraction"),
    ("S --method patch-sampling --guide photo.png", "not support following a guide; .*ashikhmin"),
    ("synth sample.png sample.png -o x.png --tileable-sample", "--tileable-sample needs one"),
    ("S --turn 2", "--turn is '2'; known: 4, 8, flip, half"),
    ("S --window 1,2", "--window is '1,2'; it must be TOP,LEFT,HEIGHT,WIDTH"),
    ("S --window 1,2,3,4 --size 50", "give --size or --window, not both"),
    ("S --period 50", "--period has no effect without --window"),
    ("S --part 1/2", "--part has no effect"),
    ("P p.tif --part 1/2 --workers 2", "give --part or --workers"),
    ("P p.tif --workers 2 --threads 2", "--threads has no effect"),
    ("P p.tif --restart --part 1/2", "--restart has no effect"),
    ("P p.tif --block 64 --guide photo.png", "--guide needs the whole image"),
    ("P p.tif --block 64 --best-of 3", "--best-of needs the whole image"),
    ("S --block 0", "--block has no effect"),
    ("prepare sample.png -o x.png", "nothing to do"),
    ("prepare sample.png -o x.png --even-light 9", "--even-light is '9'; it must be from 1 to 8"),
    ("fill photo.png -o x.png --mask hole.png --tileable-sample", "no effect without --sample"),
    ("fill photo.png -o x.png", "no transparent pixels; give a mask \\(--mask"),
    ("fill photo.png --mask other.png -o old.png", "40x40.*96x80; scale or crop the mask"),
    ("replay photo.png sample.png -o x.png", "not a saved weftex result"),
    ("replay a.npz photo.png -o x.png", "integer multiple"),
    ("F hole.png --colors red,blue", "--colors is 'red,blue'; it must be colors, #rrggbb, or gray"),
    ("F hole.png --colors 1", "1 colors for 2 samples"),
    ("F hole.png --mixed 3", "--mixed is '3'; it must be colors and two samples each"),
    ("F hole.png --mixed #00ff00=1+x", "--mixed is '#00ff00=1.x'"),
    ("F hole.png --width 0.5", "--width has no effect unless --map is gradient"),
    ("F hole.png --size 2m", "weftex prepare sets it: --sample-width 0.6m"),
    ("F gradient --size 50 --direction down", "--direction is 'down'; it must be a number"),
    ("F gradient --size 50 --width 0", "width is 0.0; it must be above 0"),
    ("S --best-of 0", "--best-of is '0'; it must be from 1"),
    ("S --best-of graphcut", "--best-of is 'graphcut'; it must be from 1"),
    ("S --debug new --sample-guide photo.png", "--sample-guide has no effect without a guide"),
    ("S --size 2m", "sample.png states no density; give the"),
    ("S --size 2mx3", "2k or 2mx1.5m \\(meters\\)"),
    ("S --sample-width 2k", "0.6m, 60cm or 600mm"),
    ("S --sample-width 0m", "a length above 0"),
    ("S --sample-width 9m --density 90px/m", "sample.png, 72x64, would be scaled 11.25 times"),
    ("prepare sample.png -o b.png --density 90", "sample.png states none; give the"),
    ("batch uneven -o out --size 2m", "batch needs pixels, as samples may differ"),
    ("analyze nothing.tif", "nothing.tif: cannot read"),
    ("analyze sample.png --jsno", "did you mean '--json'"),
    ("analyze sample.png photo.png", "unexpected argument 'photo.png'"),
    ("analyze sample.png --lattice 1,2,3", "lattice is '1,2,3'; it must be 4 numbers"),
    ("analyze sample.png --lattice 900,0,0,20", "it must be smaller"),
    ("estimate sample.png -o b --relief -1", "above 0"),
    ("estimate sample.png photo.png -o b --maps rough", "maps has 'rough'"),
    ("atlas sample.png -o out --colors 4", "--colors is '4'; it must be from 2 to 3"),
    ("atlas sample.png -o out --gutter -1", "--gutter is '-1'; it must be 0 or more"),
    ("atlas sample.png -o out --tile-size 512", "72x64, too small for the corners of tiles"),
    ("atlas sample.png -o out --method best-tile", "best-tile does not support hole filling"),
    ("atlas sample.png -o out --size 64", "--size has no effect on atlas; it is for synth, fuse"),
    ("compare sample.png -o c.png", "cannot write '.png'"),
    ("compare sample.png --json --seed -1", "--seed is"),
    ("report sample.png", "RESULT"),
    ("report sample.png no.png --json", "no.png: cannot read"),
    ("report no.png sample.png --json", "no.png: cannot read"),
    ("report sample.png photo.png -o r.htm", "did you mean '.html'"),
    ("report sample.png photo.png -o no/r.html", "does not exist"),
    ("report sample.png photo.png --source no.npz --json", "does not exist"),
    ("report sample.png photo.png --source photo.png --json", "not a saved weftex result"),
    ("report sample.png photo.png --source a.npz --json", "the source makes 80x80 from 72x64"),
    ("report sample.png other.png --json", "uint8 with 1 channels"),
    ("methods quiltin", "did you mean 'quilting'"),
    ("samples more", "unexpected argument"),
]


@pytest.mark.parametrize(("words", "message"), WRONG, ids=[words[:60] for words, _ in WRONG])
def test_bad_input_is_one_line_and_leaves_everything(here, capsys, words, message):
    whole = (here / "sample.png").read_bytes()
    (here / "old.png").write_bytes(whole)
    (here / "cut.png").write_bytes(whole[: len(whole) // 2])
    (here / "bomb.png").write_bytes(bomb(100_000, 100_000))
    write_image("nan.tif", np.full((40, 40), np.nan, np.float32))
    (here / "void").mkdir()
    (here / "uneven").mkdir()
    write_image("uneven/a.png", noise((40, 40)))
    write_image("uneven/b.png", noise((40, 41)))
    (here / "linked.png").symlink_to("sample.png")
    (here / "twin.png").hardlink_to("sample.png")
    if "a.npz" in words:
        weftex.synthesize("sample.png", 80, method="quilting", seed=1).save("a.npz")
    words = re.sub("^[SFP](?= )", lambda start: STARTS[start.group()], words).split()
    assert re.search(message, fails(capsys, here, *words))


def test_not_enough_memory_is_one_line(here, capsys, monkeypatch):
    def fail(*_, **__):
        raise MemoryError

    monkeypatch.setattr("weftex.recipe.opening.OpenedRecipe.make", fail)
    message = fails(capsys, here, "synth", "sample.png", "-o", "x.png")
    assert "not enough memory" in message


def test_a_map_that_cannot_be_written_leaves_no_map(here, capsys, monkeypatch):
    import weftex.io.outputs

    real, seen = weftex.io.outputs.write_image, []

    def fail_third(*words, **options):
        seen.append(words)
        if len(seen) == 3:
            raise weftex.FileError("the disk is full")
        real(*words, **options)

    monkeypatch.setattr(weftex.io.outputs, "write_image", fail_third)
    words = ["synth", "sample:stone_wall", "-o", "new", "--size", 80]
    fails(capsys, here, *words, "--threads", 1)
    assert len(seen) == 3
    seen.clear()
    fails(capsys, here, *words, "--threads", 3)
    (here / "old").mkdir()
    real("old/albedo.png", noise((9, 9)))
    seen.clear()
    fails(capsys, here, "synth", "sample:stone_wall", "-o", "old", "--size", 80)
