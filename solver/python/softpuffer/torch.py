"""A simulation as a function of PyTorch, for a loss of one's own.

    u = softpuffer.torch.simulate(scene, vertices, {"chamber.cavity.pressure": pressure})
    loss = ((u[tip] - wanted) ** 2).sum()
    loss.backward()
"""

from __future__ import annotations

from typing import Any, Mapping, Sequence

import torch

from ._native import InputError
from .beside import run_all
from .differentiable import ONCE, check_inputs, not_one, solved
from .run import Run, Unusable
from .scene import Scene


class _Simulate(torch.autograd.Function):
    @staticmethod
    def forward(
        ctx: Any,
        scene: Scene,
        paths: tuple[str, ...],
        unusable: Unusable,
        vertices: torch.Tensor | None,
        *values: torch.Tensor,
    ) -> torch.Tensor:
        at = vertices.detach().cpu().double().numpy() if vertices is not None else None
        ctx.run = solved(scene, at, {path: value.item() for path, value in zip(paths, values)}, unusable)
        ctx.paths = paths
        ctx.save_for_backward(vertices, *values)
        inputs = [x for x in (vertices, *values) if x is not None]
        kind = inputs[0].dtype
        for x in inputs[1:]:
            kind = torch.promote_types(kind, x.dtype)
        return torch.as_tensor(ctx.run.displacement, dtype=kind, device=inputs[0].device)

    @staticmethod
    def backward(ctx: Any, *by: torch.Tensor) -> Any:
        return None, None, None, *_Pulled.apply(ctx.run, ctx.paths, by[0], *ctx.saved_tensors)


class _Pulled(torch.autograd.Function):
    """The vector-Jacobian product, as a function of the inputs: so that a second derivative asks for its own."""

    @staticmethod
    def forward(
        ctx: Any,
        run: Run,
        paths: tuple[str, ...],
        by_u: torch.Tensor,
        vertices: torch.Tensor | None,
        *values: torch.Tensor,
    ) -> tuple[torch.Tensor | None, ...]:
        names = ([] if vertices is None else ["shape"]) + list(paths)
        found = run.vjp(by_u.detach().cpu().double().numpy(), names)
        by_shape = None if vertices is None else _like(found["shape"], vertices)
        return by_shape, *(_like(found[path], value) for path, value in zip(paths, values))

    @staticmethod
    def backward(ctx: Any, *by: torch.Tensor) -> Any:
        raise InputError(ONCE)


def simulate(
    scene: Scene,
    vertices: torch.Tensor | None = None,
    parameters: Mapping[str, torch.Tensor | float] | None = None,
    *,
    unusable: Unusable = "raise",
) -> torch.Tensor:
    """The displacement of the nodes at the end (n, 3) [m] of a scene with other rest positions (vertices, 3) [m],
    or other numbers by their paths. It can be differentiated once by both; the scene does not change.

    parameters: tensors with one value each, or numbers, in the SI units of `scene.numbers`. Integers become
        numbers of torch's default type.
    unusable: as for `Scene.simulate`.

    Raises what `Scene.simulate` raises.
    """
    parameters = parameters or {}
    check_inputs(vertices, parameters)
    values = [_one(path, value) for path, value in parameters.items()]
    at = None if vertices is None else _real("vertices", torch.as_tensor(vertices))
    found: torch.Tensor = _Simulate.apply(scene, tuple(parameters), unusable, at, *values)
    return found


def _like(found: object, x: torch.Tensor) -> torch.Tensor:
    return torch.as_tensor(found, dtype=x.dtype, device=x.device).reshape(x.shape)


def _real(what: str, tensor: torch.Tensor) -> torch.Tensor:
    """A tensor of real numbers."""
    if tensor.is_complex():
        raise InputError(f"{what}: a tensor of {tensor.dtype}, needed real numbers")
    return tensor if tensor.is_floating_point() else tensor.to(torch.get_default_dtype())


def _one(path: str, value: torch.Tensor | float) -> torch.Tensor:
    tensor = _real(path, torch.as_tensor(value))
    if tensor.numel() != 1:
        raise not_one(path, tuple(tensor.shape))
    return tensor


def simulate_batch(
    scene: Scene,
    vertices: Sequence[torch.Tensor] | torch.Tensor | None = None,
    parameters: Mapping[str, torch.Tensor | Sequence[float]] | None = None,
    *,
    unusable: Unusable = "raise",
) -> torch.Tensor:
    """Displacements (batch, n, 3) [m] of several cases, which run beside each other; `parameters` are lists of
    values, one for each case.

    Raises InputError where the lists are not of one length, and what `simulate` raises.
    """
    parameters = parameters or {}
    check_inputs(vertices, parameters)
    lengths = {path: len(values) for path, values in parameters.items()}
    if vertices is not None:
        lengths["vertices"] = len(vertices)
    if len(set(lengths.values())) > 1 or not all(lengths.values()):
        listed = ", ".join(f"{count} of {what}" for what, count in lengths.items())
        raise InputError(f"simulate_batch: {listed}; needed as many of each, one or more")

    def case(k: int) -> torch.Tensor:
        at = None if vertices is None else vertices[k]
        return simulate(scene, at, {path: values[k] for path, values in parameters.items()}, unusable=unusable)

    return torch.stack(run_all(case, next(iter(lengths.values()))))
