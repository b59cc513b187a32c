"""Hostile sweep.toml: `sweeps.py PIPELINES/SWEEP FOLDER CASES SEED`, by structure-aware mutations.

FOLDER holds sim.toml and its like. Each case is one error of a few lines with exit code 2, or a sweep whose folders
are written. Anything else ends this program with the sweep that did it.
"""

import contextlib
import io
import os
import random
import shutil
import sys
import time
from pathlib import Path

SWEEP, FOLDER, CASES, SEED = Path(sys.argv[1]), Path(sys.argv[2]), int(sys.argv[3]), int(sys.argv[4])
sys.path.insert(0, str(SWEEP))
os.chdir(FOLDER)
import files  # noqa: E402
import jobs  # noqa: E402
import keys  # noqa: E402
import plan  # noqa: E402
import sweep  # noqa: E402

# Longest time of the processor that a case may take [s].
SLOWEST = 10
VALUES = [
    "0", "-1", "1", "2", "1e155", "1e308", "-1e308", "5e-324", "-0.0", "nan", "inf", "-inf", "100_000", "1000001",
    "9223372036854775807", "-9223372036854775808", "9223372036854775808", "1" + "0" * 400, "1" + "0" * 5000,
    "0x" + "f" * 5000, "1e999", "0.1", "true", "false", '""', '"x"', "'a b'", '"\\u0000"', '"\\u001b[31m"', '"\\u202e"',
    '"/dev/zero"', '"fifo"', '"loop.toml"', '"deep.toml"', '"' + "n" * 5000 + '"', '"../../../../etc/passwd"', '"{x}"',
    '"\'"', '"--output x"', '"-o x"', '"--color"', "'''\na\nb'''", "[]", "[[]]", "[1, [2, [3]]]", "[nan]", "[true, 1, 'a']", "{}",
    "{ a = 1 }", "[{}]", "1979-05-27", "07:32:00", "1979-05-27T07:32:00Z", "[1979-05-27]", "[" * 3000 + "]" * 3000,
    '"grid"', '"list"', '"latin"', '"log"', '"sim.toml"', '"model.toml"', '"tetmesh.edge_length"', '["degree", "degree"]',
    "[1, 2, 3]", "[1e308, 5e-324]", '["a", "b"]', "1e5", "3", "100000000000", '"{body}/x"',
]
NAMES = ["p", "q", '"a b"', '"\\u001b]0;x\\u0007"', '"__proto__"', "status", "case", '""', '"' + "k" * 400 + '"', "p.q", '"é"', '"<b>"']
BASE = [("kind", '"grid"'), ("simulate", '"sim.toml"')]
PARAMETER = [("file", '"sim.toml"'), ("set", '"chamber.cavity.pressure"')]


def lines(chance):
    """A sweep with some of its values, keys and tables changed."""
    top = dict(BASE)
    top["kind"] = chance.choice(['"grid"', '"list"', '"latin"'])
    if top["kind"] == '"latin"':
        top["cases"] = "5"
    tables = []
    for name in chance.sample(NAMES, chance.choice([1, 1, 2, 3])) if chance.random() < 0.5 else ["p", "q"]:
        table = dict(PARAMETER)
        table |= chance.choice([{"values": "[1, 2]"}, {"value": "3"}, {"from": "1", "to": "2", "count": "2"}])
        if "cases" in top:
            table.pop("count", None)
        if chance.random() < 0.95:
            table["set"] = f'"degree{len(tables)}"'
        tables.append((name, table))
    for _ in range(chance.choice([1, 1, 1, 2, 3])):
        table, known = chance.choice([(top, keys.KEYS), (chance.choice(tables)[1], keys.PARAMETER_KEYS)])
        key = chance.choice([*known, *table]) if chance.random() < 0.95 else chance.choice(NAMES)
        if chance.random() < 0.15:
            table.pop(key, None)
        else:
            table[key] = chance.choice(VALUES)
    yield from (f"{key} = {value}" for key, value in top.items())
    for name, table in tables:
        yield f"[parameters.{name}]" if chance.random() < 0.97 else chance.choice([f"[[parameters.{name}]]", "[parameters", f"[{name}]"])
        yield from (f"{key} = {value}" for key, value in table.items())


def bytes_of(chance):
    text = "\n".join(lines(chance)).encode()
    if chance.random() < 0.1:
        at = chance.randrange(len(text))
        text = text[:at] + chance.choice([b"\xff\xfe", b"\x00", b"\r", b"\xed\xa0\x80", b"[", b'"', b"#", text[:at]]) + text[at:]
    return text


def outcome():
    """Exit code of the check, and what it said; folders are written where there are few."""
    said = io.StringIO()
    sys.argv = ["sweep.py", "sweep.toml", "-o", "out", "--plan"]
    with contextlib.redirect_stderr(said), contextlib.redirect_stdout(said):
        code = sweep.main()
    if code == 0 and int(said.getvalue().split()[0]) <= 30:
        try:
            out = Path("out")
            out.mkdir()
            files.prepare(out)
            jobs.write(plan.Sweep("sweep.toml"), out)
        finally:
            shutil.rmtree("out", ignore_errors=True)
    return code, said.getvalue()


def main():
    counts = {0: 0, 2: 0}
    for case in range(CASES):
        chance = random.Random(SEED * 1_000_000 + case)
        text = bytes_of(chance)
        Path("sweep.toml").write_bytes(text)
        begun = time.process_time()
        try:
            code, said = outcome()
            assert code in counts, f"exit code {code}"
            assert code == 0 or said.startswith("error: ") and said.count("\n") <= 5 and len(said) < 3000, said
            assert all(c == "\n" or c.isprintable() for c in said), said
            assert time.process_time() - begun < SLOWEST, "slow"
        except BaseException:
            print(f"case {case}: {text[:3000]!r}", file=sys.stderr)
            raise
        counts[code] += 1
    # most are wrong, and some are sound
    assert min(counts.values()) > CASES // 50, counts
    print(counts)


main()
