"""Which keys a scene and a scenario have, for those who check types. What they mean is in the book; a test compares them."""

from __future__ import annotations

from typing import Any, Literal, Mapping, Sequence, TypedDict

Table = Mapping[str, Any]


class Tables(TypedDict, total=False):
    """Keys of a scene beside the arguments of `Scene`."""

    quadrature: int | None
    gravity: Sequence[float | str]
    contact: Table | Literal["ignored"] | None
    time: Table | None
    solver: Table
    parameters: Mapping[str, float]
    numbers: Mapping[str, float]
    uncertainty: Table | None
    limit: Table | None
    obstacle: Sequence[Table]
    symmetry: Sequence[Table]
    membrane: Sequence[Table]
    rigid: Sequence[Table]
    fibre: Sequence[Table]
    winding: Sequence[Table]
    relaxation: Sequence[Table]
    mullins: Sequence[Table]
    body_force: Sequence[Table]
    traction: Sequence[Table]


class Changes(TypedDict, total=False):
    """Keys of a scenario."""

    name: str
    weight: float
    wall: float | Mapping[str, float]
    modulus: float | Mapping[str, float]
    density: float | Mapping[str, float]
    membrane: float | Mapping[str, float]
    friction: float
    pressure: float
    numbers: Mapping[str, float]
    parameters: Mapping[str, float]
    weights: Mapping[str, float]
