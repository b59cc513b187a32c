"""CAD lofts: sections that turn, taper and change their width along an upright axis, as STEP files of OpenCASCADE.

The chamber is a loft of the same sections, set in. Where lofts bend, the wall is not what they were set in by: it is
measured on the triangles of both.
"""

import math

import gmsh
import manifold3d
import numpy

from bodies import LEAST_INLET, LEAST_WALL, apart
from fillets import finish, holes, redrawn

# Longest edge of the triangles on which walls are measured, in walls.
FINE = 0.7


def body(random):
    """A random loft."""
    size = 15 * 10 ** random.random()
    wall = max(LEAST_WALL, size * random.uniform(0.06, 0.1))
    return redrawn(random.choice(KINDS), random, size, wall)


def loft(occ, shape, levels):
    """The solid through sections (height, half width, turn); smooth through more than two."""
    wires = [occ.addCurveLoop(shape(occ, *level)) for level in levels]
    (_, solid), = [part for part in occ.addThruSections(wires, makeSolid=True) if part[0] == 3]
    return solid


def polygon(corners):
    """Sections with so many corners, of an inscribed circle of the half width."""
    def shape(occ, height, half, turn):
        around = half / math.cos(math.pi / corners)
        turns = [turn + math.tau * (k + 0.5) / corners for k in range(corners)]
        points = [occ.addPoint(around * math.cos(t), around * math.sin(t), height) for t in turns]
        return [occ.addLine(a, b) for a, b in zip(points, points[1:] + points[:1])]
    return shape


def oval(flat):
    """Ellipses whose shorter radius is the half width and whose longer one `flat` times that."""
    def shape(occ, height, half, turn):
        axis = [math.cos(turn), math.sin(turn), 0]
        return [occ.addEllipse(0, 0, height, flat * half, half, zAxis=[0, 0, 1], xAxis=axis)]
    return shape


def meshed(occ, solid, edge):
    """A solid as a manifold of triangles, meshed alone."""
    occ.synchronize()
    gmsh.option.setNumber("Mesh.MeshSizeMax", edge)
    gmsh.model.mesh.generate(2)
    tags, places, _ = gmsh.model.mesh.getNodes()
    order = numpy.argsort(tags)
    corners = numpy.searchsorted(tags[order], gmsh.model.mesh.getElementsByType(2)[1])
    mesh = manifold3d.Mesh(places.reshape(-1, 3)[order].astype("f4"), corners.reshape(-1, 3).astype("u4"))
    gmsh.model.mesh.clear()
    found = manifold3d.Manifold(mesh)
    if found.is_empty():
        raise ValueError("its triangles do not close")
    return found


def made(kind, random, occ, shape, levels, wall):
    """The body of sections; the chamber begins and ends a wall within it."""
    low, high = levels[0][0], levels[-1][0]
    inward = wall * 1.15
    heights = numpy.array([level[0] for level in levels])
    inner = []
    for share in numpy.linspace(0, 1, len(levels)):
        at = low + wall + share * (high - low - 2 * wall)
        half, turn = (numpy.interp(at, heights, [level[k] for level in levels]) for k in (1, 2))
        inner.append((at, half - inward, turn))
    chamber = loft(occ, shape, inner)
    walls = meshed(occ, chamber, FINE * wall)
    occ.remove([(3, chamber)], recursive=True)
    outside = loft(occ, shape, levels)
    skin = meshed(occ, outside, FINE * wall)
    least = apart(skin, walls)
    if least < 0.6 * wall:
        raise ValueError(f"the wall is {least:.2f} mm")
    chamber = loft(occ, shape, inner)
    hole = holes(random, inner[0][1])
    inlet = 0, 0, hole, wall + (high - low) / 4
    box = skin.bounding_box()
    size = max(b - a for a, b in zip(box[:3], box[3:]))
    return finish(kind, occ, outside, [chamber], [inlet], size=size, wall=least)


def twisted(random, occ, size, wall):
    """A prism that turns and tapers."""
    half = max(size * random.uniform(0.2, 0.4), 1.3 * wall + 2 * LEAST_INLET)
    turn, tip = math.radians(random.uniform(10, 70)), random.uniform(0.8, 1.1)
    levels = [(size * s, half * (1 + (tip - 1) * s), turn * s) for s in numpy.linspace(0, 1, 5)]
    return made("twisted", random, occ, polygon(random.randint(3, 6)), levels, wall)


def ovals(random, occ, size, wall):
    """An ellipse that turns and tapers: two smooth faces and a seam."""
    half = max(size * random.uniform(0.15, 0.3), 1.3 * wall + 2 * LEAST_INLET)
    turn = math.radians(random.uniform(0, 60))
    levels = [(size * s, half * (1 - 0.2 * s), turn * s) for s in numpy.linspace(0, 1, 4)]
    return made("ovals", random, occ, oval(random.uniform(1.1, 1.8)), levels, wall)


def waist(random, occ, size, wall):
    """A bottle: wide, narrow and wide again, turning a little."""
    half = max(size * random.uniform(0.25, 0.4), 1.6 * wall + 3 * LEAST_INLET)
    narrow = random.uniform(0.75, 0.95)
    turn = math.radians(random.uniform(0, 30))
    shares = (1, (1 + narrow) / 2, narrow, (1 + narrow) / 2, 0.95)
    levels = [(size * k / 4, half * share, turn * k / 4) for k, share in enumerate(shares)]
    shape = random.choice((oval(1.2), polygon(random.randint(4, 6))))
    return made("waist", random, occ, shape, levels, wall)


KINDS = (twisted, ovals, waist)
