"""Open the studio in the browser: make textures from a photo, paint, compare and export.

Everything stays on this machine. The address contains a secret token; requests without it are
refused.

examples:
  weftex studio
  weftex studio brick.png
  weftex studio sample:bricks --no-browser
"""

from __future__ import annotations

import threading
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

from weftex.cli.parser import Parser
from weftex.cli.terminal import say
from weftex.errors import InvalidInputError, missing_packages

if TYPE_CHECKING:
    from weftex.studio.studio import Studio

_PATIENCE = 60  # seconds for the browser to load the page


def run(argv: list[str]) -> None:
    """Run the command; `argv` is what follows its name."""
    parser = Parser("studio", __doc__)
    add = parser.add_argument
    text = "image, folder of maps, or sample:NAME to open"
    add("sample", metavar="SAMPLE", nargs="?", help=text)
    add("--no-browser", action="store_true", help="print the address without opening a browser")
    add("--port", type=int, metavar="N", help="port to listen on; default: 8427, or any free port")
    text = "folder for uploads and saved results; default: a folder in your home, such as "
    add("--data", metavar="DIR", help=text + "~/.local/state")
    text = "memory for stored results, in MiB; default: depends on this machine"
    add("--memory", type=int, metavar="MIB", help=text)
    args = parser.parse(argv)
    if args.port is not None and not 0 <= args.port < 2**16:
        raise InvalidInputError(f"--port is {args.port}; it must be from 0 to 65535")
    if args.memory is not None and not 64 <= args.memory <= 2**20:
        raise InvalidInputError(f"--memory is {args.memory}; it must be from 64 to 2**20")
    if args.data == "":
        raise InvalidInputError("--data is ''; it must name a folder")
    if any(find_spec(name) is None for name in ("starlette", "uvicorn", "anyio")):
        raise missing_packages("the studio needs a web server", "studio")
    from dataclasses import replace

    from weftex.studio.limits import usual_limits
    from weftex.studio.server import address_of, listen, server_of
    from weftex.studio.sessions import default_folder
    from weftex.studio.studio import Studio
    from weftex.studio.uploads import StartMaterial

    limits = usual_limits()
    if args.memory is not None:
        limits = replace(limits, memory_bytes=args.memory * 2**20)
    opened = None if args.sample is None else StartMaterial.of(args.sample, limits)
    listener = listen(args.port)
    folder = default_folder() if args.data is None else Path(args.data)
    try:
        studio = Studio(folder, limits, opened)
    except BaseException:
        listener.close()
        raise
    address = address_of(listener, studio.token)
    say(f"the studio is at {address}   (Ctrl-C stops it)")
    if not args.no_browser:  # it starts, and waits for the answer, while the server starts
        threading.Thread(target=_open, args=(address, studio), daemon=True).start()
    server_of(listener, studio).run([listener])


def _open(address: str, studio: Studio) -> None:
    """Open a browser without the token in its command line, which other users can read."""
    import webbrowser

    from weftex.studio.server import redirect_file

    with redirect_file(address, studio.downloads) as file:
        if not webbrowser.open(file.resolve().as_uri()):
            say("no browser was found; open this address")
        elif not studio.began.wait(_PATIENCE):
            say("if the page stays empty, open this address")
