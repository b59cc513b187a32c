"""Puffer designs, optimises and casts soft pneumatic actuators.

    import softpuffer as sp
    body = sp.Body.read("tagged.msh")
    scene = sp.Scene(body, material="dragon-skin-10-medium", fixed=["seat"], chambers={"cavity": 20e3})
    run = scene.simulate()
    run.displacement                                   # (nodes, 3) [m]

Lengths are metres, pressures pascals: SI units throughout. Pressure is gauge, and positive inflates.

`softpuffer.torch` and `softpuffer.jax` make a simulation a function that others can differentiate,
`softpuffer.fab` plans, makes and verifies molds, and `softpuffer.programs` has the commands.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from . import fab as fab, jax as jax, programs as programs, torch as torch
    from ._native import InputError as InputError, NoEquilibrium as NoEquilibrium
    from .body import Body as Body
    from .designs import Design as Design, design as design
    from .folders import mesh as mesh, new as new
    from .programs import ProgramError as ProgramError
    from .responses import Response as Response, response as response
    from .run import Run as Run, RunWarning as RunWarning, UnusableRun as UnusableRun
    from .scene import Scene as Scene, load as load, simulate_all as simulate_all

    __version__: str

_PLACES = {
    "Body": "body",
    "Design": "designs",
    "InputError": "_native",
    "NoEquilibrium": "_native",
    "ProgramError": "programs",
    "Response": "responses",
    "Run": "run",
    "RunWarning": "run",
    "Scene": "scene",
    "UnusableRun": "run",
    "design": "designs",
    "load": "scene",
    "mesh": "folders",
    "new": "folders",
    "response": "responses",
    "simulate_all": "scene",
}
_MODULES = ("fab", "jax", "programs", "torch")

__all__ = ["__version__", *_PLACES, *_MODULES]


if not TYPE_CHECKING:

    def __getattr__(name: str) -> Any:
        # loaded when first used: the commands need neither NumPy nor the solver
        if name == "__version__":
            return import_module("._native", __name__).version()
        if name in _PLACES:
            return getattr(import_module(f".{_PLACES[name]}", __name__), name)
        if name in _MODULES:
            return import_module(f".{name}", __name__)
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
