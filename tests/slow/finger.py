"""A bellows finger of OpenCASCADE with fillets, 179 faces, in millimetres: `finger.step`, and in `wall.json` and
`ends.json` the names that the faces of its chamber and of its two ends will have."""

import json

import gmsh

LENGTH, WIDTH, HEIGHT, RIBS = 88.0, 20.0, 17.0, 6
PITCH = (LENGTH - 8) / RIBS

gmsh.initialize()
gmsh.option.setNumber("General.Terminal", 0)
occ = gmsh.model.occ


def fused(boxes):
    parts = [(3, occ.addBox(*box)) for box in boxes]
    return occ.fuse(parts[:1], parts[1:])[0]


def rounded(body, radius, wanted):
    occ.synchronize()
    faces = gmsh.model.getBoundary(body, oriented=False)
    curves = sorted({tag for _, tag in gmsh.model.getBoundary(faces, combined=False, oriented=False)})
    return occ.fillet([body[0][1]], [tag for tag in curves if wanted(*gmsh.model.getBoundingBox(1, tag))], [radius])


def place(face):
    return [*occ.getCenterOfMass(2, face), occ.getMass(2, face)]


ribs = [8 + i * PITCH for i in range(RIBS)]
body = fused([(0, -WIDTH / 2, 0, LENGTH, WIDTH, 7), (0, -WIDTH / 2, 0, 8, WIDTH, HEIGHT)]
             + [(x + 1, -WIDTH / 2, 0, PITCH - 2, WIDTH, HEIGHT) for x in ribs])
body = rounded(body, 0.8, lambda *box: box[5] > 7.5 and box[0] > 9)
air = fused([(-5, -1.5, 3, LENGTH, 3, 2.5)]
            + [(x + 2.5, 2 - WIDTH / 2, 3, PITCH - 5, WIDTH - 4, HEIGHT - 5) for x in ribs])
air = rounded(air, 0.6, lambda *box: box[2] > 5.6 and box[0] > 0)
occ.synchronize()
# all walls of the air but those that stick out
wall = [place(face) for _, face in gmsh.model.getBoundary(air, oriented=False)]
holes = [(3, occ.addCylinder(-1, y, z, 4, 0, 0, 0.75)) for y, z in ((-7, 14), (7, 14), (-7, 3), (7, 3), (0, 14))]
holes.append((3, occ.addCylinder(5, 7, -1, 0, 0, 20, 0.8)))
occ.cut(body, air + holes)
occ.synchronize()
gmsh.write("finger.step")

gmsh.clear()
gmsh.open("finger.step")
found = {face: place(face) for _, face in gmsh.model.getEntities(2)}


def inside(face):
    """Whether a face is a wall of the air, or what is left of one of the four of the inlet."""
    x, y, z, _ = found[face]
    same = any(max(abs(a - b) for a, b in zip(found[face], other)) < 1e-6 for other in wall)
    low = gmsh.model.getBoundingBox(2, face)
    within_inlet = low[0] < 1e-3 and 0 < x < LENGTH - 6 and abs(y) < 1.6 and 2.9 < z < 5.6
    return same or within_inlet


def at(x):
    return [f"face-{f}" for f, p in found.items() if abs(p[0] - x) < 1e-6 and p[3] > 50]


json.dump([f"face-{face}" for face in found if inside(face)], open("wall.json", "w"))
json.dump({"seat": at(0), "tip": at(LENGTH - 1) + at(LENGTH)}, open("ends.json", "w"))
gmsh.finalize()
