"""The size of the package, beside that of the last release; `make check` fails where it is above the ceilings.

The ceilings stand in `pyproject.toml`. A change that needs more raises them, and says in its message what for.
"""

import ast
import io
import sys
import tokenize
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[1]
SIZES = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["hcsearch"]["size"]
NO_CODE = {tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT, tokenize.ENDMARKER}


def code_lines(source):
    """Return the number of lines of a module that hold more than comments and texts that stand alone, as docstrings."""
    texts = [node for node in ast.walk(ast.parse(source)) if isinstance(node, ast.Expr)]
    texts = [node for node in texts if isinstance(node.value, ast.Constant) and isinstance(node.value.value, str)]
    told = {line for node in texts for line in range(node.lineno, node.end_lineno + 1)}
    tokens = tokenize.generate_tokens(io.StringIO(source).readline)
    written = (token for token in tokens if token.type not in NO_CODE)
    return len({line for token in written for line in range(token.start[0], token.end[0] + 1)} - told)


def size_of(package):
    """Return the number of modules, of lines, and of lines of code below a folder."""
    sources = [file.read_text(encoding="utf-8") for file in package.rglob("*.py")]
    return {
        "modules": len(sources),
        "lines": sum(len(source.splitlines()) for source in sources),
        "code": sum(map(code_lines, sources)),
    }


def table_of(size):
    """Return a size beside that of the last release and the ceilings, as lines."""
    named = {"modules": "modules", "lines": "lines", "code": "without comments and docstrings"}
    rows = [("hcsearch/**/*.py", "now", SIZES["released"]["version"], "ceiling")]
    rows += [(named[key], f"{size[key]:,}", f"{SIZES['released'][key]:,}", f"{SIZES[key]:,}") for key in named]
    return [f"{name:<33}" + "".join(f"{cell:>10}" for cell in cells) for name, *cells in rows]


def faults_of(size):
    """Return what is above its ceiling, as sentences."""
    return [
        f"{count:,} {key} are above the ceiling of {SIZES[key]:,}: shrink, or raise it in pyproject.toml on purpose"
        for key, count in size.items()
        if count > SIZES[key]
    ]


def main():
    size = size_of(ROOT / "hcsearch")
    print(*table_of(size), sep="\n")
    if faults := faults_of(size):
        sys.exit("\n".join(faults))


if __name__ == "__main__":
    main()
