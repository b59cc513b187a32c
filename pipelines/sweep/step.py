"""Runs the commands of one body or case: `step.py FOLDER`. What fails is a result, too.

Writes `step.json` last, with `status` "ok" or "failed"; what the programs say is in `log.txt`.
Interrupted (exit code 130 or 143), it writes nothing, and the same command begins again. Programs that
keep what they have done, such as `solver optimize`, continue.
"""

import fcntl
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import files

INTERRUPTED = {130: 130, 143: 143, -signal.SIGINT: 130, -signal.SIGTERM: 143}
# Longest message that is kept of a program that failed [characters].
LONGEST = 2000


def main(folder):
    with files.lock(folder / "lock") as lock:
        # a step whose Snakemake was killed may still be at it
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not (folder / "step.json").exists():
            keep(folder, outcome(folder))


def outcome(folder):
    job = json.loads((folder / "job.json").read_text())
    start = time.monotonic()
    stages, failure = {}, None
    if job["body"]:
        failure = failure_of(folder.parents[1] / "bodies" / job["body"])
    with open(folder / "log.txt", "w+b") as log:
        for command in job["commands"] if failure is None else []:
            begun = time.monotonic()
            left = 60 * job["minutes"] - (begun - start)
            failure = run(command, log, left, job)
            stages[command[1]] = time.monotonic() - begun
            if failure and command[1] == "picture":
                failure = None     # the numbers are there; the page has no picture
            if failure:
                break
    status = "failed" if failure else "ok"
    return {"status": status, "failure": failure, "seconds": time.monotonic() - start, "stages": stages}


def failure_of(body):
    try:
        return json.loads((body / "step.json").read_text())["failure"]
    except (ValueError, KeyError, TypeError, RecursionError):
        sys.exit(f"error: {body}/step.json: not as a sweep leaves it: remove {body}, and run the sweep again")


def run(command, log, seconds, job):
    """What went wrong, or nothing."""
    stage = f"{Path(command[0]).name} {command[1]}"
    threads = {"RAYON_NUM_THREADS": str(job["threads"]), "OMP_NUM_THREADS": str(job["threads"])}
    begin = log.tell()
    try:
        child = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=log, stderr=log, env={**os.environ, **threads})
    except OSError as error:
        return {"stage": stage, "code": None, "message": f"{command[0]}: {error.strerror}"}
    signal.signal(signal.SIGTERM, lambda *_: child.terminate())
    try:
        code = child.wait(seconds)
    except subprocess.TimeoutExpired:
        child.terminate()
        child.wait()
        message = f"stopped after {job['minutes']} minutes, the limit for a case: raise `minutes` in the sweep"
        return {"stage": stage, "code": None, "message": message}
    except KeyboardInterrupt:
        child.wait()
        sys.exit(130)
    if code in INTERRUPTED:
        sys.exit(INTERRUPTED[code])
    if code == 0:
        return None
    # a character takes four bytes at most
    log.seek(max(begin, log.seek(0, os.SEEK_END) - 4 * LONGEST))
    said = log.read().decode(errors="replace").strip()
    killed = f"killed by signal {-code}" if code < 0 else f"exit code {code}"
    return {"stage": stage, "code": code, "message": said[-LONGEST:] or killed}


def keep(folder, result):
    content = json.dumps(result, ensure_ascii=False).encode(errors="replace")
    files.replace(folder / "step.json", lambda file: file.write(content), sync=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
