"""Commands of weftex, run in this process, and what they leave behind."""

from weftex import cli
from weftex.io.map_files import map_files
from weftex.io.pictures import read_image


def listing(folder):
    """Every file below a folder, with its bytes."""
    return {p: p.read_bytes() for p in folder.rglob("*") if p.is_file()} | {
        p: None for p in folder.rglob("*") if p.is_dir()
    }


def weft_run(*words):
    return cli.main([str(word) for word in words])


def fails(capsys, folder, *words):
    """Run a command that must fail; return its message."""
    before = listing(folder)
    code = weft_run(*words)
    out, err = capsys.readouterr()
    assert code == 2 and out == ""
    assert err.startswith("weftex: error: ") and err.count("\n") == 1, err
    assert listing(folder) == before
    return err


def read_maps(folder, **limits):
    """All pictures of a folder by their names without suffix."""
    paths = map_files(folder)[0]
    return {stem: read_image(path, **limits) for stem, path in sorted(paths.items())}
