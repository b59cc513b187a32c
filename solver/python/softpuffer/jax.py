"""A simulation as a function of JAX, for a loss of one's own.

    def loss(pressure):
        u = softpuffer.jax.simulate(scene, None, {"chamber.cavity.pressure": pressure})
        return ((u[tip] - wanted) ** 2).sum()

    jax.grad(loss)(20e3)

JAX counts in single precision unless `jax.config.update("jax_enable_x64", True)`.
"""

from __future__ import annotations

from collections import OrderedDict
from contextlib import contextmanager
from typing import Any, Callable, Iterator, Mapping, Sequence

import jax
import jax.numpy as jnp
import numpy as np
from jax.core import Tracer
from numpy.typing import ArrayLike

from ._native import InputError
from .beside import run_all
from .differentiable import ONCE, check_inputs, not_one, solved
from .run import Run, Unusable
from .scene import Scene


def simulate(
    scene: Scene,
    vertices: jax.Array | ArrayLike | None = None,
    parameters: Mapping[str, jax.Array | ArrayLike] | None = None,
    *,
    unusable: Unusable = "raise",
) -> jax.Array:
    """The displacement of the nodes at the end (n, 3) [m] of a scene with other rest positions (vertices, 3) [m],
    or other numbers by their paths. It has derivatives in reverse mode by both; the scene does not change. With
    `jax.vmap` the cases run beside each other.

    parameters: arrays with one value each, in the SI units of `scene.numbers`.
    unusable: as for `Scene.simulate`.

    Raises what `Scene.simulate` raises; within `jax.jit` see `exceptions`.
    """
    parameters = parameters or {}
    check_inputs(vertices, parameters)
    last = _Last(scene.copy(), tuple(parameters), unusable)
    real = jnp.result_type(float)
    like_u = _Like((scene._native.node_count(), 3), real)

    @jax.custom_vjp
    def displacement(vertices: Any, values: Any) -> Any:
        return _called(last.displacement, like_u, vertices, values)

    def forward(vertices: Any, values: Any) -> Any:
        return displacement(vertices, values), (vertices, values)

    @jax.custom_vjp
    def backward(inputs: Any, by_u: Any) -> Any:
        like = jax.tree.map(lambda x: _Like(jnp.shape(x), jnp.result_type(x)), inputs)
        return _called(last.vjp, like, *inputs, by_u)

    displacement.defvjp(forward, backward)
    backward.defvjp(lambda *inputs: (backward(*inputs), None), _refused)
    values = [_one(path, jnp.asarray(value, dtype=real)) for path, value in parameters.items()]
    found: jax.Array = displacement(None if vertices is None else jnp.asarray(vertices, dtype=real), values)
    return found


@contextmanager
def exceptions() -> Iterator[None]:
    """Within it, functions that `jax.jit` has compiled raise the exceptions of this package, too, in place of
    JAX's own, which have them as text alone."""
    _raised.clear()
    try:
        yield
    except (RuntimeError, ValueError) as error:
        raise (_raised.pop() if _raised else error) from None


#: Shape and type of an array.
_Like: Any = jax.ShapeDtypeStruct
#: The last exception that JAX was to hand on.
_raised: list[Exception] = []


def _one(path: str, value: jax.Array) -> jax.Array:
    if value.size != 1:
        raise not_one(path, value.shape)
    return value.reshape(())


def _refused(*_: Any) -> Any:
    raise InputError(ONCE)


def _known(tree: Any) -> bool:
    return not any(isinstance(leaf, Tracer) for leaf in jax.tree.leaves(tree))


def _called(of: Callable[..., Any], like: Any, *inputs: Any) -> Any:
    """Calls a function of arrays of NumPy: now where the inputs are known, so that its exceptions are raised as they are,
    and else where they will be. A batch is called with all of its cases beside each other."""

    def now(*inputs: Any) -> Any:
        return jax.tree.map(jnp.asarray, of(*inputs))

    if _known(inputs):
        return now(*inputs)

    def later(*inputs: Any) -> Any:
        try:
            return of(*inputs)
        except Exception as error:
            _raised[:] = [error]
            raise

    @jax.custom_batching.custom_vmap
    def call(*inputs: Any) -> Any:
        if _known(inputs):
            return now(*inputs)
        return jax.pure_callback(later, like, *inputs, vmap_method="sequential")

    @call.def_vmap
    def batch(size: int, batched: Any, *inputs: Any) -> Any:
        leaves, tree = jax.tree.flatten(inputs)
        is_batched = jax.tree.leaves(batched)

        def all_cases(*inputs: Any) -> Any:
            leaves = jax.tree.leaves(inputs)

            def case(k: int) -> Any:
                return of(*jax.tree.unflatten(tree, [x[k] if own else x for x, own in zip(leaves, is_batched)]))

            found = run_all(case, size)
            return jax.tree.map(lambda *parts: np.stack(parts), *found)

        many = jax.tree.map(lambda one: _Like((size, *one.shape), one.dtype), like)
        return _called(all_cases, many, *inputs), jax.tree.map(lambda _: True, many)

    return call(*inputs)


class _Last:
    """Simulates, and keeps the last runs: their derivatives are mostly what is asked for next."""

    #: Runs that are kept, of a batch.
    MOST = 16

    def __init__(self, scene: Scene, paths: tuple[str, ...], unusable: Unusable):
        self.scene, self.paths = scene, paths
        self.unusable: Unusable = unusable
        self.known: OrderedDict[Any, Run] = OrderedDict()

    def run(self, vertices: ArrayLike | None, values: Sequence[Any]) -> Run:
        at = None if vertices is None else np.asarray(vertices, dtype=float)
        numbers = {path: float(value) for path, value in zip(self.paths, values)}
        inputs = (None if at is None else at.tobytes(), tuple(numbers.values()))
        run = self.known.get(inputs)
        if run is None:
            run = self.known[inputs] = solved(self.scene, at, numbers, self.unusable)
            if len(self.known) > self.MOST:
                self.known.popitem(last=False)
        return run

    def displacement(self, vertices: ArrayLike | None, values: Sequence[Any]) -> Any:
        return np.asarray(self.run(vertices, values).displacement, dtype=jnp.result_type(float))

    def vjp(self, vertices: Any, values: Sequence[Any], by_u: ArrayLike) -> Any:
        names = ([] if vertices is None else ["shape"]) + list(self.paths)
        by = self.run(vertices, values).vjp(np.asarray(by_u, dtype=float), names)
        by_shape = None if vertices is None else _like(by["shape"], vertices)
        return by_shape, [_like(by[path], value) for path, value in zip(self.paths, values)]


def _like(found: Any, x: Any) -> Any:
    return np.asarray(found, dtype=jnp.result_type(x)).reshape(jnp.shape(x))
