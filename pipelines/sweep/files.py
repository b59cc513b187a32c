"""Files that are read whole, and written so that they appear whole or not at all."""

import os
import tomllib
import unicodedata
from pathlib import Path

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
        return Path(path).read_text(encoding="utf-8")
    except (OSError, ValueError) as error:
        raise Refused(f"{path}: {getattr(error, 'strerror', None) or error}") from None


def parsed(path, text):
    """The content of a file in TOML; where it is none, tomllib.TOMLDecodeError says where."""
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise Refused(f"{path}: nested too deeply") from None


def lock(path):
    """An open file that is ours to lock; its content does not matter."""
    return open(path, "ab")


def replace(path, write, sync=False):
    """A file that appears whole: `write` gets it as a binary file. With `sync`, it outlasts a loss of power."""
    partial = path.with_name(path.name + ".partial")
    with open(partial, "wb") as file:
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
