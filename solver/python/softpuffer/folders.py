"""Folders of bodies, as `puffer new` writes them and `make` uses them."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Iterable

from ._native import InputError
from .body import Body
from .programs import run

#: Models that `cad2fem model` reads; `cad2fem import` reads the others.
_MODELS = (".toml", ".geo", ".step")
_OTHERS = (".stp", ".brep", ".iges", ".3mf", ".stl", ".obj", ".ply")

#: CAD files that state the unit of their edges.
_CAD = (".geo", ".step", ".stp", ".iges")


def new(folder: str | os.PathLike[str], like: str = "blank") -> Path:
    """Writes a folder with all files of a body, to begin with: blank, beam, finger, pneunet, arm, frog, gripper, ...

    Raises ProgramError where the folder is there already or there is no such body.
    """
    run("cad2fem", ["new", os.fspath(folder), "--like", like])
    return Path(folder)


def mesh(folder: str | os.PathLike[str], set: Iterable[str] = (), edge_length: float | None = None) -> Body:
    """Makes the tagged mesh of a folder from its model, in its folder `build`, as make does, and reads it.

    set: other numbers of the model, as `cad2fem model` takes them: ["cavity.slot.shape.box.size.1=8"].
    edge_length: longest edge of the tetrahedra [m], in place of that of cad2fem.toml, and of the triangles of a
        CAD model. Where a script has sizes of its own, `set` makes its triangles longer: ["h=4"].

    Raises InputError where there is no model, ProgramError where a program fails.
    """
    folder, build = Path(folder), Path(folder) / "build"
    models = [folder / f"model{ending}" for ending in (*_MODELS, *_OTHERS)]
    model = next((path for path in models if path.is_file()), None)
    if model is None:
        raise InputError(f"{folder}: there is no model.toml, .geo, .step, .stl, ...")
    verb = "model" if model.suffix in _MODELS else "import"
    unit = ["--unit", "mm"] if model.suffix == ".geo" else []
    changes = [word for change in set for word in ("--set", change)]
    edges = [] if edge_length is None else ["--edge-length", repr(edge_length)]
    surface, volume, tagged = build / "model", build / "volume.msh", build / "tagged.msh"
    run("cad2fem", [verb, str(model), *unit, *changes, *(edges if model.suffix in _CAD else []), "-o", str(surface)])
    settings = ["--config", str(folder / "cad2fem.toml")]
    run("cad2fem", ["tetmesh", str(surface / "model.stl"), *settings, *edges, "-o", str(volume)])
    names = ["--config", str(folder / "tags.toml"), "--patches", str(surface / "patches")]
    run("tagger", ["tag", str(volume), *names, "-o", str(tagged)])
    return Body.read(tagged)
