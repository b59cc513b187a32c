"""Design problems: handles, levels and free vertices, as `solver optimize` solves them."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

from .programs import run
from .scene import Scene, load


class Design:
    """What a design problem found."""

    def __init__(self, folder: Path):
        self.folder = folder

    @property
    def history(self) -> list[dict[str, Any]]:
        """A row for each accepted iteration: level, objective, terms and more."""
        lines = (self.folder / "history.jsonl").read_text().splitlines()
        return [json.loads(line) for line in lines]

    @property
    def report(self) -> dict[str, Any]:
        """The content of `report.json`."""
        report: dict[str, Any] = json.loads((self.folder / "report.json").read_text())
        return report

    @property
    def scene(self) -> Scene:
        """The scene with the designed body."""
        scene = self.folder / self.report["inputs"]["scene"]["path"]
        return load(scene, [f"mesh={(self.folder / 'design.msh').resolve()}"])


def design(path: str | os.PathLike[str], output: str | os.PathLike[str], *arguments: str) -> Design:
    """Solves the design problem of a `design.toml` into a folder; a run that was interrupted continues.

    arguments: further words of `solver optimize`, such as "--restart".
    """
    run("solver", ["optimize", os.fspath(path), "-o", os.fspath(output), *arguments])
    return Design(Path(output))
