# Meshes the faces of a CAD file; leaves points.npy, triangles.npy, patch.npy (the
# patch of each triangle) and patches.json (their names).
arguments = ["cad2fem"]
for name, value in settings["numbers"].items():
    if not re.search(rf"\b{re.escape(name)}\b", open(settings["file"], errors="replace").read()):
        explain(f"{settings['shown']}: there is no number {name} to set")
    arguments += ["-setnumber", name, repr(value)]
gmsh.initialize(arguments, readConfigFiles=False)
gmsh.option.setString("Geometry.OCCTargetUnit", "M")
if settings["edge_length"] is not None:
    gmsh.option.setNumber("Mesh.MeshSizeMax", settings["edge_length"])
try:
    gmsh.open(os.path.abspath(settings["file"]))
    gmsh.model.occ.synchronize()
    gmsh.model.mesh.generate(2)
except Exception as error:
    message = str(error).replace(os.path.abspath(settings["file"]), settings["shown"])
    explain(f"{settings['shown']}: gmsh cannot mesh it: {message}")



def file_name(name):
    """Names become names of files."""
    return re.sub(r"[^A-Za-z0-9_-]+", "-", name)


# Physical surfaces are the patches; without any, every named or numbered face is.
groups = []
for _, tag in gmsh.model.getPhysicalGroups(2):
    name = gmsh.model.getPhysicalName(2, tag) or f"surface-{tag}"
    groups.append((name, gmsh.model.getEntitiesForPhysicalGroup(2, tag)))
if not groups:
    for _, face in gmsh.model.getEntities(2):
        name = gmsh.model.getEntityName(2, face).split("/")[-1]
        groups.append((name or f"face-{face}", [face]))

names, corners, patch = [], [], []
seen = set()
for name, faces in groups:
    name = file_name(name)
    if name not in names:
        names.append(name)
    for face in faces:
        if face in seen:
            explain(f"{settings['shown']}: face {face} is in two physical surfaces")
        seen.add(face)
        _, triangles = gmsh.model.mesh.getElementsByType(2, face)
        corners.append(triangles.reshape(-1, 3))
        patch += [names.index(name)] * len(corners[-1])
left_over = [face for _, face in gmsh.model.getEntities(2)
             if face not in seen and len(gmsh.model.getAdjacencies(2, face)[0]) > 0]
for face in left_over:
    _, triangles = gmsh.model.mesh.getElementsByType(2, face)
    corners.append(triangles.reshape(-1, 3))
    patch += [-1] * len(corners[-1])

if sum(len(c) for c in corners) == 0:
    explain(f"{settings['shown']}: no faces found")
tags, points, _ = gmsh.model.mesh.getNodes()
corners = numpy.concatenate(corners).astype(numpy.int64)
used = numpy.unique(corners)
row = numpy.zeros(int(tags.max()) + 1, dtype=numpy.int64)
row[tags.astype(numpy.int64)] = numpy.arange(len(tags))
numpy.save("points.npy", points.reshape(-1, 3)[row[used]])
numpy.save("triangles.npy", numpy.searchsorted(used, corners).astype(float))
numpy.save("patch.npy", numpy.array(patch, dtype=float).reshape(-1, 1))
json.dump(names, open("patches.json", "w"))
gmsh.finalize()
