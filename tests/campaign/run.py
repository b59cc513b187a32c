"""Random bodies from their files to verified molds, and what became of them, by family.

    python run.py PROGRAMS FOLDER [--count 200] [--seed 0] [--family NAME] [--jobs 2] [--seconds 1e9]
                  [--made] [--later | --judge]

Makes the bodies (bodies.py) unless they are there (--made), runs each through the programs, and writes
FOLDER/results.jsonl, one line a body. A refusal counts as right if verdict.py finds from the model alone that the
body cannot be cast; that takes seconds each and numpy, and can come --later, when results that are there get verdicts
by --judge. Bodies whose turn does not come within --seconds are left out. Fetches nothing.
"""

import argparse
import concurrent.futures
import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import threading
import time

# The longest time of one command [s].
LONGEST = 900
# Whether a program ended as it should, with a result or a refusal.
REFUSED = (1, 2)
# Part of the bodies that may fail for no reason that the model shows.
MOST_WRONG = 0.03
FAMILIES = ("shells", "lattices", "fillets", "lofts", "periodic", "scans")


def chain(folder):
    """The commands by the stage they belong to."""
    cad, skin = folder / "model.step", folder / "skin.stl"
    if skin.exists():
        brought = ["import", skin, "--subtract", folder / "cavity.stl", "--unit", "mm"]
    else:
        brought = ["model", cad if cad.exists() else folder / "model.toml"]
    yield "model", ["cad2fem", *brought, "-o", folder / "model"]
    yield "mesh", ["cad2fem", "tetmesh", folder / "model/model.stl", "--config", folder / "cad2fem.toml",
                   "--no-cache", "-o", folder / "volume.msh"]
    yield "tags", ["tagger", "tag", folder / "volume.msh", "--config", folder / "tags.toml",
                   "--patches", folder / "model/patches", "-o", folder / "tagged.msh"]
    yield "mold", ["fab", "mold", folder / "tagged.msh", "--model", folder / "model/model.stl",
                   "--config", folder / "mold.toml", "--no-pictures", "-o", folder / "mold"]
    yield "verify", ["fab", "verify", "--all", folder / "mold"]


def run(command, log):
    """Exit code, none after a signal or too long a time; and seconds of processor time."""
    log.write(f"$ {' '.join(map(str, command))}\n")
    log.flush()
    threads = {**os.environ, "RAYON_NUM_THREADS": "1"}
    command = [str(part) for part in command]
    started = subprocess.Popen(command, stdout=log, stderr=log, env=threads, process_group=0)
    timer = threading.Timer(LONGEST, os.killpg, (started.pid, signal.SIGKILL))  # with its mesher
    timer.start()
    _, status, usage = os.wait4(started.pid, 0)
    timer.cancel()
    code = os.waitstatus_to_exitcode(status)
    started.returncode = code
    log.write(f"# ends with {code} after {usage.ru_utime + usage.ru_stime:.1f} s\n")
    log.flush()
    return (code if code >= 0 else None), usage.ru_utime + usage.ru_stime


def attempt(programs, folder):
    """What becomes of a body: the stage that it reaches, what was said there, seconds by stage."""
    facts = folder / "facts.json"
    if not facts.exists():
        family, seed = folder.name.split("-")
        return {"family": family, "seed": int(seed), "kind": "?", "end": "no body is made", "said": "", "seconds": {}}
    result = {**json.loads(facts.read_text()), "end": "verified", "said": "", "seconds": {}}
    shutil.rmtree(folder / "mold", ignore_errors=True)
    with open(folder / "log.txt", "w+") as log:
        for stage, (program, *arguments) in chain(folder):
            start = log.tell()
            code, seconds = run([programs / program, *arguments], log)
            result["seconds"][stage] = round(seconds, 2)
            if code == 0:
                continue
            log.seek(start)
            said = log.read()
            died = code not in REFUSED or "panicked" in said
            result |= {"end": f"{stage} {'dies' if died else 'refuses'}", "said": said[-3000:]}
            break
    return result


def judge(folder, result):
    """Adds whether the model alone shows that a refusal of `fab mold` is right, where there is numpy to find out."""
    if result["end"] != "mold refuses":
        return result
    import verdict
    right, why = verdict.cannot_be_cast(folder)
    return result | {"right": right, "why": why}


def table(results):
    """One line a family."""
    head = ("family", "bodies", "modelled", "meshed", "tagged", "verified", "rightly", "wrongly", "s each")
    lines = [head]
    for family in (*FAMILIES, "all"):
        own = [r for r in results if family in (r["family"], "all")]
        if not own:
            continue
        stages = ("model", "mesh", "tags")
        left, counts = len(own), []
        for stage in stages:
            left -= sum(r["end"].startswith(stage) for r in own)
            counts.append(left)
        verified = sum(r["end"] == "verified" for r in own)
        rightly = sum(bool(r.get("right")) for r in own)
        each = sum(sum(r["seconds"].values()) for r in own) / len(own)
        lines.append((family, len(own), *counts, verified, rightly, len(own) - verified - rightly, f"{each:.1f}"))
    for line in lines:
        print("".join(f"{cell!s:>10}" for cell in line))
    for stage in ("model", "mesh", "tags", "mold", "verify"):
        times = sorted(r["seconds"].get(stage, 0.0) for r in results)
        if times:
            mean = sum(times) / len(times)
            print(f"{stage:>10}: {mean:.1f} s of processor time in the mean, {times[-1]:.1f} s at most")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("programs", type=pathlib.Path)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--family", choices=FAMILIES)
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--seconds", type=float, default=1e9)
    for flag in ("--made", "--later", "--judge"):
        parser.add_argument(flag, action="store_true")
    asked = parser.parse_args()
    asked.folder.mkdir(parents=True, exist_ok=True)
    families = [asked.family] if asked.family else FAMILIES
    wanted = [(family, seed) for seed in range(asked.seed, asked.seed + asked.count) for family in families]
    found = known(asked) if asked.judge else made(asked, wanted)
    results, path = [], asked.folder / "results.jsonl"
    with open(path.with_suffix(".incomplete"), "w") as lines:
        for result in found:
            if not asked.later:
                result = judge(asked.folder / f"{result['family']}-{result['seed']}", result)
            results.append(result)
            lines.write(json.dumps(result) + "\n")
            lines.flush()
            right = {None: "", True: ", rightly", False: ", WRONGLY"}[result.get("right")]
            body = f"{result['family']:>9} {result['seed']:>4} {result['kind']:<9}"
            print(f"{body} {result['end']}{right}", flush=True)
    path.with_suffix(".incomplete").replace(path)
    table(results)
    if not asked.judge and len(results) < len(wanted):
        print(f"{len(wanted) - len(results)} bodies were left out for want of time")
    wrong = sum(r["end"] != "verified" and not r.get("right") for r in results)
    sys.exit(wrong > MOST_WRONG * len(results) or any(r["end"].startswith("model") for r in results))


def known(asked):
    return [json.loads(line) for line in (asked.folder / "results.jsonl").read_text().splitlines()]


def made(asked, wanted):
    """Results as they come."""
    programs, until = asked.programs.resolve(), time.monotonic() + asked.seconds
    # gmsh, which makes bodies and is asked by verdicts, works in the first thread only
    for family, seed in [] if asked.made else wanted:
        import bodies
        bodies.make(asked.folder, family, seed)

    def one(body):
        family, seed = body
        return attempt(programs, asked.folder / f"{family}-{seed}") if time.monotonic() < until else None

    with concurrent.futures.ThreadPoolExecutor(asked.jobs) as pool:
        for job in concurrent.futures.as_completed([pool.submit(one, body) for body in wanted]):
            if job.result() is not None:
                yield job.result()


if __name__ == "__main__":
    main()
