"""Options of several commands that say nothing about what is made: outputs, limits, printing."""

from __future__ import annotations

from typing import Any

HUGE = 2**28  # pixels

_OUTPUT, _SETS, _LARGE = "output", "map sets", "large outputs"
_NAMES = ("ambientcg", "polyhaven", "substance", "gltf")
#: Headings in the help, and arguments of `argparse.ArgumentParser.add_argument`.
SHARED: dict[str, tuple[str, dict[str, Any]]] = {
    "--output": ("", {"metavar": "OUT", "required": True,
                      "help": "file to write; a folder for a map set"}),
    "--threads": ("", {"type": int, "metavar": "N",
                       "help": "maximum number of threads; default: one per processor"}),
    "--quiet": ("", {"action": "store_true", "help": "print errors only"}),
    "--verbose": ("", {"action": "store_true", "help": "print what was read, all parameters and "
                       "the time that each stage took"}),
    "--allow-huge": (_OUTPUT, {"action": "store_true", "help": "accept images larger than "
                               f"{HUGE // 10**6} megapixels"}),
    "--save-source": (_OUTPUT, {"metavar": "F.npz", "help": "save the source of every pixel, for "
                                "'weftex replay' and 'weftex report'"}),
    "--preview": (_OUTPUT, {"metavar": "FILE", "help": "image to update during the run: a small "
                            "preview at first, the result at the end"}),
    "--names": (_SETS, {"choices": _NAMES, "metavar": "STYLE", "help": "how to name the written "
                        f"maps: {', '.join(_NAMES)}; default: as in the sample"}),
    "--mtlx": (_SETS, {"action": "store_true", "help": "also write a MaterialX file (.mtlx), "
                       "which renderers can open"}),
    "--block": (_LARGE, {"type": int, "metavar": "PX", "help": "side of the blocks, a power of "
                         "two; the image does not depend on it; default: 2048"}),
    "--restart": (_LARGE, {"action": "store_true",
                           "help": "delete what was written before and start again"}),
    "--part": (_LARGE, {"metavar": "K/N", "help": "write part K of N, on any machine that shares "
                        "the folder; needs --seed"}),
    "--workers": (_LARGE, {"type": int, "metavar": "N",
                           "help": "number of worker processes on this machine"}),
    "--cluster": (_LARGE, {"metavar": "tcp://HOST:PORT", "help": "use the workers of a Dask "
                           "scheduler that share the folder; needs weftex[dask]"}),
}  # fmt: skip
#: Those of images that are written block by block.
BLOCKS = ("--part", "--workers", "--cluster", "--restart", "--block")
SHORT = {"--output": "-o", "--verbose": "-v"}
#: Below headings of the help.
ABOUT = {
    _LARGE: "OUT.zarr and OUT.dzi, and OUT.tif of more than 268 megapixels, are written\n"
    "block by block. The same command resumes an interrupted run."
}
