"""weftex methods and samples: lists of both, and the parameters of a method."""

from __future__ import annotations

from weftex.cli.arguments import parameters_of
from weftex.cli.parser import Parser
from weftex.io.pictures import is_folder, sample_names
from weftex.registry import AUTO, METHODS, method_class

#: Headings of what not every method does, and the kinds of canvas that it takes.
_KINDS = {"FILLS HOLES": "known", "FOLLOWS A GUIDE": "guide", "FUSES SAMPLES": "many"}
_LINE = "{:16}{:37}{:13}{:17}{}"


def run(argv: list[str]) -> None:
    """Run `weftex methods`; `argv` is what follows its name."""
    parser = Parser("methods", "List the methods, or the parameters of one.")
    parser.add_argument("method", metavar="NAME", nargs="?", help="method whose parameters to list")
    name = parser.parse(argv).method
    if name is None:
        print(_LINE.format("NAME", "METHOD", *_KINDS))
        for slug, cls in ((AUTO, method_class(AUTO)), *METHODS.items()):
            able = ("yes" if slug == AUTO or k in cls.supports else "no" for k in _KINDS.values())
            print(_LINE.format(slug, cls.title, *able))
        print("\nAll built-in methods make larger and tileable images.", end=" ")
        print("'weftex methods NAME' lists parameters.")
        return
    cls = method_class(name)
    print(f"{cls.title}\n{cls.paper}\n")
    for field, values in parameters_of(cls):
        print(f"--{field.name.replace('_', '-')}\n    {field.metadata['help']}\n    {values}")


def run_samples(argv: list[str]) -> None:
    """Run `weftex samples`."""
    Parser("samples", "List the samples that ship with weftex.").parse(argv)
    for name in sample_names():
        folder = "  (a folder of aligned maps)" if is_folder(f"sample:{name}") else ""
        print(f"sample:{name}{folder}")
