"""Bodies of others, from files to designs, pages and verified molds: python run.py PROGRAMS FOLDER [BODY...]

Makes the files (files.py), then runs each body through the programs, and prints every command with its
seconds. Each design is for the same thing: the skin is to move by half as much again, in the way in which it
moves. Fetches nothing. `make foreign` runs it.
"""

import json
import pathlib
import subprocess
import sys
import time

# More than the envelope of the mesher, less than any wall.
EPSILON = "relative_epsilon = 6e-3\n"
TAG = '[[tag]]\nname = "{0}"\npatch = {1}\n'
WALL = 'pressure = true\nrim = "seat"\n'
MOLD = """chamber = {chambers}

[casting]
silicone = "dragon-skin-10-medium"
printer = "prusa-mk4"
"""

# What the skin is to move by, of what it does.
FACTOR = 1.5
DESIGN = """scene = "sim.design.toml"

[mold]
config = "mold.toml"

[shape]
on = [{chambers}]
{keep}
[[shape.level]]
handles = 2
iterations = 4

[[shape.level]]
handles = 6
iterations = 4

[[objective]]
kind = "probe"
name = "moves"
share = 0.8
probe = "way"
target = {target}                # [m]

[[objective]]
kind = "smoothness"
name = "smooth"
share = 0.1
on = [{chambers}]

[[objective]]
kind = "wall-thickness"
name = "wall"
weight = 1e10                    # [1/m^4]
on = [{chambers}]
against = ["skin"]
minimum = 1e-3                   # [m], as casting.least_wall
activation = 0.5e-3              # [m]
"""
# Flat faces that stay: the pad is to be cast open at its top, as it was.
KEEP = {"pad": 'keep = [{ axis = "z", at = 4e-3 }]\n'}
PROBE = """include = "sim.toml"

[[probe]]
name = "way"
kind = "displacement"
on = "skin"
axis = {axis}
"""


def tags(seat, walls, skin):
    """The seat, walls of chambers by their names, and the skin."""
    text = EPSILON + TAG.format("seat", seat)
    text += "".join(TAG.format(name, patch) + WALL for name, patch in walls.items())
    return text + TAG.format("skin", skin)


# Files and options of import, tags, chambers, pressure [Pa], keys of the mold.
BODIES = {
    "bellows": (
        ["bellows.stl", "--subtract", "bellows-air.stl"],
        EPSILON + '[[tag]]\nname = "seat"\npoint = { at = [8e-3, 0, 0] }\n'
        + TAG.format("air", '"bellows-air.stl"') + WALL + TAG.format("skin", '"bellows.stl"'),
        ["air"], 5e3, "",
    ),
    "finger": (
        ["finger.stl", "--split", "40"],
        EPSILON + '[[tag]]\nname = "seat"\npoint = { at = [-6e-3, 0, 0] }\n'
        '[[tag]]\nname = "air"\nbox = { min = [-2.5e-3, -4.5e-3, -1e-3], max = [6.5e-3, 4.5e-3, 54.5e-3] }\n'
        + WALL + TAG.format("skin", '"outer-*.stl"'),
        ["air"], 8e3, "",
    ),
    "defective": (
        ["defective.stl"],
        EPSILON + '[[tag]]\nname = "seat"\npoint = { at = [-9e-3, 0, 0] }\n'
        '[[tag]]\nname = "air"\nbox = { min = [-4.2e-3, -6.2e-3, -1e-3], max = [8.2e-3, 6.2e-3, 30.2e-3] }\n'
        + WALL
        + TAG.format("skin", '"outer.stl"'),
        ["air"], 8e3, "",
    ),
    "capsule": (
        ["capsule.step"],
        tags('"color-ff0000.stl"', {"air": '"color-0000ff.stl"'}, '"color-cccccc.stl"'),
        ["air"], 8e3, "",
    ),
    "pad": (
        ["pad.step"],
        tags('"mount.stl"', {"air": '"air.stl"'}, '["skin.stl", "bottom.stl"]'),
        ["air"], 5e3, "",
    ),
    "arm": (
        ["arm.step"],
        tags('"base.stl"', {f"ch{i}": f'"ch{i}.stl"' for i in (1, 2, 3)}, '"skin.stl"'),
        ["ch1", "ch2", "ch3"], 10e3, '\n[fitting]\nname = "tube-6x4"\n',
    ),
}


def write(folder, text_of_tags, chambers, pressure, fitting):
    folder.mkdir(parents=True, exist_ok=True)
    names = ", ".join(f'"{name}"' for name in chambers)
    (folder / "cad2fem.toml").write_text(
        '[tetmesh]\nmesher = "ftetwild"\nrelative_edge_length = 0.08\nrelative_envelope = 2e-3\n'
    )
    (folder / "tags.toml").write_text(text_of_tags)
    air = f'[[chamber]]\non = "{chambers[0]}"\npressure = {pressure}\n'
    rest = "".join(f'[[chamber]]\non = "{name}"\npressure = 0\n' for name in chambers[1:])
    (folder / "sim.toml").write_text(
        f'mesh = "build/tagged.msh"\nmaterial = "dragon-skin-10-medium"\n\n'
        f'[[fixed]]\non = "seat"\n\n{air}{rest}'
    )
    (folder / "mold.toml").write_text(MOLD.format(chambers=f"[{names}]") + fitting)


def write_design(folder, chambers):
    """The design, for the way in which the skin moves."""
    skin = json.loads((folder / "build/baseline/report.json").read_text())["tags"]["skin"]
    vector = skin["mean_displacement_vector"]
    length = sum(x * x for x in vector) ** 0.5
    (folder / "sim.design.toml").write_text(PROBE.format(axis=[x / length for x in vector]))
    names = ", ".join(f'"{name}"' for name in chambers)
    (folder / "design.toml").write_text(DESIGN.format(chambers=names, target=FACTOR * length, keep=KEEP.get(folder.name, "")))


def chain(folder, files, chambers):
    """Command by command; files lie in the folder above."""
    build = folder / "build"
    files = [str(folder.parent / "files" / f) if f.endswith((".stl", ".step")) else f for f in files]
    yield ["cad2fem", "import", *files, "-o", build / "model"]
    yield ["cad2fem", "tetmesh", build / "model/model.stl", "--config", folder / "cad2fem.toml", "-o", build / "volume.msh"]
    yield ["tagger", "tag", build / "volume.msh", "--config", folder / "tags.toml", "--patches", build / "model/patches", "-o", build / "tagged.msh"]
    yield ["solver", "simulate", folder / "sim.toml", "-o", build / "baseline"]
    write_design(folder, chambers)
    yield ["solver", "optimize", folder / "design.toml", "-o", build / "optimize"]
    designed = build / "optimize/design.msh"
    yield ["solver", "simulate", folder / "sim.design.toml", "--mesh", designed, "-o", build / "optimized"]
    yield ["fab", "mold", designed, "--config", folder / "mold.toml", "-o", build / "mold"]
    yield ["fab", "verify", build / "mold", "--simulation", build / "optimized"]
    pictures = build / "pictures"
    pictures.mkdir(parents=True, exist_ok=True)
    patches = sorted((build / "model/patches").glob("*.stl"))
    yield ["cad2fem", "picture", *patches, "--together", "--captions", ",".join(p.stem for p in patches), "--title", f"{folder.name}: patches", "-o", pictures / "model.png"]
    yield ["cad2fem", "picture", build / "baseline/result.vtu", "--color", "displacement", "--title", f"{folder.name}, inflated", "-o", pictures / "baseline.png"]
    yield ["cad2fem", "picture", build / "baseline/result.vtu", build / "optimized/result.vtu", "--color", "displacement", "--captions", "as it came,designed", "--title", f"{folder.name}, inflated", "-o", pictures / "optimized.png"]
    yield ["cad2fem", "report", build, "--title", folder.name, "-o", build / "report.html"]


def gained(folder):
    """How far the skin moved in its way before and after the design [mm], and what it was to be."""
    def report(run):
        return json.loads((folder / "build" / run / "report.json").read_text())
    before = sum(x * x for x in report("baseline")["tags"]["skin"]["mean_displacement_vector"]) ** 0.5
    return 1e3 * before, 1e3 * report("optimized")["probes"]["way"]["value"], 1e3 * FACTOR * before


def run(programs, folder, files, chambers):
    """Whether all went well, and the seconds of it."""
    start, log = time.time(), (folder / "log.txt").open("w")
    for command in chain(folder, files, chambers):
        command = [str(part) for part in command]
        began = time.time()
        print("  " + " ".join(command), flush=True)
        done = subprocess.run([programs / command[0], *command[1:]], stdout=log, stderr=log, check=False)
        print(f"    {time.time() - began:.1f} s", flush=True)
        if done.returncode != 0:
            log.flush()
            last = (folder / "log.txt").read_text().strip().splitlines()[-6:]
            print("    exit code %d:\n      %s" % (done.returncode, "\n      ".join(last)), flush=True)
            return False, time.time() - start
    return True, time.time() - start


def main():
    programs, top = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()
    chosen = sys.argv[3:] or list(BODIES)
    here = pathlib.Path(__file__).parent
    subprocess.run([sys.executable, here / "files.py", top / "files"], check=True, stdout=subprocess.DEVNULL)
    ends = {}
    for name in chosen:
        files, text_of_tags, chambers, pressure, fitting = BODIES[name]
        print(name, flush=True)
        write(top / name, text_of_tags, chambers, pressure, fitting)
        ends[name] = run(programs, top / name, files, chambers)
    print("\nbody        verified    minutes   the skin moves by [mm]")
    for name, (good, seconds) in ends.items():
        ways = "%.3f -> %.3f, wanted %.3f" % gained(top / name) if good else ""
        print(f"{name:<12}{'yes' if good else 'NO':<12}{seconds / 60:<10.1f}{ways}")
    sys.exit(0 if all(good for good, _ in ends.values()) else 1)


main()
