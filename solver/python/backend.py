"""Builds the Python package (PEP 517): the programs and the files that they share by cargo, then the wheel by maturin.

In the environment, PUFFER_GLIBC=2.17 builds for Linux with that glibc or a newer one, with Zig as linker; PUFFER_TARGET
is then the target of Rust, x86_64-unknown-linux-gnu if not given. PUFFER_LICENCES is a file with the licences of all
crates in the programs. Without them the wheel is for machines like this one.
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


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    """Builds a wheel and returns its name."""
    import maturin

    with _prepared():
        _put_programs_and_shared_files()
        os.environ["MATURIN_PEP517_ARGS"] = " ".join(_arguments_of_maturin())
        if _glibc():
            # The linker of maturin has another name than that of cargo-zigbuild, so that each would discard what the
            # other has compiled.
            os.environ["CARGO_TARGET_DIR"] = str(_compiled() / "python")
        return maturin.build_wheel(wheel_directory, config_settings, metadata_directory)


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


def _put_programs_and_shared_files():
    for folder in ("bin", "share"):
        shutil.rmtree(PACKAGE / folder, ignore_errors=True)
    (PACKAGE / "bin").mkdir()
    schemas = PACKAGE / "share/puffer/schemas"
    schemas.mkdir(parents=True)
    built = _built(_target())
    own = built if _runs(built / "solver") else _built("")
    for name in PROGRAMS:
        _put_stripped(built / name, PACKAGE / "bin" / name)
        _said(own / name, "shell-files", PACKAGE / "share")
        for line in _said(own / name, "schema").splitlines():
            kind = line.split()[0]
            (schemas / f"{kind}.json").write_text(_said(own / name, "schema", kind))
    for path in SHARED:
        shutil.copy(ROOT / path, PACKAGE / "share/puffer")
    sweep = ROOT / "pipelines/sweep"
    for path in (path for pattern in SWEEP for path in sweep.glob(pattern) if path.is_file()):
        place = PACKAGE / "share/puffer/sweep" / path.relative_to(sweep)
        place.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(path, place)
    if sys.version_info >= (3, 11):
        (schemas / "sweep.json").write_text(_said(sys.executable, "-B", sweep / "schema.py"))
    licences = os.environ.get("PUFFER_LICENCES")
    if licences:
        shutil.copy(licences, PACKAGE / "share/puffer/LICENCES")


def _glibc():
    return os.environ.get("PUFFER_GLIBC", "")


def _target():
    """Target of Rust where Zig links, else nothing, which is that of this machine."""
    return os.environ.get("PUFFER_TARGET", "x86_64-unknown-linux-gnu") if _glibc() else ""


def _arguments_of_maturin():
    if not _glibc():
        return ["--locked"]
    return ["--locked", "--zig", "--target", _target(), "--compatibility", "manylinux_" + _glibc().replace(".", "_")]


def _built(target):
    """The folder of the programs, which are brought up to date."""
    packages = [word for name in PROGRAMS for word in ("-p", name)]
    verb = ["zigbuild", "--target", f"{target}.{_glibc()}"] if target else ["build"]
    subprocess.run(["cargo", *verb, "--release", "--locked", *packages], cwd=ROOT, check=True)
    return _compiled() / target / "release"


def _compiled():
    return Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))


def _put_stripped(source, place):
    native = not _target() or _target().startswith(platform.machine())
    strip = ["strip", "-o", place, source] if native else [
        sys.executable, "-m", "ziglang", "objcopy", "--strip-all", source, place]
    subprocess.run(strip, check=True)
    place.chmod(0o755)
    versions = {tuple(map(int, found)) for found in re.findall(rb"GLIBC_(\d+)\.(\d+)", place.read_bytes())}
    if _glibc() and max(versions) > tuple(map(int, _glibc().split("."))):
        sys.exit(f"{place}: needs glibc {max(versions)}, more than {_glibc()}")


def _runs(program):
    """Whether this machine can run a program: its own, or with QEMU another's."""
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
