"""All cases as one table, `table.csv` and `table.parquet`, and `sweep.html`: `table.py FOLDER`.

A row is a case, whether it went well or not; a column a parameter or a number of the report.
"""

import json
import sys
from pathlib import Path

import pandas

import page

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
    replace(folder / "table.csv", lambda path: table.to_csv(path, index=False))
    replace(folder / "table.parquet", lambda path: table.to_parquet(path, index=False))
    replace(folder / "sweep.html", lambda path: path.write_text(page.assemble(plan, cases, table), encoding="utf-8"))


def replace(path, write):
    partial = path.with_name(path.name + ".partial")
    write(partial)
    partial.replace(path)


class Case:
    """What a case has left in its folder."""

    def __init__(self, folder, plan, case):
        self.number, self.values = case["number"], case["values"]
        self.names = [p["name"] for p in plan["parameters"]]
        self.folder = folder / "cases" / case["key"]
        self.step = json.loads((self.folder / "step.json").read_text())
        self.failure = self.step["failure"]
        report = self.folder / "run/report.json"
        self.report = json.loads(report.read_text()) if self.failure is None and report.is_file() else {}

    def row(self):
        row = {"case": self.number, **dict(zip(self.names, self.values)), "status": self.step["status"]}
        row["failure"] = f"{self.failure['stage']}: {self.failure['message']}" if self.failure else None
        row |= {"seconds": self.step["seconds"], "folder": f"cases/{self.folder.name}"}
        # a parameter that is called as a number of the report keeps its column
        return row | {name: value for name, value in numbers(self.report).items() if name not in row}

    def picture(self):
        path = self.folder / "picture.png"
        return path.read_bytes() if self.failure is None and path.is_file() else None

    def curves(self):
        """Numbers of every load step, time step or accepted shape, by their names."""
        history = self.folder / "run/history.jsonl"
        if history.is_file():
            steps = [json.loads(line) for line in history.read_text().splitlines()]
        else:
            steps = self.report.get("steps", [])
        rows = [step_numbers(step) for step in steps] if self.failure is None else []
        names = set.intersection(*map(set, rows)) if rows else set()
        return {name: [row[name] for row in rows] for name in sorted(names)}


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
    return {name: value for name, value in found.items() if isinstance(value, (int, float))}


def step_numbers(step):
    found = {key: step.get(key) for key in ("load", "t", "iteration", "objective")}
    for name, chamber in (step.get("chambers") or {}).items():
        found |= {f"chambers.{name}.{key}": chamber.get(key) for key in ("pressure", "volume")}
    for name, probe in (step.get("probes") or {}).items():
        found[f"probes.{name}"] = probe.get("value") if isinstance(probe, dict) else probe
    for name, vector in (step.get("mean_displacement") or {}).items():
        if isinstance(vector, list):
            found[f"mean_displacement.{name}"] = sum(x * x for x in vector) ** 0.5
    return {name: value for name, value in found.items() if isinstance(value, (int, float))}


if __name__ == "__main__":
    main(Path(sys.argv[1]))
