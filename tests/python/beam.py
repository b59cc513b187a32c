"""The beam, from an installed package to a page and a verified mold, by its commands one after the other: for systems
without make. Run it in an empty folder. It ends with 1 where a command fails or the mold does."""

import subprocess
import sys
from pathlib import Path

COMMANDS = """
cad2fem new mine --like beam
cad2fem model mine/model.toml -o mine/build/model
cad2fem tetmesh mine/build/model/model.stl --config mine/cad2fem.toml -o mine/build/volume.msh
tagger tag mine/build/volume.msh --config mine/tags.toml --patches mine/build/model/patches -o mine/build/tagged.msh
solver simulate mine/sim.toml --curve -o mine/build/baseline
solver optimize mine/design.toml -o mine/build/optimize
solver simulate mine/sim.toml --mesh mine/build/optimize/design.msh --curve -o mine/build/optimized
fab mold mine/build/optimize/design.msh --model mine/build/model/model.stl --from mine/build/tagged.msh --config mine/mold.toml -o mine/build/mold
fab verify mine/build/mold --simulation mine/build/optimized -o mine/build/mold.checks.txt
cad2fem report mine/build -o mine/build/report.html
cad2fem pack mine/build --sources mine -o mine/build/mine.zip
"""


def main():
    for command in COMMANDS.strip().splitlines():
        print(f"$ puffer {command}", flush=True)
        if subprocess.run([sys.executable, "-m", "softpuffer", *command.split()]).returncode:
            sys.exit(1)
    import softpuffer

    checks = Path("mine/build/mold.checks.txt").read_text(encoding="utf-8").splitlines()
    failed = [line for line in checks if "FAIL" in line]
    page = Path("mine/build/report.html").stat().st_size
    print(f"softpuffer {softpuffer.__version__}: page {page / 1e6:.1f} MB, {len(checks)} lines of checks, {len(failed)} failed")
    sys.exit(1 if failed or len(checks) < 10 or page < 1e5 else 0)


if __name__ == "__main__":
    main()
