"""Random bodies of six families, each with what is known of it by construction.

    python bodies.py FOLDER [--family NAME] [--count 10] [--seed 0]

A body is a folder FAMILY-SEED with the files for `cad2fem`, `tagger` and `fab`, and facts.json: its least wall, the
radius of its inlet and the least width of the grooves outside of it [mm], and whether it can be cast.
"""

import argparse
import importlib
import json
import pathlib
import random

import manifold3d
import numpy

FAMILIES = ("shells", "lattices", "fillets", "lofts", "periodic", "scans")

# No wall and no radius of an inlet is less [mm].
LEAST_WALL, LEAST_INLET = 1.4, 1.5

# The mesher's envelope over the least wall: what it moves does not matter to a wall.
ENVELOPE = 1 / 10
# Selections reach further than the envelope.
SELECTION = 2.0


class Body:
    """What a generator returns: a model, the names of its chambers, and facts [mm]. A model is implicit, the bytes of a
    STEP file, or triangles (corners, three a row) by the names of their STL files."""

    def __init__(self, kind, model, chambers=("cavity",), *, size, wall, inlet, gap=None, castable=True):
        self.kind, self.model, self.chambers = kind, model, chambers
        self.facts = {"size": size, "wall": wall, "inlet": inlet, "gap": gap, "castable": castable}

    def write(self, folder, family, seed):
        folder.mkdir(parents=True, exist_ok=True)
        if isinstance(self.model, bytes):
            (folder / "model.step").write_bytes(self.model)
        elif isinstance(self.model, dict):
            for name, corners in self.model.items():
                write_stl(folder / f"{name}.stl", corners)
        else:
            (folder / "model.toml").write_text(self.model.text())
        wall, size = (self.facts[name] * 1e-3 for name in ("wall", "size"))
        envelope = ENVELOPE * wall
        edge = max(1.5 * wall, 0.06 * size)
        (folder / "cad2fem.toml").write_text(
            f"[tetmesh]\nedge_length = {edge:.3e}\nenvelope = {envelope:.3e}\nstop_energy = 30\n"
            "max_iterations = 8\nthreads = 1\n"
        )
        tags = f"epsilon = {SELECTION * envelope:.3e}\n"
        for name in (*self.chambers, "seat", "skin"):
            seat = name == "seat" and isinstance(self.model, dict)
            where = "plane = { point = [0, 0, 0], normal = [0, 0, -1] }" if seat else f'patch = "{name}.stl"'
            tags += f'[[tag]]\nname = "{name}"\n{where}\n'
            tags += "pressure = true\n" if name in self.chambers else ""
            tags += 'rim = "seat"\n' if name in self.chambers and self.facts["inlet"] else ""
        (folder / "tags.toml").write_text(tags)
        (folder / "mold.toml").write_text(f"chamber = {json.dumps(list(self.chambers))}\n")
        facts = {"family": family, "kind": self.kind, "seed": seed, **self.facts}
        (folder / "facts.json").write_text(json.dumps(facts, indent=1) + "\n")


def between(a, b):
    """Least distance of two segments, by points on them; exact to 1/400 of their length."""
    along = numpy.linspace(0, 1, 41)[:, None]
    first, second = (s + along * (e - s) for s, e in (a, b))
    return numpy.linalg.norm(first[:, None] - second[None], axis=2).min()


def triangles(solid):
    """Corners of the triangles of a manifold, three a row."""
    mesh = solid.to_mesh()
    return numpy.asarray(mesh.vert_properties, float)[:, :3][mesh.tri_verts]


def apart(skin, chamber):
    """Least distance of a manifold to another one within it."""
    box = numpy.array(skin.bounding_box()).reshape(2, 3) + [[-1], [1]]
    around = manifold3d.Manifold.cube(box[1] - box[0]).translate(box[0]) - skin
    return around.min_gap(chamber, float((box[1] - box[0]).max()))


def write_stl(path, corners):
    """A binary STL, whose triangles share no corners."""
    facets = numpy.zeros(len(corners), dtype=[("normal", "<3f4"), ("corners", "<9f4"), ("rest", "<u2")])
    facets["corners"] = corners.reshape(-1, 9)
    path.write_bytes(bytes(80) + numpy.uint32(len(corners)).tobytes() + facets.tobytes())


def make(folder, family, seed):
    """Writes the body of a seed; its folder."""
    generator = importlib.import_module(family)
    place = pathlib.Path(folder) / f"{family}-{seed}"
    generator.body(random.Random(f"{family} {seed}")).write(place, family, seed)
    return place


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder")
    parser.add_argument("--family", choices=FAMILIES)
    parser.add_argument("--count", type=int, default=10)
    parser.add_argument("--seed", type=int, default=0)
    return parser.parse_args()


if __name__ == "__main__":
    from bodies import FAMILIES, make  # one module, also for the families

    asked = arguments()
    for name in [asked.family] if asked.family else FAMILIES:
        for number in range(asked.seed, asked.seed + asked.count):
            make(asked.folder, name, number)
