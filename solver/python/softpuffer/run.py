"""Runs of a scene: states, measures and gradients."""

from __future__ import annotations

import json
import os
import re
import tempfile
import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Any, Callable, Dict, Iterable, Literal, SupportsFloat, overload

import numpy as np
from numpy.typing import ArrayLike

from . import _native
from ._native import InputError
from .arrays import Floats, Integers, floats, listed
from .beside import unpickled

if TYPE_CHECKING:
    import pyvista

    from .scene import Scene

#: What becomes of a run that must not be used.
Unusable = Literal["raise", "return"]


class RunWarning(UserWarning):
    """What a user should know of a run: as `solver simulate` warns of it."""


class UnusableRun(RuntimeError):
    """The result of a run must not be used. The text says why.

    run: the run, to study it.
    """

    def __init__(self, why: str, run: Run):
        super().__init__(why, run)
        self.run = run

    def __str__(self) -> str:
        return str(self.args[0])


class Derivatives(Dict[str, Any]):
    """Derivatives of a result: by "shape" an array (vertices, 3), by the path of a number a number."""

    if TYPE_CHECKING:

        @overload
        def __getitem__(self, name: Literal["shape"]) -> Floats: ...  # type: ignore[overload-overlap]

        @overload
        def __getitem__(self, name: str) -> float: ...

        def __getitem__(self, name: str) -> Any: ...


class Run:
    """What `Scene.simulate` found. Steps are the load steps of a static scene, the last at full load, or the
    time steps of a scene with time. It does not change."""

    def __init__(self, native: _native.Run, scene: Scene):
        self._native, self._scene = native, scene

    @property
    def scene(self) -> Scene:
        """The scene that was solved, a copy."""
        return self._scene.copy()

    @property
    def usable(self) -> bool:
        """Whether the result may be used: where not, `solver simulate` ends with exit code 1."""
        return self._native.refusal is None

    @property
    def status(self) -> str:
        """What the result is, as `status` of report.json: "ok", "surfaces_crossed", ..."""
        return self._native.status

    @property
    def refusal(self) -> str | None:
        """Why the result must not be used; None where it may be."""
        return self._native.refusal

    @property
    def warnings(self) -> list[str]:
        """What a user should know of the result, as `solver simulate` warns of it. The estimate of what elements
        hold back, where they are likely to lock, costs an assembly and a factorisation with the next degree."""
        return [*self._known_warnings, *self._native.locking_warnings()]

    @property
    def _known_warnings(self) -> list[str]:
        return [*([self.refusal] if self.refusal else []), *self._native.warnings()]

    @property
    def times(self) -> Floats:
        """Times of the steps [s]; in a static scene parts of the full load."""
        return self._native.times

    @property
    def newton_iterations(self) -> int:
        """Iterations of Newton's method, those of rejected steps included."""
        return self._native.newton_iterations

    @property
    def nodes(self) -> Floats:
        """Rest positions of the nodes (n, 3) [m]; the first are the vertices."""
        return self._native.nodes

    @property
    def elements(self) -> Integers:
        """Nodes of each tetrahedron (m, k): four corners, and of degree 2 and 3 those on edges and faces."""
        return self._native.elements

    def facets(self, tag: str) -> Integers:
        """Nodes of each facet of a tag (m, k): three corners, and of degree 2 and 3 those on edges and in the middle."""
        return self._native.facets(tag)

    @property
    def displacement(self) -> Floats:
        """Displacement of the nodes at the end (n, 3) [m]; the first are the vertices."""
        return self._native.displacement_at(-1)

    def displacement_at(self, step: int) -> Floats:
        """Displacement of the nodes at a step (n, 3) [m]; -1 is the last."""
        return self._native.displacement_at(step)

    @property
    def probes(self) -> dict[str, Floats]:
        """The values of every probe at all steps, in its SI unit."""
        return self._native.probes()

    def probe(self, name: str) -> float:
        """The value of a probe at the end, in its SI unit; angles are in degrees."""
        probes = self.probes
        if name not in probes:
            raise InputError(f'unknown probe "{name}"; the scene has: {", ".join(probes)}')
        return float(probes[name][-1])

    def unit(self, probe: str) -> str:
        """The unit of a probe; angles are in degrees."""
        units = {name: unit for name, _, unit in self._native.probe_units()}
        if probe not in units:
            raise InputError(f'unknown probe "{probe}"; the scene has: {", ".join(units)}')
        return units[probe]

    @property
    def chambers(self) -> dict[str, dict[str, float]]:
        """`pressure` [Pa], `volume` and `volume_rest` [m³] of every chamber at the end."""
        return self._native.chambers(-1)

    def chambers_at(self, step: int) -> dict[str, dict[str, float]]:
        """`pressure` [Pa], `volume` and `volume_rest` [m³] of every chamber at a step; -1 is the last."""
        return self._native.chambers(step)

    @property
    def error_bars(self) -> dict[str, dict[str, Any]] | None:
        """Error bars of every probe at the end, to first order, as report.json has them; None where the scene has
        no table `uncertainty`."""
        found = self._native.error_bars()
        bars: dict[str, dict[str, Any]] | None = None if found is None else json.loads(found)
        return bars

    def stress(self, name: str = "von_mises", *, cells: bool = False, step: int = -1) -> Floats:
        """A field of stress or strain at the nodes, or of the tetrahedra, as columns.

        name: von_mises, hydrostatic_pressure, nominal_stress [Pa], stretch [1], strain_energy [J/m³];
            cauchy_stress [Pa], nine columns, of tetrahedra alone.
        cells: one row for each tetrahedron, in place of one for each node.
        step: a step as for `displacement_at`.
        """
        fields = self._native.fields(step)[int(cells)]
        if name not in fields:
            raise InputError(f'unknown field "{name}"; there are: {", ".join(fields)}')
        values = fields[name][1]
        column: Floats = values[:, 0]
        return column if values.shape[1] == 1 else values

    def gradient(
        self,
        objective: str | Callable[[Floats], SupportsFloat],
        wrt: str | Iterable[str] = ("shape",),
        *,
        derivative: Callable[[Floats], ArrayLike] | None = None,
        through_time: bool = False,
    ) -> tuple[float, Derivatives]:
        """A result J and its exact derivatives, by the adjoint method.

        objective: the name of a probe, or a function J(u) of the displacement at the end (n, 3) [m].
        wrt: "shape" for dJ/dX by the rest positions of the vertices (n, 3), and paths of numbers, such as
            "chamber.cavity.pressure"; one alone, or several. A load is changed by the same amount at all times.
        derivative: the function dJ/du, of the shape of u. Without it the package autograd differentiates
            J: write it with operators, or with autograd.numpy in place of numpy.
        through_time: J has the displacements at the ends of all time steps (steps, n, 3).

        Ctrl-C ends it with KeyboardInterrupt.
        """
        names = listed(wrt)
        if isinstance(objective, str):
            found, slopes = self._native.probe_gradient(objective, names)
            return found, Derivatives(slopes)
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
        return value, Derivatives(self._native.gradient(by, names))

    def vjp(self, by_displacement: ArrayLike, wrt: str | Iterable[str] = ("shape",)) -> Derivatives:
        """The vector-Jacobian product: derivatives of a result from those by the displacement at the end.

        by_displacement: dJ/du (n, 3), of the shape of `displacement`.
        wrt: as for `gradient`; "shape" gives an array (vertices, 3), a path a number.
        """
        last = self._native.ends()
        by = [(last, floats(by_displacement, "by_displacement"))]
        return Derivatives(self._native.gradient(by, listed(wrt)))

    def _ends(self) -> Floats:
        count, steps = self._native.ends(), len(self.times)
        first = steps - count
        return np.stack([self._native.displacement_at(k) for k in range(first, steps)])

    def to_pyvista(self, step: int = -1) -> pyvista.UnstructuredGrid:
        """The deformed body with all fields, as a grid of PyVista, which must be installed."""
        import pyvista

        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "state.vtu")
            self.write_vtu(path, step)
            grid: Any = pyvista.read(path)
        deformed: pyvista.UnstructuredGrid = grid.warp_by_vector("displacement")
        return deformed

    def write_vtu(self, path: str | os.PathLike[str], step: int = -1) -> None:
        """Writes a step for ParaView: the body at rest, its displacement and all other fields."""
        self._native.write_vtu(os.fspath(path), step)

    def save(self, folder: str | os.PathLike[str]) -> None:
        """Writes what `solver simulate` writes into a folder: report.json, steps.jsonl, curve.csv, ...; beside
        them the scene and its meshes, from which the program makes the same."""
        scene, meshes = self._scene._write(folder)
        self._scene._said.warn(self._native.save(os.fspath(folder), os.fspath(scene), meshes))

    def report(self, path: str | os.PathLike[str], title: str | None = None) -> None:
        """Writes all of it as one page of HTML, which needs no network."""
        from .programs import run

        with tempfile.TemporaryDirectory() as folder:
            self.save(folder)
            title = title or Path(path).stem
            run("cad2fem", ["report", folder, "--title", title, "-o", os.fspath(path)])

    def _rows(self) -> list[tuple[str, float, str]]:
        """What is told of it: name, value and unit."""
        rows = [("largest displacement", np.linalg.norm(self.displacement, axis=1).max() * 1e3, "mm")]
        rows += [(f"pressure of {name}", of["pressure"] / 1e3, "kPa") for name, of in self.chambers.items()]
        rows += [(f"volume of {name}", of["volume"] * 1e6, "mL") for name, of in self.chambers.items()]
        units = {name: unit for name, _, unit in self._native.probe_units()}
        return rows + [(name, values[-1], units[name]) for name, values in self.probes.items()]

    def _repr_html_(self) -> str:
        cells = [f"<tr><td>{_escaped(what)}</td><td>{value:.6g} {unit}</td></tr>" for what, value, unit in self._rows()]
        why = "" if self.usable else f"<caption>{_escaped(self.refusal or self.status)}</caption>"
        return f"<table>{why}{''.join(cells)}</table>"

    def __copy__(self) -> Run:
        return self

    def __deepcopy__(self, memo: dict[int, Any]) -> Run:
        return self

    def __reduce__(self) -> tuple[Any, tuple[Any, ...]]:
        return _of_bytes, (self._scene, self._native.to_bytes())

    def __repr__(self) -> str:
        steps, iterations = len(self.times), self.newton_iterations
        told = ", ".join(f"{what} {value:.4g} {unit}" for what, value, unit in self._rows())
        return f"<Run: {self.status}, {steps} steps, {iterations} Newton iterations, {told}>"


class Said:
    """What was warned of, of a scene and its copies."""

    def __init__(self) -> None:
        self.kinds: set[str] = set()
        self.locking = False

    def warn(self, texts: list[str]) -> None:
        """Warns of what is new, as whoever calls the caller: texts that differ in their numbers are one kind."""
        for text in texts:
            kind = re.sub(r"[-+.\d]+(e[-+]?\d+)?", "#", text)
            if kind not in self.kinds:
                self.kinds.add(kind)
                warnings.warn(text, RunWarning, stacklevel=3)


def check_unusable(unusable: str) -> None:
    """Refuses a word that is none."""
    if unusable not in ("raise", "return"):
        raise InputError(f'unusable={unusable!r}: expected "raise" or "return"')


def _of_bytes(scene: Scene, data: bytes) -> Run:
    return Run(unpickled(lambda: scene._native.run_of_bytes(data)), scene)


def _value_and_derivative(
    objective: Callable[[Floats], SupportsFloat], derivative: Callable[[Floats], ArrayLike] | None, u: Floats
) -> tuple[float, Floats]:
    if derivative is not None:
        return float(objective(u)), np.asarray(derivative(u), dtype=float)
    try:
        import autograd
    except ImportError:
        raise InputError("the derivative of the objective is needed: give derivative=, or install autograd") from None
    try:
        both: Any = autograd.value_and_grad
        value, by = both(objective)(u)
    except TypeError as error:
        raise InputError(
            f"autograd cannot differentiate the objective ({error}): write it with autograd.numpy, or give derivative="
        ) from error
    return float(value), np.asarray(by, dtype=float)


def _escaped(text: str) -> str:
    return text.replace("&", "&amp;").replace("<", "&lt;")
