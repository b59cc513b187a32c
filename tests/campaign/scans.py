"""Scanned bodies: a skin of many small facets with noise, holes and facets the wrong way around, as STL, and a clean
chamber. Only the seat is flat, where the body stood while it was scanned.
"""

import math

import manifold3d
import numpy

from bodies import LEAST_INLET, LEAST_WALL, Body, apart, triangles

# The noise of a scanner over the wall, at most.
NOISE = 0.06


def body(random):
    """A random scan."""
    size = 15 * 5 ** random.random()
    wall = max(LEAST_WALL, size * random.uniform(0.06, 0.1))
    return random.choice(KINDS)(random, size, wall)


def waves(random, size):
    """Bumps as a hand makes them: three waves, with slopes of at most 0.15."""
    found = []
    for _ in range(3):
        x, y, z = (random.gauss(0, 1) for _ in range(3))
        turn = math.tau / (size * random.uniform(0.5, 1.0))
        scale = turn / math.hypot(x, y, z)
        found.append((scale * x, scale * y, scale * z, 0.05 / turn, random.uniform(0, math.tau)))
    return lambda x, y, z: sum(high * math.sin(a * x + b * y + c * z + phase) for a, b, c, high, phase in found)


def scanned(kind, random, distance, size, wall, room):
    """The skin of a signed distance, positive inside, with its bumps, noise and damage."""
    bumps = waves(random, size)
    depth = lambda less: lambda x, y, z: distance(x, y, z) + bumps(x, y, z) - less
    edge = size / random.uniform(35, 55)
    bounds = [-0.6 * size, -0.6 * size, -2 * edge, 0.6 * size, 0.6 * size, 1.1 * size]
    clean = manifold3d.Manifold.level_set(depth(0), bounds, edge).trim_by_plane((0, 0, 1), 0)
    chamber = manifold3d.Manifold.level_set(depth(1.2 * wall), bounds, 1.5 * edge).trim_by_plane((0, 0, 1), wall)
    least = apart(clean, chamber)
    radius = max(LEAST_INLET, room * random.uniform(0.3, 0.6))
    hole = manifold3d.Manifold.cylinder(2 * wall + 4, radius, circular_segments=48).translate((0, 0, -4))
    noise = NOISE * wall * random.random()
    skin = damaged(random, noisy(random, clean, noise), random.choice((0, 0, 1, 3)), random.choice((0, 0, 5)))
    files = {"skin": skin, "cavity": triangles(chamber + hole)}
    return Body(kind, files, size=size, wall=least - 3 * noise, inlet=radius)


def noisy(random, solid, noise):
    """Triangles whose corners above the seat moved along their normals."""
    mesh = solid.to_mesh()
    places = numpy.asarray(mesh.vert_properties, float)[:, :3]
    corners = places[mesh.tri_verts]
    normals = numpy.zeros_like(places)
    facets = numpy.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    for k in range(3):
        numpy.add.at(normals, mesh.tri_verts[:, k], facets)
    normals /= numpy.maximum(numpy.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    moved = numpy.random.default_rng(random.randrange(2**32)).normal(0, noise, len(places)).clip(-3 * noise, 3 * noise)
    moved[places[:, 2] < 1] = 0
    return (places + moved[:, None] * normals)[mesh.tri_verts]


def damaged(random, corners, missing, turned):
    """Without so many of the triangles above the seat, and with others turned around."""
    above = [int(k) for k in numpy.flatnonzero(corners[:, :, 2].min(axis=1) > 1)]
    chosen = random.sample(above, missing + turned)
    corners[chosen[missing:]] = corners[chosen[missing:], ::-1]
    return numpy.delete(corners, chosen[:missing], axis=0)


def stone(random, size, wall):
    """An ellipsoid that stands on its flat side."""
    a, b, c = (size / 2 * part for part in (1, random.uniform(0.75, 1), random.uniform(0.75, 1)))
    height = c * random.uniform(0.4, 0.7)

    def distance(x, y, z):
        return min(a, b, c) * (1 - math.hypot(x / a, y / b, (z - height) / c))

    return scanned("stone", random, distance, size, wall, 0.5 * min(a, b, c) - wall / 2)


def digit(random, size, wall):
    """A capsule that leans."""
    radius = max(size * random.uniform(0.18, 0.28), 1.3 * wall + 2 * LEAST_INLET)
    a, b, c = size * random.uniform(-0.2, 0.2), size * random.uniform(-0.2, 0.2), size - radius
    square = a * a + b * b + c * c

    def distance(x, y, z):
        along = min(max((x * a + y * b + z * c) / square, -1), 1)
        return radius - math.hypot(x - along * a, y - along * b, z - along * c)

    return scanned("digit", random, distance, size, wall, radius - 1.3 * wall)


def slab(random, size, wall):
    """A box with round edges."""
    half = [size / 2 * part for part in (1, random.uniform(0.5, 1), random.uniform(0.8, 1.2))]
    rounding = 0.4 * min(half)

    def distance(x, y, z):
        far = [abs(c) - h + rounding for c, h in zip((x, y, z), half)]
        return rounding - math.hypot(*(max(f, 0) for f in far)) - min(max(far), 0)

    return scanned("slab", random, distance, size, wall, min(half[:2]) - 1.3 * wall)


KINDS = (stone, digit, slab)
