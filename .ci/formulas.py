"""Formulas of the book as MathML, which browsers draw without scripts, fonts or network.

A preprocessor of mdBook: it reads the book as JSON and turns ```math blocks and $`…`$, written in TeX as on GitHub, into
MathML. `make book` runs it in .cargo-tools/math, where latex2mathml (MIT) is.
"""

import json
import re
import sys

from latex2mathml.converter import convert

BLOCK = re.compile(r"^```math\n(.*?)\n```$", re.MULTILINE | re.DOTALL)
INLINE = re.compile(r"\$`([^`]+)`\$")


def drawn(chapter):
    """A chapter with its formulas as MathML, and those below it."""
    text = BLOCK.sub(lambda m: convert(" ".join(m[1].split()), display="block"), chapter["content"])
    chapter["content"] = INLINE.sub(lambda m: convert(m[1]), text)
    for item in chapter["sub_items"]:
        if "Chapter" in item:
            drawn(item["Chapter"])


def main():
    if sys.argv[1:2] == ["supports"]:
        sys.exit(sys.argv[2:] != ["html"])
    _, book = json.load(sys.stdin)
    for item in book["items"]:
        if "Chapter" in item:
            drawn(item["Chapter"])
    json.dump(book, sys.stdout)


if __name__ == "__main__":
    main()
