"""Cases of a sweep: what `sweep.toml` says, checked, as the commands of every case."""

import difflib
import hashlib
import itertools
import json
import math
import random
import re
import reprlib
import shlex
import tomllib
import unicodedata
from dataclasses import dataclass, field
from pathlib import Path

from files import LINE, Refused, is_file, parsed, read
from keys import COLUMNS, KEYS, KINDS, LOOKS, PARAMETER_KEYS, PARAMETER_NEEDED

MOST_CASES = 1_000_000
# Most values of all parameters in all cases.
MOST_VALUES = 10_000_000
PICTURE = "--color displacement --no-ground"
# Longest wait for one case, if the file says nothing [min].
MINUTES = 24 * 60
# Most that a case may ask for: cores, minutes (20 years), MB.
MOST = {"threads": 1024, "minutes": 1e7, "memory_mb": 1e9}


def shown(value):
    """A value in a message, which is short whatever the value is."""
    short = reprlib.Repr()
    short.maxstring = short.maxother = 100
    return short.repr(value)


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
        self.text = read(self.path)
        self.lines = self.text.split("\n")
        try:
            self.content = parsed(self.path, self.text)
        except tomllib.TOMLDecodeError as error:
            place = re.search(r"\(at line (\d+), column (\d+)\)", str(error))
            # or "at end of document"
            line, column = map(int, place.groups()) if place else (len(self.lines), 1)
            raise Refused(self.excerpt(str(error).split(" (at ")[0], line, column)) from None
        self.check_content()

    def check_content(self):
        """Numbers that the programs can read, and texts that command lines can hold."""
        rest = [((), self.content)]
        while rest:
            place, value = rest.pop()
            if isinstance(value, dict):
                rest += [(place + (key,), v) for key, v in value.items()] + [(place + (key,), key) for key in value]
            elif isinstance(value, list):
                rest += [(place, v) for v in value]
            elif type(value) is int and not -2**63 <= value < 2**63:
                self.refuse_at(place, "a whole number of more than 64 bits")
            elif isinstance(value, float) and not math.isfinite(value):
                self.refuse_at(place, f"{value}: expected finite numbers")
            elif isinstance(value, str) and any(unicodedata.category(c) == "Cc" for c in value):
                self.refuse_at(place, f"{shown(value)}: no text or name here may have control characters")

    def refuse_at(self, place, what):
        of_parameter = place[0] == "parameters" and len(place) > 2
        self.refuse(what, *(place[1:3] if of_parameter else (None, place[0])))

    def excerpt(self, what, line, column=1, width=1):
        text = self.lines[line - 1].rstrip("\r") if line <= len(self.lines) else ""
        margin = " " * len(str(line))
        mark = " " * (column - 1) + "^" * max(1, width) if column + width <= LINE else ""
        return f"{self.path}:{line}:{column}: {what}\n{margin} |\n{line} | {text}\n{margin} | {mark}"

    def refuse(self, what, table=None, key=None):
        """The error at a key, at the header of a parameter's table, or of the file as a whole."""
        inside, wanted = None, key is not None and re.compile(rf"\s*([\"']?{re.escape(key)}[\"']?)\s*[=.]")
        for number, line in enumerate(self.lines, 1):
            # the place of a key in a longer line is not worth the time
            header = len(line) <= LINE and re.match(r"\s*\[+\s*(.+?)\s*\]+", line)
            name = header and re.sub(r"[\"' ]", "", header[1])
            if header:
                inside = name
                if table is not None and key is None and name == f"parameters.{table}":
                    raise Refused(self.excerpt(what, number, line.index("[") + 1, len(header[0].strip())))
            here = inside == f"parameters.{table}" if table is not None else inside is None
            found = wanted and here and wanted.match(line)
            if found:
                raise Refused(self.excerpt(what, number, found.start(1) + 1, len(found[1])))
        raise Refused(f"{self.path}: {what}")

    def check_keys(self, table, known, name=None):
        """Unknown keys and wrong types."""
        for key, value in table.items():
            if key not in known:
                near = difflib.get_close_matches(key, known, 1)
                proposal = f"; did you mean `{near[0]}`?" if near else ""
                self.refuse(f"unknown key `{key[:LINE]}`{proposal} (known: {', '.join(known)})", name, key)
            kind, _ = known[key]
            if kind is not None and (not isinstance(value, kind) or isinstance(value, bool)):
                words = {str: "a text", int: "a whole number", list: "a list", dict: "tables [parameters.NAME]"}
                expected = words.get(kind, "a text or a list of texts" if kind == (str, list) else "a number")
                self.refuse(f"{key} = {shown(value)}: expected {expected}", name, key)


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
        self.model = next((m for m in models if is_file(self.folder / m)), models[0])
        self.mesh = top.get("mesh", "cad2fem.toml")
        self.tags = top.get("tags", "tags.toml")
        self.files = {"model": self.model, "mesh": self.mesh, "tags": self.tags, "scene": self.scene}
        for role, file in self.files.items():
            key = {"scene": "optimize" if self.optimizes else "simulate"}.get(role, role)
            if not is_file(self.folder / file):
                self.source.refuse(f"there is no {self.folder / file}: name the file with `{key} = \"…\"`", key=key)
        self.threads = self.positive("threads", 1)
        self.minutes = self.positive("minutes", MINUTES)
        self.memory_mb = self.positive("memory_mb", None)
        self.inside = self.texts("inside", r"[^/]+", "names of patches")
        self.body = "".join(self.texts("body", r"[^=/]+", "the name of a body"))
        self.looks = self.picture()
        self.parameters = [self.parameter(*item) for item in top.get("parameters", {}).items()]
        if not any(p.varies for p in self.parameters):
            self.source.refuse("nothing varies: add [parameters.NAME] with `values`, or `from` and `to`")
        self.check_keys_differ()
        for key in ("cases", "seed"):
            if key in top and self.kind != "latin":
                self.source.refuse(f"`{key}` is for kind = \"latin\"; here kind = \"{self.kind}\"", key=key)

    def check_keys_differ(self):
        by = {}
        for p in self.parameters:
            for key in p.keys:
                if (p.file, key) in by:
                    self.source.refuse(f"{shown(key)} of {p.file} is set twice, by [parameters.{by[p.file, key]}]", p.name)
                by[p.file, key] = p.name

    def one_of(self, key, known):
        value = self.source.content.get(key)
        if value not in known:
            found = f"{key} = {shown(value)}" if value is not None else f"no `{key}`"
            self.source.refuse(f"{found}: expected one of {', '.join(map(repr, known))}", key=key)
        return value

    def positive(self, key, default):
        value = self.source.content.get(key, default)
        if value is not None and not 0 < value <= MOST[key]:
            self.source.refuse(f"{key} = {value}: expected a positive number, at most {MOST[key]:g}", key=key)
        return value

    def texts(self, key, pattern, what):
        """The texts of a key, one or a list of them."""
        value = self.source.content.get(key, [])
        texts = value if isinstance(value, list) else [value]
        if not all(isinstance(text, str) and re.fullmatch(pattern, text) for text in texts):
            self.source.refuse(f"{key} = {shown(value)}: expected {what}", key=key)
        return texts

    def picture(self):
        """The options for pictures: how they look, no files."""
        text = self.source.content.get("picture", PICTURE)
        try:
            looks = shlex.split(text)
        except ValueError as error:
            self.source.refuse(f"picture = {shown(text)}: {str(error).lower()}", key="picture")
        after = None
        for option in looks:
            name, *value = option.split("=", 1)
            if after is None and name not in LOOKS:
                self.source.refuse(f"picture: {shown(option)}: expected options of {', '.join(LOOKS)}", key="picture")
            after = None if after or value or not LOOKS[name] else name
        return looks

    def parameter(self, name, table):
        refuse = lambda what, key=None: self.source.refuse(f"[parameters.{name}]: {what}", name, key)
        if not isinstance(table, dict):
            self.source.refuse(f"parameters.{name} = {shown(table)}: expected a table [parameters.{name}]")
        if name in COLUMNS:
            refuse(f"the table of cases has a column {name} of its own: give the parameter another name")
        self.source.check_keys(table, PARAMETER_KEYS, name)
        for key in PARAMETER_NEEDED:
            if key not in table:
                refuse(f"no `{key}`: it needs the `file` that the number is in, and in `set` its key there")
        if table["file"] not in self.files.values():
            refuse(f"file = {shown(table['file'])}: expected one of {', '.join(self.files.values())}", "file")
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
            if not isinstance(value, (int, float, str, bool)):
                refuse(f"{shown(value)}: expected finite numbers, texts or true and false", "values")
        if table.get("values") == []:
            refuse("`values` is empty", "values")
        if "from" not in table:
            for key in ("to", "count", "scale"):
                if key in table:
                    refuse(f"`{key}` goes with `from`", key)
            return
        if "to" not in table or table["from"] == table["to"] or not math.isfinite(table["to"] - float(table["from"])):
            refuse("`from` and `to` must be two different numbers with a finite difference", "from")
        if table.get("scale", "linear") not in ("linear", "log"):
            refuse(f"scale = {shown(table['scale'])}: expected 'linear' or 'log'", "scale")
        if table.get("scale") == "log" and min(table["from"], table["to"]) <= 0:
            refuse("scale = \"log\" needs positive `from` and `to`", "scale")
        if table.get("scale") == "log" and not 0 < table["to"] / table["from"] < math.inf:
            refuse("scale = \"log\" needs `from` and `to` with a finite ratio", "scale")
        if self.kind == "latin" and "count" in table:
            refuse("a Latin hypercube has `cases` values of each: take `count` out", "count")
        if self.kind != "latin" and table.get("count", 0) < 2:
            refuse("`from` and `to` need `count`, 2 or more, or kind = \"latin\"", "from")

    def rows(self):
        """Values of all parameters, a row for each case."""
        return {"grid": self.grid, "list": self.list, "latin": self.latin}[self.kind]()

    def bound(self, cases, reason=""):
        """Refuses more than memory holds, before any of it is made."""
        advice = "take values out"
        if cases > MOST_CASES:
            self.source.refuse(f"{reason}{amount(cases)} cases: at most {MOST_CASES}; {advice}")
        if cases * len(self.parameters) > MOST_VALUES:
            self.source.refuse(f"{cases} cases of {len(self.parameters)} parameters: at most {MOST_VALUES} values; {advice}")

    def grid(self):
        counts = [count(p) for p in self.parameters]
        factors = [amount(c) for c in counts if c > 1]
        product = " × ".join(factors[:9] + ["…"] * (len(factors) > 9))
        self.bound(math.prod(counts), f"{product} = " if len(factors) > 1 else "")
        return [list(row) for row in itertools.product(*map(listed, self.parameters))]

    def list(self):
        most = max(count(p) for p in self.parameters if p.varies)
        for p in self.parameters:
            if p.varies and count(p) != most:
                self.source.refuse(
                    f"[parameters.{p.name}]: {count(p)} values, others have {most}: in a list, the first values of "
                    "all make the first case, and so on", p.name)
        self.bound(most)
        columns = [listed(p) for p in self.parameters]
        return [[c[i] if p.varies else c[0] for p, c in zip(self.parameters, columns)] for i in range(most)]

    def latin(self):
        """McKay, Beckman and Conover 1979: of n cases, each nth of a range has exactly one."""
        cases = self.source.content.get("cases")
        if cases is None or not 1 <= cases <= MOST_CASES:
            found = "no `cases`" if cases is None else f"cases = {cases}"
            self.source.refuse(f"{found}: a Latin hypercube needs from 1 to {MOST_CASES}", key="cases")
        self.bound(cases)
        chance = random.Random(self.source.content.get("seed", 0))
        columns = []
        for p in self.parameters:
            places = [(i + chance.random()) / cases for i in range(cases)]
            chance.shuffle(places)
            columns.append([at(p, place) for place in places])
        return [list(row) for row in zip(*columns)]


def count(parameter):
    """How many values a parameter has in a grid or list."""
    return parameter.table["count"] if "from" in parameter.table else len(parameter.table.get("values", [None]))


def amount(number):
    """A whole number, however large."""
    return str(number) if number < 10**15 else "more than 10^15"


def listed(parameter):
    table = parameter.table
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
