"""Run every method on one sample, and write a page with the results.

The page shows the results, the sources of their pixels, scores, times and parameters. Slow methods
run with faster parameters, which the page names.

examples:
  weftex compare brick.png -o compare.html
  weftex compare brick.png --methods quilting,graphcut,near-regular -o compare.html --json
"""

from __future__ import annotations

from weftex.cli.arguments import check_numbers, refuse_huge
from weftex.cli.files import load_sample
from weftex.cli.parser import Parser
from weftex.cli.terminal import Bar, Outputs, print_json, run_and_report
from weftex.io.pictures import check_output
from weftex.pages.comparisons import compare
from weftex.recipe import MATERIAL, SEED
from weftex.recipe.command_line import value_of
from weftex.recipe.declared import OUTPUT_SIZE, TILEABLE


def run(argv: list[str]) -> None:
    """Run the command; `argv` is what follows its name."""
    parser = Parser("compare", __doc__)
    add = parser.add_argument
    add("sample", metavar="SAMPLE", help="image, folder of maps, or sample:NAME")
    add("-o", "--output", metavar="OUT.html", help="page to write")
    add("--methods", metavar="A,B,...", help="only these methods; see 'weftex methods'")
    size = OUTPUT_SIZE._replace(default_text="twice the sample's, at most 512")
    seed = SEED._replace(help="random seed of all methods", default_text="1")
    text = "compare tileable outputs: along both axes, or only along x or y"
    parser.take(size, seed)
    parser.take(TILEABLE, help=text)
    own = ("maps", "map_weights", "repeats", "turn")
    parser.take(*(MATERIAL[name] for name in own))
    add("--json", action="store_true", help="print the scores and times as JSON")
    parser.share("--threads", "--quiet", "--allow-huge")
    args = parser.parse(argv)
    values = {one.name: value_of(one, vars(args)) for one in (size, seed, TILEABLE)}
    if values["size"] is not None:
        refuse_huge(values["size"], args)
    names = None if args.methods is None else [word.strip() for word in args.methods.split(",")]
    check_numbers(args)
    how = {"seed": 1 if values["seed"] is None else values["seed"], "threads": args.threads}

    def work(bar: Bar, outputs: Outputs) -> str:
        if args.output is not None:
            check_output(args.output, suffixes=(".html",))
        exemplar, axes = load_sample(args.sample, args, *own), values["tileable"] or False
        found = compare(exemplar, values["size"], tileable=axes, methods=names, progress=bar, **how)
        if args.output is not None:
            found.save(outputs.staged_path(args.output))
        if args.json:
            print_json(found.as_dict())
        best = found.entries[0]
        said = f"compared {len(found.entries)} methods in {bar.took:.1f} s"
        said += f"; {best.method} has the best score" if best.assessment is not None else ""
        said += f"; {args.output} shows all" if args.output is not None else ""
        entries = () if args.output or args.json else found.entries
        lines = [f"{entry.method} {entry.rank:.2f}" for entry in entries]
        return "\n".join([*lines, *filter(None, [found.contradiction]), said])

    run_and_report(work, args.quiet)
