"""A simulation as a function of PyTorch, for a loss of one's own.

    u = softpuffer.torch.simulate(scene, vertices, {"chamber.cavity.pressure": pressure})
    loss = ((u[tip] - wanted) ** 2).sum()
    loss.backward()
"""

from __future__ import annotations

from typing import Mapping, Sequence

import numpy as np
import torch

from .beside import run_all
from .differentiable import solved
from .scene import Scene


class _Simulate(torch.autograd.Function):
    @staticmethod
    def forward(ctx, scene, paths, vertices, *values):
        at = vertices.detach().cpu().numpy() if vertices is not None else None
        ctx.run = solved(scene, at, {path: value.item() for path, value in zip(paths, values)})
        ctx.paths = paths
        like = vertices if vertices is not None else values[0]
        ctx.like = [None if x is None else (x.dtype, x.device, x.shape) for x in (vertices, *values)]
        return torch.as_tensor(ctx.run.displacement, dtype=like.dtype, device=like.device)

    @staticmethod
    @torch.autograd.function.once_differentiable
    def backward(ctx, by_u):
        names = (["shape"] if ctx.like[0] else []) + list(ctx.paths)
        by = ctx.run.vjp(by_u.detach().cpu().numpy(), names)
        found = [by["shape"] if ctx.like[0] else None, *(by[path] for path in ctx.paths)]
        to = lambda value, like: None if like is None else torch.as_tensor(
            np.asarray(value), dtype=like[0], device=like[1]
        ).reshape(like[2])
        return None, None, *(to(value, like) for value, like in zip(found, ctx.like))


def simulate(
    scene: Scene,
    vertices: torch.Tensor | None = None,
    parameters: Mapping[str, torch.Tensor] | None = None,
) -> torch.Tensor:
    """The displacement of the nodes at the end (n, 3) [m] of a scene with other rest positions (vertices, 3) [m],
    or other numbers by their paths. It can be differentiated once by both; the scene does not change.

    parameters: tensors with one value each, in the SI units of `scene.numbers`.
    """
    parameters = parameters or {}
    if vertices is None and not parameters:
        raise ValueError("simulate: neither vertices nor parameters; scene.simulate() does that")
    values = [torch.as_tensor(value) for value in parameters.values()]
    return _Simulate.apply(scene, tuple(parameters), vertices, *values)


def simulate_batch(
    scene: Scene,
    vertices: Sequence[torch.Tensor] | None = None,
    parameters: Mapping[str, torch.Tensor] | None = None,
) -> torch.Tensor:
    """Displacements (batch, n, 3) [m] of several cases, which run beside each other; `parameters` are lists of
    values, one for each case."""
    cases = len(vertices) if vertices is not None else len(next(iter((parameters or {"": []}).values())))
    case = lambda k: simulate(
        scene,
        None if vertices is None else vertices[k],
        {path: values[k] for path, values in (parameters or {}).items()},
    )
    return torch.stack(run_all(case, cases))
