"""Meshes whose facets and parts have names."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any, Iterator, Mapping

import numpy as np
from numpy.typing import ArrayLike

from . import _native
from ._native import InputError
from .arrays import Floats, Integers, floats, integers
from .beside import unpickled

if TYPE_CHECKING:
    import meshio
    import pyvista


class Body:
    """A mesh of tetrahedra with tags. It does not change.

    vertices: positions (n, 3) [m]; each is a corner of a tetrahedron.
    tets: vertices of each tetrahedron (m, 4).
    tags: facets (k, 3) of each tag, as vertices in any order; they lie on the boundary.
    volumes: tetrahedra of each named part; those in none are the part `body`.

    Raises InputError where shapes, indices or numbers cannot be used.
    """

    def __init__(
        self,
        vertices: ArrayLike,
        tets: ArrayLike,
        tags: Mapping[str, ArrayLike] | None = None,
        volumes: Mapping[str, ArrayLike] | None = None,
    ):
        facets = [(name, integers(of, 2, f'tag "{name}"')) for name, of in (tags or {}).items()]
        parts = [(name, integers(of, 1, f'volume "{name}"')) for name, of in (volumes or {}).items()]
        self._native = _native.Body(floats(vertices, "vertices"), integers(tets, 2, "tets"), facets, parts)

    @classmethod
    def _of(cls, native: _native.Body) -> Body:
        body = cls.__new__(cls)
        body._native = native
        return body

    @classmethod
    def read(cls, path: str | os.PathLike[str]) -> Body:
        """Reads a mesh of Gmsh, such as `tagger tag` writes; it may be compressed by gzip."""
        return cls._of(_native.Body.read(os.fspath(path)))

    @classmethod
    def from_meshio(cls, mesh: meshio.Mesh, scale: float = 1.0) -> Body:
        """The tetrahedra of a mesh of meshio. Physical groups of Gmsh and cell sets are tags where they have triangles,
        and volumes where they have tetrahedra.

        scale: metres of a unit of the mesh: 1e-3 of one in millimetres.
        """
        kinds = [block.type for block in mesh.cells]
        tets = _joined(mesh, "tetra", 4)
        if not len(tets):
            raise InputError(f"the mesh has no tetrahedra of four nodes; it has: {', '.join(sorted(set(kinds)))}")
        used, numbers = np.unique(tets, return_inverse=True)
        place = np.full(len(mesh.points), -1)
        place[used] = np.arange(len(used))
        triangles = place[_joined(mesh, "triangle", 3)]
        tags = {name: triangles[of] for name, of in _groups(mesh, "triangle", 2)}
        points = scale * np.asarray(mesh.points, dtype=float)[used]
        return cls(points, numbers.reshape(tets.shape), tags, dict(_groups(mesh, "tetra", 3)))

    def write(self, path: str | os.PathLike[str]) -> None:
        """Writes the mesh in Gmsh's format 2.2."""
        self._native.write(os.fspath(path))

    @property
    def vertices(self) -> Floats:
        """Positions (n, 3) [m], a copy."""
        return self._native.vertices

    @property
    def tets(self) -> Integers:
        """Vertices of each tetrahedron (m, 4), a copy."""
        return self._native.tets

    @property
    def tags(self) -> dict[str, Integers]:
        """Facets (k, 3) of each tag, as vertices, copies."""
        return self._native.tags

    @property
    def volumes(self) -> dict[str, Integers]:
        """Numbers (k,) of the tetrahedra of each named part, copies; empty where there are no parts."""
        return self._native.volumes

    def to_pyvista(self) -> pyvista.MultiBlock:
        """Blocks of PyVista, which must be installed: the tetrahedra as `body`, and the facets of each tag."""
        import pyvista

        points = self.vertices
        body = pyvista.UnstructuredGrid({pyvista.CellType.TETRA: self.tets}, points)
        faces = {name: np.insert(of, 0, 3, axis=1).ravel() for name, of in self.tags.items()}
        blocks = {f"tag {name}": pyvista.PolyData(points, of) for name, of in faces.items()}
        return pyvista.MultiBlock({"body": body, **blocks})

    def __copy__(self) -> Body:
        return self

    def __deepcopy__(self, memo: dict[int, Any]) -> Body:
        return self

    @classmethod
    def _of_arrays(cls, *arrays: Any) -> Body:
        return cls._of(unpickled(lambda: cls(*arrays)._native))

    def __reduce__(self) -> tuple[Any, tuple[Any, ...]]:
        return Body._of_arrays, (self.vertices, self.tets, self.tags, self.volumes)

    def __repr__(self) -> str:
        vertices = self.vertices
        names = ", ".join(self.tags)
        return f"<Body: {len(vertices)} vertices, {len(self.tets)} tetrahedra, {_extent(vertices)}, tags {names}>"


def _extent(vertices: Floats) -> str:
    """The size of a body."""
    return " × ".join(f"{1e3 * size:.4g}" for size in np.ptp(vertices, axis=0)) + " mm"


def _joined(mesh: meshio.Mesh, kind: str, corners: int) -> Integers:
    """The cells of a kind."""
    found = [integers(block.data, 2, kind) for block in mesh.cells if block.type == kind]
    return np.concatenate(found) if found else np.zeros((0, corners), dtype=np.int64)


def _groups(mesh: meshio.Mesh, kind: str, dimension: int) -> Iterator[tuple[str, Integers]]:
    """Names of cells of a kind with their numbers among those."""
    ours = [k for k, block in enumerate(mesh.cells) if block.type == kind]
    begins = np.concatenate([[0], np.cumsum([len(mesh.cells[k].data) for k in ours])]).astype(np.int64)
    physical = mesh.cell_data.get("gmsh:physical")
    if physical is not None and ours:
        of = np.concatenate([np.asarray(physical[k]) for k in ours])
        names = {int(row[0]): name for name, row in mesh.field_data.items() if int(row[1]) == dimension}
        for group in np.unique(of):
            if group:
                yield names.get(int(group), str(group)), np.flatnonzero(of == group)
    for name, blocks in mesh.cell_sets.items():
        # meshio has sets of its own for the entities of Gmsh
        if not name.startswith("gmsh:"):
            own = [begin + np.asarray(blocks[k]) for begin, k in zip(begins, ours) if blocks[k] is not None]
            cells = np.concatenate(own) if own else np.zeros(0)
            if len(cells):
                yield name, cells.astype(np.int64)
