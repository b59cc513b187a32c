"""Builds the Python package (PEP 517): cargo compiles the programs and the module that Python loads, maturin writes the
metadata, and `wheel` packs both with the files that all programs share.

In the environment, PUFFER_TARGET is the target of Rust to build for, where it is not this machine, and PUFFER_COMPILE
the command that compiles the programs for it. PUFFER_LICENCES is a file with the licences of all crates in them.
Without these the wheel is for machines like this one.
"""

import io
import os
import platform
import re
import shutil
import subprocess
import sys
import tarfile
import tempfile
from contextlib import contextmanager
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
PACKAGE = HERE / "softpuffer"
PROGRAMS = ("cad2fem", "tagger", "solver", "fab")
# What is in the wheel beside the programs: shared by them, or named by its metadata.
SHARED = ("pipelines/chain.mk", "pipelines/folder.mk", "pipelines/gallery.py")
SWEEP = ("*.py", "Snakefile", "web/**/*", "vendor/**/*")
LICENCES = ("LICENSE-MIT", "LICENSE-APACHE")
# The module, as cargo names it on Linux, macOS and Windows.
MODULES = ("lib_native.so", "lib_native.dylib", "_native.dll")


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    """Builds a wheel and returns its name."""
    from wheel.wheelfile import WheelFile

    with tempfile.TemporaryDirectory() as folder:
        package = Path(folder) / PACKAGE.name
        shutil.copytree(PACKAGE, package, ignore=shutil.ignore_patterns("__pycache__"))
        _put_programs(package)
        _put_shared_files(package / "share/puffer")
        tag = f"cp310-abi3-{_platform(package)}"
        metadata = Path(folder) / prepare_metadata_for_build_wheel(folder)
        (metadata / "WHEEL").write_text(f"Wheel-Version: 1.0\nGenerator: softpuffer\nRoot-Is-Purelib: false\nTag: {tag}\n")
        name = f"{metadata.stem}-{tag}.whl"
        with WheelFile(Path(wheel_directory) / name, "w") as wheel:
            wheel.write_files(folder)
    return name


def prepare_metadata_for_build_wheel(metadata_directory, config_settings=None):
    """Writes the metadata of a wheel and returns the name of their folder."""
    import maturin

    with _prepared():
        return maturin.prepare_metadata_for_build_wheel(metadata_directory, config_settings)


def build_sdist(sdist_directory, config_settings=None):
    """Packs all files that git knows, with pyproject.toml at the top, and returns the name of the archive."""
    version = _version()
    name = f"softpuffer-{version}"
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, check=True, capture_output=True, text=True)
    project = (HERE / "pyproject.toml").read_text().replace('backend-path = ["."]', 'backend-path = ["solver/python"]')
    with tarfile.open(Path(sdist_directory) / f"{name}.tar.gz", "w:gz", format=tarfile.PAX_FORMAT) as archive:
        for path in sorted(filter(None, listed.stdout.split("\0"))):
            archive.add(ROOT / path, f"{name}/{path}", recursive=False, filter=_anonymous)
        for path, text in (("pyproject.toml", project), ("PKG-INFO", _metadata())):
            entry = tarfile.TarInfo(f"{name}/{path}")
            entry.size = len(text.encode())
            archive.addfile(entry, io.BytesIO(text.encode()))
    return f"{name}.tar.gz"


@contextmanager
def _prepared():
    """In the folder of the package, with the licences in it and the tools of this Python before others."""
    before, path = os.getcwd(), os.environ.get("PATH", "")
    for name in LICENCES:
        shutil.copy(ROOT / name, HERE / name)
    os.environ["PATH"] = os.pathsep.join((str(Path(sys.executable).parent), path))
    os.chdir(HERE)
    try:
        yield
    finally:
        os.chdir(before)
        os.environ["PATH"] = path


def _put_programs(package):
    """Programs, what they say of themselves, and the module."""
    built, windows = _compiled(_target()), "windows" in _system()
    suffix = ".exe" if windows else ""
    schemas = package / "share/puffer/schemas"
    schemas.mkdir(parents=True)
    (package / "bin").mkdir()
    own = built if _runs(built / f"solver{suffix}") else _compiled("")
    for name in PROGRAMS:
        _put_stripped(built / (name + suffix), package / "bin" / (name + suffix))
        _said(own / name, "shell-files", package / "share")
        for line in _said(own / name, "schema").splitlines():
            kind = line.split()[0]
            (schemas / f"{kind}.json").write_text(_said(own / name, "schema", kind))
    module = next(path for path in map(built.joinpath, MODULES) if path.exists())
    _put_stripped(module, package / ("_native.pyd" if windows else "_native.abi3.so"))


def _put_shared_files(share):
    for path in SHARED:
        shutil.copy(ROOT / path, share)
    sweep = ROOT / "pipelines/sweep"
    for path in (path for pattern in SWEEP for path in sweep.glob(pattern) if path.is_file()):
        place = share / "sweep" / path.relative_to(sweep)
        place.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(path, place)
    if sys.version_info >= (3, 11):
        (share / "schemas/sweep.json").write_text(_said(sys.executable, "-B", sweep / "schema.py"))
    licences = os.environ.get("PUFFER_LICENCES")
    if licences:
        shutil.copy(licences, share / "LICENCES")


def _target():
    """Target of Rust, nothing for that of this machine."""
    return os.environ.get("PUFFER_TARGET", "")


def _system():
    return _target() or {"win32": "windows"}.get(sys.platform, sys.platform)


def _compiled(target):
    """The folder of the programs and of the module, which are brought up to date. All packages at once, as `make setup`
    does: for some of them, cargo would compile what they build on with other features."""
    own = "cargo build --release --locked --workspace --bins"
    if sys.platform == "win32":
        own += " --exclude tests"  # which are for Unix
    command = (os.environ["PUFFER_COMPILE"] if target else own).split()
    # that of the stable ABI: which Python is here does not count, and nothing is compiled again for another one
    environment = os.environ | {"PYO3_NO_PYTHON": "1"}
    subprocess.run([*command, "--lib"], cwd=ROOT, env=environment, check=True)
    return Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / target / "release"


def _put_stripped(source, place):
    """PUFFER_COMPILE may have stripped what it compiled; on Windows itself, symbols are in files of their own."""
    strip = os.environ.get("PUFFER_STRIP", "" if _target() or sys.platform == "win32" else "strip")
    if not strip:
        shutil.copy(source, place)
    else:
        subprocess.run([strip, *(["-x"] if sys.platform == "darwin" else []), "-o", place, source], check=True)
        place.chmod(0o755)


def _platform(package):
    """The platform in the tag: for Linux by the glibc that programs and module ask for."""
    machine = _target().split("-")[0] or platform.machine().lower()
    if "windows" in _system():
        return "win_" + machine.replace("x86_64", "amd64")
    if "darwin" in _system():
        # on ARM the oldest that the mesher has a wheel for, else the oldest that Rust compiles for
        return "macosx_15_0_arm64" if machine in ("arm64", "aarch64") else "macosx_10_12_x86_64"
    files = [*(package / "bin").iterdir(), package / "_native.abi3.so"]
    asked = {tuple(map(int, v)) for file in files for v in re.findall(rb"GLIBC_(\d+)\.(\d+)", file.read_bytes())}
    return "manylinux_{}_{}_{}".format(*max(asked), machine) if asked else f"linux_{machine}"


def _runs(program):
    """Whether this machine can run a program: its own, or with QEMU or Wine another's."""
    try:
        return subprocess.run([program, "--version"], capture_output=True).returncode == 0
    except OSError:
        return False


def _said(*command):
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def _version():
    return re.search(r'^version = "(.*)"', (ROOT / "Cargo.toml").read_text(), re.MULTILINE)[1]


def _metadata():
    """That of a wheel, which pip wants to read of the sources, too."""
    with tempfile.TemporaryDirectory() as folder:
        return (Path(folder) / prepare_metadata_for_build_wheel(folder) / "METADATA").read_text()


def _anonymous(entry):
    entry.uid = entry.gid = 0
    entry.uname = entry.gname = ""
    return entry
