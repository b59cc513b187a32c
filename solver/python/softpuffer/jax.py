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
from .scene import Scene


def simulate(
    scene: Scene,
    vertices: jax.Array | None = None,
    parameters: Mapping[str, jax.Array] | None = None,
) -> jax.Array:
    """The displacement of the nodes at the end (n, 3) [m] of a scene with other rest positions (vertices, 3) [m],
    or other numbers by their paths. It has derivatives in reverse mode by both; the scene does not change."""
    paths = tuple(parameters or {})
    runs = {}

    def displacement(vertices, values):
        at = None if vertices is None else np.asarray(vertices, dtype=float)
        runs["last"] = solved(scene, at, {path: float(value) for path, value in zip(paths, values)})
        return runs["last"].displacement

    def shape_of(vertices, values):
        dtype = jnp.result_type(float)
        return jax.ShapeDtypeStruct((scene._native.node_count(), 3), dtype)

    @jax.custom_vjp
    def call(vertices, values):
        return jax.pure_callback(
            lambda v, p: np.asarray(displacement(v, p), dtype=jnp.result_type(float)),
            shape_of(vertices, values), vertices, values,
        )

    def forward(vertices, values):
        return call(vertices, values), (vertices, values)

    def backward(saved, by_u):
        vertices, values = saved

        def pull(vertices, values, by_u):
            at = None if vertices is None else np.asarray(vertices, dtype=float)
            run = solved(scene, at, {path: float(value) for path, value in zip(paths, values)})
            names = (["shape"] if vertices is not None else []) + list(paths)
            by = run.vjp(np.asarray(by_u, dtype=float), names)
            like = lambda value, x: np.asarray(value, dtype=x.dtype).reshape(x.shape)
            shape = None if vertices is None else like(by["shape"], vertices)
            return shape, [like(by[path], value) for path, value in zip(paths, values)]

        struct = lambda x: jax.ShapeDtypeStruct(jnp.shape(x), jnp.result_type(x))
        out = (None if vertices is None else struct(vertices), [struct(value) for value in values])
        return jax.pure_callback(pull, out, vertices, values, by_u)

    call.defvjp(forward, backward)
    values = [jnp.asarray(value, dtype=float) for value in (parameters or {}).values()]
    return call(None if vertices is None else jnp.asarray(vertices), values)
