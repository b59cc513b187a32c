"""Runs notebooks of the book: `notebooks.py [--nbclient] [--pictures FOLDER] [NAME ...]`, all of them without names.

The cells of code of each run one after the other in plain Python, in a folder of their own. With --nbclient a kernel of
Jupyter runs them, as a reader does. A notebook whose packages are not installed is skipped, with a line
`SKIPPED NAME: reason`. Where matplotlib alone is missing, nothing is drawn. Exit codes: 0 all ran or were skipped, 1 not.
"""

import argparse
import importlib.util
import json
import os
import re
import shutil
import sys
import tempfile
import time
import traceback
from pathlib import Path
from unittest import mock

FOLDER = Path(__file__).resolve().parents[2] / "pipelines/book/notebooks"


def cells(path):
    """The code of the cells of a notebook."""
    notebook = json.loads(path.read_text())
    return ["".join(cell["source"]) for cell in notebook["cells"] if cell["cell_type"] == "code"]


def missing(code):
    """Packages that some code imports and that are not installed."""
    names = set(re.findall(r"^(?:import|from) (\w+)", code, re.MULTILINE))
    own = {path.stem for path in FOLDER.glob("*.py")}
    return sorted(name for name in names - own - set(sys.modules) if importlib.util.find_spec(name) is None)


def without_pictures():
    """Puts something that draws nothing in the place of matplotlib."""
    print("matplotlib is not installed: nothing is drawn")
    sys.modules["matplotlib"] = sys.modules["matplotlib.pyplot"] = mock.MagicMock()


def run_plainly(path, pictures):
    """Runs the cells in this process."""
    names = {"__name__": "__main__"}
    for number, code in enumerate(cells(path)):
        exec(compile(code, f"{path.name}, cell {number + 1}", "exec"), names)
    if pictures and "plt" in names and names["plt"].get_fignums():
        names["plt"].savefig(pictures / f"{path.stem}.png", dpi=80)
    if "plt" in names:
        names["plt"].close("all")


def run_by_nbclient(path, _):
    """Runs the cells in a kernel of this Python."""
    import nbclient
    import nbformat

    nbclient.NotebookClient(nbformat.read(path, as_version=4), timeout=1200).execute()


def run_in_a_folder(path, how, pictures):
    """Runs a notebook in a folder that has the files beside it, and returns whether it ran to its end."""
    before, began = os.getcwd(), time.monotonic()
    with tempfile.TemporaryDirectory() as folder:
        for file in [*FOLDER.glob("*.py"), *FOLDER.glob("*.csv")]:
            shutil.copy(file, folder)
        os.chdir(folder)
        sys.path.insert(0, folder)
        try:
            how(path, pictures)
        except Exception:
            traceback.print_exc()
            return False
        finally:
            sys.path.remove(folder)
            os.chdir(before)
    print(f"{path.stem}: {time.monotonic() - began:.1f} s")
    return True


def main():
    """Runs the notebooks that were asked for."""
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("names", nargs="*")
    arguments.add_argument("--nbclient", action="store_true")
    arguments.add_argument("--pictures", type=Path)
    given = arguments.parse_args()
    os.environ["MPLBACKEND"] = "Agg"
    sys.dont_write_bytecode = True
    paths = [FOLDER / f"{name}.ipynb" for name in given.names] or sorted(FOLDER.glob("*.ipynb"))
    how, good = (run_by_nbclient if given.nbclient else run_plainly), True
    if not given.nbclient and importlib.util.find_spec("matplotlib") is None:
        without_pictures()
    for path in paths:
        lacking = missing("\n".join(cells(path)))
        if lacking:
            print(f"SKIPPED {path.stem}: {', '.join(lacking)} not installed")
            continue
        good &= run_in_a_folder(path, how, given.pictures and given.pictures.resolve())
    return not good


if __name__ == "__main__":
    sys.exit(main())
