"""All cases as one table, `table.csv` and `table.parquet`, and `sweep.html`: `table.py FOLDER`.

A row is a case, whether it went well or not; a column a parameter or a number of the report.
"""

import json
import sys
from pathlib import Path

import pandas

import page
from files import Refused, is_file, printable, replace

# What a report has for every name, as columns `chambers.cavity.volume` and so on.
NAMED = {
    "probes": ("value",),
    "chambers": ("pressure", "volume", "volume_rest"),
    "tags": ("max_displacement", "mean_displacement"),
    "energies": None,
    "terms": None,
}
# Numbers of a report that have no name.
SINGLE = ("objective", "iterations", "dofs", "tets", "newton_iterations", "wall_s", "peak_rss_mb", "tolerance_met")


def main(folder):
    plan = json.loads((folder / "plan.json").read_text())
    cases = [Case(folder, plan, case) for case in plan["cases"]]
    table = pandas.DataFrame([case.row() for case in cases])
    # Parquet has one type for a column
    for name in table.columns[table.dtypes == object]:
        there = table[name].dropna()
        if there.map(lambda value: isinstance(value, bool)).all():
            table[name] = table[name].astype("boolean")
        elif not there.map(lambda value: isinstance(value, str)).all():
            table[name] = table[name].map(str, na_action="ignore")
    html = page.assemble(plan, cases, table).encode(errors="replace")
    texts = [name for name in table.columns if not pandas.api.types.is_numeric_dtype(table[name])]
    plain = table.assign(**{name: table[name].map(no_formula, na_action="ignore") for name in texts})
    plain = plain.rename(columns=no_formula)
    replace(folder / "table.csv", lambda file: plain.to_csv(file, index=False))
    replace(folder / "table.parquet", lambda file: table.to_parquet(file, index=False))
    replace(folder / "sweep.html", lambda file: file.write(html))


def no_formula(cell):
    """A text that a spreadsheet does not take for a formula, as `solver` writes names: a space comes before it."""
    if not isinstance(cell, str) or not cell.startswith(("=", "+", "-", "@", "\t", "\r")):
        return cell
    try:
        float(cell)
    except ValueError:
        return f" {cell}"
    return cell


class Case:
    """What a case has left in its folder, which others may have sent."""

    def __init__(self, folder, plan, case):
        self.number, self.values = case["number"], case["values"]
        self.names = [p["name"] for p in plan["parameters"]]
        self.folder = folder / "cases" / case["key"]
        try:
            self.read()
        except (ValueError, ArithmeticError, KeyError, TypeError, AttributeError, RecursionError) as error:
            raise Refused(f"{self.folder}: not as the programs leave it ({type(error).__name__}: {error}): "
                          "remove this folder, and run the sweep again") from None

    def read(self):
        step = loaded((self.folder / "step.json").read_text())
        failure, self.status, self.seconds = step["failure"], str(step["status"]), number(step["seconds"])
        self.failure = f"{failure['stage']}: {failure['message']}" if failure else None
        report = self.folder / "run/report.json"
        report = loaded(report.read_text()) if self.failure is None and is_file(report) else {}
        self.numbers = numbers(report)
        probes = (report.get("probes") or {}).items()
        units = {f"probes.{name}": probe.get("unit") for name, probe in probes if isinstance(probe, dict)}
        self.units = {name: unit for name, unit in units.items() if isinstance(unit, str)}
        self.curves = self.read_curves(report)

    def row(self):
        row = {"case": self.number, **dict(zip(self.names, self.values)), "status": self.status}
        row |= {"failure": self.failure, "seconds": self.seconds, "folder": f"cases/{self.folder.name}"}
        # a parameter that is called as a number of the report keeps its column
        return row | {name: value for name, value in self.numbers.items() if name not in row}

    def picture(self):
        path = self.folder / "picture.png"
        return path.read_bytes() if self.failure is None and is_file(path) else None

    def read_curves(self, report):
        """Numbers of every load step, time step or accepted shape, by their names."""
        history = self.folder / "run/history.jsonl"
        if is_file(history):
            steps = [loaded(line) for line in history.read_text().splitlines()]
        else:
            steps = report.get("steps", [])
        rows = [step_numbers(step) for step in steps] if self.failure is None else []
        names = set.intersection(*map(set, rows)) if rows else set()
        return {name: [row[name] for row in rows] for name in sorted(names)}


def loaded(text):
    """A value of JSON whose texts can be written."""
    value = json.loads(text)
    json.dumps(value, ensure_ascii=False).encode()
    return value


def numbers(report):
    """The numbers of a report by their names, joined by dots."""
    found = {}
    for group, keys in NAMED.items():
        for name, entry in (report.get(group) or {}).items():
            if keys is None:
                found[f"{group}.{name}"] = entry
                continue
            for key in keys:
                column = f"{group}.{name}" if keys == ("value",) else f"{group}.{name}.{key}"
                found[column] = entry.get(key)
    found["stretch.largest"] = (report.get("stretch_range") or {}).get("largest")
    found |= {key: report.get(key) for key in SINGLE}
    return sound(found)


def step_numbers(step):
    found = {key: step.get(key) for key in ("load", "t", "iteration", "objective")}
    for name, chamber in (step.get("chambers") or {}).items():
        found |= {f"chambers.{name}.{key}": chamber.get(key) for key in ("pressure", "volume")}
    for name, probe in (step.get("probes") or {}).items():
        found[f"probes.{name}"] = probe.get("value") if isinstance(probe, dict) else probe
    for name, vector in (step.get("mean_displacement") or {}).items():
        if isinstance(vector, list):
            found[f"mean_displacement.{name}"] = sum(x * x for x in vector) ** 0.5
    return sound(found)


def number(value):
    """A number as a table has it; nothing if it is none."""
    if isinstance(value, bool):
        return value
    # whole numbers of more than 64 bits are none to Parquet
    return value if isinstance(value, float) or isinstance(value, int) and abs(value) < 2**63 else None


def sound(found):
    return {name: number(value) for name, value in found.items() if number(value) is not None}


if __name__ == "__main__":
    try:
        main(Path(sys.argv[1]))
    except Refused as refusal:
        sys.exit(printable(f"error: {refusal}"))
