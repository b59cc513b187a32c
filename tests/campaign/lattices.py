"""Lattices of tubes: hollow struts between nodes, whose bores are one chamber."""

import itertools
import math

import numpy

from bodies import Body, between
from implicit import Model, capsule

# No wall and no radius of a bore is less [mm].
LEAST_WALL, LEAST_BORE = 1.4, 1.5
# Tubes without a common node are at least this far apart [mm].
LEAST_GAP = 3.0


def body(random):
    """A random lattice."""
    return random.choice(KINDS)(random, 40 * 5 ** random.random())


class Tubes:
    """Nodes, struts between them and legs, and the tubes that they become."""

    def __init__(self, random, pitch, blended):
        bore = max(LEAST_BORE, pitch * random.uniform(0.06, 0.1))
        self.wall = max(LEAST_WALL, bore * random.uniform(0.5, 0.9))
        self.bore, self.radius = bore, bore + self.wall
        # The function of the bores is that of the tubes plus the wall, also where they blend, and grows no faster
        # than a distance: the wall stays. Silicone between bores ends half as thick as the blend is wide.
        self.blend = max(3.0, 1.2 * self.wall) if blended else 0.0
        self.least_angle = 40 if blended else 65
        # no blend from tube to tube
        self.gap = max(LEAST_GAP, 0.6 * self.radius, 1.25 * self.blend + 1)
        self.nodes, self.struts, self.legs = [], [], []

    def floor(self, random):
        """Height of the lowest nodes."""
        return self.radius * random.uniform(1, 1.5) + self.gap

    def apart(self):
        """Whether struts without a common node keep their distance, and those with one meet at no sharp angle."""
        ends = [(self.nodes[a], self.nodes[b]) for a, b in self.struts]
        for (a, first), (b, second) in itertools.combinations(zip(self.struts, ends), 2):
            common = set(a) & set(b)
            if not common and between(first, second) < 2 * self.radius + self.gap:
                return False
            if common and angle(self.nodes, a, b, *common) < math.radians(self.least_angle):
                return False
        return True

    def connected(self, struts):
        reached = {struts[0][0]}
        for _ in struts:
            for a, b in struts:
                if {a, b} & reached:
                    reached |= {a, b}
        return reached == {node for strut in self.struts for node in strut}

    def thinned(self, random, share):
        """Leaves out struts as long as the rest hangs together."""
        for strut in random.sample(self.struts, int(share * len(self.struts))):
            rest = [other for other in self.struts if other != strut]
            if self.connected(rest):
                self.struts = rest

    def body(self, kind, random, solid=(), castable=True):
        """All tubes but those in `solid`, which are full; turned about the vertical."""
        turn = random.choice((0.0, random.uniform(0, math.pi)))
        cos, sin = math.cos(turn), math.sin(turn)
        nodes = [numpy.array([cos * x - sin * y, sin * x + cos * y, z]) for x, y, z in self.nodes]
        tubes = [(nodes[a], nodes[b], (a, b) not in solid) for a, b in self.struts]
        tubes += [(nodes[k] * (1, 1, 0) - (0, 0, self.radius), nodes[k], True) for k in self.legs]
        size = numpy.ptp(numpy.array(nodes), axis=0).max() + 2 * self.radius
        model = Model(self.wall, size)
        for start, end, _ in tubes:
            model.add("solid", capsule(start, end, [self.radius] * 2), self.blend)
        for start, end, hollow in tubes:
            if hollow:
                model.add("cavity", capsule(start, end, [self.bore] * 2), self.blend)
        model.chamber("cavity")
        facts = {"size": size, "wall": self.wall, "inlet": self.bore, "gap": self.gap}
        return Body(kind, model, **facts, castable=castable)


def angle(nodes, a, b, common):
    """Angle between two struts at their common node."""
    ways = [nodes[sum(strut) - common] - nodes[common] for strut in (a, b)]
    cosine = ways[0] @ ways[1] / numpy.prod([numpy.linalg.norm(way) for way in ways])
    return math.acos(min(max(cosine, -1), 1))


def upright(random, size, bent):
    """Rows and columns of struts in an upright plane, or in one that is bent, with nodes moved at random."""
    columns, rows = random.randint(2, 4), random.randint(1, 3)
    pitch = size / max(columns - 1, rows)
    while True:
        tubes = Tubes(random, pitch, random.random() < 0.5)
        floor, depth = tubes.floor(random), random.uniform(0.1, 0.25) * size if bent else 0.0
        place = {}
        for i, j in itertools.product(range(columns), range(rows + 1)):
            x, z = (pitch * (k + random.uniform(-0.08, 0.08)) for k in (i, j))
            place[i, j] = len(tubes.nodes)
            y = depth * math.sin(math.pi * x / max(size, pitch * (columns - 1)))
            tubes.nodes.append(numpy.array([x, y, floor + max(z, 0.0)]))
        tubes.struts = [(place[i, j], place[k]) for i, j in place for k in ((i + 1, j), (i, j + 1)) if k in place]
        tubes.thinned(random, random.choice((0, 0, 0.3)))
        feet = [place[i, 0] for i in range(columns)]
        tubes.legs = random.sample(feet, random.choice((1, 1, 2)))
        if tubes.apart():
            return tubes


def frame(random, size):
    """A flat frame on its legs."""
    return upright(random, size, bent=False).body("frame", random)


def wave(random, size):
    """The same, bent."""
    return upright(random, size, bent=True).body("wave", random)


def net(random, size):
    """A lying net, square or of triangles, on a foot."""
    slant, count = random.choice((0.0, 0.5)), random.randint(2, 3)
    pitch = size / (count - 1 + slant)
    while True:
        tubes = Tubes(random, pitch, slant > 0 or random.random() < 0.5)
        floor, place = tubes.floor(random), {}
        for i, j in itertools.product(range(count), repeat=2):
            x, y = pitch * (i + slant * (j % 2)), pitch * j * (1 - 0.27 * slant)
            place[i, j] = len(tubes.nodes)
            moved = [pitch * random.uniform(-0.06, 0.06) for _ in range(2)]
            tubes.nodes.append(numpy.array([x + moved[0], y + moved[1], floor]))
        ways = ((1, 0), (0, 1))
        pairs = [((i, j), (i + a, j + b)) for i, j in place for a, b in ways]
        if slant:
            pairs += [((i, j), (i + (1 if j % 2 else -1), j + 1)) for i, j in place]
        tubes.struts = [(place[a], place[b]) for a, b in pairs if b in place]
        tubes.thinned(random, random.choice((0, 0.25)))
        tubes.legs = [random.choice(sorted({node for strut in tubes.struts for node in strut}))]
        if tubes.apart():
            return tubes.body("net", random)


def wheel(random, size):
    """Spokes and a rim, lying on a foot below the hub."""
    count = random.randint(4, 6)
    tubes = Tubes(random, size / 2 * min(1, math.tau / count), True)
    floor = tubes.floor(random)
    tubes.nodes = [numpy.array([0.0, 0.0, floor])]
    turns = [math.tau * (k + random.uniform(-0.05, 0.05)) / count for k in range(count)]
    tubes.nodes += [numpy.array([size / 2 * math.cos(t), size / 2 * math.sin(t), floor]) for t in turns]
    tubes.struts = [(0, k + 1) for k in range(count)] + [(k + 1, (k + 1) % count + 1) for k in range(count)]
    tubes.legs = [0]
    return tubes.body("wheel", random)


def tree(random, size):
    """A stem that branches twice in an upright plane."""
    while True:
        tubes = Tubes(random, size / 3, True)
        floor = tubes.floor(random) + size * random.uniform(0.1, 0.2)
        tubes.nodes, tubes.legs, ends = [numpy.array([0.0, 0.0, floor])], [0], [(0, math.pi / 2)]
        for level in range(2):
            grown = []
            for node, heading in ends:
                for way in (-1, 1):
                    to = heading + way * random.uniform(0.5, 0.8) / (1 + 0.2 * level)
                    step = size * random.uniform(0.3, 0.4)
                    tubes.struts.append((node, len(tubes.nodes)))
                    grown.append((len(tubes.nodes), to))
                    tubes.nodes.append(tubes.nodes[node] + step * numpy.array([math.cos(to), 0, math.sin(to)]))
            ends = grown
        if tubes.apart():
            return tubes.body("tree", random)


def ties(random, size):
    """A frame with full struts across some of its openings."""
    while True:
        tubes = upright(random, size, bent=False)
        used = {node for strut in tubes.struts for node in strut}
        pairs = [p for p in itertools.combinations(sorted(used), 2) if p not in tubes.struts]
        near = [p for p in pairs if numpy.linalg.norm(tubes.nodes[p[0]] - tubes.nodes[p[1]]) < 0.75 * size]
        ties = random.sample(near, min(len(near), random.choice((1, 2))))
        tubes.struts += ties
        if ties and tubes.apart():
            return tubes.body("ties", random, solid=set(ties))


def cage(random, size):
    """The edges of a box: bars above the parting surface hold what lies below them, along every pull."""
    tubes = Tubes(random, size, True)
    floor = tubes.floor(random)
    sides = [size * part for part in (1, random.uniform(0.7, 1), random.uniform(0.7, 1))]
    corners = list(itertools.product((0, 1), repeat=3))
    tubes.nodes = [numpy.array([k * side for k, side in zip(c, sides)]) + (0, 0, floor) for c in corners]
    pairs = itertools.combinations(range(8), 2)
    tubes.struts = [(a, b) for a, b in pairs if numpy.abs(numpy.subtract(corners[a], corners[b])).sum() == 1]
    tubes.legs = [0]
    return tubes.body("cage", random, castable=False)


# Each as often as it stands here.
KINDS = 3 * (frame, wave, net, wheel, tree, ties) + (cage,)
