"""CAD with fillets: solids of OpenCASCADE, by gmsh, as STEP files whose faces have the names of their tags.

Outer edges are rounded by at most the wall or the rounding of the chamber plus the wall, so that the wall stays.
"""

import math
import os
import re
import sys
import tempfile

import gmsh

from bodies import LEAST_INLET, LEAST_WALL, Body

# No radius of a fillet is less [mm].
LEAST_FILLET = 0.3


def body(random):
    """A random body."""
    size = 10 * 20 ** random.random()
    wall = max(LEAST_WALL, size * random.uniform(0.06, 0.1))
    return redrawn(random.choice(KINDS), random, size, wall)


def redrawn(kind, random, size, wall):
    """A body of that kind; its numbers are drawn again where OpenCASCADE makes no solid with them."""
    for _ in range(20):
        gmsh.initialize()
        gmsh.option.setNumber("General.Terminal", 0)
        try:
            return kind(random, gmsh.model.occ, size, wall)
        except Exception as error:  # gmsh raises plain exceptions
            said = str(error)
        finally:
            gmsh.finalize()
    raise RuntimeError(f"OpenCASCADE makes no {kind.__name__}: {said}")


def edges(occ, solid, wanted):
    """Curves of a solid for whose bounding box `wanted` holds."""
    occ.synchronize()
    curves = {abs(tag) for _, tag in gmsh.model.getBoundary([(3, solid)], combined=False, recursive=False)
              for _, tag in gmsh.model.getBoundary([(2, abs(tag))], oriented=False)}
    boxes = {tag: gmsh.model.getBoundingBox(1, tag) for tag in sorted(curves)}
    return [tag for tag, box in boxes.items() if wanted(box) and longest(box) > 1e-3]


def longest(box):
    return max(high - low for low, high in zip(box[:3], box[3:]))


def rounded(occ, solid, radius, wanted=lambda box: True):
    """The solid with fillets on those curves."""
    chosen = edges(occ, solid, wanted)
    if not chosen:
        return solid
    (_, made), = occ.fillet([solid], chosen, [radius])
    return made


def off_the_ground(box):
    return box[5] > 1e-3


def holes(random, room):
    """The radius of an inlet for a chamber of so much room around its axis."""
    return max(LEAST_INLET, min(room * random.uniform(0.35, 0.65), room - 0.2))


def fused(occ, parts):
    made, _ = occ.fuse([(3, parts[0])], [(3, part) for part in parts[1:]])
    (_, solid), = made
    return solid


def finish(kind, occ, outside, chambers, inlets, **facts):
    """Cuts chambers, each with a hole (x, y, radius, top), out of the outside, and names the faces."""
    airs = []
    for chamber, (x, y, radius, top) in zip(chambers, inlets):
        airs.append(fused(occ, [chamber, occ.addCylinder(x, y, -1, 0, 0, top + 1, radius)]))
    made, _ = occ.cut([(3, outside)], [(3, air) for air in airs], removeObject=False)
    (_, solid), = made
    occ.synchronize()
    names = ["cavity"] if len(airs) == 1 else [f"ch{k + 1}" for k in range(len(airs))]
    near = 0.3 * facts["wall"]

    def name(face, chamber_of):
        if gmsh.model.getBoundingBox(2, face)[5] < 1e-4:
            return "seat"
        # of a face with holes the middle of its parameters may not be on it; its edges are
        edges = gmsh.model.getBoundary([(2, face)], oriented=False)
        inside = [point for point in map(middle, edges or [(2, face)]) if is_within(point)]
        return chamber_of(inside[0]) if inside else "skin"

    def is_within(point):
        """Deeper in the outside than a part of the wall."""
        around = [[c + s * near * (k == i) for k, c in enumerate(point)] for i in range(3) for s in (-1, 1)]
        return all(gmsh.model.isInside(3, outside, p) for p in around)

    def chamber_of(point):
        return min(zip(names, inlets), key=lambda pair: math.hypot(point[0] - pair[1][0], point[1] - pair[1][1]))[0]

    faces = [tag for _, tag in gmsh.model.getBoundary([(3, solid)], oriented=False)]
    named = {center(face): name(face, chamber_of) for face in faces}
    occ.remove([(3, outside)], recursive=True)
    occ.synchronize()
    text = step(named)
    inlet = min(radius for *_, radius, _ in inlets)
    return Body(kind, text, tuple(names), inlet=inlet, **facts)


def middle(entity):
    """The point of a curve or surface in the middle of its parameters."""
    low, high = gmsh.model.getParametrizationBounds(*entity)
    return gmsh.model.getValue(*entity, [(a + b) / 2 for a, b in zip(low, high)])


def center(face):
    box = gmsh.model.getBoundingBox(2, face)
    return tuple(round(value, 3) for value in (*box, gmsh.model.occ.getMass(2, face)))


def step(named):
    """The solid as a STEP file, with a name for each face."""
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "body.step")
        silently(gmsh.write, path)
        gmsh.clear()
        silently(gmsh.open, path)  # the order of faces is that of the file
        names = [nearest(named, center(tag)) for _, tag in gmsh.model.getEntities(2)]
        text = open(path).read()
    shells = re.findall(r"CLOSED_SHELL\s*\('[^']*',\s*\(([^)]*)\)", text)
    faces = [face for shell in shells for face in re.findall(r"#(\d+)", shell)]
    assert len(faces) == len(names), "as many faces as gmsh finds"
    for face, name in zip(faces, names):
        text = re.sub(rf"(#{face} = ADVANCED_FACE\()''", rf"\1'{name}'", text)
    return text.encode()


def silently(call, path):
    """OpenCASCADE writes to standard output whatever its options are."""
    sys.stdout.flush()
    kept, nothing = os.dup(1), os.open(os.devnull, os.O_WRONLY)
    os.dup2(nothing, 1)
    try:
        call(path)
    finally:
        os.dup2(kept, 1)
        os.close(kept)
        os.close(nothing)


def nearest(named, wanted):
    key = min(named, key=lambda key: sum(abs(a - b) for a, b in zip(key, wanted)))
    assert max(abs(a - b) for a, b in zip(key, wanted)) < 0.05 * max(1, *map(abs, wanted)), "a face was lost"
    return named[key]


def radii(random, wall, least):
    """Fillets of a chamber and of the outside around it, which keep the wall."""
    inner = random.uniform(LEAST_FILLET, max(LEAST_FILLET, 0.3 * least))
    return inner, random.uniform(0.3, 1) * min(inner + wall, 0.3 * least + wall)


def block(random, occ, size, wall):
    """A box with a box in it, all edges rounded but those of the seat."""
    least = 2 * wall + 4 * LEAST_INLET
    x, y, z = (max(size * part, least) for part in (1, random.uniform(0.4, 1), random.uniform(0.4, 1)))
    inner, outer = radii(random, wall, min(x, y, z) - 2 * wall)
    outside = rounded(occ, occ.addBox(-x / 2, -y / 2, 0, x, y, z), outer, off_the_ground)
    room = [length - 2 * wall for length in (x, y, z)]
    chamber = rounded(occ, occ.addBox(wall - x / 2, wall - y / 2, wall, *room), inner)
    hole = holes(random, min(x, y) / 2 - wall - inner)
    return finish("block", occ, outside, [chamber], [(0, 0, hole, wall + z / 3)], size=max(x, y, z), wall=wall)


def steps(random, occ, size, wall):
    """A block with a lower one beside it and a chamber in both, inner and outer edges rounded."""
    size = max(size, 20)
    y, high = size * random.uniform(0.4, 0.8), size * random.uniform(0.5, 0.9)
    y, high = max(y, 2 * wall + 6), max(high, 4 * wall + 8)
    low, long = high * random.uniform(0.45, 0.6), size * random.uniform(0.45, 0.6)
    inner, outer = radii(random, wall, min(low, long, y) - 2 * wall)

    def both(less):
        lower = occ.addBox(less, less - y / 2, less, size - 2 * less, y - 2 * less, low - 2 * less)
        upper = occ.addBox(less, less - y / 2, less, long - 2 * less, y - 2 * less, high - 2 * less)
        return fused(occ, [lower, upper])

    # the chamber's edges stay sharp where the outside is rounded by no more than the wall
    outside = rounded(occ, both(0), min(outer, wall), off_the_ground)
    hole = holes(random, min(long, y) / 2 - wall)
    inlet = long / 2, 0, hole, wall + low / 3
    return finish("steps", occ, outside, [both(wall)], [inlet], size=max(size, high), wall=wall)


def turned(random, occ, size, wall):
    """Discs on each other, and a chamber of discs; all edges rounded."""
    size = max(size, 20)
    count = random.randint(1, 3)
    wide = max(size * random.uniform(0.3, 0.5), wall + 2 * LEAST_INLET + 2)
    narrow = max(wide * random.uniform(0.65, 0.85), wall + 2 * LEAST_INLET)
    tall = max(size / (2 * count + 1), 2 * wall + 2.5)
    high = (2 * count + 1) * tall

    def pile(less):
        stem = occ.addCylinder(0, 0, less, 0, 0, high - 2 * less, narrow - less)
        floors = [(2 * k + 1) * tall + less for k in range(count)]
        return fused(occ, [stem] + [occ.addCylinder(0, 0, z, 0, 0, tall - 2 * less, wide - less) for z in floors])

    radius = random.uniform(0.4, 0.95) * min(wall, (wide - narrow) / 2, tall / 3)
    outside = rounded(occ, pile(0), radius, off_the_ground)
    inner = min(0.4 * (tall - 2 * wall), 0.4 * (wide - narrow), radius)
    chamber = rounded(occ, pile(wall), max(inner, 0.2))
    inlet = 0, 0, holes(random, narrow - wall - radius), wall + tall / 2
    return finish("turned", occ, outside, [chamber], [inlet], size=max(high, 2 * wide), wall=wall)


def profile(random, occ, size, wall):
    """An upright L, T or plus of boxes with the same less the wall in it, upright and upper edges rounded."""
    size = max(size, 20)
    thick, high = max(size * random.uniform(0.3, 0.4), 2 * wall + 5), max(size * random.uniform(0.4, 1), 2 * wall + 4)
    arms = random.choice(((1, 0, 1, 0), (1, 1, 1, 0), (1, 1, 1, 1)))
    long = max(size / 2, thick)

    def cross(less):
        half = thick / 2 - less
        reach = [long - less if arm else half for arm in arms]
        along = occ.addBox(-reach[1], -half, less, reach[0] + reach[1], 2 * half, high - 2 * less)
        across = occ.addBox(-half, -reach[3], less, 2 * half, reach[2] + reach[3], high - 2 * less)
        return fused(occ, [along, across])

    outside = rounded(occ, cross(0), random.uniform(0.3, 1) * wall, off_the_ground)
    hole = holes(random, thick / 2 - wall)
    inlet = 0, 0, hole, wall + high / 3
    return finish("profile", occ, outside, [cross(wall)], [inlet], size=max(2 * long, high), wall=wall)


def twin(random, occ, size, wall):
    """A block with two chambers beside each other, all edges rounded."""
    size = max(size, 24)
    y, z = (max(size * random.uniform(0.35, 0.8), 2 * wall + 6) for _ in range(2))
    room = max((size - 3 * wall) / 2, 4 * LEAST_INLET)
    x = 2 * room + 3 * wall
    inner, outer = radii(random, wall, min(room, y - 2 * wall, z - 2 * wall))
    outside = rounded(occ, occ.addBox(-x / 2, -y / 2, 0, x, y, z), outer, off_the_ground)
    chambers, inlets = [], []
    hole = holes(random, min(room, y - 2 * wall) / 2 - inner)
    for side in (-1, 1):
        at = side * (room + wall) / 2
        box = occ.addBox(at - room / 2, wall - y / 2, wall, room, y - 2 * wall, z - 2 * wall)
        chambers.append(rounded(occ, box, inner))
        inlets.append((at, 0, hole, wall + z / 3))
    return finish("twin", occ, outside, chambers, inlets, size=max(x, y, z), wall=wall)


def finned(random, occ, size, wall):
    """A block with fins on its upper side, rounded at their feet and tips."""
    size = max(size, 20)
    y, z = (max(size * part, 2 * wall + 6) for part in (random.uniform(0.4, 0.8), random.uniform(0.35, 0.6)))
    x = size
    count = random.randint(1, 3)
    thick, tall = max(2.5, 0.08 * size), size * random.uniform(0.1, 0.15)
    pitch = x / (count + 1)
    feet = [-x / 2 + (k + 1) * pitch - thick / 2 for k in range(count)]
    fins = [occ.addBox(at, -y / 2, z / 2, thick, y, z / 2 + tall) for at in feet]
    outside = fused(occ, [occ.addBox(-x / 2, -y / 2, 0, x, y, z), *fins])
    radius = random.uniform(0.4, 0.9) * min(wall, thick / 2.2, tall / 2.2, (pitch - thick) / 3)
    outside = rounded(occ, outside, radius, off_the_ground)
    chamber = occ.addBox(wall - x / 2, wall - y / 2, wall, x - 2 * wall, y - 2 * wall, z - 2 * wall)
    chamber = rounded(occ, chamber, random.uniform(LEAST_FILLET, 0.3 * (min(x, y, z) - 2 * wall)))
    hole = holes(random, 0.65 * (min(x, y) / 2 - wall))
    facts = {"size": max(x, y, z + tall), "wall": wall, "gap": pitch - thick}
    return finish("finned", occ, outside, [chamber], [(0, 0, hole, wall + z / 3)], **facts)


KINDS = (block, steps, turned, profile, twin, finned)
