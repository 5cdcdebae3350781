"""weftex methods: list the methods, or the parameters of one."""

from __future__ import annotations

from weftex.cli.options import parameters_of
from weftex.cli.parser import Parser


def run(argv: list[str]) -> None:
    """Run the command; `argv` is what follows its name."""
    parser = Parser("methods", "List the methods, or the parameters of one.", "")
    parser.add_argument("method", metavar="NAME", nargs="?", help="method whose parameters to list")
    name = parser.parse(argv).method
    from weftex.method import CANVAS_KINDS
    from weftex.methods import METHODS
    from weftex.tasks.method_names import AUTO, method_class

    if name is None:
        for slug, cls in ((AUTO, method_class(AUTO)), *METHODS.items()):
            kinds = ", ".join(text for kind, text in CANVAS_KINDS.items() if kind in cls.supports)
            print(f"{slug:16}  {cls.title:22}  {kinds}")
        return
    cls = method_class(name)
    print(f"{cls.title}\n{cls.paper}\n")
    for field, values in parameters_of(cls):
        print(f"--{field.name.replace('_', '-')}\n    {field.metadata['help']}\n    {values}")
