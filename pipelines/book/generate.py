"""Writes the chapters that the programs print, every key of every file and every function in Python.

`generate.py PROGRAMS FOLDER`: PROGRAMS has `cad2fem`, `tagger`, `solver` and `fab`; FOLDER gets the pages. `make book` runs
it; git ignores what it writes.
"""

import subprocess
import sys
from pathlib import Path

TOP = Path(__file__).resolve().parents[2]

#: Each page: its file, its title, its first lines, and the command that prints the rest.
PAGES = [
    ("keys-model", "model.toml",
     "A body of primitives, for `cad2fem model`. Lengths are in the `unit` of the file.",
     "cad2fem schema model --markdown"),
    ("keys-cad2fem", "cad2fem.toml",
     "How a surface is filled with tetrahedra, for `cad2fem tetmesh`. Lengths are metres, or parts of the diagonal of the body.",
     "cad2fem schema cad2fem --markdown"),
    ("keys-tags", "tags.toml",
     "Which part of the surface has which name, for `tagger tag`. The first selection that holds a facet wins.",
     "tagger schema tags --markdown"),
    ("keys-sim", "sim.toml",
     "A scene, for `solver simulate`. SI units; paths are relative to the file. Where a number may change over time it is an "
     "expression of `t`, or a table `{ t = [...], value = [...] }`.",
     "solver schema sim --markdown"),
    ("keys-numbers", "Numbers of a scene",
     "The paths of numbers that may be set, calibrated, uncertain, designed and checked: see [Scenes](scenes.md#numbers).",
     "solver list --numbers"),
    ("keys-design", "design.toml",
     "A design problem, for `solver optimize`, `check` and `gradient`. The sum of all objectives is minimised; a weight is in "
     "the inverse of the unit of its objective.",
     "solver schema design --markdown"),
    ("keys-mold", "mold.toml",
     "How a body is cast, for `fab`. Lengths are metres. Every key has a default.",
     "fab schema mold --markdown"),
    ("keys-sweep", "sweep.toml",
     "Many cases of a body, for `make sweep`: see [Many cases, here or on a cluster](sweep.md).",
     "pipelines/sweep/schema.py --markdown"),
    ("keys-calibrate", "calibrate.toml",
     "What is sought and from which measurements, for `solver calibrate`: see [Calibrate](calibrate.md).",
     "solver schema calibrate --markdown"),
    ("keys-validation", "validation.toml",
     "Simulations beside measured tables, for `solver validate`: see [Calibrate](calibrate.md).",
     "solver schema validation --markdown"),
    ("keys-report", "report.json",
     "What `solver simulate` writes. All quantities are in SI units. A run without an equilibrium has `reason` and `failure` "
     "in place of the keys from the last state. A number that is not finite is `null`.",
     "solver schema report --markdown"),
    ("keys-optimization", "report.json of a design",
     "What `solver optimize` writes at its end. All quantities are in SI units. Where the body at the start of a level has no "
     "equilibrium, there are `level`, `reason` and `failure` in place of the design. A number that is not finite is `null`.",
     "solver schema optimization --markdown"),
    ("keys-history", "history.jsonl",
     "What `solver optimize` writes while it runs: a line for the start of each level, and one for each accepted iteration. "
     "All quantities are in SI units. A number that is not finite is `null`.",
     "solver schema history --markdown"),
    ("keys-mold-report", "mold.json",
     "What `fab mold` writes beside the parts of a mold, for the person who casts and for `fab verify`. Its lengths are "
     "millimetres, except those of `casting`, which are the keys of `mold.toml`.",
     "fab schema mold-report --markdown"),
    ("python-api", "Every function in Python",
     "[In Python](python.md) shows how to use the package, and [notebooks](notebooks.md) show whole tasks. Here is every public "
     "function, with `sp` for `import softpuffer as sp`. Lengths are metres and pressures are pascals: SI units throughout.\n\n"
     "The solver raises two errors. `sp.InputError`, a `ValueError`, has the message of the programs on what is wrong. "
     "`sp.NoEquilibrium`, a `RuntimeError`, says what is known where a body has no equilibrium. `sp.__version__` is the "
     "version.",
     "solver/python/api.py"),
]


def printed(command, programs):
    """What a program, or a script of the checkout, prints."""
    name, *arguments = command.split()
    run = [sys.executable, "-B", TOP / name] if name.endswith(".py") else [programs / name]
    text = subprocess.run([*run, *arguments], stdout=subprocess.PIPE, check=True, encoding="utf-8").stdout
    is_markdown = name.endswith(".py") or "--markdown" in arguments
    return text if is_markdown else f"```text\n{text}```\n"


def main():
    """Writes all pages."""
    programs, folder = (Path(argument).resolve() for argument in sys.argv[1:])
    for name, title, begins, command in PAGES:
        text = f"# {title}\n\n{begins}\n\n{printed(command, programs)}"
        (folder / f"{name}.md").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
