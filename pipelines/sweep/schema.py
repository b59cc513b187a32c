"""The keys of sweep.toml, of the same tables that the program checks a file by: `schema.py [--markdown]`.

Prints a JSON Schema for editors, or a table for people.
"""

import json
import sys

from keys import KEYS, KINDS, NEEDED, PARAMETER_KEYS, PARAMETER_NEEDED

TYPES = {
    str: {"type": "string"},
    int: {"type": "integer"},
    list: {"type": "array"},
    (int, float): {"type": "number"},
    (str, list): {"anyOf": [{"type": "string"}, {"type": "array", "items": {"type": "string"}}]},
    None: {"type": ["string", "number", "boolean"]},
}
WORDS = {
    str: "text", int: "whole number", list: "list", dict: "tables", (int, float): "number",
    (str, list): "text or list of text", None: "text, number, true or false",
}


def schema():
    parameter = table(PARAMETER_KEYS, PARAMETER_NEEDED)
    parameter["properties"]["scale"]["enum"] = ["linear", "log"]
    parameter["oneOf"] = [{"required": [key]} for key in ("value", "values", "from")]
    parameter["dependentRequired"] = {"from": ["to"], **{key: ["from"] for key in ("to", "count", "scale")}}
    top = table({key: entry for key, entry in KEYS.items() if key != "parameters"}, NEEDED)
    top["properties"]["kind"]["enum"] = list(KINDS)
    meaning = KEYS["parameters"][1]
    top["properties"]["parameters"] = {
        "type": "object", "description": meaning, "minProperties": 1, "additionalProperties": parameter,
    }
    top["not"] = {"required": ["simulate", "optimize"]}
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", "title": "sweep.toml", **top}


def table(keys, needed):
    properties = {key: {**TYPES[kind], "description": meaning} for key, (kind, meaning) in keys.items()}
    return {"type": "object", "properties": properties, "required": list(needed), "additionalProperties": False}


def markdown(keys, needed):
    lines = ["| key | value | meaning |", "|-|-|-|"]
    for key, (kind, meaning) in keys.items():
        lines.append(f"| `{key}` | {WORDS[kind]}{', needed' if key in needed else ''} | {meaning} |")
    return "\n".join(lines)


def main():
    if sys.argv[1:] == ["--markdown"]:
        print(markdown(KEYS, NEEDED))
        print("\n## `[parameters.NAME]`\n")
        print(markdown(PARAMETER_KEYS, PARAMETER_NEEDED) + "\n")
    elif sys.argv[1:]:
        sys.exit(f"{' '.join(sys.argv[1:])}: expected nothing, or --markdown")
    else:
        print(json.dumps(schema(), indent=2))


main()
