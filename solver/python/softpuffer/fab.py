"""Molds: how to cast a body, the parts to print, and their verification.

Each function runs the program `fab` and returns what it wrote. Raises ProgramError, with its message, where that fails.
"""

from __future__ import annotations

import json
import os
import tempfile
from pathlib import Path
from typing import Any

from .programs import run


def plan(design: str | os.PathLike[str], *arguments: str) -> dict[str, Any]:
    """Which method casts a tagged mesh, along which pull, and why: as `fab plan` writes it, with lengths in millimetres.

    arguments: further words of `fab plan`, such as "--config", "mold.toml".
    """
    with tempfile.TemporaryDirectory() as folder:
        run("fab", ["plan", os.fspath(design), "-o", folder, "--no-pictures", *arguments])
        found: dict[str, Any] = json.loads((Path(folder) / "plan.json").read_text())
        return found


def mold(design: str | os.PathLike[str], output: str | os.PathLike[str], *arguments: str) -> dict[str, Any]:
    """Makes the printable parts of a mold in a folder, as `fab mold` does, and returns its `mold.json`, in millimetres.

    arguments: further words of `fab mold`.
    """
    run("fab", ["mold", os.fspath(design), "-o", os.fspath(output), *arguments])
    found: dict[str, Any] = json.loads((Path(output) / "mold.json").read_text())
    return found


def verify(folder: str | os.PathLike[str], *arguments: str) -> str:
    """Checks a mold as `fab verify` does, and returns a line for each check.

    arguments: further words of `fab verify`.
    """
    return run("fab", ["verify", os.fspath(folder), *arguments])
