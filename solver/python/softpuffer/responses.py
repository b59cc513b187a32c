"""The quasi-static response of an actuator as a table, for a controller or another simulator."""

from __future__ import annotations

import csv
import itertools
import os
from dataclasses import dataclass
from typing import Iterable, Mapping, Sequence

import numpy as np

from ._native import NoEquilibrium
from .run import Run
from .scene import Scene


@dataclass
class Response:
    """A row for each case.

    columns: names of the columns: paths of the numbers, names of the probes, and `d PROBE/d PATH`.
    rows: their values (cases, columns) in SI units; NaN where there is no equilibrium.
    """

    columns: list[str]
    rows: np.ndarray

    def __getitem__(self, column: str) -> np.ndarray:
        return self.rows[:, self.columns.index(column)]

    def write(self, path: str | os.PathLike) -> None:
        """Writes the table as CSV."""
        with open(path, "w", newline="") as file:
            table = csv.writer(file)
            # a name is never a formula of a spreadsheet
            table.writerow([f" {name}" if name.startswith((*"=+-@\t\r",)) else name for name in self.columns])
            table.writerows([[repr(float(value)) for value in row] for row in self.rows])


def response(
    scene: Scene,
    grid: Mapping[str, Sequence[float]],
    probes: Iterable[str] | None = None,
    by: Iterable[str] = (),
) -> Response:
    """The values of probes, and their exact derivatives, at all combinations of values of some numbers.

    grid: values of each number by its path: {"chamber.left.pressure": [0, 5e3, 10e3], ...}.
    probes: names of probes; all of the scene if not given.
    by: further numbers to differentiate by. By the components of a traction on the tip, which may be zero, the
        derivatives of its displacement are the compliance of the actuator there.

    The scene does not change.
    """
    scene = scene.copy()
    names = list(scene.probes if probes is None else probes)
    paths = [*grid, *(path for path in by if path not in grid)]
    columns = [*grid, *names, *(f"d {name}/d {path}" for name in names for path in paths)]
    rows, start = [], None
    for values in itertools.product(*grid.values()):
        for path, value in zip(grid, values):
            scene.set(path, value)
        row, run = _case(scene, names, paths, start)
        rows.append([*values, *row])
        # the next case goes on from this one, where the way to it does not matter
        start = run if scene._native.is_free_of_history() else None
    return Response(columns, np.array(rows, dtype=float))


def _case(
    scene: Scene, names: list[str], paths: list[str], start: Run | None
) -> tuple[list[float], Run | None]:
    """The values of a row, and its run."""
    try:
        run = scene.simulate(progress=False, start=start)
        found = [run.gradient(name, paths) for name in names]
    except NoEquilibrium:
        return [np.nan] * (len(names) * (1 + len(paths))), None
    return [value for value, _ in found] + [slopes[path] for _, slopes in found for path in paths], run
