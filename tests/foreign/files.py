"""Files as laboratories have them, made here so that nothing is fetched: python files.py FOLDER

Two STL in millimetres, one defective STL, two STEP (one with colours, one with names of faces), and the
STEP of an arm with three chambers.
"""

import os
import re
import sys

import gmsh
import numpy
import trimesh


def bellows():
    """Four folds, and beside them the air inside with its inlet; both closed, in millimetres."""
    def turned(profile):
        return trimesh.creation.revolve(numpy.array(profile), sections=64)

    heights = numpy.linspace(4, 40, 9)
    outside = [(0, 0), (13, 0)] + [(13 if i % 2 == 0 else 10, z) for i, z in enumerate(heights)]
    inside = [(0, -1), (2.5, -1), (2.5, 4), (7.5, 4)]
    inside += [(10.5 if i % 2 == 0 else 7.5, z) for i, z in enumerate(heights[1:], 1)]
    turned(outside + [(13, 44), (0, 44)]).export("bellows.stl")
    turned(inside + [(0, 40)]).export("bellows-air.stl")


def finger():
    """A finger with its chamber already taken out, one shell, in millimetres."""
    body = trimesh.creation.box(bounds=[[-9, -8, 0], [9, 8, 60]])
    air = trimesh.creation.box(bounds=[[-2, -4, -1], [6, 4, 54]])
    trimesh.boolean.difference([body, air]).export("finger.stl")


def defective():
    """A post whose triangles were torn apart and have gaps, some of them missing and some twice, with a
    lug that crosses it."""
    body = trimesh.creation.cylinder(12, 40, sections=48)
    body.apply_translation([0, 0, 20])
    air = trimesh.creation.cylinder(6, 31, sections=48)
    air.apply_translation([2, 0, 14.5])
    post = trimesh.boolean.difference([body, air]).subdivide()
    lug = trimesh.creation.box(bounds=[[8, -4, 25], [16, 4, 33]])
    corners = numpy.concatenate([post.triangles, lug.triangles, post.triangles[40:46]])
    wall = numpy.hypot(*post.triangles_center[:, :2].T) > 11
    missing = numpy.flatnonzero(wall)[[3, 4, 5, 90]]
    corners = numpy.delete(corners, missing, axis=0)
    corners += numpy.random.default_rng(1).uniform(-2e-5, 2e-5, corners.shape)
    torn = trimesh.Trimesh(corners.reshape(-1, 3), numpy.arange(corners.size // 3).reshape(-1, 3), process=False)
    torn.export("defective.stl")


def step(name, shapes):
    """Writes the solid that `shapes` leaves in OpenCASCADE."""
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    shapes(gmsh.model.occ)
    gmsh.model.occ.synchronize()
    gmsh.write(name)
    gmsh.clear()
    gmsh.open(name)  # the order of faces is that of the file
    boxes = [gmsh.model.getBoundingBox(2, face) for _, face in gmsh.model.getEntities(2)]
    gmsh.finalize()
    return boxes


def listed(text):
    """Entities of the faces, in the order in which gmsh numbers them."""
    shells = re.findall(r"CLOSED_SHELL\s*\('[^']*',\s*\(([^)]*)\)", text)
    return [face for shell in shells for face in re.findall(r"#(\d+)", shell)]


def colored(name, boxes, color_of):
    """Gives faces colours, by their bounding boxes, as CAD programs do."""
    text = open(name).read()
    context = re.search(r"#(\d+) = \( GEOMETRIC_REPRESENTATION_CONTEXT", text).group(1)
    last = max(int(number) for number in re.findall(r"^#(\d+) =", text, re.M))
    lines, styled = [], []

    def add(entity):
        lines.append(f"#{last + len(lines) + 1} = {entity};")
        return f"#{last + len(lines)}"

    for face, box in zip(listed(text), boxes):
        fill = add(f"FILL_AREA_STYLE_COLOUR('',{add(f'COLOUR_RGB({chr(39)}{chr(39)},{color_of(box)})')})")
        side = add(f"SURFACE_STYLE_FILL_AREA({add(f'FILL_AREA_STYLE({chr(39)}{chr(39)},({fill}))')})")
        usage = add(f"SURFACE_STYLE_USAGE(.BOTH.,{add(f'SURFACE_SIDE_STYLE({chr(39)}{chr(39)},({side}))')})")
        styled.append(add(f"STYLED_ITEM('',({add(f'PRESENTATION_STYLE_ASSIGNMENT(({usage}))')}),#{face})"))
    add(f"MECHANICAL_DESIGN_GEOMETRIC_PRESENTATION_REPRESENTATION('',({','.join(styled)}),#{context})")
    open(name, "w").write(text.replace("ENDSEC;\nEND-ISO", "\n".join(lines) + "\nENDSEC;\nEND-ISO"))


def named(name, boxes, name_of):
    """Gives faces names, by their bounding boxes."""
    text = open(name).read()
    for face, box in zip(listed(text), boxes):
        text = re.sub(rf"(#{face} = ADVANCED_FACE\()''", rf"\1'{name_of(box)}'", text)
    open(name, "w").write(text)


def within(box, low, high):
    return all(l - 1e-3 <= a and b <= h + 1e-3 for a, b, l, h in zip(box[:3], box[3:], low, high))


def capsule():
    """An upright oval body whose seat is red and whose chamber is blue."""
    def shapes(occ):
        body = occ.addCylinder(0, 0, 0, 0, 0, 45, 13)
        air = occ.addCylinder(2.5, 0, 5, 0, 0, 34, 6.5)
        inlet = occ.addCylinder(2.5, 0, -1, 0, 0, 8, 3)
        occ.cut([(3, body)], [(3, air), (3, inlet)])

    def color(box):
        if within(box, (-14, -14, 0), (14, 14, 0)):
            return "1.,0.,0."
        return "0.,0.,1." if within(box, (-4.1, -6.6, -1), (9.1, 6.6, 39)) else "0.8,0.8,0.8"

    colored("capsule.step", step("capsule.step", shapes), color)


def pad():
    """A flat pad with a flat chamber; its faces have names."""
    def shapes(occ):
        body = occ.addBox(0, 0, 0, 50, 30, 14)
        air = occ.addBox(6, 6, 4, 38, 18, 6)
        inlet = occ.addCylinder(-1, 15, 7, 9, 0, 0, 2.5)
        occ.cut([(3, body)], [(3, air), (3, inlet)])

    def name(box):
        if within(box, (0, 0, 0), (0, 30, 14)):
            return "mount"
        if within(box, (0, 6, 4), (44, 24, 10)):
            return "air"
        return "bottom" if within(box, (0, 0, 0), (50, 30, 0)) else "skin"

    named("pad.step", step("pad.step", shapes), name)


def arm():
    """An arm with three chambers that open at its base."""
    places = [(6.5 * numpy.cos(a), 6.5 * numpy.sin(a)) for a in numpy.pi * (numpy.arange(3) * 2 / 3 + 0.5)]

    def shapes(occ):
        body = occ.addCylinder(0, 0, 0, 0, 0, 80, 12)
        air = []
        for x, y in places:
            air += [(3, occ.addCylinder(x, y, 8, 0, 0, 67, 3.4)), (3, occ.addCylinder(x, y, -1, 0, 0, 10, 2.6))]
        occ.cut([(3, body)], air)

    def name(box):
        if within(box, (-13, -13, 0), (13, 13, 0)):
            return "base"
        for number, (x, y) in enumerate(places, 1):
            if within(box, (x - 3.5, y - 3.5, 0), (x + 3.5, y + 3.5, 75)):
                return f"ch{number}"
        return "skin"

    named("arm.step", step("arm.step", shapes), name)


os.makedirs(sys.argv[1], exist_ok=True)
os.chdir(sys.argv[1])
for make in (bellows, finger, defective, capsule, pad, arm):
    make()
