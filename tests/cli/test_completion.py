"""Completion: what shells make of it, where they are installed."""

import shutil
import subprocess

import pytest

from commands import weft_run
from weftex import METHODS, cli

pytest.importorskip("shtab")
#: What each shell is given, and asked to complete.
ASKED = {
    "bash": """source {0}
        COMP_WORDS=({1}); COMP_CWORD=$((${{#COMP_WORDS[@]}} - 1))
        _shtab_weftex; echo "${{COMPREPLY[@]}}" """,
    "fish": "source {0}; complete -C '{1}'",
    "zsh": None,  # completes at a prompt only, so it is only read
}


@pytest.mark.parametrize("shell", ASKED)
def test_shells_read_it(shell, tmp_path, capsys):
    assert weft_run("completion", shell) == 0
    text = capsys.readouterr().out
    assert all(f"{name}" in text for name in (*cli._COMMANDS, *METHODS, "patch-size"))
    script = tmp_path / "weftex"
    script.write_text(text, "utf-8")
    if shutil.which(shell) is None:
        pytest.skip(f"{shell} is not installed")
    done = subprocess.run([shell, "-n", script], capture_output=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (0, b"", b"")
    for line, found in {
        "weftex syn": "synth",
        "weftex synth --method gra": "graphcut",
        "weftex fuse --patch-s": "--patch-size",
        "weftex methods qui": "quilting",
    }.items():
        if ASKED[shell] is not None:
            asked = ASKED[shell].format(script, line)
            done = subprocess.run([shell, "-c", asked], capture_output=True, text=True, check=False)
            assert done.stdout.split()[0] == found, done
