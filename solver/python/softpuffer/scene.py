"""Scenes: bodies, materials, supports and loads."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any, Iterable, Mapping, overload

from numpy.typing import ArrayLike

from . import _native
from .arrays import Floats, floats, listed
from .beside import run_all, unpickled
from .body import Body
from .progress import Progress, shown
from .run import Run, Said, Unusable, UnusableRun, check_unusable
from .values import as_json

if TYPE_CHECKING:
    import pyvista
    from typing_extensions import Unpack

    from .tables import Changes, Tables


class Scene:
    """A body under loads.

    body: a Body, or several by their names.
    material: a silicone of the library (`solver list --silicones`), a table such as
        {"kind": "neo-hookean", "young": 120e3, "poisson": 0.49}; of several bodies one for each name, or one for all.
    fixed: tags that do not move, or tables such as {"on": "seat", "components": "xz"}.
    chambers: pressure [Pa] of each chamber by the tag of its wall; a text is a function of time, such as
        "20e3*t"; a table has the keys of another gas law, such as {"fill": 20e3, "ambient": 101.3e3, "exponent": 1}.
    probes: what is measured, by name: tables such as {"kind": "displacement", "on": "tip", "axis": [0, 0, 1]}.
    degree: of the displacement in an element, 1, 2 or 3.
    folder: where paths of the tables begin, such as that of an obstacle.
    tables: every other key of a scene of TOML, as the book lists them: gravity=[0, 0, -9.81],
        contact={...}, time={...}, solver={...}, traction=[{...}], membrane=[{...}], relaxation=[{...}], ...

    A number has a path, and `scene["chamber.cavity.pressure"] = 5e3` gives it a value.
    A scene may be used by several threads. Raises InputError, with the message of the programs, where it cannot be simulated.
    """

    def __init__(
        self,
        body: Body | Mapping[str, Body],
        *,
        material: str | Mapping[str, Any],
        fixed: str | Iterable[str | Mapping[str, Any]] = (),
        chambers: Mapping[str, Any] | None = None,
        probes: Mapping[str, Mapping[str, Any]] | None = None,
        degree: int = 2,
        folder: str | os.PathLike[str] = "",
        **tables: Unpack[Tables],
    ):
        supports = [fixed] if isinstance(fixed, str) else fixed
        whole: dict[str, Any] = {
            "degree": degree,
            "fixed": [{"on": of} if isinstance(of, str) else dict(of) for of in supports],
            "chamber": [{"on": on, **_gas(gas)} for on, gas in (chambers or {}).items()],
            "probe": [{"name": name, **probe} for name, probe in (probes or {}).items()],
            **tables,
        }
        if isinstance(body, Mapping):
            each = material if isinstance(material, Mapping) else {}
            whole["body"] = [
                {"name": name, "mesh": _IN_MEMORY, "material": each.get(name, material)} for name in body
            ]
            bodies = list(body.values())
        else:
            whole |= {"mesh": _IN_MEMORY, "material": material}
            bodies = [body]
        given = {key: value for key, value in whole.items() if value is not None}
        self._native = _native.Scene.of_json(as_json(given), os.fspath(folder), [body._native for body in bodies])
        self._said = Said()

    @classmethod
    def _of(cls, native: _native.Scene, said: Said | None = None) -> Scene:
        scene = cls.__new__(cls)
        scene._native, scene._said = native, said or Said()
        return scene

    @classmethod
    def _of_toml(cls, text: str, folder: str, bodies: list[Body]) -> Scene:
        return cls._of(unpickled(lambda: _native.Scene.of_toml(text, folder, [body._native for body in bodies])))

    def copy(self) -> Scene:
        """A scene of its own that is like this one."""
        return self._of(self._native.copy(), self._said)

    def to_toml(self) -> str:
        """The scene as the programs read it. Its meshes are not in it: `write` writes both."""
        return self._native.to_toml()

    def write(self, folder: str | os.PathLike[str]) -> Path:
        """Writes `sim.toml` with its meshes, as they are now, into a folder, and returns its path."""
        return self._write(folder)[0]

    def _write(self, folder: str | os.PathLike[str]) -> tuple[Path, list[str]]:
        folder = Path(folder)
        folder.mkdir(parents=True, exist_ok=True)
        meshes = []
        for name, body in self._native.bodies():
            meshes.append(folder / f"{name}.msh")
            body.write(os.fspath(meshes[-1]))
        scene = folder / "sim.toml"
        scene.write_text(self._native.to_toml([mesh.name for mesh in meshes]))
        return scene, [os.fspath(mesh) for mesh in meshes]

    @property
    def numbers(self) -> dict[str, float | None]:
        """The numbers of the scene by their paths, in SI units; None where one is a function of time."""
        return {path: value for path, _, value in self._native.numbers()}

    @property
    def probes(self) -> list[str]:
        """The names of the probes."""
        return self._native.probes()

    def unit(self, path: str) -> str:
        """The SI unit of a number."""
        units = {own: unit for own, unit, _ in self._native.numbers()}
        if path not in units:
            self.get(path)  # says which there are
        return units[path]

    def get(self, path: str) -> float:
        """The value of a number, such as `chamber.cavity.pressure` or `material.body.c1`; also `scene[path]`."""
        return self._native.get(path)

    @overload
    def set(self, path: str, value: float) -> None: ...

    @overload
    def set(self, path: Mapping[str, float]) -> None: ...

    def set(self, path: str | Mapping[str, float], value: float | None = None) -> None:
        """Gives a number another value; also `scene[path] = value`. `wall.TAG` moves a wall outward by a distance [m]
        from where it is.

        path: path of a number; or several with their values, of which all are set or none.
        """
        if isinstance(path, str):
            if value is None:
                raise _native.InputError(f"{path}: no value is given")
            path = {path: value}
        self._native.set([(own, _number(own, value)) for own, value in path.items()])

    def __getitem__(self, path: str) -> float:
        return self.get(path)

    def __setitem__(self, path: str, value: float) -> None:
        self.set(path, value)

    @property
    def vertices(self) -> Floats:
        """Rest positions of the vertices (n, 3) [m], body after body, a copy."""
        return self._native.vertices

    @vertices.setter
    def vertices(self, positions: ArrayLike) -> None:
        self._native.move_to(floats(positions, "vertices"))

    @property
    def body(self) -> Body:
        """The body at rest as it is now, several as one."""
        return Body._of(self._native.body())

    def scenario(self, **changes: Unpack[Changes]) -> Scene:
        """A copy of the scene under a scenario, with the keys of `[[scenario]]` in design.toml: wall=-0.15e-3,
        modulus={"insert": 0.9}, pressure=500, friction=0.7, numbers={...}, parameters={...}. So
        `scene.scenario(**table)` takes a table of that file; its name and weights change nothing.

        Raises InputError where the scene does not have what is changed, or does not admit it.
        """
        return Scene._of(self._native.scenario(as_json({"name": "", **changes})), self._said)

    def simulate(
        self,
        progress: Progress | bool | None = None,
        start: Run | None = None,
        *,
        unusable: Unusable = "raise",
    ) -> Run:
        """Solves the scene for its equilibrium, or through time.

        progress: True draws a line while it runs, a function is called at every
            iteration of Newton's method, None draws where there is a terminal.
        start: a run on the same tetrahedra, of a scene that differs a little, such as the one before in a design
            or a sweep. The equilibrium is sought next to its end, in one load step, and from rest where
            none is found there: to the same tolerance, in a fraction of the time. Where there are several
            equilibria, it stays on the branch of `start`. For scenes without time and friction.
        unusable: "return" gives a run that must not be used, too, to study it: `run.usable` says so.

        What a user should know of the run is warned of, as RunWarning: of a scene and its copies each kind of
        warning once. `run.warnings` has all of them.

        Raises NoEquilibrium with what is known of the reason, UnusableRun where `solver simulate` ends with exit code 1,
        InputError where the scene cannot begin at `start`. Ctrl-C ends it with KeyboardInterrupt.
        """
        check_unusable(unusable)
        solved = self.copy()
        first, self._said.locking = not self._said.locking, True
        with shown(progress) as told:
            run = Run(solved._native.simulate(told, None if start is None else start._native, first), solved)
        known = run.warnings if first else run._known_warnings
        if run.usable or unusable == "return":
            self._said.warn(known)
            return run
        # the first of them is the exception
        self._said.warn(known[1:])
        raise UnusableRun(known[0], run)

    def to_pyvista(self) -> pyvista.MultiBlock:
        """The body at rest and its tags, as `Body.to_pyvista` has them."""
        return self.body.to_pyvista()

    def __copy__(self) -> Scene:
        return self.copy()

    def __deepcopy__(self, memo: dict[int, Any]) -> Scene:
        return self.copy()

    def __reduce__(self) -> tuple[Any, tuple[Any, ...]]:
        bodies = [Body._of(body) for _, body in self._native.bodies()]
        text = self._native.to_toml([_IN_MEMORY for _ in bodies])
        return Scene._of_toml, (text, os.fspath(self._native.folder), bodies)

    def __repr__(self) -> str:
        tets, degree = self._native.size()
        known = self._native.numbers()
        of = [f"{path} = {value:g} {unit}" for path, unit, value in known if value is not None and "wall" not in path]
        more = f", and {len(of) - _SHOWN} more" if len(of) > _SHOWN else ""
        return f"<Scene: {tets} tetrahedra of degree {degree}, {', '.join(of[:_SHOWN])}{more}>"


def load(path: str | os.PathLike[str], set: str | Iterable[str] = ()) -> Scene:
    """Reads a scene of TOML, with changes as `--set` of the programs takes them: ["degree=1"].

    Raises InputError, with the message of the programs, where it cannot be simulated.
    """
    return Scene._of(_native.Scene.read(os.fspath(path), listed(set)))


def simulate_all(scenes: Iterable[Scene], start: Run | None = None, *, unusable: Unusable = "raise") -> list[Run]:
    """Solves several scenes beside each other, such as the scenarios of a design, and returns their runs in order.

    start: as for `Scene.simulate`, for all of them.
    unusable: as for `Scene.simulate`.

    Raises what `Scene.simulate` raises, for the first scene that fails.
    """
    scenes = list(scenes)
    run = lambda k: scenes[k].simulate(progress=False, start=start, unusable=unusable)
    return run_all(run, len(scenes))


#: Stands for the path of a mesh that is in memory.
_IN_MEMORY = "memory"
#: Numbers that the repr of a scene has at most.
_SHOWN = 6


def _number(path: str, value: float) -> float:
    try:
        return float(value)
    except (TypeError, ValueError):
        raise _native.InputError(f"{path}: {value!r} is not a number") from None


def _gas(gas: Any) -> Mapping[str, Any]:
    return gas if isinstance(gas, Mapping) else {"pressure": gas}
