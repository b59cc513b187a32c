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

_PLACES = {
    "Body": "body",
    "InputError": "_native",
    "NoEquilibrium": "_native",
    "ProgramError": "programs",
    "Run": "run",
    "Scene": "scene",
    "design": "designs",
    "load": "scene",
    "mesh": "folders",
    "new": "folders",
    "response": "responses",
    "simulate_all": "scene",
}
_MODULES = ("fab", "jax", "torch")

__all__ = ["__version__", *_PLACES, *_MODULES]


def __getattr__(name):
    # loaded when first used: the commands need neither NumPy nor the solver
    if name == "__version__":
        return import_module("._native", __name__).version()
    if name in _PLACES:
        return getattr(import_module(f".{_PLACES[name]}", __name__), name)
    if name in _MODULES:
        return import_module(f".{name}", __name__)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__():
    return sorted(__all__)
