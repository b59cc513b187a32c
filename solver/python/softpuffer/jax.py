"""A simulation as a function of JAX, for a loss of one's own.

    def loss(pressure):
        u = softpuffer.jax.simulate(scene, None, {"chamber.cavity.pressure": pressure})
        return ((u[tip] - wanted) ** 2).sum()

    jax.grad(loss)(20e3)

JAX counts in single precision unless `jax.config.update("jax_enable_x64", True)`.
"""

from __future__ import annotations

from typing import Mapping

import jax
import jax.numpy as jnp
import numpy as np

from .differentiable import solved
from .run import Run
from .scene import Scene


def simulate(
    scene: Scene,
    vertices: jax.Array | None = None,
    parameters: Mapping[str, jax.Array] | None = None,
) -> jax.Array:
    """The displacement of the nodes at the end (n, 3) [m] of a scene with other rest positions (vertices, 3) [m],
    or other numbers by their paths. It has derivatives in reverse mode by both; the scene does not change.

    parameters: arrays with one value each, in the SI units of `scene.numbers`.
    """
    last = _Last(scene.copy(), tuple(parameters or {}))
    nodes = scene._native.node_count()

    @jax.custom_vjp
    def displacement(vertices, values):
        real = jnp.result_type(float)
        find = lambda vertices, values: np.asarray(last.run(vertices, values).displacement, dtype=real)
        return jax.pure_callback(find, jax.ShapeDtypeStruct((nodes, 3), real), vertices, values)

    def forward(vertices, values):
        return displacement(vertices, values), (vertices, values)

    def backward(inputs, by_u):
        like = jax.tree.map(lambda x: jax.ShapeDtypeStruct(jnp.shape(x), jnp.result_type(x)), inputs)
        return jax.pure_callback(last.vjp, like, *inputs, by_u)

    displacement.defvjp(forward, backward)
    values = [jnp.asarray(value, dtype=float) for value in (parameters or {}).values()]
    return displacement(None if vertices is None else jnp.asarray(vertices), values)


class _Last:
    """Simulates, and keeps the last run: its derivatives are mostly what is asked for next."""

    def __init__(self, scene: Scene, paths: tuple[str, ...]):
        self.scene, self.paths = scene, paths
        self.known: tuple[object, Run] | None = None

    def run(self, vertices, values) -> Run:
        at = None if vertices is None else np.asarray(vertices, dtype=float)
        numbers = {path: float(value) for path, value in zip(self.paths, values)}
        inputs = (None if at is None else at.tobytes(), tuple(numbers.values()))
        if self.known is None or self.known[0] != inputs:
            self.known = (inputs, solved(self.scene, at, numbers))
        return self.known[1]

    def vjp(self, vertices, values, by_u):
        names = ([] if vertices is None else ["shape"]) + list(self.paths)
        by = self.run(vertices, values).vjp(np.asarray(by_u, dtype=float), names)
        like = lambda name, x: np.asarray(by[name], dtype=x.dtype).reshape(x.shape)
        by_shape = None if vertices is None else like("shape", vertices)
        return by_shape, [like(path, value) for path, value in zip(self.paths, values)]
