"""Files of others: only plain files are read, of bounded size and in bounded time, and no link is followed.

A results folder may come from others, too. What is written there replaces what had the name: it never goes through a
link. `prepare` refuses a folder with links, pipes or devices in it, and removes what Snakemake keeps there.
"""

import os
import shutil
import signal
import stat
import tomllib
import unicodedata
from contextlib import contextmanager
from pathlib import Path

# Largest file that is read [bytes], and longest time to understand it [s].
LARGEST = 16_000_000
LONGEST = 60
# Longest line that a message shows of a file or a program [characters].
LINE = 300


class Refused(Exception):
    """What cannot be used: file, line, what was found, what to do."""


def printable(text):
    """Text for a terminal: no control characters, and of long lines the beginning."""
    plain = "".join(c if c in "\n\t" or not unicodedata.category(c).startswith("C") else repr(c)[1:-1] for c in text)
    return "\n".join(line if len(line) <= LINE else f"{line[:LINE]}…" for line in plain.split("\n"))


def is_file(path):
    """A plain file; a name that no file can have is none."""
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False


def read(path):
    """The text of a file."""
    try:
        with os.fdopen(os.open(path, os.O_RDONLY | os.O_NONBLOCK), "rb") as file:
            if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
                raise Refused(f"{path}: no plain file")
            text = file.read(LARGEST + 1)
        if len(text) > LARGEST:
            raise Refused(f"{path}: larger than {LARGEST // 1_000_000} MB, which is the most that is read")
        return text.decode()
    except (OSError, ValueError) as error:
        raise Refused(f"{path}: {getattr(error, 'strerror', None) or error}") from None


def parsed(path, text):
    """The content of a file in TOML; where it is none, tomllib.TOMLDecodeError says where."""
    try:
        with at_most(LONGEST):
            return tomllib.loads(text)
    except tomllib.TOMLDecodeError:
        raise
    except TimeoutError:
        raise Refused(f"{path}: not understood after {LONGEST} s; is it nested, or has it very long keys?") from None
    except RecursionError:
        raise Refused(f"{path}: nested too deeply") from None
    except ValueError as error:
        raise Refused(f"{path}: {error}") from None


@contextmanager
def at_most(seconds):
    def late(*_):
        raise TimeoutError

    before = signal.signal(signal.SIGALRM, late)
    signal.alarm(seconds)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


def prepare(out):
    """Makes a results folder fit for use, whoever it comes from.

    Snakemake would run Python that lies in `.snakemake`. It needs nothing of it: a file of ours is there whole or not
    at all.
    """
    kept = out / ".snakemake"
    if kept.is_symlink() or kept.is_file():
        kept.unlink()
    elif kept.exists():
        shutil.rmtree(kept)
    folders = [out]
    while folders:
        with os.scandir(folders.pop()) as entries:
            for entry in entries:
                if entry.is_dir(follow_symlinks=False):
                    folders.append(Path(entry.path))
                elif not entry.is_file(follow_symlinks=False):
                    raise Refused(f"{entry.path}: a link, pipe or device among results, which are files: remove it")


def lock(path):
    """An open file that is ours to lock; its content does not matter."""
    flags = os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW | os.O_NONBLOCK
    return os.fdopen(os.open(path, flags, 0o644), "r+b", buffering=0)


def create(path):
    """A new file to write, in the place of what had the name."""
    path.unlink(missing_ok=True)
    return os.fdopen(os.open(path, os.O_RDWR | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW, 0o644), "w+b")


def replace(path, write, sync=False):
    """A file that appears whole: `write` gets it as a binary file. With `sync`, it outlasts a loss of power."""
    partial = path.with_name(path.name + ".partial")
    with create(partial) as file:
        write(file)
        if sync:
            file.flush()
            os.fsync(file.fileno())
    partial.replace(path)


def write_if_new(path, text):
    """Files keep their times where nothing changes: Snakemake goes by them."""
    content = text.encode()
    if path.is_file() and path.read_bytes() == content:
        return
    replace(path, lambda file: file.write(content))
