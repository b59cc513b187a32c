"""What a Newton iteration takes here, in FEniCSx and in CalculiX, one after the other on this machine.

usage: run.py SOLVER OUTPUT SCENE...

FEniCSx and CalculiX are those of Debian: `apt install python3-dolfinx-real calculix-ccx`. One that is not there is
left out, and the table says so. Each runs with its own threads; processor seconds are those of all of them.
"""

import json
import os
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

# The Python that Debian's packages are for.
PYTHON = "/usr/bin/python3"
# Runs of ours, of which the one with the median time counts.
RUNS = 3
# A law with the constants of the scenes and the volumetric term that CalculiX has.
THEIR_LAW = "material.kind=mooney-rivlin-quadratic"


def timed(command, folder, **environment):
    """What a command printed, its wall and its processor time [s]."""
    before, began = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    environment = {**os.environ, **environment}
    run = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)
    wall, after = time.perf_counter() - began, resource.getrusage(resource.RUSAGE_CHILDREN)
    if run.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}: {(run.stdout + run.stderr)[-2000:]}")
    used = [getattr(after, key) - getattr(before, key) for key in ("ru_utime", "ru_stime")]
    return run.stdout, wall, sum(used)


def puffer(solver, scene, folder):
    """Iterations, wall and processor time of the run with the median time."""
    runs = []
    for number in range(RUNS):
        output = folder / f"run{number}"
        command = [solver, "simulate", scene, "-o", output, "--final-only"]
        _, wall, processor = timed(command, folder)
        report = json.loads((output / "report.json").read_text())
        iterations = sum(step["newton_iterations"] for step in report["steps"])
        runs.append((wall, processor, iterations))
    wall, processor, iterations = sorted(runs)[RUNS // 2]
    return iterations, wall, processor


def fenicsx(scene, folder):
    """The same of FEniCSx; none where it is not installed."""
    if subprocess.run([PYTHON, "-c", "import dolfinx"], capture_output=True).returncode != 0:
        return None
    script = Path(__file__).with_name("fenicsx.py")
    # its compiled forms are in a cache after the first run, which is not counted
    timed([PYTHON, script, scene], folder)
    printed, wall, processor = timed([PYTHON, script, scene], folder)
    return json.loads(printed.splitlines()[-1])["iterations"], wall, processor


def calculix(solver, scene, folder):
    """The same of CalculiX; none where it is not installed."""
    if shutil.which("ccx") is None:
        return None
    timed([solver, "export", scene, "-o", "deck.inp", "--set", THEIR_LAW], folder)
    threads = str(os.cpu_count())
    _, wall, processor = timed(["ccx", "deck"], folder, OMP_NUM_THREADS=threads)
    lines = [line.split() for line in (folder / "deck.sta").read_text().splitlines()]
    iterations = sum(int(line[3]) for line in lines if line and line[0].isdigit())
    return iterations, wall, processor


def main():
    """Runs all scenes and prints the table."""
    solver, output, *scenes = (Path(argument).resolve() for argument in sys.argv[1:])
    heads = ("scene", "program", "Newton", "wall [s]", "processor [s]", "processor s/iteration", "times ours")
    rows = ["{:<10}{:<10}{:>8}{:>10}{:>15}{:>23}{:>12}".format(*heads)]
    for scene in scenes:
        ours = None
        peers = {
            "Puffer": lambda folder: puffer(solver, scene, folder),
            "FEniCSx": lambda folder: fenicsx(scene, folder),
            "CalculiX": lambda folder: calculix(solver, scene, folder),
        }
        for name, run in peers.items():
            print(f"{scene.parent.name}: {name}", file=sys.stderr)
            with tempfile.TemporaryDirectory() as folder:
                found = run(Path(folder))
            if found is None:
                rows.append(f"{scene.parent.name:<10}{name:<10}  SKIPPED: not installed")
                continue
            iterations, wall, processor = found
            each = processor / iterations
            ours = ours or each
            numbers = f"{iterations:>8}{wall:>10.1f}{processor:>15.1f}{each:>23.3f}{each / ours:>12.1f}"
            rows.append(f"{scene.parent.name:<10}{name:<10}{numbers}")
    table = "\n".join(rows) + "\n"
    print(table, end="")
    output.parent.mkdir(parents=True, exist_ok=True)
    output.write_text(table)


if __name__ == "__main__":
    main()
