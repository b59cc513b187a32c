"""What the functions for PyTorch and JAX share."""

from __future__ import annotations

from typing import Mapping

import numpy as np

from .run import Run
from .scene import Scene


def solved(scene: Scene, vertices: np.ndarray | None, numbers: Mapping[str, float]) -> Run:
    """The run of a scene with other rest positions and numbers; the scene does not change."""
    scene = scene.copy()
    if vertices is not None:
        scene.vertices = vertices
    for path, value in numbers.items():
        scene.set(path, value)
    return scene.simulate(progress=False)
