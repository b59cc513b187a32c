"""Folders of a sweep: a `job.json` for each body and each case, and `plan.json` for Snakemake."""

import json
import os
import re
import tomllib
from pathlib import Path

from files import Refused, is_file, parsed, read, write_if_new
from plan import key_of

ROOT = Path(__file__).resolve().parents[2]
PROGRAMS = Path(os.environ.get("PUFFER_BIN", ROOT / "target/release")).resolve()
SIZE = "320x240"


def require_programs():
    for program in ("cad2fem", "tagger", "solver"):
        if not os.access(PROGRAMS / program, os.X_OK):
            raise Refused(f"{PROGRAMS / program} is not there: make setup builds it")


def write(sweep, out):
    """Writes all folders, leaving what is as it should be; returns the plan."""
    writer = Writer(sweep, out)
    plan = writer.plan()
    text = json.dumps(plan, ensure_ascii=False)
    write_if_new(out / "plan.json", text)
    return plan


class Writer:
    def __init__(self, sweep, out):
        self.sweep, self.out = sweep, out

    def plan(self):
        sweep, bodies, cases = self.sweep, {}, []
        for number, row in enumerate(sweep.rows(), 1):
            body = self.body(row)
            if body["key"] not in bodies:
                bodies[body["key"]] = self.keep("bodies", body)
            case = self.case(row, body["key"])
            self.keep("cases", case)
            cases.append({"number": number, "key": case["key"], "body": body["key"], "values": row})
        parameters = [
            {"name": p.name, "unit": p.unit, "file": p.file, "set": p.keys, "varies": p.varies} for p in sweep.parameters
        ]
        return {
            "sweep": str(sweep.source.path), "title": f"{sweep.folder.name}: {sweep.source.path.name}",
            "optimizes": sweep.optimizes, "parameters": parameters, "cases": cases, "threads": sweep.threads,
            "memory_mb": sweep.memory_mb, "minutes": sweep.minutes,
            "body_inputs": self.inputs("model", "mesh", "tags"), "case_inputs": self.inputs("scene"),
        }

    def keep(self, kind, job):
        folder = self.out / kind / job["key"]
        folder.mkdir(parents=True, exist_ok=True)
        write_if_new(folder / "job.json", json.dumps(job, ensure_ascii=False))
        return folder

    def sets(self, row, file, folder=None):
        """Values that belong to a file, as `--set`; {body} in a text is the folder of the body."""
        found = []
        for parameter, value in zip(self.sweep.parameters, row):
            if parameter.file == file:
                value = value.replace("{body}", str(folder)) if folder and isinstance(value, str) else value
                found += [f"{key}={as_toml(value)}" for key in parameter.keys]
        return found

    def body(self, row):
        s = self.sweep
        sets = {role: self.sets(row, s.files[role]) for role in ("model", "mesh", "tags")}
        key = key_of(s.model, s.mesh, s.tags, s.inside, sets)
        folder = self.out / "bodies" / key
        # a script of gmsh has no unit of its own; ours are in millimetres
        unit = ["--unit", "mm"] if s.model.endswith(".geo") else []
        inside = [f"--inside={folder}/model/patches/{name}.stl" for name in s.inside]
        commands = [
            self.command("cad2fem", "model", s.folder / s.model, "-o", folder / "model", *unit, *flags(sets["model"])),
            self.command("cad2fem", "tetmesh", folder / "model/model.stl", *inside, "--config", s.folder / s.mesh,
                         "-o", folder / "volume.msh", *flags(sets["mesh"])),
            self.command("tagger", "tag", folder / "volume.msh", "--config", s.folder / s.tags,
                         "--patches", folder / "model/patches", "-o", folder / "tagged.msh", *flags(sets["tags"])),
        ]
        return {"key": key, "body": None, "commands": commands, **self.limits()}

    def case(self, row, body):
        s = self.sweep
        name = s.body
        key = key_of(body, s.scene, s.optimizes, name, self.sets(row, s.scene), " ".join(s.looks))
        folder = self.out / "cases" / key
        mesh = self.out / "bodies" / body / "tagged.msh"
        sets = flags(self.sets(row, s.scene, mesh.parent))
        run = ["-o", folder / "run", "--threads", str(s.threads), *sets]
        if s.optimizes:
            solve = self.command("solver", "optimize", s.folder / s.scene, f"--set=scene.mesh={as_toml(str(mesh))}", *run)
        else:
            part = f"{name}={mesh}" if name else mesh
            solve = self.command("solver", "simulate", s.folder / s.scene, "--mesh", part, "--final-only", *run)
        picture = self.command("cad2fem", "picture", folder / "run/result.vtu", "--size", SIZE, *s.looks,
                               "-o", folder / "picture.png")
        return {"key": key, "body": body, "commands": [solve, picture], **self.limits()}

    def limits(self):
        return {"threads": self.sweep.threads, "minutes": self.sweep.minutes}

    def command(self, program, verb, *rest):
        return [str(PROGRAMS / program), verb, "--quiet", *map(str, rest)]

    def inputs(self, *roles):
        found = []
        for role in roles:
            with_includes(self.sweep.folder / self.sweep.files[role], found)
        return [plain(str(path)) for path in found]


def plain(path):
    """A path that Snakemake takes as it is."""
    if re.search(r"[{}\n]", path):
        raise Refused(f"{path}: Snakemake takes braces and ends of lines in a path for its own: give it another name")
    return path


def with_includes(path, found):
    """A file and, in TOML, what it includes; whatever is wrong there, the programs say better."""
    rest = [path]
    while rest:
        path = Path(os.path.abspath(rest.pop()))
        if path in found or not is_file(path):
            continue
        found.append(path)
        try:
            include = parsed(path, read(path)).get("include", []) if path.suffix == ".toml" else []
        except (Refused, tomllib.TOMLDecodeError):
            continue
        rest += [path.parent / str(other) for other in (include if isinstance(include, list) else [include])]


def flags(sets):
    return [f"--set={text}" for text in sets]


def as_toml(value):
    """A basic string of TOML is one of JSON, but for what lies beyond ASCII, which stays."""
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    return str(value).lower() if isinstance(value, bool) else repr(value)
