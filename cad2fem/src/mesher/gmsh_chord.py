# Sizes of triangles by their chord error, the distance of triangles from the face that they stand for, and its
# measure. An edge h on a circle of radius r is h² / 8r away from it.

# gmsh tells the smallest radius of curvature at a point r as the size 2πr / TURN.
TURN = 6
# Radius and chord error to edge length of triangles of any direction, which gmsh makes up to a fifth longer [1].
SQUARED = 4.5
# Faces between four lines of curvature get rows of triangles: how much longer they may be along than across [1].
STRETCH = 3.0
# How far such a line may be from a line of parameters, over its length [1].
SLANT = 0.6
# How fast edges grow from a place with short ones [1], and over what parts of the box's diagonal they are looked up.
GROWTH = 0.8
CELLS = 96
# Longest edges without other wishes [diagonal].
LONGEST = 0.05
# More triangles than these are announced, more than those refused.
MANY, MOST = 200_000, 2_000_000
# Triangles that gmsh makes in a second.
RATE = 15_000
# How often faces that are too far off may be meshed again, and by how much more they are refined than they need.
ROUNDS, MARGIN = 7, 0.9
# Parts of a triangle's corners at which its distance from the face is measured: its middle and those of its edges.
PROBES = numpy.array([[1 / 3, 1 / 3, 1 / 3], [0.5, 0.5, 0], [0, 0.5, 0.5], [0.5, 0, 0.5]])


class Sizes:
    """Wanted edge lengths of a model whose chord error is to be `chord`, all in its unit."""

    def __init__(self, chord, longest):
        box = numpy.reshape(gmsh.model.getBoundingBox(-1, -1), (2, 3))
        diagonal = numpy.linalg.norm(box[1] - box[0])
        self.chord, self.longest = chord, longest or LONGEST * diagonal
        self.low, self.step = box[0].tolist(), diagonal / CELLS
        self.last = numpy.ceil((box[1] - box[0]) / self.step).astype(int).tolist()
        self.near = None
        self.finer = {}
        self.beside = {curve: gmsh.model.getAdjacencies(1, curve)[0].tolist()
                       for _, curve in gmsh.model.getEntities(1)}

    def factor(self, dim, tag):
        """How much shorter edges are than by the formula, as faces were too far off."""
        faces = [tag] if dim == 2 else self.beside.get(tag, []) if dim == 1 else []
        return min((self.finer.get(face, 1.0) for face in faces), default=1.0)

    def by_radius(self, radius, squared=SQUARED):
        """What is smaller than the chord error need not be seen."""
        return numpy.minimum(numpy.sqrt(squared * self.chord * numpy.maximum(radius, self.chord)), self.longest)

    def here(self, dim, tag, x, y, z, size):
        """gmsh asks for it; `size` is what it knows of the curvature."""
        radius = max(size * TURN / (2 * numpy.pi), self.chord)
        wanted = min((SQUARED * self.chord * radius) ** 0.5 * self.factor(dim, tag), self.longest)
        if self.near is None:
            return wanted
        cell = (min(max(int((p - low) / self.step + 0.5), 0), most)
                for p, low, most in zip((x, y, z), self.low, self.last))
        return min(wanted, float(self.near[tuple(cell)]))

    def cells(self, points):
        """Where points are looked up in `near`."""
        return tuple(((points - self.low) / self.step + 0.5).astype(int).clip(0, self.last).T)

    def spread(self):
        """Lets edges grow from those of the curves, which are meshed."""
        near = numpy.full([last + 1 for last in self.last], self.longest)
        for _, curve in gmsh.model.getEntities(1):
            _, points, there = gmsh.model.mesh.getNodes(1, curve, includeBoundary=True)
            points = points.reshape(-1, 3)[numpy.argsort(there)]
            edges = numpy.linalg.norm(numpy.diff(points, axis=0), axis=1)
            for ends in (points[:-1], points[1:]):
                # a pole has a curve without length
                numpy.minimum.at(near, self.cells(ends), numpy.where(edges > 0, edges, self.longest))
        for axis in range(3):
            ramp = numpy.arange(near.shape[axis]).reshape([-1 if i == axis else 1 for i in range(3)])
            ramp = GROWTH * self.step * ramp
            for _ in range(2):  # this way, and turned round
                near = numpy.flip(numpy.minimum.accumulate(near - ramp, axis) + ramp, axis)
        self.near = near


def parameters(face):
    """A grid of parameters inside a face."""
    low, high = (numpy.array(bound) for bound in gmsh.model.getParametrizationBounds(2, face))
    parts = (numpy.arange(5) + 0.5) / 5
    return low + (high - low) * numpy.array([[u, v] for u in parts for v in parts])


def radii(face):
    """Smallest radii of curvature of a face on a grid."""
    most, least, _, _ = gmsh.model.getPrincipalCurvatures(face, parameters(face).ravel())
    return 1 / numpy.maximum(numpy.nan_to_num(numpy.maximum(numpy.abs(most), numpy.abs(least))), 1e-12)


def foretold(sizes):
    """About how many triangles all faces get."""
    count = 0.0
    for _, face in gmsh.model.getEntities(2):
        wanted = sizes.by_radius(radii(face)) * sizes.factor(2, face)
        if sizes.near is not None:
            points = numpy.reshape(gmsh.model.getValue(2, face, parameters(face).ravel()), (-1, 3))
            wanted = numpy.minimum(wanted, sizes.near[sizes.cells(points)])
        count += gmsh.model.occ.getMass(2, face) * numpy.mean(4 / (3 ** 0.5 * wanted ** 2))
    return count


def announce(sizes, chord):
    """Says how many triangles there will be, if they are many, before they are made."""
    count = foretold(sizes)
    if count < MANY:
        return
    metres = settings["metres"]
    text = (f"{settings['shown']}: about {count:.1e} triangles for a chord error of {1e3 * metres * chord:.4g} mm, "
            f"of which gmsh makes {RATE} in a second; --chord {metres * chord * count / MANY:.1e} asks for {MANY}")
    if count > MOST:
        explain(f"{text}; more than {MOST} are not made")
    note(text)


def rows_of(face):
    """The curves around a face in pairs that lie opposite, and its corners, if these are about lines of its
    parameters."""
    around = [curve for _, curve in gmsh.model.getBoundary([(2, face)], oriented=False, combined=False)]
    if len(around) != 4 or len(set(around)) != 4 or gmsh.model.getType(2, face) in ("Plane", "Sphere"):
        return None
    pairs = ([], [])
    ends = {curve: set(gmsh.model.getAdjacencies(1, curve)[1].tolist()) for curve in around}
    middle = numpy.mean(gmsh.model.getParametrizationBounds(2, face), axis=0)
    slopes = numpy.linalg.norm(numpy.reshape(gmsh.model.getDerivative(2, face, middle), (2, 3)), axis=1)
    for curve in around:
        low, high = (bound[0] for bound in gmsh.model.getParametrizationBounds(1, curve))
        there = gmsh.model.reparametrizeOnSurface(1, curve, numpy.linspace(low, high, 5), face)
        moved = numpy.ptp(numpy.reshape(there, (-1, 2)), axis=0) * slopes
        if min(moved) > SLANT * max(moved) or len(ends[curve]) != 2:
            return None
        pairs[int(moved[0] > moved[1])].append(curve)  # first those along v, then those along u
    if len(pairs[0]) != 2 or ends[pairs[0][0]] & ends[pairs[0][1]] or ends[pairs[1][0]] & ends[pairs[1][1]]:
        return None
    (a, b), (c, d) = pairs
    corners = [*(ends[a] & ends[c]), *(ends[a] & ends[d]), *(ends[b] & ends[d]), *(ends[b] & ends[c])]
    return (pairs, corners) if len(corners) == 4 else None


def steps(sizes, face):
    """Edge lengths along v and along u of a face between lines of its parameters."""
    points = parameters(face)
    most, least, along, _ = gmsh.model.getPrincipalCurvatures(face, points.ravel())
    slopes = numpy.reshape(gmsh.model.getDerivative(2, face, points.ravel()), (-1, 2, 3))
    along = numpy.reshape(along, (-1, 3))
    wanted = []
    for direction in (slopes[:, 1], slopes[:, 0]):
        length = numpy.linalg.norm(direction, axis=1) * numpy.linalg.norm(along, axis=1)
        share = (numpy.sum(direction * along, axis=1) / numpy.maximum(length, 1e-300)) ** 2
        bend = numpy.max(numpy.abs(numpy.nan_to_num(share * most + (1 - share) * least)))
        wanted.append(float(sizes.by_radius(1 / max(bend, 1e-12), 8.0)) * sizes.factor(2, face))
    v, u = wanted
    return min(v, STRETCH * u), min(u, STRETCH * v)


def set_rows(sizes):
    """Gives faces between four lines of their parameters rows of triangles, which may be longer along than across."""
    faces = {face: rows for _, face in gmsh.model.getEntities(2) if (rows := rows_of(face))}
    length = {curve: gmsh.model.occ.getMass(1, curve) for curve in sizes.beside}
    closest = {face: float(sizes.by_radius(radii(face).min())) * sizes.factor(2, face)
               for _, face in gmsh.model.getEntities(2)}
    while faces:
        group = {curve: curve for curve in length}

        def of(curve):
            while group[curve] != curve:
                curve = group[curve]
            return curve

        count = {}
        for pairs, _ in faces.values():
            for a, b in pairs:
                group[of(a)] = of(b)
        for face, (pairs, _) in faces.items():
            for pair, step in zip(pairs, steps(sizes, face)):
                for curve in pair:
                    needed = int(numpy.ceil(length[curve] / step - 1e-6))
                    count[of(curve)] = max(count.get(of(curve), 1), needed)

        for curve in group:
            beside = [face for face in sizes.beside[curve] if face not in faces]
            if of(curve) in count and beside:
                needed = int(numpy.ceil(length[curve] / min(closest[face] for face in beside)))
                count[of(curve)] = max(count[of(curve)], needed)

        def lean(pairs):
            v, u = (sum(length[curve] / count[of(curve)] for curve in pair) for pair in pairs)
            return max(v, u) > 2 * STRETCH * min(v, u)

        askew = [face for face, (pairs, _) in faces.items() if lean(pairs)]
        if not askew:
            break
        for face in askew:
            del faces[face]
    for face, (pairs, corners) in faces.items():
        for curve in pairs[0] + pairs[1]:
            gmsh.model.mesh.setTransfiniteCurve(curve, count[of(curve)] + 1)
        gmsh.model.mesh.setTransfiniteSurface(face, "Alternate", corners)


def distance(face):
    """Largest distance of the triangles of a face from it, at their PROBES."""
    tags, points, there = gmsh.model.mesh.getNodes(2, face, includeBoundary=True, returnParametricCoord=True)
    _, corners = gmsh.model.mesh.getElementsByType(2, face)
    if not len(corners):
        return 0.0
    order = numpy.argsort(tags, kind="stable")
    corners = order[numpy.searchsorted(tags[order], corners)].reshape(-1, 3)
    there = there.reshape(-1, 2)[corners]
    span = numpy.subtract(*gmsh.model.getParametrizationBounds(2, face)[::-1])
    # beyond the seam of a closed face parameters begin again
    there -= span * (there - there.min(axis=1, keepdims=True) > 0.5 * span)
    probes = numpy.einsum("pc,tcx->tpx", PROBES, points.reshape(-1, 3)[corners]).reshape(-1, 3)
    there = numpy.einsum("pc,tcx->tpx", PROBES, there).reshape(-1, 2)
    # the point with the mean parameters is on the face, so that none is farther than that
    most = numpy.linalg.norm(numpy.reshape(gmsh.model.getValue(2, face, there.ravel()), (-1, 3)) - probes, axis=1)
    order, found = numpy.argsort(-most), 0.0
    for first in range(0, len(order), 64):
        some = order[first : first + 64]
        if most[some[0]] <= found:
            break
        closest = numpy.reshape(gmsh.model.getClosestPoint(2, face, probes[some].ravel())[0], (-1, 3))
        away = numpy.linalg.norm(closest - probes[some], axis=1)
        found = max(found, float(numpy.minimum(away, most[some]).max()))
    return found


def reached():
    """Largest distance of all triangles from their faces; nothing where gmsh cannot say it, as of some faces of its
    own kernel."""
    try:
        return max((distance(face) for _, face in gmsh.model.getEntities(2)), default=0.0)
    except Exception:
        return None


def follow(chord, longest):
    """Meshes all faces with this chord error; gives what was reached."""
    sizes = Sizes(chord, longest)
    gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", TURN)
    gmsh.option.setNumber("Mesh.MeshSizeExtendFromBoundary", 0)
    gmsh.model.mesh.setSizeCallback(sizes.here)
    announce(sizes, chord)
    rows = True
    for attempt in range(ROUNDS):
        gmsh.model.mesh.clear()
        gmsh.model.mesh.removeConstraints()
        sizes.near = None
        if rows:
            set_rows(sizes)
        gmsh.model.mesh.generate(1)
        sizes.spread()
        if attempt == 0:
            announce(sizes, chord)
        gmsh.model.mesh.clear()
        try:
            gmsh.model.mesh.generate(2)
        except Exception:
            if not rows or attempt + 1 == ROUNDS:
                raise
            rows = False
            continue
        off = {face: distance(face) for _, face in gmsh.model.getEntities(2)}
        if max(off.values(), default=0.0) <= chord:
            break
        for face, found in off.items():
            if found > chord:
                sizes.finer[face] = sizes.finer.get(face, 1.0) * MARGIN * (chord / found) ** 0.5
    return max(off.values(), default=0.0)
