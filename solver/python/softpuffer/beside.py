"""Cases beside each other."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from typing import Callable, TypeVar

T = TypeVar("T")


def run_all(case: Callable[[int], T], count: int) -> list[T]:
    """All cases, beside each other: the solver releases Python's lock."""
    with ThreadPoolExecutor() as pool:
        return list(pool.map(case, range(count)))
