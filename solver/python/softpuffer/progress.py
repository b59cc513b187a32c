"""A line that says how far a simulation is."""

from __future__ import annotations

import sys
import time
from contextlib import contextmanager

#: Seconds between two lines.
_BETWEEN = 0.1


@contextmanager
def shown(progress):
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
    def __init__(self):
        self.next, self.width = 0.0, 0

    def __call__(self, at, iteration, residual, wanted):
        now = time.monotonic()
        if now < self.next:
            return
        self.next = now + _BETWEEN
        self._write(f"towards t = {at:.4g}: newton {iteration}, {residual:.1e} of {wanted:.1e} N")

    def _write(self, text):
        sys.stderr.write("\r" + text.ljust(self.width))
        sys.stderr.flush()
        self.width = len(text)

    def clear(self):
        """Leaves nothing behind."""
        if self.width:
            self._write("")
            sys.stderr.write("\r")
            sys.stderr.flush()
