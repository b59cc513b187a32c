"""`puffer studio`: a body from a CAD file to its molds on a page, without a terminal.

A server for one person on this machine, and one page. It calls the programs and writes the files of a folder, and holds
nothing else: all that it shows is read from the folder each time.
"""

from __future__ import annotations

import argparse
import os
import signal
import sys
import tempfile
import webbrowser
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import NoReturn, Sequence


def studio(arguments: Sequence[str]) -> None:
    """Runs `puffer studio` until it is interrupted."""
    parser = argparse.ArgumentParser(
        prog="puffer studio",
        description="Serves a page to this machine alone, on which you make a body from a CAD file: drop it, click its "
        "faces, choose silicone and pressure, make it, see its page and its mold. The same folders are made by "
        "`puffer make -C BODY`.",
    )
    parser.add_argument("folder", nargs="?", default=".", help="where the folders of bodies are [default: here]")
    parser.add_argument("--port", type=int, default=0, help="port of the page [default: one that is free]")
    parser.add_argument("--no-browser", action="store_true", help="only print the address")
    options = parser.parse_args(arguments)
    if os.name == "nt":
        _refuse("it needs Linux or macOS: on Windows, puffer new and puffer make do the same from a terminal")
    if not Path(options.folder).is_dir():
        _refuse(f"{options.folder}: there is no such folder; make it, or give another one")
    if (Path(options.folder) / "rules.mk").is_file():
        _refuse(f"{options.folder}: bodies in pipelines of a checkout are made by its make; give another folder")
    # all paths, and all commands that the page shows, are as seen from there
    os.chdir(options.folder)
    _serve(options.port, not options.no_browser)


def _serve(port: int, browse: bool) -> None:
    from . import bodies
    from .server import Studio

    try:
        page = Studio(port)
    except (OSError, OverflowError) as error:
        _refuse(f"port {port}: {str(error).rstrip('.')}; give another --port, or none for one that is free")
    # in one piece: who reads the address may go then
    print(f"{page.address}\nThe address is for you alone. Ctrl-C ends the studio.\n", end="", flush=True)
    with page, ExitStack() as until_the_end:
        if browse:
            private = until_the_end.enter_context(tempfile.TemporaryDirectory(prefix="puffer-studio-"))
            _open(page.address, Path(private) / "open.html")
        signal.signal(signal.SIGTERM, signal.default_int_handler)
        with suppress(KeyboardInterrupt):
            page.serve_forever()
    try:
        print(flush=True)
        for body in bodies.all_bodies():
            if body.run.is_running():
                print(f"{body.name} is still being made, see {body.run.log}; puffer studio goes on with it", flush=True)
    except BrokenPipeError:
        # who reads the address may be gone; Python would try once more
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _open(address: str, file: Path) -> None:
    """Opens a browser. It is given a file of ours: others can read the words with which it is started."""
    file.touch(mode=0o600)
    file.write_text(f'<!doctype html><meta http-equiv="refresh" content="0;url={address}">')
    webbrowser.open(file.as_uri())


def _refuse(why: str) -> NoReturn:
    print(f"puffer studio: {why}", file=sys.stderr)
    sys.exit(2)
