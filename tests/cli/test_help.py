"""What the command line says: methods, samples, version and help."""

import dataclasses

import weftex
from commands import weft_run


def test_methods(capsys):
    assert weft_run("methods") == 0
    table = capsys.readouterr().out
    assert all(slug in table and weftex.METHODS[slug].title in table for slug in weftex.METHODS)
    for slug in weftex.METHODS:
        assert weft_run("methods", slug) == 0
        text = capsys.readouterr().out
        assert weftex.METHODS[slug].paper in text
        for field in dataclasses.fields(weftex.METHODS[slug]):
            assert f"--{field.name.replace('_', '-')}\n    {field.metadata['help']}\n" in text
    assert weft_run("methods", "quilting") == 0
    assert f"to 10; default: {weftex.Quilting().repeat_distance:g}" in capsys.readouterr().out


def test_samples_version_and_help(capsys):
    assert weft_run("samples") == 0
    assert "sample:bricks\n" in capsys.readouterr().out
    assert weft_run("--version") == 0
    assert capsys.readouterr().out == f"weftex {weftex.__version__}\n"
    assert weft_run("--help") == 0
    out = capsys.readouterr().out
    assert all(name in out for name in ("synth", "fill", "replay", "methods", "samples"))
    assert weft_run("synth", "--help", "--method", "quilting") == 0
    out = capsys.readouterr().out
    assert "--tolerance" in out and "examples:" in out
    assert out.startswith("usage: weftex synth SAMPLE [SAMPLE ...] -o OUT [options]\n")
