"""The path that the tip of the tube shall follow, and how far from it a run is.

Seen from the free end the path is an arc of a circle of 50 mm that begins downward and turns to the side, 8 mm along it for
each 15 kPa; along the tube it stays where it was. At the distance s along it, from where the tip is at rest,

x = 0        y = −R (1 − cos s/R)        z = −R sin s/R.

It is a curve that we chose, and no answer of a model.

python3 pipelines/fibre/path/path.py                    # the path, as CSV
python3 pipelines/fibre/path/path.py steps.jsonl ...    # how far runs are from it
"""

import json
import sys
from math import cos, dist, sin

RADIUS, STEP = 50e-3, 8e-3  # [m], and along the path for each unit of time [m]
POINTS = 2000


def path(time):
    """Displacement of the tip at a time [m]."""
    angle = STEP * time / RADIUS
    return (0.0, -RADIUS * (1 - cos(angle)), -RADIUS * sin(angle))


def show(lines):
    """Where the tip is in a run, how far from its place at this pressure, and from the path [mm]."""
    print("pressure [kPa],x [mm],y [mm],z [mm],off [mm],from the path [mm]")
    curve = [path(4.2 * i / POINTS) for i in range(POINTS + 1)]
    for step in map(json.loads, lines):
        time = step["t"]
        tip = [step["probes"][axis] for axis in "xyz"]
        off, beside = dist(tip, path(time)), min(dist(tip, place) for place in curve)
        print(f"{15 * time:g}", *(f"{1e3 * value:.3f}" for value in (*tip, off, beside)), sep=",")


if __name__ == "__main__":
    if len(sys.argv) > 1:
        for name in sys.argv[1:]:
            with open(name, encoding="utf-8") as file:
                show(file)
    else:
        print("x [mm],y [mm],z [mm]")
        for i in range(17):
            print(*(f"{1e3 * value:.4f}" for value in path(i / 4)), sep=",")
