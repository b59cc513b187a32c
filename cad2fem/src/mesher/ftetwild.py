# Runs fTetWild on vertices.npy, triangles.npy; leaves points.npy, tets.npy.
import itertools
import json

import numpy

# How far the grid on which pytetwild gets wanted edge lengths reaches beyond the surface [diagonal], and how many points
# it may have: with that many the beam took 0.7 GB.
BEYOND, MOST = 0.1, 500_000

settings = json.load(open("settings.json"))
scale, edge_length, balls, envelope = (settings[key] for key in ("scale", "edge_length", "refine", "envelope"))
vertices = numpy.ascontiguousarray(numpy.load("vertices.npy")) * scale
triangles = numpy.load("triangles.npy")


def lengths(points):
    """Wanted edge lengths at points, both scaled."""
    wanted = numpy.full(len(points), edge_length)
    for ball in balls:
        outside = numpy.linalg.norm(points / scale - ball["center"], axis=1) - ball["radius"]
        wanted = numpy.minimum(wanted, ball["edge_length"] + 0.5 * numpy.maximum(outside, 0.0))
    return wanted * scale


def seed(library):
    # the system lists libraries without links, such as that of an environment
    if not fix_seed(os.path.realpath(library.__file__), settings["seed"]):
        open("unseeded", "w").close()


def by_wildmeshing():
    library = load("wildmeshing").wildmeshing
    seed(library)
    mesher = library.Tetrahedralizer(
        stop_quality=settings["stop_energy"], max_its=settings["max_iterations"], max_threads=settings["threads"],
        epsilon=envelope, edge_length_r=settings["relative_edge_length"], coarsen=settings["coarsen"],
    )
    mesher.set_log_level(6)
    if not mesher.set_mesh(vertices, triangles.astype(numpy.int32)) in (None, True):
        sys.exit("fTetWild refused the surface")
    if balls:
        mesher.set_sizing_field_from_func(lambda point: lengths(numpy.reshape(point, (1, 3)))[0])
    mesher.tetrahedralize()
    return mesher.get_tet_mesh(all_mesh=True) if settings["inside"] else mesher.get_tet_mesh(manifold_surface=True)


def by_pytetwild():
    library = load("pytetwild")
    seed(library)
    return library.tetrahedralize_mesh(
        vertices, triangles.astype(numpy.uint32),
        True, False,  # optimises, simplifies
        settings["relative_edge_length"], 0.0, envelope, settings["stop_energy"], settings["coarsen"],
        settings["threads"], settings["max_iterations"],
        6, True, False,  # says nothing, keeps the order of corners
        settings["inside"], *sizing_field(),
    )


def sizing_field():
    """Points, tetrahedra and wanted edge lengths of a grid around the surface; nothing without balls."""
    if not balls:
        return numpy.empty((0, 3)), numpy.empty((0, 4), numpy.int32), numpy.empty(0)
    low, high = vertices.min(axis=0) / scale, vertices.max(axis=0) / scale
    beyond = BEYOND * numpy.linalg.norm(high - low)
    sides = [planes(axis, low[axis] - beyond, high[axis] + beyond) for axis in range(3)]
    counts = [len(side) for side in sides]
    if numpy.prod(counts) > MOST:
        explain(f"refine: pytetwild gets the wanted edge lengths on a grid, which for these {len(balls)} balls would have "
                f"{numpy.prod(counts)} points, {MOST} at most: give fewer, or larger ones")
    points = scale * numpy.stack(numpy.meshgrid(*sides, indexing="ij"), axis=-1).reshape(-1, 3)
    number = numpy.arange(len(points), dtype=numpy.int32).reshape(counts)
    tets = []
    for axes in itertools.permutations(range(3)):
        # from a corner of each cell to the opposite one, along one axis after the other
        path = [[int(axis in axes[:length]) for axis in range(3)] for length in range(4)]
        corners = [number[tuple(slice(at, n - 1 + at) for at, n in zip(place, counts))] for place in path]
        tets.append(numpy.stack(corners, axis=-1).reshape(-1, 4))
    return points, numpy.concatenate(tets), lengths(points)


def planes(axis, low, high):
    """Where the planes of the grid lie across an axis [m]: close in balls, and further apart with the distance."""
    at = [low]
    while at[-1] < high:
        outside = [max(abs(at[-1] - ball["center"][axis]) - ball["radius"], 0.0) for ball in balls]
        steps = [max(ball["edge_length"], ball["radius"] / 3) + d / 2 for ball, d in zip(balls, outside)]
        at.append(at[-1] + min(steps))
    return at


def explain(message):
    print(message, file=sys.stderr)
    sys.exit(3)


try:
    # Inside is where the winding number of the input exceeds 1/2. Where surfaces lie inside, whose winding number is
    # not that of the body, all tetrahedra of the box around it are left, of which the caller takes those in the body.
    points, tets = {"wildmeshing": by_wildmeshing, "pytetwild": by_pytetwild}[settings["package"]]()[:2]
except ImportError as error:
    explain(f"fTetWild cannot be loaded ({error}); `cad2fem doctor` says what is missing")
numpy.save("points.npy", numpy.ascontiguousarray(points, dtype=float) / scale)
numpy.save("tets.npy", numpy.ascontiguousarray(tets, dtype=float))
