"""Folders of bodies: what is in them, and what the studio writes there."""

from __future__ import annotations

import hashlib
import os
import re
import shutil
import subprocess
import tempfile
import threading
from pathlib import Path
from typing import Any, Iterator

from .. import programs
from . import settings
from .runs import Refused, Run, steps, words

#: Files that make imports as the model of a body.
KINDS = ("step", "stp", "brep", "iges", "3mf", "stl", "obj", "ply")
LARGEST = 200_000_000
_NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_-]{0,63}")
#: What of `cad2fem new` belongs to its own model, and not to one that comes from elsewhere.
_OF_THE_TEMPLATE = ("model.toml", "sim.blocked.toml", "tags.toml")
_EDITED = (".toml", ".geo", ".md")
#: What `cad2fem pick` takes for a file of several solids.
_HOW = re.compile(r"|--unite|--subtract( [0-9]+)+")
#: Changes are made one after the other.
CHANGING = threading.Lock()


class Body:
    """The folder of a body, in the folder of the studio."""

    def __init__(self, name: str):
        if not _NAME.fullmatch(name):
            raise Refused(400, f"{name!a}: a body is called by 1 to 64 letters, digits, - and _, as make has no others")
        self.name, self.folder = name, Path(name)
        self.build = self.folder / "build"
        self.run = Run(self.build)

    def exists(self) -> bool:
        """Whether it is there; a folder behind a link is not."""
        return not self.folder.is_symlink() and (self.folder / "sim.toml").is_file()

    def existing(self) -> Body:
        """Itself, if it is there."""
        if not self.exists():
            raise Refused(404, f"{self.name}: there is no such body here")
        return self

    def files(self) -> Iterator[str]:
        """All files in it. No link is followed, and hidden files are nobody's business."""
        for folder, folders, names in os.walk(self.folder):
            folders[:] = [name for name in folders if not name.startswith(".")]
            for name in names:
                path = Path(folder, name)
                if path.is_file() and not path.is_symlink() and not name.startswith("."):
                    yield path.relative_to(self.folder).as_posix()

    def file(self, name: str) -> Path:
        """A file that is in it."""
        if name not in self.files():
            raise Refused(404, f"{name!a}: there is no such file in {self.name}")
        return self.folder / name

    def models(self) -> list[str]:
        """Its models; make wants one."""
        return sorted(p.name for p in self.folder.glob("model.*") if p.suffix[1:] in (*KINDS, "toml", "geo"))

    def create(self) -> None:
        """Writes a folder to begin with, which is that of a sample."""
        programs.run("cad2fem", ["new", self.name])

    def create_for(self, kind: str, content: bytes) -> None:
        """The same, with a CAD file in the place of its model."""
        _check_cad(kind, content)
        self.create()
        for own in _OF_THE_TEMPLATE:
            (self.folder / own).unlink()
        self.replace_model(kind, content)

    def replace_model(self, kind: str, content: bytes) -> None:
        """Takes a newer CAD file in place of that which is there."""
        self.not_running()
        _check_cad(kind, content)
        before, name = self.models(), f"model.{kind}"
        if own := {"model.toml", "model.geo"} & set(before):
            raise Refused(409, f"{self.folder}/{own.pop()} is this body's model: begin a new body for a CAD file")
        _written(self.folder, name, content).replace(self.folder / name)
        for other in set(before) - {name}:
            (self.folder / other).unlink()
        self.pick("")

    def pick(self, how: str) -> None:
        """Begins to read the model and to make the page on which its faces are clicked.

        how: nothing, or what becomes of several solids.
        """
        if not _HOW.fullmatch(how):
            raise Refused(400, "mark the solids that are air, or say that all are one body")
        program, environment = programs.program("cad2fem"), programs.make_command([])[1]
        arguments = [*self.pick_command(), *how.split()]
        self.run.start(words("cad2fem", *arguments), [str(program), *arguments], environment)
        if how:
            # make keeps such a copy, and imports a model again, without `how`, where it is missing
            (self.build / ".sources").mkdir(exist_ok=True)
            shutil.copy2(arguments[1], self.build / ".sources")

    def pick_command(self, tags: Path | None = None, model: str | None = None) -> list[str]:
        """Arguments of `cad2fem pick`; with the tags that there are."""
        tags = tags or self.folder / "tags.toml"
        of = model or str(self.folder / next(iter(self.models()), "build/model"))
        return ["pick", of, *(["--tags", str(tags)] if tags.is_file() else []), "-o", str(self.build / "pick.html")]

    def make(self) -> None:
        """Begins to make all that is missing or out of date."""
        shown = words("puffer", "make", "-C", self.name)
        command, environment = programs.make_command(["-C", self.name])
        plan = subprocess.run([*command, "-n"], env=environment, capture_output=True, text=True)
        self.run.start(shown, command, environment, steps(plan.stdout))

    def save(self, name: str, text: str, seen: str) -> None:
        """Replaces the text of a file that was seen in a version, if the program that reads it finds nothing wrong."""
        self.not_running()
        if name != "tags.toml" and name not in self.edited():
            raise Refused(404, f"{name!a}: no file that is edited here")
        path = self.folder / name
        if seen != self.version(name):
            raise Refused(412, f"{path}: was changed meanwhile, in another window or program; load it again")
        kept = _written(self.folder, name, text.replace("\r\n", "\n").encode())
        try:
            self._check(name, kept)
            kept.replace(path)
        finally:
            kept.unlink(missing_ok=True)

    def _check(self, name: str, kept: Path) -> None:
        """Has a text read by the programs that will read it."""
        with tempfile.TemporaryDirectory(prefix="puffer-") as folder:
            # programs read their settings first: one that finds no mesh has found nothing wrong in them
            nowhere, out = f"{folder}/nowhere.msh", f"{folder}/out"
            readers: dict[str, list[tuple[str | Path, ...]]] = {
                "cad2fem": [("cad2fem", "tetmesh", nowhere, "--config", kept, "-o", f"{out}.msh")],
                "tags": [("tagger", "tag", nowhere, "--config", kept, "-o", f"{out}.msh")],
                "sim": [("solver", "simulate", kept, "--mesh", nowhere, "-o", out)],
                "design": [("solver", "check", kept, "--mesh", nowhere)],
                "mold": [("fab", "plan", nowhere, "--config", kept, "-o", out)],
                "model": [("cad2fem", "model", kept, "-o", out, *(("--unit", "mm") if name.endswith(".geo") else ()))],
            }
            if (self.build / "model/model.json").is_file():
                readers["tags"] += [("cad2fem", "-q", *self.pick_command(kept, str(self.build / "model")))]
            for program, *arguments in readers.get(name.split(".")[0], []) if not name.endswith(".md") else []:
                try:
                    programs.run(str(program), [str(word) for word in arguments])
                except programs.ProgramError as error:
                    if nowhere not in str(error):
                        raise Refused(422, str(error).replace(str(kept), str(self.folder / name))) from None

    def edited(self) -> list[str]:
        """Files that people edit. A Makefile is a program, which no page writes."""
        return sorted(name for name in self.files() if "/" not in name and name.endswith(_EDITED))

    def version(self, name: str) -> str:
        """Of a text, by what it says; 0 where there is no file."""
        path = self.folder / name
        return version(path.read_bytes()) if path.is_file() else "0"

    def text(self, name: str) -> str:
        """Of a file, empty where there is none."""
        path = self.folder / name
        return path.read_text(errors="replace") if path.is_file() and not path.is_symlink() else ""

    def not_running(self) -> None:
        """Refuses a change while programs read the files."""
        if self.run.is_running():
            raise Refused(409, f"{self.name} is being made; wait until it has ended, or stop it")

    def state(self) -> dict[str, Any]:
        """All that the page shows."""
        files = sorted(self.files(), key=lambda name: (name.count("/"), name))
        scene, mold = self.text("sim.toml"), self.text("mold.toml")
        tags = settings.tags(self.text("tags.toml"))
        chambers = settings.chambers(scene)
        names = [tag["name"] for tag in tags]
        here = {name: self.version(name) for name in ["tags.toml", *self.edited()]}
        models, report, page = self.models(), self.build / "report.html", self.build / "pick.html"
        return {
            "name": self.name,
            "above": os.getcwd(),
            "models": models,
            "page": _date(page) if all(_date(self.folder / model) <= _date(page) for model in models) else 0,
            "pick": words("cad2fem", *self.pick_command()),
            "tags": tags,
            "missing": [*settings.unknown("sim.toml", scene, names), *settings.unknown("mold.toml", mold, names)],
            "chambers": chambers,
            "unfilled": [tag["name"] for tag in tags if tag["chamber"] and tag["name"] not in settings.filled(scene)],
            "silicone": settings.named(scene, "", "material"),
            "cast": settings.named(mold, "casting", "silicone"),
            "files": here,
            "shown": [name for name in files if name in ("Makefile", "rules.mk")],
            "run": self.run.state(),
            "report": _date(report),
            "old": any(_date(self.folder / name) > _date(report) for name in [*here, *models]),
            "pictures": [name for name in files if re.fullmatch(r"build/pictures/mold.*\.png", name)],
            "parts": [name for name in files if re.fullmatch(r"build/mold/.*\.stl", name)],
            "zip": next((name for name in files if re.fullmatch(r"build/[^/]*\.zip", name)), None),
        }


def all_bodies() -> list[Body]:
    """Those in the folder of the studio."""
    names = sorted(name for name in os.listdir() if _NAME.fullmatch(name))
    return [body for body in map(Body, names) if body.exists()]


def version(content: bytes) -> str:
    """Of a text: another one has another version."""
    return hashlib.sha256(content).hexdigest()[:16]


def _date(path: Path) -> float:
    """When a file was written last, 0 if it is not there: a run may have just removed it."""
    try:
        return path.stat().st_mtime
    except FileNotFoundError:
        return 0


def _check_cad(kind: str, content: bytes) -> None:
    if kind not in KINDS:
        raise Refused(400, f"{kind!a}: no such CAD file is read here; there are .{', .'.join(KINDS)}")
    if not content:
        raise Refused(400, "the CAD file is empty: export it again")


def _written(folder: Path, name: str, content: bytes) -> Path:
    """A new file that is to replace another one; make does not look at its name."""
    with tempfile.NamedTemporaryFile(dir=folder, prefix=".incomplete-", suffix=f".{name}", delete=False) as file:
        try:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
            os.chmod(file.name, 0o644)
        except BaseException:
            os.unlink(file.name)
            raise
    return Path(file.name)
