"""One page that shows what was made of many bodies: `gallery.py OUTPUT NAME=SOURCES=RESULTS ...`.

SOURCES is the folder that people wrote, RESULTS the one with the `report.html` that make left. The folder OUTPUT gets
`index.html`, the page and a picture of each body, so that it can be moved or put on a server. A body without a page is
named on it, with the command that makes it. Exit codes: 0 written, 1 no body has a page, 2 wrong arguments.
"""

import html
import json
import os
import re
import shutil
import sys
from pathlib import Path

#: The first of these that is there shows the body.
PICTURES = ("optimized", "film-optimized", "gripping-optimized", "inflated", "pressed", "baseline", "study", "mesh")
#: The first of these simulations that is there gives the numbers.
RUNS = ("optimized", "reached", "cylinder/optimized", "baseline")

STYLE = """
:root { color-scheme: light dark; --card: light-dark(#fff, #22252a); --line: light-dark(#d5d9de, #3a3f46);
  --dim: light-dark(#5b636d, #a3abb5); --back: light-dark(#f4f5f7, #17191c); }
body { font: 15px/1.45 system-ui, sans-serif; margin: 2rem auto; max-width: 1240px; padding: 0 1rem; background: var(--back); }
main { display: grid; gap: 1.2rem; grid-template-columns: repeat(auto-fill, minmax(19rem, 1fr)); }
article { background: var(--card); border: 1px solid var(--line); border-radius: 8px; overflow: hidden; display: flex;
  flex-direction: column; }
article > a { display: block; border-bottom: 1px solid var(--line); }
article img { display: block; width: 100%; aspect-ratio: 16 / 9; object-fit: cover; }
article > div { padding: .8rem 1rem 1rem; }
h1, h2 { margin: 0 0 .4rem; } h2 { font-size: 1.1rem; } main + h2 { margin-top: 1.6rem; } p { margin: 0 0 .6rem; } .dim { color: var(--dim); }
dl { display: grid; grid-template-columns: auto 1fr; gap: .1rem .8rem; margin: 0; font-size: .9rem; }
dt { color: var(--dim); } dd { margin: 0; }
"""


def read(path):
    """The content of a file of JSON; nothing where it is not there or is none."""
    try:
        return json.loads(path.read_text())
    except (OSError, ValueError):
        return {}


def first_sentence(sources):
    """What the README of a body begins with."""
    try:
        text = (sources / "README.md").read_text()
    except OSError:
        return ""
    paragraphs = [part for part in text.split("\n\n") if part.strip() and part.lstrip()[0] not in "#!|`<"]
    words = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", " ".join(paragraphs[0].split())) if paragraphs else ""
    return re.split(r"(?<!al)[.:] (?=[A-Z])", words.replace("`", ""))[0].rstrip(".") + "." if words else ""


def of_simulation(report):
    """Rows on a simulated state."""
    tags = report.get("tags", {}).values()
    moved = max((tag.get("max_displacement") or 0 for tag in tags), default=0)
    chambers = report.get("chambers", {})
    if chambers:
        highest = max(chamber["pressure"] for chamber in chambers.values())
        yield "pressure", f"{highest / 1e3:.3g} kPa" + (f" at most in {len(chambers)} chambers" * (len(chambers) > 1))
    if moved:
        yield "moves by", f"{moved * 1e3:.3g} mm"
    if (report.get("stretch_range") or {}).get("largest"):
        yield "largest stretch", f"{report['stretch_range']['largest']:.2f}"
    for name, probe in list(report.get("probes", {}).items())[:2]:
        if isinstance(probe.get("value"), (int, float)):
            yield name, in_units(probe["value"], probe["unit"])
    if report.get("tets"):
        yield "mesh", f"{report['tets']:,} tetrahedra".replace(",", " ")
    if report.get("wall_s"):
        yield "simulated in", f"{report['wall_s']:.3g} s"


def in_units(value, unit):
    """A number as people say it."""
    factor, shown = {"m": (1e3, "mm"), "m³": (1e6, "mL"), "Pa": (1e-3, "kPa")}.get(unit, (1, unit))
    return f"{value * factor:.3g}°" if shown == "deg" else f"{value * factor:.3g} {shown}"


def numbers(results):
    """Rows on all that is there of a body."""
    runs = [read(results / name / "report.json") for name in RUNS]
    yield from of_simulation(next((report for report in runs if report.get("usable")), {}))
    design = read(results / "optimize/report.json")
    if design.get("objective_before"):
        yield "objective", f"{design['objective_before']:.3g} → {design['objective_after']:.3g}"
    molds = [read(path) for path in sorted(results.glob("mold/**/mold.json"))]
    parts = [part for mold in molds for part in mold.get("parts", [])]
    checks = results / "mold.checks.txt"
    if parts and checks.is_file():
        lines = checks.read_text().splitlines()
        failed = sum(line.lower().startswith("fail") for line in lines)
        yield "mold", f"{len(parts)} parts, {len(lines)} checks, {failed or 'none'} failed"


def put(source, place):
    """A file under another name, without a copy where the disk allows it."""
    place.unlink(missing_ok=True)
    try:
        os.link(source, place)
    except OSError:
        shutil.copy(source, place)


def card(name, sources, results, output):
    """The part of the page on a body that was made."""
    put(results / "report.html", output / f"{name}.html")
    places = [folder / f"{kind}.png" for kind in PICTURES for folder in (results / "pictures", sources)]
    picture = next((path for path in places if path.is_file()), None)
    image = ""
    if picture:
        put(picture, output / f"{name}.png")
        image = f'<a href="{name}.html"><img src="{name}.png" alt="{name}" loading="lazy"></a>'
    rows = "".join(f"<dt>{html.escape(what)}</dt><dd>{html.escape(value)}</dd>" for what, value in numbers(results))
    about = html.escape(first_sentence(sources))
    return (f'<article>{image}<div><h2><a href="{name}.html">{name}</a></h2><p>{about}</p><dl>{rows}</dl></div>'
            "</article>\n")


def page(cards, missing):
    """The whole page."""
    lacking = "".join(f"<li><b>{name}</b>: <code>{html.escape(command)}</code></li>" for name, command in missing)
    lacking = lacking and f"<h2>Not made yet</h2><ul>{lacking}</ul>"
    return (f'<!doctype html><html lang="en"><meta charset="utf-8"><title>Puffer: gallery</title>'
            f'<meta name="viewport" content="width=device-width, initial-scale=1"><style>{STYLE}</style>'
            f'<h1>Gallery</h1><p class="dim">{len(cards)} bodies, from models to molds. Each has a page on which you '
            f"turn, cut and inflate it.</p><main>{''.join(cards)}</main>{lacking}</html>\n")


def main(arguments):
    """Writes the gallery."""
    bodies = [argument.split("=") for argument in arguments[1:]]
    if not bodies or any(len(body) != 3 or not re.fullmatch(r"[\w.-]+", body[0]) for body in bodies):
        print(f"gallery: needed are OUTPUT NAME=SOURCES=RESULTS ..., found {arguments}", file=sys.stderr)
        return 2
    output, cards, missing = Path(arguments[0]), [], []
    output.mkdir(parents=True, exist_ok=True)
    for name, sources, results in bodies:
        if (Path(results) / "report.html").is_file():
            cards.append(card(name, Path(sources), Path(results), output))
        else:
            missing.append((name, f"make {name}" if sources.startswith("pipelines/") else f"make -C {sources}"))
            print(f"gallery: {name} is not made yet: {missing[-1][1]}")
    written = output / "index.html.new"
    written.write_text(page(cards, missing))
    written.replace(output / "index.html")
    print(f"gallery: open {output}/index.html: {len(cards)} bodies")
    return 0 if cards else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
