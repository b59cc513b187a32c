"""How many simulations with gradients a second: `RAYON_NUM_THREADS=1 rate.py [--profile]`, of a box with a hole.

A case has another pressure each, from rest, and the derivatives of its height by the shape of the body and two numbers. The
largest rate of three rounds, by processor time, is printed for each size. CONTRIBUTING.md says how to run it.
"""

import cProfile
import sys
import time
import warnings
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent))

import softpuffer as sp
from package import SILICONE, box

#: Cells along an edge of a box with a hole, degree of the displacement, and cases of a round.
SIZES = [(4, 1, 40), (3, 2, 20), (4, 2, 10)]


def cases(scene, count):
    """Simulates and differentiates."""
    for k in range(count):
        scene["chamber.cavity.pressure"] = 10e3 + 100 * k
        run = scene.simulate(progress=False)
        run.gradient("height", ["shape", "chamber.cavity.pressure", "material.body.c1"])
    return run


def main():
    """Prints a line for each size."""
    warnings.simplefilter("ignore")
    for cells, degree, count in SIZES:
        scene = sp.Scene(
            sp.Body(*box(cells)),
            material=SILICONE,
            fixed="seat",
            chambers={"cavity": 10e3},
            probes={"height": {"kind": "displacement", "on": "top", "axis": [0, 0, 1]}},
            degree=degree,
        )
        dofs = 3 * len(cases(scene, 2).nodes)
        if "--profile" in sys.argv:
            cProfile.runctx("cases(scene, count)", globals(), locals(), sort="tottime")
            continue
        rates = []
        for _ in range(3):
            begin = time.process_time()
            cases(scene, count)
            rates.append(count / (time.process_time() - begin))
        print(f"{dofs} degrees of freedom: {max(rates):.0f} simulations with gradients a second")


if __name__ == "__main__":
    main()
