# Meshes the faces of a CAD file; leaves points.npy, triangles.npy, and faces.json: names and kinds of
# patches, the patch of each triangle and whether it is no part of the boundary, names and triangles of physical
# volumes and of solids, and how far triangles are from their faces.
arguments = ["cad2fem"]
for name, value in settings["numbers"].items():
    if not re.search(rf"\b{re.escape(name)}\b", open(settings["file"], errors="replace").read()):
        explain(f"{settings['shown']}: there is no number {name} to set")
    arguments += ["-setnumber", name, repr(value)]
gmsh.initialize(arguments, readConfigFiles=False)
# Before a STEP file has been read, gmsh cannot set the unit in which IGES files come: millimetres.
if settings["unit"] is not None:
    gmsh.option.setString("Geometry.OCCTargetUnit", settings["unit"])
if settings["edge_length"] is not None:
    gmsh.option.setNumber("Mesh.MeshSizeMax", settings["edge_length"])
path = os.path.abspath(settings["file"])


def described(face):
    """A face by number, name and place, as it can be found in a viewer."""
    name = gmsh.model.getEntityName(2, face).split("/")[-1]
    low_and_high = gmsh.model.getBoundingBox(2, face)
    low, high = (" ".join(f"{x:.4g}" for x in low_and_high[k : k + 3]) for k in (0, 3))
    return f"face {face}{' ' + repr(name) if name else ''} (from {low} to {high})"


def failed_faces():
    """The faces at which meshing stopped."""
    faces = {tag for dim, tag in gmsh.model.mesh.getLastEntityError() if dim == 2}
    edges = {tag for dim, tag in gmsh.model.mesh.getLastEntityError() if dim == 1}
    for edge in edges:
        faces.update(gmsh.model.getAdjacencies(1, edge)[0])
    return ", ".join(described(face) for face in sorted(faces)[:5])


try:
    gmsh.open(path)
    gmsh.model.occ.synchronize()
    # surfaces alone, as IGES files have them, may bound a body once they are sewn
    if settings["solids"] and not gmsh.model.getEntities(3) and gmsh.model.getEntities(2):
        gmsh.clear()
        for option in ("OCCSewFaces", "OCCMakeSolids", "OCCFixDegenerated", "OCCFixSmallEdges"):
            gmsh.option.setNumber(f"Geometry.{option}", 1)
        gmsh.open(path)
        gmsh.model.occ.synchronize()
except Exception as error:
    message = str(error).replace(path, settings["shown"])
    explain(f"{settings['shown']}: gmsh cannot read it: {message}")
def file_name(name):
    """Names become names of files."""
    return re.sub(r"[^A-Za-z0-9_-]+", "-", name)


def text_of_step():
    return open(settings["file"], errors="replace").read() if settings["step"] else ""


def names_in_step(count):
    """Names of faces as a STEP file has them, in the order of its shells; gmsh does not read them."""
    text = text_of_step()
    named = dict(re.findall(r"#(\d+)\s*=\s*ADVANCED_FACE\s*\(\s*'([^']*)'", text))
    shells = re.findall(r"(?:CLOSED|OPEN)_SHELL\s*\(\s*'[^']*'\s*,\s*\(([^)]*)\)", text)
    listed = [face for shell in shells for face in re.findall(r"#(\d+)", shell)]
    if len(listed) != count:  # an assembly, or faces that were healed
        return [""] * count
    return [named.get(face, "") for face in listed]


def faces_by_mark():
    """Each face with its name, or its colour if not all faces have the same, or its number."""
    faces = [face for _, face in gmsh.model.getEntities(2)]
    colors = [gmsh.model.getColor(2, face) for face in faces]
    several = len(set(colors)) > 1
    names = names_in_step(len(faces))
    for face, name, (r, g, b, is_set) in zip(faces, names, colors):
        name = gmsh.model.getEntityName(2, face).split("/")[-1] or name
        color = f"color-{r:02x}{g:02x}{b:02x}" if several and is_set else ""
        yield name or color or f"face-{face}", [face]


def named_solids():
    """Each solid of a file without physical groups with its name."""
    solids = [solid for _, solid in gmsh.model.getEntities(3)]
    if not settings["solids"] or gmsh.model.getPhysicalGroups():
        return {}
    text = text_of_step()
    breps = re.findall(r"(?:MANIFOLD_SOLID_BREP|BREP_WITH_VOIDS)\s*\(\s*'([^']*)'", text)
    # an assembly is a product as well as its parts are, the first one
    parts = re.findall(r"\bPRODUCT\s*\(\s*'([^']*)'", text)[-len(solids):]
    own = [gmsh.model.getEntityName(3, solid).split("/")[-1] for solid in solids]
    lists = [own] + [names for names in (breps, parts) if len(names) == len(solids)]
    anonymous = "Open CASCADE STEP translator"
    best = [next((n for n in names if n and not n.startswith(anonymous)), "") for names in zip(*lists)]
    return dict(zip(solids, best))


def place(face):
    """Where a face is, and its size: the same before and after solids were cut elsewhere."""
    return *gmsh.model.occ.getCenterOfMass(2, face), gmsh.model.occ.getMass(2, face)


def box(face):
    return gmsh.model.getBoundingBox(2, face)


def is_part(face, kind, whole):
    """Whether a face may be what is left of one with this kind and box."""
    low_and_high = zip(box(face), whole)
    reach = 1e-4 * max(high - low for low, high in zip(whole[:3], whole[3:]))
    inside = [new >= old - reach if i < 3 else new <= old + reach for i, (new, old) in enumerate(low_and_high)]
    return gmsh.model.getType(2, face) == kind and all(inside)


def name_before(face, before):
    """The name that a face, or what it was cut from, had before solids were cut."""
    same = [name for there, _, _, name in before if numpy.allclose(place(face), there, 1e-6, 1e-9)]
    cut = [name for _, kind, whole, name in before if name and is_part(face, kind, whole)]
    return (same or cut or [""])[0] or f"face-{face}"


def solids_called(wanted):
    """Solids by their names or numbers."""
    solids = named_solids()
    for text in wanted:
        called = [solid for solid, name in solids.items() if name == text]
        numbered = [solid for i, solid in enumerate(solids, 1) if str(i) == text]
        found = called or numbered
        if len(found) != 1:
            known = ", ".join(f"{i} {name!r}" if name else str(i) for i, name in enumerate(solids.values(), 1))
            why = "several solids are called so, say its number" if found else "there is no such file or solid"
            explain(f"--subtract {text}: {why}; the solids of {settings['shown']} are {known or 'none'}")
        yield found[0], solids[found[0]] or f"solid-{text}"


def cut_away(wanted):
    """Takes solids out of the others; gives for each face that is a wall of one its number and name."""
    named = dict(solids_called(wanted))
    air = list(named)
    kept = [solid for solid in named_solids() if solid not in air]
    if not kept:
        explain(f"{settings['shown']}: --subtract takes all of its {len(air)} solids; one must be left")
    occ = gmsh.model.occ
    _, pieces = occ.fragment([(3, solid) for solid in kept], [(3, solid) for solid in air])
    occ.synchronize()
    holes = [{piece for _, piece in of} for of in pieces[len(kept):]]
    taken = set().union(*holes)
    body = {piece for of in pieces[: len(kept)] for _, piece in of} - taken
    wall = {}
    for name, hole in zip(named.values(), holes):
        faces = gmsh.model.getBoundary([(3, piece) for piece in hole], combined=False, oriented=False)
        own = sorted({f for _, f in faces if body & set(gmsh.model.getAdjacencies(2, f)[0].tolist())})
        if not own:
            explain(f"--subtract: the solid {name} of {settings['shown']} does not meet the body")
        wall.update({face: f"{name}-{i}" for i, face in enumerate(own, 1)})
    occ.remove([(3, piece) for piece in taken], recursive=True)
    occ.synchronize()
    return wall


walls, before = {}, []
try:
    if settings["subtract"]:
        before = [(place(face), gmsh.model.getType(2, face), box(face), "" if name == f"face-{face}" else name)
                  for name, [face] in faces_by_mark()]
        walls = cut_away(settings["subtract"])
    if settings["chord"] is None:
        gmsh.model.mesh.generate(2)
        off = reached()
    else:
        off = follow(settings["chord"], settings["edge_length"])
except Exception as error:
    message, faces = str(error).replace(path, settings["shown"]), failed_faces()
    where = f" at {faces}" if faces else ""
    explain(f"{settings['shown']}: gmsh cannot mesh it{where}: {message}")


# Physical surfaces are the patches; without any, every named, coloured or numbered face is.
groups = []
for _, tag in gmsh.model.getPhysicalGroups(2):
    name = gmsh.model.getPhysicalName(2, tag) or f"surface-{tag}"
    groups.append((name, gmsh.model.getEntitiesForPhysicalGroup(2, tag)))
if not groups:
    groups = [(walls.get(face) or name_before(face, before) if walls else name, [face])
              for name, [face] in faces_by_mark()]

# Faces between two volumes, or embedded in one, are inside the body.
embedded = {face for _, volume in gmsh.model.getEntities(3)
            for dim, face in gmsh.model.mesh.getEmbedded(3, volume) if dim == 2}
between = {face for _, face in gmsh.model.getEntities(2)
           if len(gmsh.model.getAdjacencies(2, face)[0]) > 1}
within = embedded | between

names, corners, patch, inside, rows = [], [], [], [], {}
seen = set()


def take(face, index):
    _, triangles = gmsh.model.mesh.getElementsByType(2, face)
    if not len(triangles):
        explain(f"{settings['shown']}: gmsh makes no triangles on {described(face)}; does its rim "
                "cross itself, or is it meshed with quadrangles?")
    rows[face] = range(len(patch), len(patch) + len(triangles) // 3)
    corners.append(triangles.reshape(-1, 3))
    patch.extend([index] * len(corners[-1]))
    inside.extend([face in within] * len(corners[-1]))


for name, faces in groups:
    name = file_name(name)
    if name not in names:
        names.append(name)
    for face in faces:
        if face in seen:
            explain(f"{settings['shown']}: face {face} is in two physical surfaces")
        seen.add(face)
        take(face, names.index(name))
    if len({face in within for face in faces}) > 1:
        explain(f"{settings['shown']}: physical surface {name} has faces on the boundary and inside; "
                "make it two")
left_over = [face for _, face in gmsh.model.getEntities(2)
             if face not in seen and len(gmsh.model.getAdjacencies(2, face)[0]) > 0]
for face in left_over:
    take(face, None)

volumes = {}
for _, tag in gmsh.model.getPhysicalGroups(3):
    solids = [(3, solid) for solid in gmsh.model.getEntitiesForPhysicalGroup(3, tag)]
    faces = [abs(face) for _, face in gmsh.model.getBoundary(solids, combined=True, oriented=False)]
    name = file_name(gmsh.model.getPhysicalName(3, tag) or f"volume-{tag}")
    if name in volumes:
        explain(f"{settings['shown']}: two physical volumes are called {name}")
    volumes[name] = [row for face in faces for row in rows[face]]

solids = [(name, [row for face in gmsh.model.getAdjacencies(3, solid)[1] for row in rows.get(face, [])])
          for solid, name in named_solids().items()]
if len(solids) < 2 or walls:
    solids = []


def kind_of(faces):
    """What faces of a patch are: plane, cylinder, ...; nothing where they differ."""
    kinds = {gmsh.model.getType(2, face).replace(" surface", "").replace(" Surface", "").lower() for face in faces}
    return kinds.pop() if len(kinds) == 1 else ""


def normals(faces, point):
    """Normals of faces at a point of both."""
    return [numpy.array(gmsh.model.getNormal(face, gmsh.model.getParametrization(2, face, point)))
            for face in faces]


def is_smooth(curve, faces):
    """Whether two faces have the same tangent plane at three points of a curve, to 8 degrees."""
    (low,), (high,) = gmsh.model.getParametrizationBounds(1, curve)
    points = [gmsh.model.getValue(1, curve, [low + part * (high - low)]) for part in (0.25, 0.5, 0.75)]
    return all(abs(a @ b) > 0.99 for a, b in (normals(faces, point) for point in points))


patch_of = {face: names.index(file_name(name)) for name, faces in groups for face in faces}
tangent = set()
for _, curve in gmsh.model.getEntities(1):
    faces = sorted(set(gmsh.model.getAdjacencies(1, curve)[0].tolist()) & set(patch_of))
    pair = tuple(sorted({patch_of[face] for face in faces}))
    if len(faces) != 2 or len(pair) != 2 or pair in tangent:
        continue
    try:
        smooth = is_smooth(curve, faces)
    except Exception:  # gmsh cannot say it of a curve without length, or of a surface of its own kernel
        continue
    if smooth:
        tangent.add(pair)

if sum(len(c) for c in corners) == 0:
    explain(f"{settings['shown']}: no faces found")
tags, points, _ = gmsh.model.mesh.getNodes()
corners = numpy.concatenate(corners).astype(numpy.int64)
used = numpy.unique(corners)
row = numpy.zeros(int(tags.max()) + 1, dtype=numpy.int64)
row[tags.astype(numpy.int64)] = numpy.arange(len(tags))
numpy.save("points.npy", points.reshape(-1, 3)[row[used]])
numpy.save("triangles.npy", numpy.searchsorted(used, corners).astype(float))
of_patch = [[face for face, own in patch_of.items() if own == i] for i in range(len(names))]
faces = {
    "names": names,
    "patch": patch,
    "inside": inside,
    "volumes": list(volumes.items()),
    "solids": solids,
    "kinds": [kind_of(faces) for faces in of_patch],
    "tangent": sorted(tangent),
    "chord_error": off,
}
json.dump(faces, open("faces.json", "w"))
gmsh.finalize()
