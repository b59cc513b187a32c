# Fills the closed surface vertices.npy, triangles.npy, of which the last `inside` triangles are
# surfaces inside that become facets; leaves points.npy, tets.npy.
gmsh.initialize(readConfigFiles=False)
gmsh.option.setNumber("General.NumThreads", settings["threads"])
inside = settings["inside"]
# HXT knows no surfaces inside, Delaunay does.
gmsh.option.setNumber("Mesh.Algorithm3D", 1 if inside else 10)
gmsh.option.setNumber("Mesh.Optimize", 1)
gmsh.option.setNumber("Mesh.OptimizeThreshold", 0.4)
gmsh.option.setNumber("Mesh.MeshSizeMax", settings["edge_length"])
vertices = numpy.load("vertices.npy")
triangles = numpy.load("triangles.npy").astype(numpy.int64)
triangles, layers = numpy.split(triangles, [len(triangles) - inside])



def shells():
    """The connected parts of the surface."""
    part = numpy.arange(len(vertices))
    while True:
        least = part.copy()
        numpy.minimum.at(least, triangles.ravel(), numpy.repeat(part[triangles].min(axis=1), 3))
        least = least[least]
        if (least == part).all():
            break
        part = least
    of = part[triangles[:, 0]]
    return [triangles[of == first] for first in numpy.unique(of)]


# The triangles themselves become the boundary of the volume: of one entity, HXT fills no cavities.
parts = shells()
entity = numpy.zeros(len(vertices), dtype=int)
for number, part in enumerate(parts):
    entity[part] = number
loops = []
for number, part in enumerate(parts):
    surface = gmsh.model.addDiscreteEntity(2)
    own = numpy.flatnonzero(entity == number)
    gmsh.model.mesh.addNodes(2, surface, own + 1, vertices[own].ravel())
    gmsh.model.mesh.addElementsByType(surface, 2, [], (part + 1).ravel())
    loops.append(gmsh.model.geo.addSurfaceLoop([surface]))
volume = gmsh.model.geo.addVolume(loops)
gmsh.model.geo.synchronize()
if inside:
    layer = gmsh.model.addDiscreteEntity(2)
    gmsh.model.mesh.addElementsByType(layer, 2, [], (layers + 1).ravel())
    gmsh.model.mesh.embed(2, [layer], 3, volume)
fields = []
for ball in settings["refine"]:
    field = gmsh.model.mesh.field.add("Ball")
    grown = 2 * (settings["edge_length"] - ball["edge_length"])
    numbers = dict(zip(("XCenter", "YCenter", "ZCenter"), ball["center"]), Radius=ball["radius"],
                   VIn=ball["edge_length"], VOut=settings["edge_length"], Thickness=max(grown, 0))
    for key, value in numbers.items():
        gmsh.model.mesh.field.setNumber(field, key, value)
    fields.append(field)
if fields:
    smallest = gmsh.model.mesh.field.add("Min")
    gmsh.model.mesh.field.setNumbers(smallest, "FieldsList", fields)
    gmsh.model.mesh.field.setAsBackgroundMesh(smallest)
try:
    gmsh.model.mesh.generate(3)
except Exception as error:
    explain(f"gmsh cannot fill this surface ({error}); use mesher = \"ftetwild\"")

tags, points, _ = gmsh.model.mesh.getNodes()
_, corners = gmsh.model.mesh.getElementsByType(4)
if len(corners) == 0:
    explain("gmsh made no tetrahedra of this surface; use mesher = \"ftetwild\"")
row = numpy.zeros(int(tags.max()) + 1)
row[tags.astype(numpy.int64)] = numpy.arange(len(tags))
numpy.save("points.npy", points.reshape(-1, 3))
numpy.save("tets.npy", row[corners.astype(numpy.int64)].reshape(-1, 4))
gmsh.finalize()
