"""The public functions and classes of the package, from its sources, as a chapter of the book: `api.py`.

Reads signatures and docstrings without importing anything. Exit code 1 names what is public and has no docstring.
"""

import ast
import re
import sys
import textwrap
from pathlib import Path

PACKAGE = Path(__file__).resolve().parent / "softpuffer"
#: What people call a module, in the order of the chapter; those of `sp` are listed by `softpuffer/__init__.py`.
MODULES = {
    "body": "sp", "folders": "sp", "scene": "sp", "run": "sp", "responses": "sp", "designs": "sp",
    "torch": "sp.torch", "jax": "sp.jax", "fab": "sp.fab", "programs": "sp.programs",
}
#: Commands of pip, which `puffer --help` explains, are no functions for others.
COMMANDS = {"cad2fem", "tagger", "solver", "fab", "puffer"}
#: Values that a user gets and does not make, and helpers that other modules share.
MADE_ELSEWHERE = {"Run", "RunWarning", "UnusableRun", "Derivatives", "Design", "Response", "ProgramError"}
SHARED = {"Said", "check_unusable"}


def public(body):
    """The functions and classes among statements that people may use."""
    kinds = (ast.FunctionDef, ast.ClassDef)
    named = [node for node in body if isinstance(node, kinds) and not node.name.startswith("_")]
    return [node for node in named if "overload" not in decorators(node)]


def decorators(node):
    """The names of the decorators of a function."""
    return {ast.unparse(decorator) for decorator in node.decorator_list}


def signature(name, function):
    """A call with the types of what it takes and returns."""
    arguments = function.args
    given = arguments.posonlyargs + arguments.args
    bound = bool(given) and given[0].arg in ("self", "cls")
    without = ast.arguments(**{field: getattr(arguments, field) for field in arguments._fields})
    without.posonlyargs, without.args = [], given[bound:]
    returned = f" -> {ast.unparse(function.returns)}" if function.returns and name[-1] != ")" else ""
    # with a type, blanks stand around the default
    listed = [re.sub(r"^(\w+: .*?)=", r"\1 = ", part) for part in parts(ast.unparse(without))]
    line = f"{name}({', '.join(listed)}){returned}"
    if len(line) <= 100:
        return line
    one_each = ",\n    ".join(listed)
    return f"{name}(\n    {one_each},\n){returned}"


def parts(text):
    """The arguments of a list, split at the commas that are in no bracket."""
    found, depth = [""], 0
    for letter in text:
        depth += (letter in "([{") - (letter in ")]}")
        if letter == "," and depth == 0:
            found.append("")
        else:
            found[-1] += letter
    return [part.strip() for part in found]


def explained(node, name, missing):
    """The docstring as Markdown; each argument that it names is an item of a list."""
    text = ast.get_docstring(node)
    if not text:
        missing.append(name)
        return ""
    blocks = []
    for paragraph in text.split("\n\n"):
        # an argument begins a line, what is said of it goes on in lines that are indented
        items = re.split(r"\n(?=\w+: )", paragraph)
        if all(re.match(r"\w+: ", item) for item in items):
            blocks.append("\n".join(wrapped("- `{}`: {}".format(*item.split(": ", 1)), "  ") for item in items))
        elif paragraph.startswith("    "):
            blocks.append(f"```\n{textwrap.dedent(paragraph)}\n```")
        else:
            blocks.append(wrapped(paragraph))
    return "\n\n".join(blocks) + "\n"


def wrapped(text, indent=""):
    """Text in lines of at most 120 letters."""
    return textwrap.fill(" ".join(text.split()), 120, subsequent_indent=indent, break_long_words=False,
                         break_on_hyphens=False)


def entry(level, title, code, node, name, missing):
    """A heading, a signature and what it means."""
    return f"{'#' * level} {title}\n\n```python\n{code}\n```\n\n{explained(node, name, missing)}"


def of_class(node, place, missing):
    """The entries of a class."""
    name, own = f"{place}.{node.name}", node.name.lower()
    made = next((part for part in node.body if isinstance(part, ast.FunctionDef) and part.name == "__init__"), None)
    if node.name in MADE_ELSEWHERE or made is None:
        yield f"## {node.name}\n\n{explained(node, name, missing)}"
    else:
        yield entry(2, name, signature(name, made), node, name, missing)
    for part in public(node.body):
        if "staticmethod" in decorators(part) or any(of.endswith(".setter") for of in decorators(part)):
            continue
        if "property" in decorators(part):
            code = f"{own}.{part.name}: {ast.unparse(part.returns)}" if part.returns else f"{own}.{part.name}"
        else:
            code = signature(f"{name if 'classmethod' in decorators(part) else own}.{part.name}", part)
        yield entry(3, f"{own}.{part.name}", code, part, f"{name}.{part.name}", missing)


def chapter(missing):
    """All entries."""
    for module, place in MODULES.items():
        tree = ast.parse((PACKAGE / f"{module}.py").read_text())
        for node in public(tree.body):
            if node.name in SHARED or module == "programs" and node.name in COMMANDS:
                continue
            if isinstance(node, ast.ClassDef):
                yield from of_class(node, place, missing)
            else:
                name = f"{place}.{node.name}"
                yield entry(2, name, signature(name, node), node, name, missing)


def main():
    """Prints the chapter."""
    missing = []
    text = "\n".join(chapter(missing))
    if missing:
        print(f"api.py: no docstring: {', '.join(missing)}", file=sys.stderr)
        return 1
    print(text)
    return 0


if __name__ == "__main__":
    sys.exit(main())
