"""Meshes whose facets and parts have names."""

from __future__ import annotations

import os
from typing import Mapping

import numpy as np
from numpy.typing import ArrayLike

from . import _native
from ._native import InputError


class Body:
    """A mesh of tetrahedra with tags.

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
        facets = [(name, _integers(of, 2, f'tag "{name}"')) for name, of in (tags or {}).items()]
        parts = [(name, _integers(of, 1, f'volume "{name}"')) for name, of in (volumes or {}).items()]
        self._native = _native.Body(floats(vertices, "vertices"), _integers(tets, 2, "tets"), facets, parts)

    @classmethod
    def _of(cls, native: _native.Body) -> Body:
        body = cls.__new__(cls)
        body._native = native
        return body

    @classmethod
    def read(cls, path: str | os.PathLike) -> Body:
        """Reads a mesh of Gmsh, such as `tagger tag` writes; it may be compressed by gzip."""
        return cls._of(_native.Body.read(os.fspath(path)))

    def write(self, path: str | os.PathLike) -> None:
        """Writes the mesh in Gmsh's format 2.2."""
        self._native.write(os.fspath(path))

    @property
    def vertices(self) -> np.ndarray:
        """Positions (n, 3) [m], a copy."""
        return self._native.vertices

    @property
    def tets(self) -> np.ndarray:
        """Vertices of each tetrahedron (m, 4), a copy."""
        return self._native.tets

    @property
    def tags(self) -> dict[str, np.ndarray]:
        """Facets (k, 3) of each tag, as vertices, copies."""
        return self._native.tags

    @property
    def volumes(self) -> dict[str, np.ndarray]:
        """Numbers (k,) of the tetrahedra of each named part, copies; empty where there are no parts."""
        return self._native.volumes

    def __repr__(self) -> str:
        return repr(self._native)


def floats(values: ArrayLike, what: str) -> np.ndarray:
    """Rows of numbers as the solver takes them."""
    try:
        array = np.ascontiguousarray(values, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(f"{what}: not an array of numbers: {error}") from None
    return _of_dimension(array, 2, what)


def _integers(values: ArrayLike, dimension: int, what: str) -> np.ndarray:
    array = np.asarray(values)
    if array.size and not np.issubdtype(array.dtype, np.integer):
        raise InputError(f"{what}: an array of {array.dtype}, needed integers")
    return _of_dimension(np.ascontiguousarray(array, dtype=np.int64), dimension, what)


def _of_dimension(array: np.ndarray, dimension: int, what: str) -> np.ndarray:
    if array.ndim != dimension:
        needed = "rows of numbers" if dimension == 2 else "a list of numbers"
        raise InputError(f"{what}: an array of shape {list(array.shape)}, needed {needed}")
    return array
