"""Bodies of others, from files to pages and verified molds: python run.py PROGRAMS FOLDER [BODY...]

Makes the files (files.py), then runs each body through the programs, and prints every command with its
seconds. Fetches nothing. `make foreign` runs it.
"""

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


def chain(folder, files):
    """Command by command; files lie in the folder above."""
    build = folder / "build"
    files = [str(folder.parent / "files" / f) if f.endswith((".stl", ".step")) else f for f in files]
    yield ["cad2fem", "import", *files, "-o", build / "model"]
    yield ["cad2fem", "tetmesh", build / "model/model.stl", "--config", folder / "cad2fem.toml", "-o", build / "volume.msh"]
    yield ["tagger", "tag", build / "volume.msh", "--config", folder / "tags.toml", "--patches", build / "model/patches", "-o", build / "tagged.msh"]
    yield ["solver", "simulate", folder / "sim.toml", "-o", build / "baseline"]
    yield ["fab", "mold", build / "tagged.msh", "--config", folder / "mold.toml", "-o", build / "mold"]
    yield ["fab", "verify", build / "mold", "--simulation", build / "baseline"]
    pictures = build / "pictures"
    pictures.mkdir(parents=True, exist_ok=True)
    patches = sorted((build / "model/patches").glob("*.stl"))
    yield ["cad2fem", "picture", *patches, "--together", "--captions", ",".join(p.stem for p in patches), "--title", f"{folder.name}: patches", "-o", pictures / "model.png"]
    yield ["cad2fem", "picture", build / "baseline/result.vtu", "--color", "displacement", "--title", f"{folder.name}, inflated", "-o", pictures / "baseline.png"]
    yield ["cad2fem", "report", build, "--title", folder.name, "-o", build / "report.html"]


def run(programs, folder, files):
    """Whether all went well, and the seconds of it."""
    start, log = time.time(), (folder / "log.txt").open("w")
    for command in chain(folder, files):
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
        ends[name] = run(programs, top / name, files)
    print("\nbody        verified    minutes")
    for name, (good, seconds) in ends.items():
        print(f"{name:<12}{'yes' if good else 'NO':<12}{seconds / 60:.1f}")
    sys.exit(0 if all(good for good, _ in ends.values()) else 1)


main()
