"""Runs a sweep: `sweep.py sweep.toml -o FOLDER [--retry] [arguments of Snakemake]`. See README.md.

Exit codes: 0 the table is there, 1 it is not or every case failed, 2 the sweep or the command is wrong.
"""

import argparse
import csv
import fcntl
import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import files
import jobs
from files import Refused, printable
from plan import Sweep

HERE = Path(__file__).resolve().parent
# How often it says how far it is [s].
PROGRESS = 10


def main():
    parser = argparse.ArgumentParser(description="Run all cases of a sweep and put them into one table.",
                                     epilog="What else is given goes to Snakemake, as in --executor slurm --jobs 20.")
    parser.add_argument("sweep", help="sweep.toml in the folder of a body")
    parser.add_argument("-o", "--output", required=True, type=Path, help="folder for all cases and the table")
    parser.add_argument("--retry", action="store_true", help="run the cases that failed again")
    parser.add_argument("--plan", action="store_true", help="only check the sweep and count its cases")
    arguments, others = parser.parse_known_args()
    try:
        return swept(arguments, others)
    except Refused as refusal:
        print(printable(f"error: {refusal}"), file=sys.stderr)
    except OSError as error:
        print(printable(f"error: {error.filename or arguments.output}: {error.strerror}"), file=sys.stderr)
    return 2


def swept(arguments, others):
    sweep = Sweep(arguments.sweep)
    rows = sweep.rows()
    jobs.require_programs()
    if arguments.plan:
        print(f"{len(rows)} cases of {sum(p.varies for p in sweep.parameters)} parameters")
        return 0
    out = Path(jobs.plain(os.path.realpath(arguments.output)))
    out.mkdir(parents=True, exist_ok=True)
    # held until this program ends
    with files.lock(out / "lock") as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise Refused(f"{out}: another sweep runs here: wait for it") from None
        # Snakemake would run Python that lies there, and needs nothing of it
        shutil.rmtree(out / ".snakemake", ignore_errors=True)
        plan = jobs.write(sweep, out)
        if arguments.retry:
            forget_failures(out)
        code = run(snakemake(out, others), plan, out)
        return summary(out, len(plan["cases"])) if code == 0 else unfinished(out, code)


def run(command, plan, out):
    """Snakemake's exit code; meanwhile, how far it is."""
    cases = {case["key"] for case in plan["cases"]}
    # Nothing that lies in the results, or where the sweep was started, is a module of Python or a profile of Snakemake.
    clean = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    child = subprocess.Popen(command, cwd=HERE, env=clean)
    signal.signal(signal.SIGTERM, lambda *_: child.terminate())
    before = None
    while True:
        try:
            return child.wait(PROGRESS)
        except subprocess.TimeoutExpired:
            done = sum((out / "cases" / case / "step.json").exists() for case in cases)
            if done != before:
                print(f"sweep: {done} of {len(cases)} cases", file=sys.stderr)
            before = done
        except KeyboardInterrupt:
            child.wait()
            return 130


def snakemake(out, others):
    """Our lock is released when a sweep is killed; Snakemake's is not."""
    given = " ".join(others)
    profiled = "--profile" in given
    cores = [] if any(flag in given for flag in ("--cores", "-c", "--jobs", "-j")) or profiled else ["--cores", "all"]
    quiet = [] if any(flag in given for flag in ("--quiet", "--verbose", "--dry-run")) else ["--quiet", "all"]
    return [
        # of this Python, whose packages it has
        sys.executable, "-Es", str(Path(sys.executable).with_name("snakemake")),
        "--snakefile", str(HERE / "Snakefile"), "--directory", str(out),
        # a profile is code: no folder has one that Snakemake would find by itself
        "--workflow-profile", "none", *([] if profiled else ["--profile", "none"]),
        "--nolock", "--rerun-incomplete", "--keep-going", "--rerun-triggers", "mtime",
        # of 10 000 jobs that are ready, only some are looked at each time
        "--scheduler", "greedy", "--scheduler-subsample", "200", *cores, *quiet, *others,
        # table and page are always ours
        "--forcerun", "table",
    ]


def forget_failures(out):
    for step in [*out.glob("bodies/*/step.json"), *out.glob("cases/*/step.json")]:
        if b'"status": "failed"' in step.read_bytes():
            step.unlink()


def unfinished(out, code):
    done = sum(1 for _ in out.glob("cases/*/step.json"))
    print(f"sweep: not finished, {done} cases are done and kept: the same command continues", file=sys.stderr)
    return code if code in (130, 143) else 1


def summary(out, cases):
    """What came out; failures are named, and no reason to fail as long as a case went well."""
    csv.field_size_limit(sys.maxsize)
    with open(out / "table.csv", newline="") as table:
        failures = [row for row in csv.DictReader(table) if row["status"] == "failed"]
    shown = os.path.relpath(out)
    print(f"sweep: {cases - len(failures)} of {cases} cases in {shown}/table.csv and table.parquet, "
          f"all to be seen in {shown}/sweep.html")
    for row in failures[:5]:
        failure = row["failure"].splitlines()[0]
        print(printable(f"  case {row['case']} failed ({row['folder']}/log.txt): {failure}"), file=sys.stderr)
    if failures:
        more = f"and {len(failures) - 5} more; " if len(failures) > 5 else ""
        print(f"  {more}failed cases are kept; RETRY=yes (--retry) runs them again", file=sys.stderr)
    return 1 if len(failures) == cases else 0


if __name__ == "__main__":
    sys.exit(main())
