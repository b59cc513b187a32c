"""Whether a body cannot be cast, from its model alone: python verdict.py FOLDER...

Uses none of the programs: implicit functions by numpy, CAD by gmsh's triangles. The filled body and its chambers
become voxels. A piece of the mold that lies below silicone leaves it along a pull only if the silicone gives way: by
as much as the piece reaches under, over the width of the silicone there. That ratio is taken where it is least of four
directions across the pull, for each voxel for itself, with the pieces and surfaces that suit that voxel. It is thus no
more than what any mold needs, and "cannot be cast" is safe, as far as voxels show the body. `fab plan` adds up both
sides and compares with the same limit. Closed chambers, in which no core can be held, are counted by trimesh.
"""

import itertools
import json
import pathlib
import re
import sys
import tomllib

import numpy

import implicit

# `limits.peel`: what silicone gives way by, over its width.
PEEL = 0.5
# Voxels along the longest side: of the body, and when it is looked at along a direction.
FINE, COARSE = 80, 30
# So many voxels above the limit may be due to voxels.
NOISE = 6
# Least volume of a closed chamber that counts [mm³].
POCKET = 0.1
CUTS = 7
AZIMUTHS = 4
LOCKED = 1e9


class Voxels:
    """The filled body and its chambers, in a box."""

    def __init__(self, low, high, inside):
        self.low, self.edge = low, (high - low).max() / FINE
        shape = numpy.maximum(numpy.ceil((high - low) / self.edge).astype(int), 1)
        axes = [low[k] + (numpy.arange(shape[k]) + 0.5) * self.edge for k in range(3)]
        points = numpy.stack(numpy.meshgrid(*axes, indexing="ij"), axis=-1)
        self.filled, self.chamber = inside(points.reshape(-1, 3), axes)
        self.filled, self.chamber = (a.reshape(shape) for a in (self.filled, self.chamber))
        self.opens_below = bool(self.chamber[:, :, 0].any())

    def along(self, axes):
        """Filled body and chambers on a coarser grid whose sides are the rows of `axes`, the last one first."""
        shape = numpy.array(self.filled.shape)
        corners = numpy.array(list(itertools.product(*[(0, n) for n in shape]))) @ axes.T
        low, high = corners.min(axis=0), corners.max(axis=0)
        step = (high - low).max() / COARSE
        counts = numpy.ceil((high - low) / step).astype(int) + 2
        sides = [low[k] + (numpy.arange(counts[k]) - 0.5) * step for k in range(3)]
        points = numpy.stack(numpy.meshgrid(*sides, indexing="ij"), axis=-1) @ axes
        at = numpy.floor(points).astype(int)
        within = ((at >= 0) & (at < shape)).all(axis=-1)
        at = numpy.clip(at, 0, shape - 1)
        look = tuple(numpy.moveaxis(at, -1, 0))
        return [numpy.moveaxis(a[look] & within, 2, 0) for a in (self.filled, self.chamber)]


def of_model(path):
    model = tomllib.loads(path.read_text())
    shapes = [part["shape"] for part in model["solid"]]
    high = max(abs(numpy.array(value, float)).max() for shape in shapes for keys in shape.values()
               for value in keys.values())
    # a box around the body, found on a coarse grid
    ends = numpy.linspace(-2 * high, 2 * high, 161)
    grid = numpy.stack(numpy.meshgrid(ends, ends, ends[ends >= 0], indexing="ij"), axis=-1).reshape(-1, 3)
    found = grid[implicit.inside(model, grid)[0]]
    margin = ends[1] - ends[0]
    low, high = found.min(axis=0) - margin, found.max(axis=0) + margin
    low[2] = 0.0
    return Voxels(low, high, lambda points, _: implicit.inside(model, points))


def of_step(path):
    """The filled body is what has an odd number of crossings with the skin above it."""
    import gmsh
    gmsh.initialize()
    gmsh.option.setNumber("General.Verbosity", 0)
    gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", 12)
    gmsh.open(str(path))
    gmsh.model.mesh.generate(2)
    text = path.read_text()
    shells = re.findall(r"CLOSED_SHELL\s*\('[^']*',\s*\(([^)]*)\)", text)
    faces = [face for shell in shells for face in re.findall(r"#(\d+)", shell)]
    names = [re.search(rf"#{face} = ADVANCED_FACE\('([^']*)'", text)[1] for face in faces]
    tags, places, _ = gmsh.model.mesh.getNodes()
    places = places.reshape(-1, 3)[numpy.argsort(tags)]
    order = numpy.sort(tags)
    triangles = {}
    for (_, face), name in zip(gmsh.model.getEntities(2), names):
        corners = gmsh.model.mesh.getElementsByType(2, face)[1].reshape(-1, 3)
        triangles.setdefault(name, []).append(places[numpy.searchsorted(order, corners)])
    gmsh.finalize()
    triangles = {name: numpy.concatenate(parts) for name, parts in triangles.items()}
    skin = triangles.pop("skin")
    triangles.pop("seat", None)
    return of_triangles(skin, numpy.concatenate(list(triangles.values())))


def of_stl(folder):
    """The same of two files."""
    def corners(path):
        facets = numpy.frombuffer(path.read_bytes()[84:], dtype=[("normal", "<3f4"), ("corners", "<9f4"), ("rest", "<u2")])
        return facets["corners"].reshape(-1, 3, 3).astype(float)

    return of_triangles(corners(folder / "skin.stl"), corners(folder / "cavity.stl"))


def of_triangles(skin, walls):
    def inside(_, axes):
        filled, chamber = (odd(part, axes) for part in (skin, walls))
        return filled, chamber & filled

    low, high = skin.reshape(-1, 3).min(axis=0), skin.reshape(-1, 3).max(axis=0)
    return Voxels(low, high, inside)


def odd(triangles, axes):
    """Whether an odd number of triangles lies above each point of a grid."""
    x, y, z = axes
    flips = numpy.zeros((len(x), len(y), len(z) + 1), int)
    step = numpy.array([x[1] - x[0], y[1] - y[0]])
    # columns that meet no corner and no edge
    origin = numpy.array([x[0], y[0]]) + 1e-4 * step
    for a, b, c in triangles:
        flat = (numpy.array([a, b, c])[:, :2] - origin) / step
        first, last = numpy.ceil(flat.min(axis=0)).astype(int), numpy.floor(flat.max(axis=0)).astype(int)
        ways = numpy.array([b - a, c - a])
        det = (flat[1] - flat[0])[0] * (flat[2] - flat[0])[1] - (flat[1] - flat[0])[1] * (flat[2] - flat[0])[0]
        if abs(det) < 1e-12:
            continue
        for i, j in itertools.product(range(max(first[0], 0), min(last[0], len(x) - 1) + 1),
                                      range(max(first[1], 0), min(last[1], len(y) - 1) + 1)):
            p, u, v = numpy.array([i, j]) - flat[0], flat[1] - flat[0], flat[2] - flat[0]
            s, t = (p[0] * v[1] - p[1] * v[0]) / det, (u[0] * p[1] - u[1] * p[0]) / det
            if s >= 0 and t >= 0 and s + t <= 1:
                height = a[2] + s * ways[0][2] + t * ways[1][2]
                flips[i, j, numpy.searchsorted(z, height)] += 1
    above = numpy.cumsum(flips[:, :, ::-1], axis=2)[:, :, ::-1][:, :, 1:]
    return (above % 2 == 1).reshape(-1)


def runs(mask, filled):
    """Along the last axis: the length of the run of `mask` around each voxel, and whether it ends at the body on
    both sides."""
    n, at = mask.shape[-1], numpy.arange(mask.shape[-1])
    before = numpy.maximum.accumulate(numpy.where(mask, -1, at), axis=-1)
    after = numpy.minimum.accumulate(numpy.where(mask, n, at)[..., ::-1], axis=-1)[..., ::-1]
    wall = numpy.take_along_axis(filled, before.clip(0), -1) & (before >= 0)
    wall &= numpy.take_along_axis(filled, after.clip(max=n - 1), -1) & (after < n)
    return after - before - 1, wall


def sheared(array, way):
    """Diagonals of the last two axes as rows."""
    rows, n = array.shape[-2:]
    wide = numpy.zeros((*array.shape[:-1], n + rows), array.dtype)
    for row in range(rows):
        wide[..., row, (shift := row if way > 0 else rows - row): shift + n] = array[..., row, :]
    return numpy.swapaxes(wide, -1, -2)


def straight(array, shape, way):
    rows, n = shape[-2:]
    array = numpy.swapaxes(array, -1, -2)
    shifts = [row if way > 0 else rows - row for row in range(rows)]
    return numpy.stack([array[..., row, shift: shift + n] for row, shift in enumerate(shifts)], axis=-2)


def gives_way(filled):
    """For each empty voxel that is to leave upward, along the first axis: what the body must give way by, over its
    width."""
    above = numpy.zeros_like(filled)
    above[:-1] = numpy.logical_or.accumulate(filled[::-1], axis=0)[::-1][1:]
    held, shade = above & ~filled, above | filled
    least = numpy.full(filled.shape, LOCKED)
    swap = lambda a: numpy.swapaxes(a, 1, 2)
    views = [(lambda a: a, lambda a: a), (swap, swap)]
    views += [(lambda a, w=w: sheared(a, w), lambda a, w=w: straight(a, filled.shape, w)) for w in (1, -1)]
    for view, back in views:
        reach, walled = runs(view(held), view(filled))
        width, _ = runs(view(shade), view(filled))
        ratio = numpy.where(walled, LOCKED, reach / numpy.maximum(width, 1))
        least = numpy.minimum(least, back(ratio))
    return numpy.where(held, least, 0.0)


def worst(ratios):
    """The largest but for noise."""
    if ratios.size <= NOISE:
        return 0.0
    return float(numpy.partition(ratios.ravel(), -NOISE)[-NOISE])


def both_ways(filled):
    return numpy.minimum(gives_way(filled), gives_way(filled[::-1])[::-1])


def across(filled):
    """The same for pulls along the last axis."""
    return numpy.moveaxis(both_ways(numpy.moveaxis(filled, 2, 0)), 0, 2)


def frames(normal):
    """Axes whose last is a direction, turned about it."""
    normal = normal / numpy.linalg.norm(normal)
    side = numpy.cross(normal, numpy.eye(3)[numpy.argmin(abs(normal))])
    side /= numpy.linalg.norm(side)
    other = numpy.cross(normal, side)
    for turn in numpy.pi * numpy.arange(AZIMUTHS) / AZIMUTHS:
        first = numpy.cos(turn) * side + numpy.sin(turn) * other
        yield numpy.array([first, numpy.cross(normal, first), normal])


def as_a_whole(voxels):
    """What the outside must give way by in the best mold of two or three pieces, standing as modelled."""
    best = LOCKED
    for axes in frames(numpy.array([0.0, 0.0, 1.0])):
        filled, _ = voxels.along(axes)
        upright, sideways, down = both_ways(filled), across(filled), gives_way(filled[::-1])[::-1]
        best = min(best, worst(upright), worst(sideways))
        for cut in range(1, len(filled), 4):
            best = min(best, max(worst(sideways[cut:]), worst(down[:cut])))
        if best <= PEEL:
            break
    return best


def half(filled, chamber, enough):
    """The same of a half that stands on its cut, the first layer, with its half core below; not all of it, where a
    part is `enough`."""
    core = gives_way(chamber)
    core = worst(numpy.where((core > 0) & ~filled, LOCKED, core))
    if core >= enough or (outside := worst(gives_way(filled))) <= core:
        return core
    return max(core, min(outside, worst(across(filled))))


def in_halves(voxels):
    """The same of halves that are glued, for planes of 13 directions."""
    best = LOCKED
    for normal in itertools.product((1, 0, -1), repeat=3):
        if normal <= (0, 0, 0):
            continue
        for axes in frames(numpy.array(normal, float)):
            filled, chamber = voxels.along(axes)
            layers = numpy.flatnonzero(filled.any(axis=(1, 2)))
            cuts = set(numpy.linspace(layers[0], layers[-1] + 1, CUTS + 2).astype(int)[1:-1])
            inner = numpy.flatnonzero(chamber.any(axis=(1, 2)))
            cuts |= {inner[0], inner[-1] + 1} if len(inner) else set()
            for cut in cuts:
                upper, lower = (filled[cut:], chamber[cut:]), (filled[:cut][::-1], chamber[:cut][::-1])
                if (needed := half(*upper, best)) < best:
                    best = min(best, max(needed, half(*lower, best)))
            if best <= PEEL:
                return best
    return best


def pockets(folder):
    """Volumes of the closed chambers of a body from two files: no core can be held in them."""
    import trimesh
    bottom = trimesh.load(folder / "skin.stl").bounds[0][2]
    parts = trimesh.load(folder / "cavity.stl").split(only_watertight=True)
    closed = [part for part in parts if part.bounds[0][2] > bottom]
    return sorted(float(part.volume) for part in closed if part.volume > POCKET)


def cannot_be_cast(folder):
    """Whether no mold makes the body, and why."""
    folder = pathlib.Path(folder)
    step, skin = folder / "model.step", folder / "skin.stl"
    if skin.exists() and (closed := pockets(folder)):
        return True, f"{len(closed)} chambers are closed, the largest has {closed[-1]:.1f} mm³"
    voxels = of_step(step) if step.exists() else of_stl(folder) if skin.exists() else of_model(folder / "model.toml")
    whole = as_a_whole(voxels) if voxels.opens_below or not voxels.chamber.any() else LOCKED
    if whole <= PEEL:
        return False, f"in one piece silicone gives way by {whole:.2f} of its width, {PEEL} is possible"
    halves = in_halves(voxels)
    needs = [f"{needed:.2f}" if needed < LOCKED else "more than all" for needed in (whole, halves)]
    said = "silicone must give way by {} of its width in one piece and by {} in halves".format(*needs)
    return halves > PEEL, f"{said}, {PEEL} is possible"


if __name__ == "__main__":
    for name in sys.argv[1:]:
        print(name, json.loads((pathlib.Path(name) / "facts.json").read_text())["kind"], *cannot_be_cast(name))
