"""Examples in documents, and links between them."""

import math
import re
from itertools import pairwise
from pathlib import Path

ROOT = Path(__file__).parent.parent
PAGES = ("CODE_OF_CONDUCT", "CONTRIBUTING", "README", "SECURITY", "paper/paper")
FOLDERS = ("changelog.d", "db", "reports")
DOCUMENTS = sorted(
    [
        *(ROOT / f"{name}.md" for name in PAGES),
        *(ROOT / name / "README.md" for name in FOLDERS),
        *(ROOT / "docs").rglob("*.md"),
    ]
)

_BLOCK = re.compile(r"(<!-- numbers differ between machines -->\n)?```(\w+)\n(.*?)```", re.DOTALL)
_TIME = re.compile(r"\d+\.\d\d s\b")
_NUMBER = re.compile(r"[-+]?\d[\d,]*\.?\d*(?:e[-+]?\d+)?")
_NEAR = 1e-3
"""How far a number with a point may be off, on another processor, over its value."""


def name_of(document):
    """A document's path in the project."""
    return str(document.relative_to(ROOT))


def blocks(text):
    """(kind, text) of every block of code of a document's text."""
    return [(kind, block) for _, kind, block in _BLOCK.findall(text)]


def shell_examples(document):
    """(command, expected output, whether its numbers count) of every ```console block of a document, in order."""
    return examples_in(document.read_text(encoding="utf-8"))


def examples_in(text):
    """The `shell_examples` of a document's text."""
    for differ, kind, block in _BLOCK.findall(text):
        if kind == "console":
            for chunk in re.split(r"^\$ ", block, flags=re.MULTILINE)[1:]:
                command, _, output = chunk.partition("\n")
                yield command, output, not differ


def files_shown(document):
    """(name, content) of every block whose first line is a comment with the name of a file."""
    for _, _, text in _BLOCK.findall(document.read_text(encoding="utf-8")):
        found = re.match(r"# (\w+\.\w+)\n", text)
        if found:
            yield found.group(1), text


def agrees(output, expected, numbers=True):
    """Whether an output is that of a document, but for times and the last digits of numbers.

    A line `...` stands for any lines. numbers : whether the numbers count.
    """
    parts = [_words(part) for part in re.split(r"^\.\.\.\n", expected, flags=re.MULTILINE)]
    words = _words(output)
    if len(parts) == 1:
        return _same(words, parts[0], numbers)
    first, last = parts[0], parts[-1]
    ends = _same(words[: len(first)], first, numbers) and _same(words[len(words) - len(last) :], last, numbers)
    return len(parts) == 2 and len(words) >= len(first) + len(last) and ends


def _words(text):
    return [word for word in _TIME.sub("_ s", text).split() if set(word) != {"-"}]


def _same(words, expected, numbers):
    return len(words) == len(expected) and all(
        _alike(word, other, numbers) for word, other in zip(words, expected, strict=True)
    )


def _alike(word, other, numbers):
    if _NUMBER.sub("#", word) != _NUMBER.sub("#", other):
        return False
    found, wanted = (list(map(_value, _NUMBER.findall(text))) for text in (word, other))
    return not numbers or all(
        math.isclose(a, b, rel_tol=0.0 if isinstance(b, int) else _NEAR) for a, b in zip(found, wanted, strict=True)
    )


def _value(digits):
    plain = digits.replace(",", "")
    return int(plain) if re.fullmatch(r"[-+]?\d+", plain) else float(plain)


def text_of(document):
    """A document without its blocks of code."""
    return re.sub(r"```.*?```", "", document.read_text(encoding="utf-8"), flags=re.DOTALL)


def links(document):
    """Targets of the links and pictures of a document, but for those to the web."""
    found = re.findall(r"\]\(([^)\s]+)\)", text_of(document))
    return [target for target in found if not re.match(r"https?:", target)]


def anchors(document):
    """The names by which a document's headings are linked, as GitHub makes them."""
    heads = re.findall(r"^#+ (.*)$", text_of(document), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", head.lower()).replace(" ", "-") for head in heads}


def levels(document):
    """Pairs of levels of headings that follow each other."""
    heads = re.findall(r"^(#+) ", text_of(document), re.MULTILINE)
    return list(pairwise(map(len, heads)))
