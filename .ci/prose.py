"""The English of READMEs and the book: proselint, and a small style of our own.

`make lint` installs proselint (.ci/prose.txt) and runs `.cargo-tools/prose/bin/python .ci/prose.py [FILE.md ...]`. It
skips code, commands, comments and addresses. Exit codes: 0 nothing found, 1 something, which is printed with its line.
"""

import re
import sys
from pathlib import Path

from proselint.checks import __register__
from proselint.registry import CheckRegistry
from proselint.registry.checks import Check, CheckResult, types
from proselint.tools import LintFile

TOP = Path(__file__).resolve().parent.parent
PAGES = ["README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "SECURITY.md", "solver/python.md", "*/README.md",
         "pipelines/*/README.md", "pipelines/*/*/README.md", "pipelines/book/*.md", "pipelines/paper/*.md"]
# Chapters that programs print, where `make book` has left them; tests/fast/book.rs lints them.
PRINTED = re.compile(r"keys-.*\.md|python-api\.md")

# What proselint checks, less what is about typography, other fields of writing, or wrong in tables.
KNOWN = ["archaism", "cliches", "hedging", "industrial_language", "malapropisms", "misc", "mixed_metaphors",
         "needless_variants", "nonwords", "oxymorons", "redundancy", "uncomparables", "weasel_words"]

# Phrases that readers had to read twice, and what to write. A blank stands for any white space.
BEGIN = r"(?:^|\n\n|[.:;] )(?:[-*] )?"
STYLE = [
    (r"\b(?:is|are|was|were) none\b", "name what is missing: `there is no ...`"),
    (r"\bin vain\b", "say that it failed"),
    (r"\bbut for\b", "except"),
    (r"\banew\b", "again"),
    (r"\bderivatives? knows?\b", "`gradients include ...`"),
    (BEGIN + r"(?:That|Those|The ones|The same) of\b", "begin with the noun"),
    (BEGIN + r"Its [a-z]+\.", "a sentence has a verb"),
    (r"\bfor want of\b", "because there is no ..."),
    (r"\b(?:is|are|was|were) of (?:the|a|an|what|another|others?)\b", "`comes from`, `has`, `belongs to`"),
    (r"\bof others\b", "of other people, or of other programs"),
    (r"\b(?:is|are|has to be|have to be|was|were) told\b", "who says it to whom?"),
    (r"\bnor the other way round\b", "say the second half, too"),
    (r"\bshall\b", "should, or must"),
    (r"\bas it were\b", "leave it out"),
    (r"\bwho(?:ever|soever)\b", "if you ..."),
    (r"\b(?:lest|save that|be it|were it)\b", "today's English"),
    (r"\bso much (?:thinner|thicker|larger|smaller)\b", "by how much?"),
    (r"\bgives? way\b", "deforms, yields or moves"),
]
# Words in a sentence. Longer ones hold more than one thought.
LONGEST = 36


def prose(text):
    """The text with all that is not prose blanked out, each line where it was."""
    def blank(match):
        return re.sub(r"[^\n]", " ", match[0])

    for what in [r"^```.*?^```", r"<!--.*?-->", r"^    .*?$", r"`[^`\n]*(?:\n[^`\n]+)?`", r"\]\([^)]*\)",
                 r"https?://\S+", r"<[^>]*>"]:
        text = re.sub(what, blank, text, flags=re.MULTILINE | re.DOTALL)
    return text


def long_sentences(text, check):
    """Sentences of paragraphs with more than LONGEST words."""
    item = r" *(?:[-*]|\d+\.) "
    other = r"\||#|!\["
    for paragraph in re.finditer(rf"^(?!{other}).+\n?(?:^(?!{other}|{item}).+\n?)*", text, re.MULTILINE):
        for sentence in re.finditer(r"\S.*?(?:[.!?:](?=\s|$)|\Z)", paragraph[0], re.DOTALL):
            words = len(sentence[0].split())
            if words > LONGEST:
                start = paragraph.start() + sentence.start()
                yield CheckResult(check.path, f"{words} words in one sentence", (start, start + 1), None)


def rules():
    """Registers all checks."""
    registry = CheckRegistry()
    registry.register_many(__register__)
    for pattern, advice in STYLE:
        pattern = pattern.replace(" ", r"\s+")
        found = types.ExistenceSimple(pattern=pattern)
        registry.register(Check(check_type=found, path="puffer.style", message=f"'{{}}': {advice}"))
    registry.register(Check(check_type=long_sentences, path="puffer.long"))


def main():
    """Lints the given files, or all pages."""
    rules()
    config = {"max_errors": 1000, "checks": dict.fromkeys([*KNOWN, "puffer"], True)}
    files = [Path(name) for name in sys.argv[1:]]
    files = files or sorted({path for pattern in PAGES for path in TOP.glob(pattern)
                             if not {"vendor", "SUMMARY.md"} & set(path.parts) and not PRINTED.match(path.name)})
    count = 0
    for path in files:
        for found in LintFile(str(path), prose(path.read_text(encoding="utf-8"))).lint(config):
            line, column = found.pos
            print(f"{path}:{line}:{column}: {' '.join(found.check_result.message.split())}"
                  f" [{found.check_result.check_path}]")
            count += 1
    print(f"prose: {count} findings in {len(files)} files")
    return count > 0


if __name__ == "__main__":
    sys.exit(main())
