"""Shells: bodies whose chambers are their outside, offset inward by the wall."""

import math

import numpy

from bodies import LEAST_INLET, LEAST_WALL, Body, between
from implicit import DEEP, Model, block, capsule, cylinder, ellipsoid, sphere

# Walls between surfaces that are approximate distances are this part of what they are offset by.
TAPERED = 0.98


def body(random):
    """A random shell."""
    size = 10 * 20 ** random.random()
    wall = max(LEAST_WALL, size * random.uniform(0.05, 0.09))
    return random.choice(KINDS)(random, size, wall)


def bore(random, model, room, seat, wall, top):
    """A hole up to a height, of a radius that leaves a wall within the seat."""
    radius = min(max(LEAST_INLET, room * random.uniform(0.3, 0.6)), seat - wall)
    model.add("cavity", cylinder((0, 0, -DEEP), (0, 0, top), radius))
    return radius


def round_shell(random, size, wall, closed=False):
    """An ellipsoid, cut by the ground, with an ellipsoid in it. The wall is the least distance of planes that touch
    both, in all directions."""
    radii = size / 2 * numpy.array([1, random.uniform(0.6, 1), random.uniform(0.6, 1)])
    radii = numpy.maximum(radii, wall + LEAST_INLET + 1)
    directions = numpy.random.default_rng(1).normal(size=(4000, 3))
    directions /= numpy.linalg.norm(directions, axis=1)[:, None]

    def least(offset):
        support = [numpy.linalg.norm(r * directions, axis=1) for r in (radii, radii - offset)]
        return (support[0] - support[1]).min()

    offset = wall * wall / least(wall)
    inner, height = radii - offset, radii[2] * random.uniform(0.2, 0.6)
    model = Model(wall, size)
    model.add("solid", ellipsoid((0, 0, height), radii))
    model.add("cavity", ellipsoid((0, 0, height), inner))
    model.cavity_above(wall)
    seat = radii[:2].min() * math.sqrt(1 - (height / radii[2]) ** 2)
    # the inlet ends in the chamber, whose floor may be above the middle
    inlet = None if closed else bore(random, model, inner[:2].min(), seat, wall, max(height, 2 * wall))
    model.chamber("cavity")
    return Body("round", model, size=2 * radii.max(), wall=0.95 * wall, inlet=inlet)


def ball(random, size, wall):
    """A ball within a ball, cut by the ground."""
    radius = max(size / 2, wall + 2 * LEAST_INLET)
    height = radius * random.uniform(0.2, 0.7)
    model = Model(wall, size)
    model.add("solid", sphere((0, 0, height), radius))
    model.add("cavity", sphere((0, 0, height), radius - wall))
    model.cavity_above(wall)
    seat = math.sqrt(radius**2 - height**2)
    inlet = bore(random, model, radius - wall, seat, wall, height)
    model.chamber("cavity")
    return Body("ball", model, size=2 * radius, wall=wall, inlet=inlet)


def box(random, size, wall, model=None):
    """A rounded box on the ground with a rounded box in it: its size and rounding, and the size of the chamber."""
    least = 2 * wall + 4 * LEAST_INLET
    x, y, z = (max(size * part, least) for part in (1, random.uniform(0.4, 1), random.uniform(0.4, 1)))
    rounding = random.uniform(0.1, 0.9) * min(x, y, z) / 2
    deep = z + rounding + wall
    outer, middle = (x, y, 2 * deep), (0, 0, z - deep)
    model.add("solid", block(middle, outer, rounding))
    inner = [length - 2 * wall for length in outer]
    model.add("cavity", block(middle, inner, max(rounding - wall, 0)))
    model.cavity_above(wall)
    return (x, y, z), inner[:2] + [z - 2 * wall]


def rounded(random, size, wall, closed=False):
    """A rounded box within a rounded box."""
    model = Model(wall, size)
    outer, inner = box(random, size, wall, model)
    inlet = None if closed else bore(random, model, min(inner[:2]) / 2, min(outer[:2]) / 2, wall, outer[2] / 2)
    model.chamber("cavity")
    return Body("rounded", model, size=max(outer), wall=wall, inlet=inlet)


def closed(random, size, wall):
    """A chamber that nothing leads to; its halves are convex, so that glued halves can be cast."""
    made = random.choice((round_shell, rounded))(random, size, wall, closed=True)
    made.kind = "closed"
    return made


def ribbed(random, size, wall):
    """A rounded box whose chamber is parted by ribs that end above its floor."""
    size = max(size, 25)
    model = Model(wall, size)
    (x, y, z), inner = box(random, size, wall, model)
    ribs = random.choice((1, 2, 3))
    while ribs > 1 and inner[0] < (ribs + 1) * (4 * LEAST_INLET) + ribs * 1.3 * wall:
        ribs -= 1
    thick = wall * random.uniform(1.05, 1.3)
    passage = max(2.5, inner[2] * random.uniform(0.25, 0.5))
    room = (inner[0] - ribs * thick) / (ribs + 1)
    for rib in range(ribs):
        at = -inner[0] / 2 + (rib + 1) * room + (rib + 0.5) * thick
        model.add("cavity", block((at, 0, wall + passage + DEEP), (thick, 2 * DEEP, 2 * DEEP)), op=' = "difference"')
    # below a rib or between two, the hole ends in the passage
    radius = min(max(LEAST_INLET, random.uniform(0.3, 0.6) * room / 2), min(x, y) / 2 - wall)
    model.add("cavity", cylinder((0, 0, -DEEP), (0, 0, wall + 0.5 * passage), radius))
    model.chamber("cavity")
    return Body("ribbed", model, size=max(x, y, z), wall=wall, inlet=radius, gap=min(passage, room))


def chain(random, size, wall):
    """Capsules in a row that winds in an upright plane; parts that do not follow each other keep their distance."""
    radius = max(size * random.uniform(0.1, 0.16), wall + LEAST_INLET + 0.5)
    gap = max(3.0, 0.5 * radius)
    while True:
        count, heading, radii = random.randint(2, 4), math.pi / 2, [radius]
        points = [numpy.array([0.0, 0.0, -radius]), numpy.array([0.0, 0.0, radius * random.uniform(1.2, 2)])]
        for _ in range(count):
            heading = min(max(heading + random.uniform(-0.9, 0.9), 0.1), math.pi - 0.1)
            step = max(1.5 * radius, size / count * random.uniform(0.6, 1))
            points.append(points[-1] + step * numpy.array([math.cos(heading), 0, math.sin(heading)]))
        radii = [radius, radius] + [radius * (1 - 0.06 * k) for k in range(1, count + 1)]
        radii = [max(r, wall + LEAST_INLET) for r in radii]
        segments = list(zip(points, points[1:]))
        apart = min((between(a, b) for i, a in enumerate(segments) for b in segments[i + 2:]), default=math.inf)
        low = min(p[2] for p in points[2:]) - radius
        if apart > 2 * radius + gap and low > gap:
            break
        size *= 1.0005  # a short row has no room to wind
    turn = random.choice((0.0, random.uniform(0, math.pi)))
    turned = [numpy.array([p[0] * math.cos(turn), p[0] * math.sin(turn), p[2]]) for p in points]
    model = Model(wall, size)
    for where, less in (("solid", 0.0), ("cavity", wall)):
        for k, (start, end) in enumerate(zip(turned, turned[1:])):
            model.add(where, capsule(start, end, (radii[k] - less, radii[k + 1] - less)))
    model.chamber("cavity")
    extent = numpy.ptp(numpy.array(points), axis=0).max() + 2 * radius
    return Body("chain", model, size=extent, wall=TAPERED * wall, inlet=radius - wall, gap=gap)


def double(random, size, wall):
    """A box-shaped chamber in another one that surrounds it, each with its inlet."""
    around = max(3.6, size * random.uniform(0.1, 0.15))
    a, b = (max(2.5, size / 2 * random.uniform(0.3, 0.6) - around) for _ in range(2))
    height = max(2 * wall + 4, size * random.uniform(0.4, 0.8))
    model = Model(wall, 2 * (a + around))
    room = height - 2 * wall

    def upright(grown, low, high):
        return block((0, 0, (low + high) / 2), (2 * (a + grown), 2 * (b + grown), high - low))

    model.add("solid", upright(2 * wall + around, -height, height))
    model.add("cavity", upright(wall + around, wall, wall + room))
    model.add("cavity", upright(wall, -DEEP, DEEP), op=' = "difference"')
    model.add("cavity", upright(0, wall, wall + room))
    inlets = 0.45 * around, min(a, b) * random.uniform(0.6, 0.8)
    for x, radius in zip((a + wall + around / 2, 0), inlets):
        model.add("cavity", cylinder((x, 0, -DEEP), (x, 0, 1.5 * wall), radius))
    model.chamber("inner", (a + wall / 2, b + wall / 2))
    model.chamber("outer")
    extent = 2 * (max(a, b) + 2 * wall + around)
    return Body("double", model, ("inner", "outer"), size=max(extent, height), wall=wall, inlet=min(inlets))


def ridged(random, size, wall):
    """A rounded box with raised bands around it, which make its wall thicker only."""
    size = max(size, 20)
    model = Model(wall, size)
    (x, y, z), inner = box(random, size, wall, model)
    for _ in range(random.choice((1, 2))):
        height = max(1.0, 0.03 * size) * random.uniform(0.6, 1)
        slab = block((x * random.uniform(-0.3, 0.3), 0, 0), (max(3, 0.1 * size), 2 * DEEP, 2 * DEEP))
        model.add("solid", slab, op=f".emboss = {{ height = {height:.4f}, width = {2 * height:.4f} }}")
    inlet = bore(random, model, min(inner[:2]) / 2, min(x, y) / 2, wall, z / 2)
    model.chamber("cavity")
    return Body("ridged", model, size=max(x, y, z) + 2 * height, wall=wall, inlet=inlet)


def coil(random, size, wall):
    """A closed chamber that winds twice around an axis: no core leaves it, whole or in halves."""
    size = max(size, 40)
    thin = size * random.uniform(0.05, 0.07)
    around, pitch = size / 2 - wall - thin, 2 * thin + 1.5 * wall
    height = 2 * pitch + 2 * (thin + wall)
    model = Model(wall, size)
    model.add("solid", cylinder((0, 0, -1), (0, 0, height), size / 2))
    at = [
        (around * math.cos(turn), around * math.sin(turn), wall + thin + pitch * turn / math.tau)
        for turn in numpy.linspace(0, 2 * math.tau, 33)
    ]
    for start, end in zip(at, at[1:]):
        model.add("cavity", capsule(start, end, (thin, thin)))
    model.chamber("cavity")
    return Body("coil", model, size=size, wall=0.9 * wall, inlet=None, castable=False)


# Each as often as it stands here.
KINDS = 2 * (round_shell, ball, rounded, chain, double, ridged, ribbed) + (closed, coil)
