"""A line that says how far a simulation is."""

from __future__ import annotations

import sys
import time
from contextlib import contextmanager
from typing import Callable, Iterator

#: What is called at every iteration of Newton's method: time [s], iteration, unbalanced and wanted force [N].
Progress = Callable[[float, int, float, float], None]

#: Seconds between two lines.
_BETWEEN = 0.1


@contextmanager
def shown(progress: Progress | bool | None) -> Iterator[Progress | None]:
    """What the solver calls: the function that was given, one that draws a line, or none."""
    if callable(progress):
        yield progress
    elif progress or (progress is None and sys.stderr.isatty()):
        line = _Line()
        try:
            yield line
        finally:
            line.clear()
    else:
        yield None


class _Line:
    def __init__(self) -> None:
        self.next, self.width = 0.0, 0

    def __call__(self, at: float, iteration: int, residual: float, wanted: float) -> None:
        now = time.monotonic()
        if now < self.next:
            return
        self.next = now + _BETWEEN
        self._write(f"towards t = {at:.4g}: newton {iteration}, {residual:.1e} of {wanted:.1e} N")

    def _write(self, text: str) -> None:
        sys.stderr.write("\r" + text.ljust(self.width))
        sys.stderr.flush()
        self.width = len(text)

    def clear(self) -> None:
        """Leaves nothing behind."""
        if self.width:
            self._write("")
            sys.stderr.write("\r")
            sys.stderr.flush()
