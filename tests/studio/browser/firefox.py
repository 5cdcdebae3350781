"""Firefox as Playwright wants it: what an older Firefox does not know is answered in its place.

Playwright drives Firefox of the system by WebDriver BiDi, and asks for commands that come with
later versions, such as the one that sets whether a page is dark. This runs Firefox, stands between
the two, and answers such a command with success.
"""

from __future__ import annotations

import asyncio
import json
import re
import sys
from functools import partial
from typing import Any

from websockets.asyncio.client import connect
from websockets.asyncio.server import serve

ADDRESS = re.compile(r"(?<=WebDriver BiDi listening on )ws://\S+")
OPEN: dict[str, Any] = {"max_size": None, "compression": None}


async def between(address: str, playwright: Any) -> None:
    """Hand everything on, both ways."""
    async with connect(address + playwright.request.path, **OPEN) as firefox:

        async def there() -> None:
            async for text in playwright:
                await firefox.send(text)
            await firefox.close()

        async def back() -> None:
            async for text in firefox:
                told = json.loads(text)
                if told.get("error") == "unknown command":
                    text = json.dumps({"type": "success", "id": told["id"], "result": {}})
                await playwright.send(text)

        await asyncio.gather(there(), back())


async def main(command: list[str]) -> None:
    """Run Firefox; the address that it prints becomes one of ours."""
    run = await asyncio.create_subprocess_exec(*command, stderr=asyncio.subprocess.PIPE)
    assert run.stderr is not None
    async for line in run.stderr:
        text = line.decode()
        if found := ADDRESS.search(text):
            server = await serve(partial(between, found[0]), "127.0.0.1", 0, **OPEN)
            port = server.sockets[0].getsockname()[1]
            text = ADDRESS.sub(f"ws://127.0.0.1:{port}", text)
        sys.stderr.write(text)
        sys.stderr.flush()
    await run.wait()


if __name__ == "__main__":
    asyncio.run(main(sys.argv[1:]))
