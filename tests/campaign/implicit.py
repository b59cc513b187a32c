"""Implicit models: their text for `cad2fem model`, and their functions by numpy, from the file alone.

The functions follow `pipelines/book/models.md` and not the code, so that a verdict does not rest on the programs that
it judges. Lengths are millimetres.
"""

import numpy

# Below the ground a body is cut off; what reaches there reaches this far [mm].
DEEP = 400.0


class Model:
    """A model file that grows."""

    def __init__(self, wall, size):
        grid = max(0.8 * wall, size / 50)
        self.head = f'unit = "mm"\ngrid = {grid:.4f}\nsimplify = {wall / 20:.4f}\n'
        self.parts, self.regions, self.count = [], [], 0

    def add(self, where, shape, blend=0.0, op=None):
        """A primitive of `where`, solid or cavity."""
        text = f'[[{where}]]\nname = "p{self.count}"\nshape.{shape}\n'
        text += f"blend = {blend:.4f}\n" if blend else ""
        self.parts.append(text + (f"op{op}\n" if op else ""))
        self.count += 1

    def cavity_above(self, height):
        """Keeps of the cavity what lies above a height."""
        box = block((0, 0, height + DEEP), (4 * DEEP, 4 * DEEP, 2 * DEEP))
        self.add("cavity", box, op=' = "intersection"')

    def chamber(self, name, half=None):
        """A region for the wall of the cavity, or of what lies within so far in x and y of the middle."""
        within = ""
        if half:
            x, y = half
            within = f"within = {{ min = [{-x:.4f}, {-y:.4f}, {-DEEP}], max = [{x:.4f}, {y:.4f}, {DEEP}] }}\n"
        self.regions.append(f'[[region]]\nname = "{name}"\ncavity = true\n{within}')

    def text(self):
        seat = '[[cut]]\nname = "seat"\nnormal = [0, 0, -1]\noffset = 0\n[[region]]\nname = "seat"\ncut = "seat"\n'
        rest = '[[region]]\nname = "skin"\nrest = true\n'
        return self.head + "".join(self.parts) + seat + "".join(self.regions) + rest


def vector(values):
    return "[" + ", ".join(f"{value:.4f}" for value in values) + "]"


def sphere(center, radius):
    return f"sphere = {{ center = {vector(center)}, radius = {radius:.4f} }}"


def ellipsoid(center, radii):
    return f"ellipsoid = {{ center = {vector(center)}, radii = {vector(radii)} }}"


def capsule(start, end, radii):
    return f"capsule = {{ from = {vector(start)}, to = {vector(end)}, radii = {vector(radii)} }}"


def cylinder(start, end, radius):
    return f"cylinder = {{ from = {vector(start)}, to = {vector(end)}, radius = {radius:.4f} }}"


def block(center, size, rounding=0.0):
    return f"box = {{ center = {vector(center)}, size = {vector(size)}, rounding = {rounding:.4f} }}"


def distance(shape, points):
    """The function of a primitive, as read from the file, at each row of `points` [mm]."""
    (kind, keys), = shape.items()
    keys = {name: numpy.array(value) for name, value in keys.items()}
    if kind == "sphere":
        return numpy.linalg.norm(points - keys["center"], axis=1) - keys["radius"]
    if kind == "ellipsoid":
        scaled = (points - keys["center"]) / keys["radii"]
        first = numpy.linalg.norm(scaled, axis=1)
        second = numpy.maximum(numpy.linalg.norm(scaled / keys["radii"], axis=1), 1e-12)
        return first * (first - 1) / second
    if kind == "box":
        far = numpy.abs(points - keys["center"]) - keys["size"] / 2 + keys["rounding"]
        inside = numpy.minimum(far.max(axis=1), 0)
        return numpy.linalg.norm(numpy.maximum(far, 0), axis=1) + inside - keys["rounding"]
    axis = keys["to"] - keys["from"]
    along = (points - keys["from"]) @ axis / (axis @ axis)
    if kind == "capsule":
        along = numpy.clip(along, 0, 1)
        radius = keys["radii"][0] + (keys["radii"][1] - keys["radii"][0]) * along
        return numpy.linalg.norm(points - keys["from"] - along[:, None] * axis, axis=1) - radius
    if kind == "cylinder":
        across = numpy.linalg.norm(points - keys["from"] - along[:, None] * axis, axis=1) - keys["radius"]
        beyond = (numpy.abs(along - 0.5) - 0.5) * numpy.linalg.norm(axis)
        outside = numpy.hypot(numpy.maximum(across, 0), numpy.maximum(beyond, 0))
        return outside + numpy.minimum(numpy.maximum(across, beyond), 0)
    raise ValueError(f"no shape is called {kind}")


def smooth_least(a, b, width):
    if width == 0:
        return numpy.minimum(a, b)
    return numpy.minimum(a, b) - numpy.maximum(width - numpy.abs(a - b), 0) ** 2 / (4 * width)


def combined(parts, points):
    """The function of a list of primitives; positive infinity without any."""
    total = numpy.full(len(points), numpy.inf)
    for part in parts:
        own, op, blend = distance(part["shape"], points), part.get("op", "union"), part.get("blend", 0.0)
        if op == "union":
            total = smooth_least(total, own, blend)
        elif op == "difference":
            total = -smooth_least(-total, own, blend)
        elif op == "intersection":
            total = -smooth_least(-total, -own, blend)
        else:
            raised = numpy.clip(0.5 - own / (2 * op["emboss"]["width"]), 0, 1)
            total = total - op["emboss"]["height"] * raised**2 * (3 - 2 * raised)
    return total


def inside(model, points):
    """Whether points are in the filled body, and in its chambers."""
    above = numpy.ones(len(points), bool)
    for cut in model["cut"]:
        normal = numpy.array(cut["normal"], float)
        above &= points @ normal / numpy.linalg.norm(normal) <= cut["offset"]
    filled, cavity = (combined(model.get(name, []), points) < 0 for name in ("solid", "cavity"))
    return filled & above, cavity & filled & above
