"""What the functions for PyTorch and JAX share."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from typing import Callable, Mapping, TypeVar

import numpy as np

from .run import Run
from .scene import Scene

T = TypeVar("T")


def solved(scene: Scene, vertices: np.ndarray | None, numbers: Mapping[str, float]) -> Run:
    """The run of a scene with other rest positions and numbers; the scene does not change."""
    scene = scene.copy()
    if vertices is not None:
        scene.vertices = vertices
    for path, value in numbers.items():
        scene.set(path, value)
    return scene.simulate(progress=False)


def run_all(case: Callable[[int], T], count: int) -> list[T]:
    """All cases, beside each other: the solver releases Python's lock."""
    with ThreadPoolExecutor() as pool:
        return list(pool.map(case, range(count)))
