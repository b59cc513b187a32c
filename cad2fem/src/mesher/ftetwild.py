# Runs fTetWild on vertices.npy, triangles.npy; leaves points.npy, tets.npy.
import json
import os
import sys

import numpy

try:
    import wildmeshing
except ImportError as error:
    print(f"fTetWild cannot be loaded ({error}); run `make setup`", file=sys.stderr)
    sys.exit(3)

settings = json.load(open("settings.json"))
scale, edge_length, balls, seed = (
    settings.pop(key) for key in ("scale", "edge_length", "refine", "seed")
)
vertices = numpy.ascontiguousarray(numpy.load("vertices.npy")) * scale
triangles = numpy.ascontiguousarray(numpy.load("triangles.npy").astype(numpy.int32))


def size(point):
    """Wanted edge length at a point, both scaled."""
    length = edge_length
    for ball in balls:
        outside = numpy.linalg.norm(numpy.ravel(point) / scale - ball["center"]) - ball["radius"]
        length = min(length, ball["edge_length"] + 0.5 * max(outside, 0.0))
    return length * scale


# the system lists libraries without links, such as that of an environment
if not fix_seed(os.path.realpath(wildmeshing.wildmeshing.__file__), seed):
    open("unseeded", "w").close()
mesher = wildmeshing.Tetrahedralizer(**settings)
mesher.set_log_level(6)
if not mesher.set_mesh(vertices, triangles) in (None, True):
    sys.exit("fTetWild refused the surface")
if balls:
    mesher.set_sizing_field_from_func(size)
mesher.tetrahedralize()
# Inside is where the winding number of the input exceeds 1/2.
result = mesher.get_tet_mesh(manifold_surface=True)
numpy.save("points.npy", numpy.ascontiguousarray(result[0], dtype=float) / scale)
numpy.save("tets.npy", numpy.ascontiguousarray(result[1], dtype=float))
