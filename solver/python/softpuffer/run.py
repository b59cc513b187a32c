"""Runs of a scene: states, measures and gradients."""

from __future__ import annotations

import json
import os
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Callable, Iterable

import numpy as np

from . import _native
from ._native import InputError
from .body import floats

if TYPE_CHECKING:
    from .scene import Scene


class Run:
    """What `Scene.simulate` found. Steps are the load steps of a static scene, the last at full load, or the
    time steps of a scene with time."""

    def __init__(self, native: _native.Run, scene: Scene):
        self._native, self._scene = native, scene

    @property
    def scene(self) -> Scene:
        """The scene that was solved, a copy."""
        return self._scene.copy()

    @property
    def times(self) -> np.ndarray:
        """Times of the steps [s]; in a static scene parts of the full load."""
        return self._native.times

    @property
    def newton_iterations(self) -> int:
        """Iterations of Newton's method, those of rejected steps included."""
        return self._native.newton_iterations

    @property
    def nodes(self) -> np.ndarray:
        """Rest positions of the nodes (n, 3) [m]; the first are the vertices."""
        return self._native.nodes

    @property
    def displacement(self) -> np.ndarray:
        """Displacement of the nodes at the end (n, 3) [m]; the first are the vertices."""
        return self._native.displacement_at(-1)

    def displacement_at(self, step: int) -> np.ndarray:
        """Displacement of the nodes at a step (n, 3) [m]; -1 is the last."""
        return self._native.displacement_at(step)

    @property
    def probes(self) -> dict[str, np.ndarray]:
        """The values of every probe at all steps, in its SI unit."""
        return self._native.probes()

    def probe(self, name: str) -> float:
        """The value of a probe at the end, in its SI unit; angles are in degrees."""
        probes = self.probes
        if name not in probes:
            raise InputError(f'unknown probe "{name}"; the scene has: {", ".join(probes)}')
        return float(probes[name][-1])

    @property
    def chambers(self) -> dict[str, dict[str, float]]:
        """`pressure` [Pa], `volume` and `volume_rest` [m³] of every chamber at the end."""
        return self._native.chambers(-1)

    def chambers_at(self, step: int) -> dict[str, dict[str, float]]:
        """`pressure` [Pa], `volume` and `volume_rest` [m³] of every chamber at a step; -1 is the last."""
        return self._native.chambers(step)

    @property
    def error_bars(self) -> dict[str, dict] | None:
        """Error bars of every probe at the end, to first order, as report.json has them; None where the scene has
        no table `uncertainty`."""
        found = self._native.error_bars()
        return None if found is None else json.loads(found)

    def stress(self, name: str = "von_mises", *, cells: bool = False, step: int = -1) -> np.ndarray:
        """A field of stress or strain at the nodes, or of the tetrahedra, as columns.

        name: von_mises, hydrostatic_pressure, nominal_stress [Pa], stretch [1], strain_energy [J/m³];
            cauchy_stress [Pa], nine columns, of tetrahedra alone.
        cells: one row for each tetrahedron, in place of one for each node.
        step: a step as for `displacement_at`.
        """
        fields = self._native.fields(step)[cells]
        if name not in fields:
            raise InputError(f'unknown field "{name}"; there are: {", ".join(fields)}')
        values = fields[name][1]
        return values[:, 0] if values.shape[1] == 1 else values

    def gradient(
        self,
        objective: str | Callable[[np.ndarray], float],
        wrt: Iterable[str] = ("shape",),
        *,
        derivative: Callable[[np.ndarray], np.ndarray] | None = None,
        through_time: bool = False,
    ) -> tuple[float, dict[str, np.ndarray | float]]:
        """A result J and its exact derivatives, by the adjoint method.

        objective: the name of a probe, or a function J(u) of the displacement at the end (n, 3) [m].
        wrt: "shape" for dJ/dX by the rest positions of the vertices (n, 3), and paths of numbers, such as
            "chamber.cavity.pressure". A load is changed by the same amount at all times.
        derivative: the function dJ/du, of the shape of u. Without it the package autograd differentiates
            J: write it with operators, or with autograd.numpy in place of numpy.
        through_time: J has the displacements at the ends of all time steps (steps, n, 3).
        """
        names = list(wrt)
        if isinstance(objective, str):
            return self._native.probe_gradient(objective, names)
        u = self._ends() if through_time else self.displacement
        value, by_u = _value_and_derivative(objective, derivative, u)
        if by_u.shape != u.shape:
            raise InputError(f"a derivative of shape {list(by_u.shape)}, needed {list(u.shape)}")
        if not np.all(np.isfinite(by_u)):
            raise InputError("the derivative of the objective is not finite")
        ends = self._native.ends()
        moments = range(1, ends + 1) if through_time else [ends]
        parts = by_u if through_time else [by_u]
        by = [(n, floats(part, "the derivative")) for n, part in zip(moments, parts)]
        return value, self._native.gradient(by, names)

    def vjp(self, by_displacement: np.ndarray, wrt: Iterable[str] = ("shape",)) -> dict[str, np.ndarray | float]:
        """The vector-Jacobian product: derivatives of a result from those by the displacement at the end.

        by_displacement: dJ/du (n, 3), of the shape of `displacement`.
        wrt: as for `gradient`; "shape" gives an array (vertices, 3), a path a number.
        """
        last = self._native.ends()
        return self._native.gradient([(last, floats(by_displacement, "by_displacement"))], list(wrt))

    def _ends(self) -> np.ndarray:
        count, steps = self._native.ends(), len(self.times)
        first = steps - count
        return np.stack([self._native.displacement_at(k) for k in range(first, steps)])

    def to_pyvista(self, step: int = -1):
        """The deformed body with all fields, as a grid of PyVista, which must be installed."""
        import pyvista

        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "state.vtu")
            self.write_vtu(path, step)
            return pyvista.read(path).warp_by_vector("displacement")

    def write_vtu(self, path: str | os.PathLike, step: int = -1) -> None:
        """Writes a step for ParaView: the body at rest, its displacement and all other fields."""
        self._native.write_vtu(os.fspath(path), step)

    def save(self, folder: str | os.PathLike) -> None:
        """Writes what `solver simulate` writes into a folder: report.json, steps.jsonl, curve.csv, ...; beside
        them the scene and its meshes, from which the program makes the same."""
        scene, meshes = self._scene._write(folder)
        self._native.save(os.fspath(folder), os.fspath(scene), meshes)

    def report(self, path: str | os.PathLike, title: str | None = None) -> None:
        """Writes all of it as one page of HTML, which needs no network."""
        from .programs import run

        with tempfile.TemporaryDirectory() as folder:
            self.save(folder)
            title = title or Path(path).stem
            run("cad2fem", ["report", folder, "--title", title, "-o", os.fspath(path)])

    def _repr_html_(self) -> str:
        rows = [("largest displacement", np.linalg.norm(self.displacement, axis=1).max() * 1e3, "mm")]
        rows += [(f"pressure of {name}", of["pressure"] / 1e3, "kPa") for name, of in self.chambers.items()]
        rows += [(f"volume of {name}", of["volume"] * 1e6, "mL") for name, of in self.chambers.items()]
        units = {name: unit for name, _, unit in self._native.probe_units()}
        rows += [(name, values[-1], units[name]) for name, values in self.probes.items()]
        cells = "".join(f"<tr><td>{_escaped(what)}</td><td>{value:.6g} {unit}</td></tr>" for what, value, unit in rows)
        return f"<table>{cells}</table>"

    def __repr__(self) -> str:
        return repr(self._native)


def _value_and_derivative(objective, derivative, u):
    if derivative is not None:
        return float(objective(u)), np.asarray(derivative(u), dtype=float)
    try:
        from autograd import value_and_grad
    except ImportError:
        raise InputError("the derivative of the objective is needed: give derivative=, or install autograd") from None
    try:
        value, by = value_and_grad(objective)(u)
    except TypeError as error:
        raise InputError(
            f"autograd cannot differentiate the objective ({error}): write it with autograd.numpy, or give derivative="
        ) from error
    return float(value), np.asarray(by, dtype=float)


def _escaped(text: str) -> str:
    return text.replace("&", "&amp;").replace("<", "&lt;")
