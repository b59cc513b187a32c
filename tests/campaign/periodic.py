"""Bodies with triply periodic surfaces (gyroid, Schwarz P and D), as STL files of marched cells: the skin and the
chamber. Their facets are what marching gives: short edges and slivers everywhere.
"""

import math

import manifold3d

from bodies import LEAST_INLET, LEAST_WALL, Body, apart, triangles


def body(random):
    """A random body."""
    size = 24 * 3 ** random.random()
    wall = max(LEAST_WALL, size * random.uniform(0.06, 0.09))
    return random.choice(KINDS)(random, size, wall)


# Each has slopes of at most about 1 and values from about -1 to 1.
def gyroid(x, y, z):
    return (math.sin(x) * math.cos(y) + math.sin(y) * math.cos(z) + math.sin(z) * math.cos(x)) / math.sqrt(3)


def schwarz_p(x, y, z):
    return (math.cos(x) + math.cos(y) + math.cos(z)) / math.sqrt(3)


def diamond(x, y, z):
    return (math.cos(x) * math.cos(y) * math.cos(z) - math.sin(x) * math.sin(y) * math.sin(z)) / math.sqrt(2)


SURFACES = (gyroid, schwarz_p, diamond)


class Box:
    """A box on the ground."""

    def __init__(self, random, size):
        self.half = size / 2, size / 2 * random.uniform(0.6, 1)
        self.height = size * random.uniform(0.5, 0.9)

    def inside(self, x, y, z):
        """Signed distance to all sides but the ground, positive inside."""
        a, b = self.half
        return min(a - abs(x), b - abs(y), self.height - z)

    def marched(self, function, edge, grown=0.0):
        """The surface of what is positive, cut off at the ground."""
        (a, b), margin = self.half, grown + 2 * edge
        bounds = -a - margin, -b - margin, -margin, a + margin, b + margin, self.height + margin
        solid = manifold3d.Manifold.level_set(function, bounds, edge)
        return max(solid.trim_by_plane((0, 0, 1), 0).decompose(), key=lambda part: part.volume())

    def filled(self, wall):
        """The box less a wall on all sides."""
        (a, b), z = self.half, self.height
        sides = 2 * (a - wall), 2 * (b - wall), z - 2 * wall
        return manifold3d.Manifold.cube(sides).translate((wall - a, wall - b, wall))


def finish(kind, skin, chamber, size, at, radius, top, castable=True):
    """A hole leads through the ground into the chamber, of which the part that it reaches is left."""
    wall = apart(skin, chamber)
    hole = manifold3d.Manifold.cylinder(top + 4, radius, circular_segments=48).translate((*at, -4))
    reached = max((chamber + hole).decompose(), key=lambda part: part.volume())
    files = {"skin": triangles(skin), "cavity": triangles(reached)}
    return Body(kind, files, size=size, wall=wall, inlet=radius, castable=castable)


def relief(random, size, wall):
    """A box with a periodic relief on all of its sides, and a box-shaped chamber."""
    box, surface = Box(random, size), random.choice(SURFACES)
    pitch = size * random.uniform(0.25, 0.5)
    deep = pitch * random.uniform(0.03, 0.1)
    turn = math.tau / pitch
    skin = box.marched(lambda x, y, z: box.inside(x, y, z) + deep * surface(turn * x, turn * y, turn * z),
                       max(size / 50, wall / 3), deep)
    room = min(box.half) - wall - deep
    radius = max(LEAST_INLET, room * random.uniform(0.3, 0.6))
    return finish("relief", skin, box.filled(wall + deep), size, (0, 0), radius, 2 * wall + deep)


def crate(random, size, wall):
    """A box whose upper side is an egg crate, and a box-shaped chamber."""
    box = Box(random, size)
    pitch = size * random.uniform(0.2, 0.4)
    deep = pitch * random.uniform(0.08, 0.15)
    turn = math.tau / pitch
    upper = box.height - deep

    def inside(x, y, z):
        return min(box.inside(x, y, z - 2 * deep), upper + deep * math.cos(turn * x) * math.cos(turn * y) - z)

    skin = box.marched(inside, max(size / 50, wall / 3))
    chamber = box.filled(wall).trim_by_plane((0, 0, -1), -(upper - deep - wall))
    radius = max(LEAST_INLET, (min(box.half) - wall) * random.uniform(0.3, 0.6))
    return finish("crate", skin, chamber, size, (0, 0), radius, 2 * wall)


def labyrinth(random, size, wall):
    """A plain box whose chamber is one side of a periodic surface: no core leaves it."""
    box, surface = Box(random, size), random.choice(SURFACES)
    pitch = size * random.uniform(0.45, 0.7)
    turn, level = math.tau / pitch, random.uniform(0.0, 0.3)

    def inside(x, y, z):
        within = min(box.inside(x, y, z), z) - wall
        return min(within, pitch / math.tau * (surface(turn * x, turn * y, turn * z) - level))

    chamber = box.marched(inside, max(size / 50, wall / 3))
    low = min(triangles(chamber).reshape(-1, 3), key=lambda p: (round(p[2], 1), abs(p[0]) + abs(p[1])))
    skin = box.filled(0)
    top = low[2] + wall
    return finish("labyrinth", skin, chamber, size, (float(low[0]), float(low[1])), LEAST_INLET, top, castable=False)


# Each as often as it stands here.
KINDS = 2 * (relief, crate) + (labyrinth,)
