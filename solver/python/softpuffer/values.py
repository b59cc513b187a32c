"""Values of Python as settings have them."""

from __future__ import annotations

import json
import math
from typing import Any, Mapping, Sequence

from ._native import InputError

#: Lists and tables in each other, at most: one that is in itself has no end.
_DEEPEST = 32


def as_json(table: Mapping[str, Any]) -> str:
    """A table of numbers, texts, lists and tables; NumPy's are among them, and paths are texts."""
    return json.dumps(_plain(table, ()))


def _plain(value: Any, at: tuple[str, ...]) -> Any:
    """The value below these keys, and numbers of items."""
    if len(at) > _DEEPEST:
        raise InputError(f"{at[0]}: {_DEEPEST} lists and tables in each other")
    if isinstance(value, float) and not math.isfinite(value):
        raise InputError(f"{' '.join(at)}: {value!r}: must be finite")
    if isinstance(value, (str, int, float)):
        return value
    if isinstance(value, Mapping):
        return {str(key): _plain(own, (*at, str(key))) for key, own in value.items()}
    if isinstance(value, Sequence):
        return [_plain(own, (*at, str(place))) for place, own in enumerate(value, 1)]
    # arrays and numbers of NumPy, and paths
    for method in ("tolist", "__fspath__"):
        if hasattr(value, method):
            return _plain(getattr(value, method)(), at)
    raise InputError(f"{' '.join(at)}: {value!r}: a scene has numbers, texts, lists and tables")
