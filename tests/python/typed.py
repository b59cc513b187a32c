"""Type checkers on the package, on the examples of the book, and on wrong ones: `typed.py`, in a folder with the package.

mypy --strict and pyright have to pass on the first two, and to find each wrong line. Where a checker, or node, which pyright
needs, is not there, a line `SKIPPED NAME: reason` says so. Exit codes: 0 all is as it has to be, 1 not.
"""

import importlib.util
import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

BOOK = Path(__file__).resolve().parents[2] / "pipelines/book"

BEGIN = """\
import softpuffer as sp
body = sp.Body.read("tagged.msh")
scene = sp.Scene(body, material="ecoflex-00-30")
run = scene.simulate()
"""

WRONG = """\
sp.Scene(body, materail="ecoflex-00-30")
sp.Scene(body, material="ecoflex-00-30", gravty=[0, 0, -9.81])
sp.Scene("tagged.msh", material="ecoflex-00-30")
sp.Scene(body, material="ecoflex-00-30", degree="2")
scene.simulate(unusable="ignore")
scene.simulat()
scene["chamber.cavity.pressure"] = "5e3"
scene.set("chamber.cavity.pressure")
scene.scenario(modulos=0.9)
run.gradient(3)
run.gradient("rise", 3)
run.gradient("rise")[1]["shape"].shapes
run.probe(1)
run.displacement = body.vertices
len(run.probe("rise"))
sp.simulate_all(scene)
sp.response(scene, ["chamber.cavity.pressure"])
sp.torch.simulate_batch(scene, unusable=True)
sp.Bodi
"""


def examples():
    """The pieces of Python of the book's chapter, in one file."""
    page = (BOOK / "python.md").read_text()
    return "\n".join(part.split("```")[0] for part in page.split("```python\n")[1:])


def of_mypy(files):
    """Errors by file and line, as mypy finds them."""
    command = [sys.executable, "-m", "mypy", "--strict", "--ignore-missing-imports", "--cache-dir=mypy", *files]
    said = subprocess.run(command, capture_output=True, text=True)
    if said.returncode not in (0, 1):
        sys.exit(f"mypy: {said.stdout}{said.stderr}")
    found = re.findall(r"^(.*?):(\d+): error: (.*)$", said.stdout, re.MULTILINE)
    return [(file, int(line), what) for file, line, what in found]


def of_pyright(files):
    """Errors by file and line, as pyright finds them; packages that are not installed are none."""
    command = [sys.executable, "-m", "pyright", "--pythonpath", sys.executable, "--outputjson", *files]
    said = subprocess.run(command, capture_output=True, text=True)
    if said.returncode not in (0, 1):
        sys.exit(f"pyright: {said.stdout}{said.stderr}")
    errors = [d for d in json.loads(said.stdout)["generalDiagnostics"] if d["severity"] == "error"]
    place = lambda d: (str(Path(d["file"]).relative_to(Path.cwd())), d["range"]["start"]["line"] + 1, d["message"])
    return [place(d) for d in errors if d.get("rule") != "reportMissingImports"]


def main():
    """Runs both checkers."""
    Path("examples.py").write_text(examples())
    Path("wrong.py").write_text(BEGIN + WRONG)
    first = len(BEGIN.splitlines()) + 1
    lines = {first + k for k in range(len(WRONG.splitlines()))}
    good = True
    for name, check in (("mypy", of_mypy), ("pyright", of_pyright)):
        if importlib.util.find_spec(name) is None:
            print(f"SKIPPED {name}: it is not installed")
            continue
        if name == "pyright" and shutil.which("node") is None:
            print(f"SKIPPED {name}: it needs node")
            continue
        found = check(["softpuffer", "examples.py", "wrong.py"])
        # of a module over a package that is not installed nothing is known
        unknown = {f"softpuffer/{own}.py" for own in ("jax", "torch") if importlib.util.find_spec(own) is None}
        unwanted = [error for error in found if error[0] not in {"wrong.py", *unknown}]
        missed = lines - {line for file, line, _ in found if file == "wrong.py"}
        for error in unwanted:
            print(f"{name}: {error}")
        for line in sorted(missed):
            print(f"{name} finds nothing wrong in: {WRONG.splitlines()[line - first]}")
        good &= not unwanted and not missed
        print(f"{name}: {len(found)} errors, of which {len(unwanted)} are unwanted, and {len(missed)} are missing")
    return not good


if __name__ == "__main__":
    sys.exit(main())
