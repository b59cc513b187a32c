"""What the functions for PyTorch and JAX share."""

from __future__ import annotations

from typing import Mapping

from ._native import InputError
from .arrays import Floats
from .run import Run, Unusable
from .scene import Scene

#: What has no second derivatives.
ONCE = "a simulation can be differentiated once: there are no second derivatives of it"


def solved(scene: Scene, vertices: Floats | None, numbers: Mapping[str, float], unusable: Unusable) -> Run:
    """The run of a scene with other rest positions and numbers; the scene does not change."""
    scene = scene.copy()
    if vertices is not None:
        scene.vertices = vertices
    scene.set(numbers)
    return scene.simulate(progress=False, unusable=unusable)


def check_inputs(vertices: object, parameters: Mapping[str, object]) -> None:
    """Refuses a function of nothing."""
    if vertices is None and not parameters:
        raise InputError("simulate: neither vertices nor parameters; scene.simulate() does that")


def not_one(path: str, shape: tuple[int, ...]) -> InputError:
    """The error of a number that is none."""
    return InputError(f"{path}: an array of shape {list(shape)}, needed one number")
