"""Cases beside each other, in threads and in processes."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from typing import Callable, NoReturn, TypeVar, cast

from . import _native

T = TypeVar("T")


def run_all(case: Callable[[int], T], count: int) -> list[T]:
    """All cases, beside each other: the solver releases Python's lock. The first that fails ends it."""
    with ThreadPoolExecutor() as pool:
        try:
            return list(pool.map(case, range(count)))
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise


def unpickled(make: Callable[[], T]) -> T:
    """What comes from another process. In one that was forked, what says why it cannot be where it is used: an error here
    would end the workers of a pool, which then waits for ever."""
    try:
        _native.check_process()
    except RuntimeError as error:
        return cast(T, _Missing(str(error)))
    return make()


class _Missing:
    def __init__(self, why: str):
        self._why = why

    def __getattr__(self, name: str) -> NoReturn:
        raise RuntimeError(self._why)
