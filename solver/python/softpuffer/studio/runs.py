"""A long command in a folder: it outlives the studio, and nobody starts it twice.

It runs in a session of its own, with a log as its output. The log is locked while the command or any program that it
started lives: the lock comes with the output that they inherit, and the system drops it with the last of them.
"""

from __future__ import annotations

import fcntl
import os
import re
import shlex
import signal
import subprocess
import time
from pathlib import Path
from typing import Any, Mapping, Sequence

#: A line by which make, or the studio, says which program it runs.
_STEP = re.compile(r"(?:/|^\$ )(cad2fem|tagger|solver|fab) ([a-z]+) .*-o ", re.MULTILINE)
#: With what a program says why it ended, and make.
_WHY = re.compile(r"^(?:cad2fem|tagger|solver|fab): .*(?:\n(?![\w/]+:|#).+)*", re.MULTILINE)
_MAKE = re.compile(r"\*\*\* (.*)")
#: Of a long log the page has the end.
_SHOWN = 20_000
# a run takes all processors: the browser and the studio come first
_SCRIPT = 'echo "# group $$, steps $0"; echo "$ $1"; shift; nice "$@"; echo "# exit code $?"'


class Refused(Exception):
    """A request that is refused, with a status of HTTP and a message for the person."""

    def __init__(self, status: int, message: str):
        self.status = status
        super().__init__(message)


class Run:
    """The last long command in a folder, and whether it still runs."""

    def __init__(self, build: Path):
        self.log = build / "studio.log"

    def is_running(self) -> bool:
        """Whether the command or a program of it lives."""
        try:
            with open(_opened(self.log, os.O_RDONLY)) as log:
                fcntl.flock(log, fcntl.LOCK_SH | fcntl.LOCK_NB)
        except BlockingIOError:
            return True
        except FileNotFoundError:
            pass
        return False

    def start(self, shown: str, command: Sequence[str], environment: Mapping[str, str], steps: int = 1) -> None:
        """Starts a command, which people write as `shown`; refused while another one runs."""
        self.log.parent.mkdir(exist_ok=True)
        with open(_opened(self.log, os.O_WRONLY | os.O_CREAT | os.O_APPEND), "w") as log:
            if not _locked(log.fileno()):
                raise Refused(409, f"{self.log}: this body is being made; wait until it has ended, or stop it")
            log.truncate(0)
            subprocess.Popen(
                ["/bin/sh", "-c", _SCRIPT, str(steps), shown, *command],
                env=dict(environment), stdin=subprocess.DEVNULL, stdout=log, stderr=log, start_new_session=True,
            )

    def stop(self) -> None:
        """Ends the command and all its programs in order."""
        group = re.match(r"# group (\d+)", self._text())
        if group is None or not self.is_running():
            raise Refused(409, f"{self.log}: nothing runs that could be stopped")
        os.killpg(int(group[1]), signal.SIGTERM)
        ends = time.monotonic() + 10
        while self.is_running() and time.monotonic() < ends:
            time.sleep(0.05)

    def state(self) -> dict[str, Any]:
        """What there is to be shown."""
        running, text = self.is_running(), self._text()
        head, command, *_ = (text + "\n\n").splitlines()
        code = re.search(r"^# exit code (\d+)\n\Z", text, re.MULTILINE)
        steps = [" ".join(step) for step in _STEP.findall(text)]
        why = [*_WHY.findall(text)[-1:], *_MAKE.findall(text)[-1:]]
        return {
            "running": running,
            "command": command[2:],
            "code": int(code[1]) if code and not running else None,
            "why": "\n".join(why),
            "step": steps[-1] if steps else "",
            "done": len(steps),
            "steps": int(head.rpartition(" ")[2] or 0) if head else 0,
            "log": text[-_SHOWN:].partition("\n")[2],
        }

    def _text(self) -> str:
        try:
            with open(_opened(self.log, os.O_RDONLY), errors="replace") as log:
                return log.read()
        except FileNotFoundError:
            return ""


def _locked(log: int) -> bool:
    """Locks a log, unless a run has it; somebody who only looks whether there is a run has it for an instant."""
    for _ in range(20):
        try:
            fcntl.flock(log, fcntl.LOCK_EX | fcntl.LOCK_NB)
            return True
        except BlockingIOError:
            time.sleep(0.02)
    return False


def steps(plan: str) -> int:
    """How many programs run in what `make -n` lists."""
    return len(_STEP.findall(plan))


def words(*command: object) -> str:
    """A command as it is written in a terminal."""
    return shlex.join(map(str, command))


def _opened(path: Path, flags: int) -> int:
    """Opens a file and no link, which may lead anywhere."""
    if path.parent.is_symlink():
        raise Refused(409, f"{path.parent}: is a link; results are made in a folder of the body itself")
    return os.open(path, flags | os.O_NOFOLLOW, 0o644)
