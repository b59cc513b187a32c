"""`sweep.html`: all cases on one page that asks no server for anything and runs only its own scripts."""

import base64
import hashlib
import json
import math
from pathlib import Path

import jinja2

from units import daily

HERE = Path(__file__).resolve().parent
# What pictures may take of the page [bytes]; of more there are some, evenly chosen.
PICTURES = 8_000_000
# Curves of at most so many cases, evenly chosen.
CURVES = 1000


def assemble(plan, cases, table):
    """The page of a table, a row of which is a case, in the same order."""
    library = text("vendor/echarts/echarts.min.js")
    script = text("web/page.js")
    # all that is filled in is text, but for what the page calls `safe`
    page = jinja2.Environment(autoescape=True, undefined=jinja2.StrictUndefined).from_string(text("web/page.html"))
    return page.render(
        policy=policy([library, script]), title=plan["title"], style=text("web/page.css"),
        licence=text("vendor/echarts/LICENSE"), notice=text("vendor/echarts/NOTICE"),
        data=script_data(data(plan, cases, table)), library=library, main=script)


def text(name):
    return (HERE / name).read_text(encoding="utf-8")


def policy(scripts):
    """Only these scripts run; ECharts styles its elements itself."""
    hashes = [base64.b64encode(hashlib.sha256(script.encode()).digest()).decode() for script in scripts]
    sources = " ".join(f"'sha256-{h}'" for h in hashes)
    return f"default-src 'none'; script-src {sources}; style-src 'unsafe-inline'; img-src data:; " \
           "base-uri 'none'; form-action 'none'"


def script_data(value):
    # only texts have such a character; U+2028 and its like are sound in JSON
    return json.dumps(value, ensure_ascii=False, allow_nan=False).replace("<", "\\u003c")


def data(plan, cases, table):
    known = {name: unit for case in cases for name, unit in case.units.items()}
    known |= {p["name"]: p["unit"] for p in plan["parameters"] if p.get("unit")}
    shown_in = {name: daily(name, known) for name in table.columns}
    factors = [shown_in[name][0] for name in table.columns]
    rows = [[plain(value, factor) for value, factor in zip(row, factors)] for row in table.itertuples(index=False)]
    pictures = [(i, picture) for i, picture in enumerate(case.picture() for case in cases) if picture]
    curves = [(i, case.curves) for i, case in enumerate(cases) if case.curves]
    size = sum(len(picture) for _, picture in pictures) * 4 / 3
    shown = some(pictures, math.floor(len(pictures) * min(1, PICTURES / max(size, 1))))
    return {
        "parameters": plan["parameters"],
        "columns": list(table.columns),
        "units": {name: unit for name, (_, unit) in shown_in.items() if unit},
        "curve_units": {name: daily(name, known)[1] for _, curve in curves for name in curve},
        "rows": rows,
        "pictures": [[i, base64.b64encode(picture).decode()] for i, picture in shown],
        "pictures_of": len(pictures),
        "curves": [[i, {name: [rounded(v * daily(name, known)[0]) for v in values] for name, values in curve.items()}]
                   for i, curve in some(curves, CURVES)],
    }


def some(items, most):
    """At most so many, evenly chosen."""
    return items if len(items) <= most else [items[i * len(items) // most] for i in range(most)]


def plain(value, factor):
    if hasattr(value, "item"):
        value = value.item()
    if isinstance(value, float) or factor != 1 and isinstance(value, int) and not isinstance(value, bool):
        return rounded(value * factor)
    return value if isinstance(value, (bool, int, str)) else None


def rounded(value):
    """Seven digits are more than a picture shows; what is no number is missing."""
    return float(f"{value:.7g}") if math.isfinite(value) else None
