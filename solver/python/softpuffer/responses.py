"""The quasi-static response of an actuator as a table, for a controller or another simulator."""

from __future__ import annotations

import csv
import itertools
import os
from dataclasses import dataclass
from typing import Iterable, Mapping, Sequence

import numpy as np

from ._native import NoEquilibrium
from .arrays import Floats, listed
from .run import Run, Unusable, check_unusable
from .scene import Scene


@dataclass(repr=False)
class Response:
    """A row for each case.

    columns: names of the columns: paths of the numbers, names of the probes, and `d PROBE/d PATH`.
    rows: their values (cases, columns) in SI units; NaN where there is no equilibrium that may be used.
    units: the unit of each column.
    status: of each row, as `Run.status` has it.
    """

    columns: list[str]
    rows: Floats
    units: list[str]
    status: list[str]

    def __getitem__(self, column: str) -> Floats:
        values: Floats = self.rows[:, self.columns.index(column)]
        return values

    def write(self, path: str | os.PathLike[str]) -> None:
        """Writes the table as CSV, with the status after the columns of numbers."""
        with open(path, "w", newline="") as file:
            table = csv.writer(file)
            # a name is never a formula of a spreadsheet
            names = [f" {name}" if name.startswith((*"=+-@\t\r",)) else name for name in self.columns]
            table.writerow([*names, "status"])
            table.writerows([[*(repr(float(v)) for v in row), word] for row, word in zip(self.rows, self.status)])

    def __repr__(self) -> str:
        columns = ", ".join(f"{name} [{unit}]" for name, unit in zip(self.columns, self.units))
        return f"<Response: {len(self.rows)} rows, {self.status.count('ok')} of them usable: {columns}>"


def response(
    scene: Scene,
    grid: Mapping[str, Sequence[float]],
    probes: str | Iterable[str] | None = None,
    by: str | Iterable[str] = (),
    *,
    unusable: Unusable = "raise",
) -> Response:
    """The values of probes, and their exact derivatives, at all combinations of values of some numbers.

    grid: values of each number by its path: {"chamber.left.pressure": [0, 5e3, 10e3], ...}.
    probes: names of probes; all of the scene if not given.
    by: further numbers to differentiate by. By the components of a traction on the tip, which may be zero, the
        derivatives of its displacement are the compliance of the actuator there.
    unusable: "return" gives values of runs that must not be used, too; else their rows are NaN.

    The scene does not change.
    """
    check_unusable(unusable)
    scene = scene.copy()
    names = listed(scene.probes if probes is None else probes)
    paths = [*grid, *(path for path in listed(by) if path not in grid)]
    slopes = [(name, path) for name in names for path in paths]
    columns = [*grid, *names, *(f"d {name}/d {path}" for name, path in slopes)]
    rows: list[list[float]] = []
    status: list[str] = []
    of_probes: dict[str, str] = {}
    start: Run | None = None
    for values in itertools.product(*grid.values()):
        scene.set(dict(zip(grid, values)))
        row, word, run = _case(scene, names, paths, start, unusable)
        rows.append([*values, *row])
        status.append(word)
        if run is not None:
            of_probes = {name: run.unit(name) for name in names}
        # the next case goes on from this one, where the way to it does not matter
        start = run if scene._native.is_free_of_history() else None
    of_names = [of_probes.get(name, "?") for name in names]
    of_slopes = [f"{of_probes.get(name, '?')}/({scene.unit(path)})" for name, path in slopes]
    units = [*map(scene.unit, grid), *of_names, *of_slopes]
    return Response(columns, np.array(rows, dtype=float), units, status)


def _case(
    scene: Scene, names: list[str], paths: list[str], start: Run | None, unusable: Unusable
) -> tuple[list[float], str, Run | None]:
    """The values of a row, what they are, and the run if it may be used."""
    none = [np.nan] * (len(names) * (1 + len(paths)))
    try:
        run = scene.simulate(progress=False, start=start, unusable="return")
        if not run.usable and unusable == "raise":
            return none, run.status, None
        found = [run.gradient(name, paths) for name in names]
    except NoEquilibrium:
        return none, "no equilibrium", None
    values = [value for value, _ in found] + [slopes[path] for _, slopes in found for path in paths]
    return values, run.status, run if run.usable else None
