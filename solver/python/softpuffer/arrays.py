"""Arrays as the solver takes them."""

from __future__ import annotations

from typing import Iterable, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._native import InputError

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

T = TypeVar("T")


def floats(values: ArrayLike, what: str) -> Floats:
    """Rows of numbers."""
    try:
        array = np.ascontiguousarray(values, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(f"{what}: not an array of numbers: {error}") from None
    check_dimension(array.shape, 2, what)
    return array


def integers(values: ArrayLike, dimension: int, what: str) -> Integers:
    """A list or rows of integers."""
    array = np.asarray(values)
    if array.size and not np.issubdtype(array.dtype, np.integer):
        raise InputError(f"{what}: an array of {array.dtype}, needed integers")
    check_dimension(array.shape, dimension, what)
    return np.ascontiguousarray(array, dtype=np.int64)


def check_dimension(shape: tuple[int, ...], dimension: int, what: str) -> None:
    """Refuses an array of another dimension."""
    if len(shape) != dimension:
        needed = "rows of numbers" if dimension == 2 else "a list of numbers"
        raise InputError(f"{what}: an array of shape {list(shape)}, needed {needed}")


def listed(names: str | Iterable[str]) -> list[str]:
    """Names, of which one may stand alone."""
    return [names] if isinstance(names, str) else list(names)
