"""The command line; what the options of a method are, its dataclass says."""

from __future__ import annotations

import os
import sys
from contextlib import suppress
from time import perf_counter
from typing import Any, NoReturn

from weft.errors import InvalidInputError, WeftError, did_you_mean
from weft.options import (
    Parser,
    add_huge,
    add_limits,
    check_numbers,
    parameters_of,
    parse_best_of,
    parse_colors,
    parse_mixed,
    parse_size,
    parse_task,
)
from weft.pictures import load, open_sample, report, settings, write, write_debug
from weft.terminal import Bar, Outputs, Stopped, run, say

_ABOUT = """\
usage: weft COMMAND ...      (weft COMMAND --help says more)

  synth     make a picture of any size from a sample of a material
  fill      fill holes of a photo
  fuse      merge several materials where a map says
  replay    lay a saved result again with another map of the same sample
  analyze   say what a sample is like: its scale, its lattice, whether it tiles
  compare   every method on one sample, side by side: pictures, figures, times
  report    say how good a result is, in figures and maps of where it fails
  methods   list the methods, or the parameters of one
  samples   list the samples that ship with weft

  weft synth sample:bricks -o wall.png --size 1024x768
  weft synth brick.png -o tile.png --size 512 --tileable --seed 7
  weft fill photo.png --mask hole.png -o whole.png
  weft --version
"""
_SYNTH = """\
examples:
  weft synth brick.png -o wall.png --size 1024x768 --save-source wall.npz
  weft synth brick.png -o tile.png --size 512 --tileable --seed 7
  weft synth stone_wall/ -o big/ --size 2048        a folder of aligned maps
  weft synth brick.png -o wall.png --method quilting --patch-size 48
  weft synth brick.png -o wall.png --best-of 8      the best of eight seeds
  weft synth brick.png -o wall.png --best-of quilting,graphcut,near-regular
  weft synth moss.png -o face.png --method ashikhmin --guide face.png
  weft synth photo.png -o new.png --method refinement --sample-guide painted.png --guide other.png
"""
_FILL_ABOUT = """\
Fill holes of a photo; all other pixels stay as they are. Patch size, boundary width and epsilon are
chosen for holes where they are not given.\
"""
_FILL = """\
examples:
  weft fill photo.png --mask hole.png -o whole.png
  weft fill photo.png --mask hole.png -o whole.png --sample grass.png
  weft fill stone_wall/ --mask hole.png -o whole/   a folder of aligned maps
"""
_FUSE_ABOUT = """\
Make a picture of several materials that merge where a map says. The map has one colour for each
sample: those of --colors, or in the order in which they appear, from the upper left corner row by
row. The map 'gradient' goes over from the first of two samples to the second, from top to bottom.\
"""
_FUSE = """\
examples:
  weft fuse clover.png grape.png plum.png --map map.png -o field.png
  weft fuse clover.png grape.png --map map.png --colors '#ff0000,#0000ff' -o field.png
  weft fuse purple.png yellow.png --map gradient --size 400x400 -o beans.png
"""
_REPLAY = """\
examples:
  weft replay wall.npz normal_16bit.png -o wall_normal.png
  weft replay filled.npz height.exr -o filled_height.exr --background photo_height.exr
  weft replay field.npz clover_height.png grape_height.png plum_height.png -o field_height.png
"""
_ANALYZE = """\
examples:
  weft analyze stones.png
  weft analyze stone_wall/ --json
  weft analyze brick.png --overlay lattice.png
"""
_COMPARE_ABOUT = """\
Make the same from one sample with every method: a page with the pictures, where every pixel comes
from, figures, times and parameters. Slow methods get fast options, and the page says so.\
"""
_COMPARE = """\
examples:
  weft compare brick.png -o compare.html
  weft compare brick.png --methods quilting,graphcut,near-regular --size 512 -o compare.html --json
"""
_REPORT_ABOUT = """\
Say how good a result is beside its sample: a page with pictures, maps of where it fails, and every
figure beside that of real pictures of the surface.\
"""
_REPORT = """\
examples:
  weft report brick.png wall.png -o report.html
  weft report brick.png wall.png --source wall.npz -o report.html
  weft report brick.png tile.png --tileable --json
"""


def main(argv: list[str] | None = None) -> int:
    """Run a command.

    Parameters
    ----------
    argv : list of str, optional
        Arguments; those of the process by default.

    Returns
    -------
    int
        The exit code: 0, 2 after an error, 130 after Ctrl-C, 143 after SIGTERM.
    """
    if "numpy" not in sys.modules:
        # The matrix products here are small; threads for them take longer to start than they save.
        os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    try:
        arguments = sys.argv[1:] if argv is None else argv
        if not arguments:
            raise InvalidInputError("a command is missing; weft --help lists them")
        name = arguments[0]
        if name in ("-h", "--help", "help"):
            print(_ABOUT, end="")
        elif name in ("-V", "--version"):
            from weft import __version__

            print(f"weft {__version__}")
        elif name in _COMMANDS:
            _COMMANDS[name](arguments[1:])
        else:
            what = "option" if name.startswith("-") else "command"
            raise InvalidInputError(f"unknown {what} '{name}'{did_you_mean(name, _COMMANDS)}")
        return 0
    except SystemExit as end:  # argparse after --help
        return int(end.code or 0)
    except (KeyboardInterrupt, Stopped) as end:
        say("stopped; nothing was written")
        return end.code if isinstance(end, Stopped) else 130
    except MemoryError as error:
        say(f"error: not enough memory{f' ({error})' if str(error) else ''}; make it smaller")
    except WeftError as error:
        hint = "; --allow-huge takes it anyway" if "max_pixels" in str(error) else ""
        say(f"error: {error}{hint}")
    except BrokenPipeError:  # such as 'weft methods | head'
        return 141
    except OSError as error:
        say(f"error: {error}")
    return 2


def _finish(message: str, quiet: bool) -> None:
    if not quiet:
        for line in message.splitlines():
            say(line)


def _synth(argv: list[str]) -> None:
    start = perf_counter()
    parser = Parser("synth", "Make a picture of any size from a sample of a material.", _SYNTH)
    parser.add_argument("sample", metavar="SAMPLE", help="picture, folder of maps, or sample:NAME")
    text = "in pixels; default: the guide's, or twice the sample's"
    parser.add_argument("--size", metavar="WxH|N", help=text)
    parser.add_argument("--guide", metavar="G", help="picture to follow, of the output's size")
    text = "what stands for the sample in the guide, such as a painted map of what is where in it"
    parser.add_argument("--sample-guide", metavar="S", help=text)
    text = "make N with the seeds from --seed on, or one with each method, and keep the best"
    parser.add_argument("--best-of", metavar="N|NAME,...", default="1", help=text)
    text = "write how it was put together: coordinates, patches, seams, uncertainty"
    parser.add_argument("--debug", metavar="DIR", help=text)
    args, method, parameters = parse_task(parser, argv)
    best_of = parse_best_of(args.best_of)
    size = None if args.size is None else parse_size(args.size, args.allow_huge)
    chosen = method(**parameters)
    if best_of != 1:
        from weft.tasks.best_of import tries

        tries(chosen, best_of)  # finds wrong names before anything is read

    def work(bar: Bar, outputs: Outputs) -> str:
        from weft.tasks.synthesize import synthesize

        exemplar, pictures, targets = open_sample(args.sample, args, outputs)
        if args.debug is not None:
            outputs.make_folder(args.debug)
        guide = None if args.guide is None else load(args.guide, args)[0]
        own = None if args.sample_guide is None else load(args.sample_guide, args)[0]
        size_made = size or (2 * exemplar.shape[0], 2 * exemplar.shape[1])
        if guide is not None:
            size_made = size or guide.shape
        guides: dict[str, Any] = {"guide": guide, "sample_guide": own, "best_of": best_of}
        result = synthesize(exemplar, size_made, method=chosen, **guides, **settings(args, bar))
        write(result, exemplar, pictures, targets, args, outputs)
        if args.debug is not None:
            write_debug(result, args.debug, outputs)
        what = f"made {result.shape[1]}x{result.shape[0]}"
        return report(args, result, what, start)

    _finish(run(work, args.quiet), args.quiet)


def _fill(argv: list[str]) -> None:
    start = perf_counter()
    parser = Parser("fill", _FILL_ABOUT, _FILL)
    parser.add_argument("photo", metavar="PHOTO", help="picture, folder of maps, or sample:NAME")
    parser.add_argument("--mask", metavar="M", required=True, help="picture, white where to fill")
    parser.add_argument("--sample", metavar="S", help="learn from this picture, not from the photo")
    args, method, parameters = parse_task(parser, argv, "patch-sampling")
    method(**parameters)  # finds wrong values before anything is read

    def work(bar: Bar, outputs: Outputs) -> str:
        from weft import io
        from weft.tasks.fill import fill

        photo, pictures, targets = open_sample(args.photo, args, outputs)
        mask = io.read_mask(args.mask, max_pixels=None if args.allow_huge else io.MAX_PIXELS)
        sample = None if args.sample is None else load(args.sample, args)[0]
        result = fill(
            photo, mask, sample=sample, method=args.method, **settings(args, bar), **parameters
        )
        write(result, photo, pictures, targets, args, outputs)
        if not mask.any():
            return f"the mask covers nothing; {args.output} is the photo unchanged"
        return report(args, result, f"filled {int(mask.sum())} pixels of", start)

    _finish(run(work, args.quiet), args.quiet)


def _fuse(argv: list[str]) -> None:
    start = perf_counter()
    parser = Parser("fuse", _FUSE_ABOUT, _FUSE)
    parser.add_argument("samples", metavar="SAMPLE", nargs="+", help="pictures, or sample:NAME")
    parser.add_argument("--map", metavar="M", required=True, help="picture, or 'gradient'")
    text = "the map's colour for each sample, as #rrggbb or a grey level"
    parser.add_argument("--colors", metavar="C,C,...", help=text)
    text = "further colours, of regions where two samples are mixed, as #rrggbb=1+2"
    parser.add_argument("--mixed", metavar="C=A+B,...", help=text)
    parser.add_argument("--size", metavar="WxH|N", help="in pixels; default: the map's")
    args, method, parameters = parse_task(parser, argv, "refinement")
    size = None if args.size is None else parse_size(args.size, args.allow_huge)
    colors = None if args.colors is None else parse_colors(args.colors)
    mixed = None if args.mixed is None else parse_mixed(args.mixed)
    chosen = method(**parameters)

    def work(bar: Bar, outputs: Outputs) -> str:
        from weft import io
        from weft.tasks.fuse import fuse

        io.check_output(args.output)
        samples, pictures = zip(*(load(path, args) for path in args.samples), strict=True)
        first = pictures[0][samples[0].name]
        io.check_output(args.output, first.pixels, alpha=first.alpha)
        label_map = args.map
        if label_map != "gradient":
            label_map = io.read_image(label_map).pixels
        named: dict[str, Any] = {"colors": colors, "mixed": mixed}
        result = fuse(samples, label_map, size, method=chosen, **named, **settings(args, bar))
        assert result.exemplar is not None
        own = {result.exemplar.name: first}
        write(result, result.exemplar, own, {result.exemplar.name: args.output}, args, outputs)
        return report(args, result, f"fused {len(samples)} samples in", start)

    _finish(run(work, args.quiet), args.quiet)


def _replay(argv: list[str]) -> None:
    start = perf_counter()
    parser = Parser("replay", "Lay a saved result again with another map of its sample.", _REPLAY)
    add = parser.add_argument
    add("source", metavar="F.npz", help="what --save-source saved")
    text = "of the sample's size, or an integer multiple of it; of a fusion one for each sample"
    add("maps", metavar="MAP", nargs="+", help=text)
    add("-o", "--output", metavar="OUT", required=True, help="file to write")
    add("--background", metavar="PHOTO", help="this map of a photo that another sample filled")
    add_limits(parser)
    args = parser.parse(argv)

    def work(bar: Bar, outputs: Outputs) -> str:
        from weft import io
        from weft.exemplar import Exemplar
        from weft.synthesis import Synthesis

        io.check_output(args.output)
        result = Synthesis.load(args.source)
        limit = None if args.allow_huge else io.MAX_PIXELS
        read = [io.read_image(path, max_pixels=limit) for path in args.maps]
        picture = read[0]
        io.check_output(args.output, picture.pixels, alpha=picture.alpha)
        given = Exemplar(picture.pixels, alpha=picture.alpha, name=os.path.basename(args.maps[0]))
        if len(read) > 1:
            from weft.tasks.fuse import stack

            names = [os.path.basename(path) for path in args.maps]
            given = stack(
                [
                    Exemplar(p.pixels, alpha=p.alpha, name=name)
                    for p, name in zip(read, names, strict=True)
                ]
            )
        around = None
        if args.background is not None:
            around = io.read_image(args.background, max_pixels=limit).pixels
        pixels = result.render(given, background=around)
        io.write_image(outputs.add(args.output), pixels, alpha=picture.alpha, icc=picture.icc)
        took = perf_counter() - start
        return f"made {pixels.shape[1]}x{pixels.shape[0]} {args.output} in {took:.2f} s"

    _finish(run(work, args.quiet), args.quiet)


def _analyze(argv: list[str]) -> None:
    parser = Parser("analyze", "Say what a sample is like, and what windows follow.", _ANALYZE)
    parser.add_argument("sample", metavar="SAMPLE", help="picture, folder of maps, or sample:NAME")
    parser.add_argument("--json", action="store_true", help="print JSON")
    text = "write the sample with its lattice drawn over it"
    parser.add_argument("--overlay", metavar="FILE", help=text)
    add_huge(parser)
    args = parser.parse(argv)
    from weft import io
    from weft.tasks.analyze import analyze

    if args.overlay is not None:
        io.check_output(args.overlay)
    exemplar = load(args.sample, args)[0]
    found = analyze(exemplar)
    if args.overlay is not None:
        from weft.analysis.overlay import draw_lattice

        io.write_image(args.overlay, draw_lattice(exemplar, found.lattice))
    if args.json:
        import json

        print(json.dumps(found.as_dict(), indent=1))
    else:
        print(found)


def _compare(argv: list[str]) -> None:
    start = perf_counter()
    parser = Parser("compare", _COMPARE_ABOUT, _COMPARE)
    add = parser.add_argument
    add("sample", metavar="SAMPLE", help="picture, folder of maps, or sample:NAME")
    add("-o", "--output", metavar="OUT.html", help="the page to write")
    add("--methods", metavar="A,B,...", help="these only; see 'weft methods'")
    add("--size", metavar="WxH|N", help="in pixels; default: twice the sample's, at most 512")
    add("--seed", type=int, metavar="N", default=1, help="of all methods; default: 1")
    text = "compare tileable outputs; along both axes or one"
    add("--tileable", nargs="?", const="xy", choices=("xy", "x", "y"), metavar="x|y", help=text)
    add("--threads", type=int, metavar="N", help="use at most so many")
    add("--json", action="store_true", help="print the figures as JSON")
    add_limits(parser)
    args = parser.parse(argv)
    if args.output is None and not args.json:
        raise InvalidInputError("nothing to do; give -o compare.html, --json, or both")
    size = None if args.size is None else parse_size(args.size, args.allow_huge)
    names = None if args.methods is None else [word.strip() for word in args.methods.split(",")]
    check_numbers(args)

    def work(bar: Bar, outputs: Outputs) -> str:
        from weft import io
        from weft.tasks.compare import compare

        if args.output is not None:
            io.check_output(args.output, suffixes=(".html",))
        exemplar = load(args.sample, args)[0]
        found = compare(exemplar, size, methods=names, **settings(args, bar))
        if args.output is not None:
            found.save(outputs.add(args.output))
        if args.json:
            import json

            print(json.dumps(found.as_dict(), indent=1, default=str))
        best, took = found.entries[0], perf_counter() - start
        said = f"compared {len(found.entries)} methods in {took:.1f} s"
        said += f"; the best score has {best.method}" if best.assessment is not None else ""
        return said + (f"; {args.output} shows all" if args.output is not None else "")

    _finish(run(work, args.quiet), args.quiet)


def _report(argv: list[str]) -> None:
    parser = Parser("report", _REPORT_ABOUT, _REPORT)
    add = parser.add_argument
    add("sample", metavar="SAMPLE", help="picture, folder of maps, or sample:NAME")
    add("result", metavar="RESULT", help="what was made from it")
    text = "what --save-source saved: says what was copied from where, and the parameters"
    add("--source", metavar="F.npz", help=text)
    text = "look at the border as well; x or y for one axis (default: what the source says)"
    add("--tileable", nargs="?", const="xy", choices=("x", "y", "xy"), help=text)
    add("-o", "--output", metavar="OUT.html", help="the page to write")
    add("--json", action="store_true", help="print the figures as JSON")
    add_huge(parser)
    args = parser.parse(argv)
    if args.output is None and not args.json:
        raise InvalidInputError("nothing to do; give -o report.html, --json, or both")
    from weft import io
    from weft.tasks.report import report as measure

    if args.output is not None:
        io.check_output(args.output, suffixes=(".html",))
    sample, result = load(args.sample, args)[0], load(args.result, args)[0]
    wrap = None if args.tileable is None else ("y" in args.tileable, "x" in args.tileable)
    found = measure(sample, result, args.source, tileable=wrap)
    if args.output is not None:
        found.save(args.output)
    if args.json:
        import json

        print(json.dumps(found.as_dict(), indent=1))
    else:
        print(found.assessment.verdict())


def _methods(argv: list[str]) -> None:
    parser = Parser("methods", "List the methods, or the parameters of one.", "")
    parser.add_argument("method", metavar="NAME", nargs="?")
    name = parser.parse(argv).method
    from weft.method import AUTO, CANVAS_KINDS, METHODS, method_class

    if name is None:
        for slug, cls in ((AUTO, method_class(AUTO)), *METHODS.items()):
            kinds = ", ".join(text for kind, text in CANVAS_KINDS.items() if kind in cls.supports)
            print(f"{slug:16}  {cls.title:22}  {kinds}")
        return
    cls = method_class(name)
    print(f"{cls.title}\n{cls.paper}\n")
    for field, values in parameters_of(cls):
        print(f"--{field.name.replace('_', '-')}\n    {field.metadata['help']}\n    {values}")


def _samples(argv: list[str]) -> None:
    Parser("samples", "List the samples that ship with weft.", "").parse(argv)
    from weft import io

    for name in io.sample_names():
        folder = "  (a folder of aligned maps)" if io.is_folder(f"sample:{name}") else ""
        print(f"sample:{name}{folder}")


_COMMANDS = {
    "synth": _synth,
    "fill": _fill,
    "fuse": _fuse,
    "replay": _replay,
    "analyze": _analyze,
    "report": _report,
    "compare": _compare,
    "methods": _methods,
    "samples": _samples,
}


def entry() -> NoReturn:
    """Run a command as a process of its own, which ends here."""
    code = main()
    with suppress(OSError):  # nobody reads on
        sys.stdout.flush()
    # Taking numpy and OpenImageIO down in order takes a tenth of a short run.
    os._exit(code)


if __name__ == "__main__":
    entry()
