"""weftex synth: synthesize an image of any size from a sample of a material."""

from __future__ import annotations

from time import perf_counter
from typing import TYPE_CHECKING, Any

from weftex.cli.files import (
    load,
    open_sample,
    open_several,
    read,
    read_samples,
    report,
    settings,
    with_turns,
    write,
    write_debug,
)
from weftex.cli.options import (
    add_map_weights,
    add_mending,
    add_sample_mask,
    add_sets,
    add_tileable_sample,
    add_turn,
    parse_best_of,
    parse_size,
    parse_task,
)
from weftex.cli.parser import Parser
from weftex.cli.planes import (
    add_plane,
    check_options,
    definition_for,
    refuse_options,
    stems_of,
    takes_any_size,
    wants_plane,
)
from weftex.cli.planes import write as write_plane
from weftex.cli.terminal import finish
from weftex.cli.windows import add_window, parse_period, parse_window

if TYPE_CHECKING:
    from weftex.cli.terminal import Bar, Outputs

_ABOUT = """\
Synthesize an image of any size from a sample of a material.\
"""

_EXAMPLES = """\
examples:
  weftex synth brick.png -o wall.png --size 1024x768 --save-source wall.npz
  weftex synth brick.png -o tile.png --size 512 --tileable --seed 7
  weftex synth near.jpg far.jpg -o wall.png           several photos of one material
  weftex synth stone_wall/ -o big/ --size 2k          a folder of aligned maps
  weftex synth brick.png -o wall.png --method quilting --patch-size 48
  weftex synth brick.png -o wall.png --best-of 8      the best of eight seeds
  weftex synth brick.png -o wall.png --best-of quilting,graphcut,near-regular
  weftex synth photo.jpg -o wall.png --straighten --even-light
  weftex synth brick.png -o part.png --window 10000,-500,512,512 --seed 7    of an endless plane
  weftex synth brick.png -o wall.zarr --size 100000x100000 --workers 4
  weftex synth moss.png -o face.png --method ashikhmin --guide face.png
  weftex synth photo.png -o new.png --method refinement --sample-guide painted.png --guide other.png
"""


def run(argv: list[str]) -> None:
    """Run the command; `argv` is what follows its name."""
    start = perf_counter()
    parser = Parser("synth", _ABOUT, _EXAMPLES)
    text = "image, folder of maps, or sample:NAME; several must show the same material"
    parser.add_argument("sample", metavar="SAMPLE", nargs="+", help=text)
    add_sets(parser)
    add_map_weights(parser)
    text = (
        "output size in pixels, such as 1024x768 or 2k; default: the guide's, or twice the sample's"
    )
    parser.add_argument("--size", metavar="WxH|N", help=text)
    text = "image of the output's size that the output follows"
    parser.add_argument("--guide", metavar="FILE", help=text)
    add = parser.under["quality"].add_argument
    text = "keep the best of N results, with successive seeds; or of one result per named method"
    add("--best-of", metavar="N|NAME,...", default="1", help=text)
    text = "guide for the sample: an image of the sample's size that labels its regions"
    add("--sample-guide", metavar="FILE", help=text)
    text = "folder for images that show how the result is put together: sources, patches, seams"
    parser.under["output"].add_argument("--debug", metavar="DIR", help=text)
    add_sample_mask(parser)
    add_tileable_sample(parser)
    add_mending(parser)
    add_turn(parser)
    add_window(parser)
    add_plane(parser)
    args, method, parameters = parse_task(parser, argv)
    best_of, window, period = parse_best_of(args.best_of), parse_window(args), parse_period(args)
    huge = args.allow_huge or takes_any_size(args.output)
    size = None if args.size is None else parse_size(args.size, huge)
    chosen = method(**parameters)
    if window is not None:
        refuse_options(args)
    elif wants_plane(args, size):
        check_options(args)

        def stream(bar: Bar, outputs: Outputs) -> str:
            exemplar, material = read_samples(args)
            made = size or (2 * exemplar.shape[0], 2 * exemplar.shape[1])
            stems, exemplar = stems_of(args, material), with_turns(exemplar, args)
            definition = definition_for(args, exemplar, stems, chosen, made)
            return write_plane(args, definition, bar, outputs, start)

        finish(stream, args.quiet)
        return
    if best_of != 1:
        from weftex.tasks.best_of import tries

        tries(chosen, best_of)  # finds wrong names before anything is read

    def work(bar: Bar, outputs: Outputs) -> str:
        from weftex.results.scales import check_size
        from weftex.tasks.synthesize import synthesize

        if len(args.sample) > 1:
            exemplar, plan = open_several(args.sample, args, outputs)
        else:
            tiles = {"tileable": args.tileable_sample}
            exemplar, plan = open_sample(args.sample[0], args, outputs, **tiles)
        if args.debug is not None:
            outputs.make_folder(args.debug)
        guide = None if args.guide is None else read(args.guide, args).exemplar()
        own = None if args.sample_guide is None else load(args.sample_guide, args)
        height, width = plan.material.pictures[plan.material.main].pixels.shape[:2]
        size_made = size or (2 * height, 2 * width)
        if guide is not None:
            size_made = size or guide.shape
        exemplar = with_turns(exemplar, args)
        check_size(exemplar, size_made if window is None else window[2:])
        guides: dict[str, Any] = {"guide": guide, "sample_guide": own, "best_of": best_of}
        how = settings(args, bar)
        if window is not None:
            how["period"] = period
            del how["tileable"]
            result = chosen.fit(exemplar).window(*window, **how)
        else:
            result = synthesize(exemplar, size_made, method=chosen, **guides, **how)
        write(result, plan, args, outputs)
        if args.debug is not None:
            write_debug(result, args.debug, outputs)
        what = f"made {result.shape[1]}x{result.shape[0]}"
        return report(args, result, what, start, plan.told)

    finish(work, args.quiet, preview=args.preview, verbose=args.verbose)
