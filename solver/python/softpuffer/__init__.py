"""Puffer designs, optimises and casts soft pneumatic actuators.

The programs are in `softpuffer.programs`. Importing this package loads nothing else.
"""


def __getattr__(name):
    if name == "__version__":
        from ._native import version

        return version()
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
