"""The commands that pip installs: four programs, and `puffer`, which calls them."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import NoReturn, Sequence

PACKAGE = Path(__file__).resolve().parent
BIN = PACKAGE / "bin"
SHARE = PACKAGE / "share" / "puffer"
PROGRAMS = ("cad2fem", "tagger", "solver", "fab")

HELP = """\
Puffer: from a model of a soft actuator to printable molds.

  puffer new FOLDER [--like BODY]   write a folder to begin with: puffer new mine --like beam
  puffer studio [FOLDER]            the same on a page in your browser: drop a CAD file, click faces, make
  puffer make [-C FOLDER]           make all of it, as `make -C FOLDER` does
  puffer sweep FOLDER [--retry]     many cases of it, by FOLDER/sweep.toml (pip install 'softpuffer[sweep]')
  puffer gallery FOLDER ...         one page that shows the bodies that were made, gallery/index.html
  puffer doctor                     say what this machine lacks
  puffer PROGRAM ...                run one program: cad2fem, tagger, solver or fab, each with its own --help
  puffer --version
"""

# What to type next, in a folder of a body and elsewhere.
NEXT_IN_BODY = """\
This folder has a body. Type

  puffer make                       make all of it, then open build/report.html

puffer --help lists all commands.
"""
# the studio does not run on Windows
_STUDIO = "" if os.name == "nt" else "  puffer studio                     begin on a page in your browser, with a CAD file\n"
NEXT = f"""\
Puffer: from a model of a soft actuator to printable molds. Type

{_STUDIO}  puffer new mine --like beam       begin with a folder of files, then: puffer make -C mine
  puffer doctor                     see what this machine lacks

puffer --help lists all commands.
"""


class ProgramError(RuntimeError):
    """A program failed. The text is its message.

    program, returncode: which one, and its exit code: 1 where a result must not be used, 2 where the input is wrong.
    stderr: all that it said.
    """

    def __init__(self, program: str, returncode: int, stderr: str):
        self.program, self.returncode, self.stderr = program, returncode, stderr
        super().__init__(_message(program, stderr) or f"{program} ended with exit code {returncode}, without a message")


def _message(program: str, stderr: str) -> str:
    """The message with which a program ended: from the last line on that begins with its name, or of what is wrong
    with its arguments."""
    lines = stderr.strip().splitlines()
    begins = [i for i, line in enumerate(lines) if line.startswith((f"{program}: ", "error: "))]
    return "\n".join(lines[begins[-1] :]) if begins else ""


def cad2fem() -> None:
    """Runs the program `cad2fem`."""
    _run_program("cad2fem", sys.argv[1:])


def tagger() -> None:
    """Runs the program `tagger`."""
    _run_program("tagger", sys.argv[1:])


def solver() -> None:
    """Runs the program `solver`."""
    _run_program("solver", sys.argv[1:])


def fab() -> None:
    """Runs the program `fab`."""
    _run_program("fab", sys.argv[1:])


def puffer() -> None:
    """Runs the command `puffer`."""
    if len(sys.argv) == 1:
        print(NEXT_IN_BODY if Path("cad2fem.toml").is_file() else NEXT, end="")
        return
    word, rest = sys.argv[1], sys.argv[2:]
    if word in PROGRAMS:
        _run_program(word, rest)
    elif word in ("new", "doctor"):
        _run_program("cad2fem", [word, *rest])
    elif word == "make":
        _make(rest)
    elif word == "studio":
        from .studio import studio

        studio(rest)
    elif word == "sweep":
        _sweep(rest)
    elif word == "gallery":
        _gallery(rest)
    elif word in ("--version", "-V"):
        from ._native import version

        print(f"puffer {version()}")
    elif word in ("--help", "-h", "help"):
        print(HELP, end="")
    else:
        _refuse(f"there is no {word!r}\n\n{HELP}")


def program(name: str) -> Path:
    """The path of a program that came with this package. Raises FileNotFoundError where it is not there."""
    path = BIN / (name + (".exe" if os.name == "nt" else ""))
    if not path.is_file():
        raise FileNotFoundError(f"{path} is not there: install softpuffer again, from a wheel")
    return path


def run(name: str, arguments: Sequence[str]) -> str:
    """Runs a program to its end and returns what it printed. Its messages go where those of Python go.

    Raises ProgramError, with the message of the program, where it fails.
    """
    command = [str(program(name)), *arguments]
    done = subprocess.run(command, env=_environment(), capture_output=True, text=True)
    if done.returncode:
        raise ProgramError(name, done.returncode, done.stderr)
    print(done.stderr, end="", file=sys.stderr)
    return done.stdout


def _run_program(name: str, arguments: Sequence[str]) -> None:
    try:
        path = program(name)
    except FileNotFoundError as error:
        _refuse(error)
    _run(path, arguments, _environment())


def _environment() -> dict[str, str]:
    """That of the programs: their meshers are packages of this Python, unless the user says otherwise."""
    environment = dict(os.environ)
    if not environment.get("PUFFER_PYTHON"):
        environment["PUFFER_PYTHON"] = sys.executable
    return environment


def _make(arguments: list[str]) -> None:
    """Runs make with the programs of this package before others."""
    try:
        command, environment = make_command(arguments)
    except FileNotFoundError as error:
        _refuse(error)
    _run(command[0], command[1:], environment)


def make_command(arguments: list[str]) -> tuple[list[str], dict[str, str]]:
    """What `puffer make` runs, and its environment; a folder without a Makefile gets the rules."""
    make = shutil.which("make")
    if make is None:
        raise FileNotFoundError("make is missing: on Debian, apt install make")
    environment = _environment()
    environment["PATH"] = os.pathsep.join(filter(None, (str(BIN), environment.get("PATH"))))
    folder = Path(arguments[arguments.index("-C") + 1]) if "-C" in arguments[:-1] else Path()
    ruled = any((folder / name).exists() for name in ("GNUmakefile", "makefile", "Makefile"))
    own = [] if ruled else ["-f", str(SHARE / "folder.mk"), f"BIN={BIN}"]
    return [make, *own, *arguments], environment


def _sweep(arguments: list[str]) -> None:
    """Runs the sweep of a folder into its `build`, as `make sweep DIR=...` does in a checkout."""
    if not arguments or arguments[0].startswith("-"):
        _refuse("of which folder? puffer sweep FOLDER, where sweep.toml is")
    given, rest = Path(arguments[0]), arguments[1:]
    try:
        import snakemake  # noqa: F401
    except ImportError:
        _refuse("Snakemake is missing: pip install 'softpuffer[sweep]', with Python 3.11 or newer")
    file = given / "sweep.toml" if given.is_dir() else given
    if not {"-o", "--output"} & set(rest):
        rest = [*rest, "--output", str(file.parent / "build" / file.stem)]
    environment = _environment()
    environment["PUFFER_BIN"] = str(BIN)
    _run(sys.executable, ["-Es", str(SHARE / "sweep" / "sweep.py"), str(file), *rest], environment)


def _gallery(folders: list[str]) -> None:
    """Writes the gallery of some folders into `gallery`, as `make gallery` does in a checkout."""
    if not folders or any(name.startswith("-") for name in folders):
        _refuse("of which folders? puffer gallery FOLDER ..., each with its build")
    bodies = [f"{Path(name).resolve().name}={name}={Path(name) / 'build'}" for name in folders]
    _run(sys.executable, ["-Es", str(SHARE / "gallery.py"), "gallery", *bodies], _environment())


def _run(path: str | Path, arguments: Sequence[str], environment: dict[str, str]) -> None:
    """Becomes another program, where the system can; its exit code is ours."""
    command = [str(path), *arguments]
    if os.name == "nt":
        sys.exit(subprocess.run(command, env=environment).returncode)
    os.execve(command[0], command, environment)


def _refuse(why: object) -> NoReturn:
    print(f"puffer: {why}", file=sys.stderr)
    sys.exit(2)
