"""Cases of a sweep: what `sweep.toml` says, checked, as the commands of every case."""

import difflib
import hashlib
import itertools
import json
import math
import random
import re
import tomllib
from dataclasses import dataclass, field
from pathlib import Path

from keys import KEYS, KINDS, PARAMETER_KEYS, PARAMETER_NEEDED

MOST_CASES = 1_000_000
# Longest wait for one case, if the file says nothing [min].
MINUTES = 24 * 60


class Refused(Exception):
    """A sweep that cannot be used: file, line, what was found, what to do."""


@dataclass
class Parameter:
    """One column of the table of cases."""
    name: str
    file: str
    keys: list
    unit: str
    table: dict
    varies: bool = field(default=True)


class Source:
    """The file, and errors with the place of a key in it."""

    def __init__(self, path):
        self.path = Path(path)
        try:
            self.text = self.path.read_text(encoding="utf-8")
            self.content = tomllib.loads(self.text)
        except (OSError, UnicodeDecodeError) as error:
            raise Refused(f"{path}: {getattr(error, 'strerror', None) or error}") from None
        except tomllib.TOMLDecodeError as error:
            place = re.search(r"\(at line (\d+), column (\d+)\)", str(error))
            # or "at end of document"
            line, column = map(int, place.groups()) if place else (max(len(self.text.splitlines()), 1), 1)
            raise Refused(self.shown(str(error).split(" (at ")[0], line, column)) from None

    def shown(self, what, line, column=1, width=1):
        text = self.text.splitlines()[line - 1] if line <= len(self.text.splitlines()) else ""
        margin = " " * len(str(line))
        mark = " " * (column - 1) + "^" * max(1, width)
        return f"{self.path}:{line}:{column}: {what}\n{margin} |\n{line} | {text}\n{margin} | {mark}"

    def refuse(self, what, table=None, key=None):
        """The error at a key, at the header of a parameter's table, or of the file as a whole."""
        inside = None
        for number, line in enumerate(self.text.splitlines(), 1):
            header = re.match(r"\s*\[+\s*(.+?)\s*\]+", line)
            name = header and re.sub(r"[\"' ]", "", header[1])
            if header:
                inside = name
                if table is not None and key is None and name == f"parameters.{table}":
                    raise Refused(self.shown(what, number, line.index("[") + 1, len(header[0].strip())))
            here = inside == f"parameters.{table}" if table is not None else inside is None
            found = key is not None and here and re.match(rf"\s*([\"']?{re.escape(key)}[\"']?)\s*[=.]", line)
            if found:
                raise Refused(self.shown(what, number, found.start(1) + 1, len(found[1])))
        raise Refused(f"{self.path}: {what}")

    def check_keys(self, table, known, name=None):
        """Unknown keys and wrong types."""
        for key, value in table.items():
            if key not in known:
                near = difflib.get_close_matches(key, known, 1)
                proposal = f"; did you mean `{near[0]}`?" if near else ""
                self.refuse(f"unknown key `{key}`{proposal} (known: {', '.join(known)})", name, key)
            kind, _ = known[key]
            if kind is not None and (not isinstance(value, kind) or isinstance(value, bool)):
                words = {str: "a text", int: "a whole number", list: "a list", dict: "tables [parameters.NAME]"}
                expected = words.get(kind, "a text or a list of texts" if kind == (str, list) else "a number")
                self.refuse(f"{key} = {value!r}: expected {expected}", name, key)


class Sweep:
    """A sweep that was read and checked."""

    def __init__(self, path):
        self.source = Source(path)
        self.folder = self.source.path.resolve().parent
        top = self.source.content
        self.source.check_keys(top, KEYS)
        self.kind = self.one_of("kind", KINDS)
        if "simulate" in top and "optimize" in top:
            self.source.refuse("`simulate` and `optimize`: a sweep runs one of them; take one out", key="optimize")
        self.optimizes = "optimize" in top
        self.scene = top.get("optimize", top.get("simulate", "sim.toml"))
        models = [top["model"]] if "model" in top else ["model.toml", "model.geo", "model.step"]
        self.model = next((m for m in models if (self.folder / m).is_file()), models[0])
        self.mesh = top.get("mesh", "cad2fem.toml")
        self.tags = top.get("tags", "tags.toml")
        self.files = {"model": self.model, "mesh": self.mesh, "tags": self.tags, "scene": self.scene}
        for role, file in self.files.items():
            key = {"scene": "optimize" if self.optimizes else "simulate"}.get(role, role)
            if not (self.folder / file).is_file():
                self.source.refuse(f"there is no {self.folder / file}: name the file with `{key} = \"…\"`", key=key)
        self.threads = self.positive("threads", 1)
        self.minutes = self.positive("minutes", MINUTES)
        self.memory_mb = self.positive("memory_mb", None)
        self.inside = top.get("inside", [])
        self.parameters = [self.parameter(*item) for item in top.get("parameters", {}).items()]
        if not any(p.varies for p in self.parameters):
            self.source.refuse("nothing varies: add [parameters.NAME] with `values`, or `from` and `to`")
        for key in ("cases", "seed"):
            if key in top and self.kind != "latin":
                self.source.refuse(f"`{key}` is for kind = \"latin\"; here kind = \"{self.kind}\"", key=key)

    def one_of(self, key, known):
        value = self.source.content.get(key)
        if value not in known:
            found = f"{key} = {value!r}" if value is not None else f"no `{key}`"
            self.source.refuse(f"{found}: expected one of {', '.join(map(repr, known))}", key=key)
        return value

    def positive(self, key, default):
        value = self.source.content.get(key, default)
        if value is not None and not (value > 0 and math.isfinite(value)):
            self.source.refuse(f"{key} = {value}: expected a positive number", key=key)
        return value

    def parameter(self, name, table):
        refuse = lambda what, key=None: self.source.refuse(f"[parameters.{name}]: {what}", name, key)
        if not isinstance(table, dict):
            self.source.refuse(f"parameters.{name} = {table!r}: expected a table [parameters.{name}]")
        self.source.check_keys(table, PARAMETER_KEYS, name)
        for key in PARAMETER_NEEDED:
            if key not in table:
                refuse(f"no `{key}`: it needs the `file` that the number is in, and in `set` its key there")
        if table["file"] not in self.files.values():
            refuse(f"file = {table['file']!r}: expected one of {', '.join(self.files.values())}", "file")
        keys = table["set"] if isinstance(table["set"], list) else [table["set"]]
        if not keys or not all(isinstance(k, str) and k and not re.search(r"[=\s]", k) for k in keys):
            refuse("`set` must be a key such as \"chamber.cavity.pressure\", or a list of such", "set")
        ways = [way for way in ("value", "values", "from") if way in table]
        if len(ways) != 1:
            found = " and ".join(f"`{w}`" for w in ways) or "none of them"
            refuse(f"expected one of `value`, `values`, and `from` with `to`; found {found}")
        parameter = Parameter(name, table["file"], keys, table.get("unit", ""), table, ways != ["value"])
        self.check_values(parameter, refuse)
        return parameter

    def check_values(self, parameter, refuse):
        table = parameter.table
        for value in table.get("values", [table["value"]] if "value" in table else []):
            number = isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)
            if not number and not isinstance(value, (str, bool)):
                refuse(f"{value!r}: expected finite numbers, texts or true and false", "values")
        if table.get("values") == []:
            refuse("`values` is empty", "values")
        if "from" not in table:
            for key in ("to", "count", "scale"):
                if key in table:
                    refuse(f"`{key}` goes with `from`", key)
            return
        if "to" not in table or not all(math.isfinite(table[k]) for k in ("from", "to")) or table["from"] == table.get("to"):
            refuse("`from` and `to` must be two different finite numbers", "from")
        if table.get("scale", "linear") not in ("linear", "log"):
            refuse(f"scale = {table['scale']!r}: expected 'linear' or 'log'", "scale")
        if table.get("scale") == "log" and min(table["from"], table["to"]) <= 0:
            refuse("scale = \"log\" needs positive `from` and `to`", "scale")
        if self.kind == "latin" and "count" in table:
            refuse("a Latin hypercube has `cases` values of each: take `count` out", "count")
        if self.kind != "latin" and table.get("count", 0) < 2:
            refuse("`from` and `to` need `count`, 2 or more, or kind = \"latin\"", "from")

    def rows(self):
        """Values of all parameters, a row for each case."""
        rows = {"grid": self.grid, "list": self.list, "latin": self.latin}[self.kind]()
        if len(rows) > MOST_CASES:
            self.source.refuse(f"{len(rows)} cases: at most {MOST_CASES}; take values out")
        return rows

    def grid(self):
        columns = [self.listed(p) for p in self.parameters]
        if math.prod(map(len, columns)) > MOST_CASES:
            self.source.refuse(f"{math.prod(map(len, columns))} cases: at most {MOST_CASES}; take values out")
        return [list(row) for row in itertools.product(*columns)]

    def list(self):
        columns = [self.listed(p) for p in self.parameters]
        count = max(len(c) for p, c in zip(self.parameters, columns) if p.varies)
        for p, column in zip(self.parameters, columns):
            if p.varies and len(column) != count:
                self.source.refuse(
                    f"[parameters.{p.name}]: {len(column)} values, others have {count}: in a list, the first values of "
                    "all make the first case, and so on", p.name)
        return [[c[i] if p.varies else c[0] for p, c in zip(self.parameters, columns)] for i in range(count)]

    def latin(self):
        """McKay, Beckman and Conover 1979: of n cases, each nth of a range has exactly one."""
        count = self.source.content.get("cases")
        if count is None or not 1 <= count <= MOST_CASES:
            found = "no `cases`" if count is None else f"cases = {count}"
            self.source.refuse(f"{found}: a Latin hypercube needs from 1 to {MOST_CASES}", key="cases")
        chance = random.Random(self.source.content.get("seed", 0))
        columns = []
        for p in self.parameters:
            places = [(i + chance.random()) / count for i in range(count)]
            chance.shuffle(places)
            columns.append([at(p, place) for place in places])
        return [list(row) for row in zip(*columns)]

    def listed(self, p):
        table = p.table
        if "from" in table:
            return [between(table, i / (table["count"] - 1)) for i in range(table["count"])]
        return table.get("values", [table.get("value")])


def at(parameter, place):
    """The value at a place in [0, 1) of what a parameter may be."""
    table = parameter.table
    if "from" in table:
        return between(table, place)
    values = table.get("values", [table.get("value")])
    return values[int(place * len(values))]


def between(table, place):
    """Rounded to nine digits, so that tables and command lines can be read."""
    low, high = table["from"], table["to"]
    value = low * (high / low) ** place if table.get("scale") == "log" else low + place * (high - low)
    return float(f"{value:.9g}")


def key_of(*parts):
    """What names the folder of a body or case: the same settings, the same folder."""
    return hashlib.sha256(json.dumps(parts, ensure_ascii=False).encode()).hexdigest()[:12]
