"""Single values in files in TOML: found, and changed in their place, so that all else of the text stays, comments too.

Only `key = value` below `[table]` is known: the programs read the files as a whole, and say what is wrong.
"""

from __future__ import annotations

import json
import re
from dataclasses import dataclass
from typing import Any, Iterable, Iterator

from .. import programs
from .runs import Refused

_TABLE = re.compile(r"^[ \t]*\[\[?[ \t]*([\w.-]+)[ \t]*\]\]?[ \t]*(?:#.*)?$", re.MULTILINE)
#: A list may go over several lines.
_VALUE = re.compile(r"^[ \t]*([\w-]+)[ \t]*=[ \t]*(\"[^\"\n]*\"|\[[^\]#]*\]|[^\s#]+)", re.MULTILINE)
#: Keys of a scene whose values are names of tags.
_NAMING = ("on", "to")


@dataclass(frozen=True)
class Entry:
    """A value: the name of its table ("" at the top), how many of all tables are before that, key, text and place."""

    table: str
    number: int
    key: str
    value: str
    place: tuple[int, int]

    @property
    def names(self) -> list[str]:
        """The texts in it."""
        return re.findall(r'"([^"]*)"', self.value)


def _tables(text: str) -> Iterator[tuple[str, int, int]]:
    """Name, begin and end of what is at the top, and of each table."""
    headers = list(_TABLE.finditer(text))
    ends = [*(header.start() for header in headers), len(text)]
    return zip(["", *(header[1] for header in headers)], [0, *ends], ends)


def entries(text: str) -> Iterator[Entry]:
    """All values of a file."""
    for number, (table, start, end) in enumerate(_tables(text)):
        for found in _VALUE.finditer(text, start, end):
            yield Entry(table, number, found[1], found[2], found.span(2))


def changed(text: str, number: int, key: str, value: str | float) -> str:
    """The text with another value of a key in a table."""
    for entry in entries(text):
        if (entry.number, entry.key) == (number, key):
            start, end = entry.place
            return text[:start] + json.dumps(value, ensure_ascii=False) + text[end:]
    raise Refused(409, f"there is no {key} any more: change the text of the file")


def left_out(text: str, number: int) -> str:
    """The text with a table as a comment."""
    _, start, end = list(_tables(text))[number]
    return text[:start] + re.sub(r"^(?=[ \t]*[^#\s])", "# ", text[start:end], flags=re.MULTILINE) + text[end:]


def with_chamber(text: str, tag: str, pressure: float) -> str:
    """The text of a scene with a chamber more."""
    chamber = f"[[chamber]]\non = {json.dumps(tag)}\npressure = {pressure!r}    # gauge [Pa]\n"
    return f"{text.rstrip()}\n\n# Air behind a wall.\n{chamber}"


def tags(text: str) -> list[dict[str, Any]]:
    """The tags of tags.toml, and parts of the volume, which scenes name, too."""
    found: dict[int, dict[str, Any]] = {}
    for entry in entries(text):
        if entry.table in ("tag", "volume"):
            tag = found.setdefault(entry.number, {"name": "", "chamber": False})
            if entry.key == "name":
                tag["name"] = "".join(entry.names)
            elif entry.key == "pressure":
                tag["chamber"] = entry.value == "true"
    return list(found.values())


def chambers(scene: str) -> list[dict[str, Any]]:
    """Chambers of a scene with a pressure that does not change with time."""
    found: dict[int, dict[str, Entry]] = {}
    for entry in entries(scene):
        if entry.table == "chamber":
            found.setdefault(entry.number, {})[entry.key] = entry
    both = [(number, one["on"], one["pressure"]) for number, one in found.items() if {"on", "pressure"} <= one.keys()]
    return [{"number": number, "on": ", ".join(on.names), "pressure": _number(of.value)} for number, on, of in both]


def filled(scene: str) -> list[str]:
    """Tags behind which a scene has air."""
    on = [entry.names for entry in entries(scene) if (entry.table, entry.key) == ("chamber", "on")]
    return [name.rpartition(".")[2] for names in on for name in names]


def unknown(file: str, text: str, known: Iterable[str]) -> list[dict[str, Any]]:
    """What names tags that are not there. In a scene of several bodies they have other names."""
    known, found, all_entries = set(known), [], list(entries(text))
    for entry in all_entries if all(entry.table != "body" for entry in all_entries) else ():
        names = entry.key in _NAMING and entry.table or (file, entry.table, entry.key) == ("mold.toml", "", "chamber")
        for name in entry.names if names else ():
            if name not in known:
                found.append({"file": file, **vars(entry), "name": name})
    return found


def named(text: str, table: str, key: str) -> dict[str, Any] | None:
    """The text that is the value of a key, if it is one, and the number of its table."""
    found = (entry for entry in entries(text) if (entry.table, entry.key) == (table, key) and len(entry.names) == 1)
    return next(({"name": entry.names[0], "number": entry.number} for entry in found), None)


def silicones() -> list[dict[str, str]]:
    """Silicones and printed elastomers of the library, with what they are called."""
    listed = programs.run("solver", ["list", "--silicones"])
    pairs = re.findall(r"^([a-z]\S+)\n  (\S.*)", listed.partition("\nsources\n")[0], re.MULTILINE)
    return [{"name": name, "about": about} for name, about in pairs]


def _number(text: str) -> float | None:
    try:
        return float(text.replace("_", ""))
    except ValueError:
        return None
