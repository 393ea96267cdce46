"""The grammar of certificates: how the checkers read the files of strangers, within limits of size and time.

This file needs NumPy alone. The limits stand in docs/explanation/certificates.md, too.
"""

import argparse
import hashlib
import json
import re
import sys
import time
from collections.abc import Callable, Iterable
from fractions import Fraction
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

FORMAT, VERSION, KINDS = "hcsearch certificate", 1, ("path", "lock", "collision")
MAX_BYTES, MAX_CLAIMS, MAX_CHARACTERS, MAX_DIGITS = 16 * 2**20, 10, 1000, 40  # limits of a file, a text, a number
MAX_LISTS = 500_000  # lists and objects of a file: each takes the memory of a hundred of its characters
MAX_SIZE, MAX_WHOLE = 1500, 10**6  # facets times the corners of the largest one, and hinges; whole coordinates
SECONDS = 50.0  # the time for a file
NUMBER = re.compile(r"[0-9]{1,20}(/[0-9]{1,20}|(\.[0-9]{1,20})?(e-?[0-9]{1,2})?)")


class NotProvedError(Exception):
    """The certificate does not prove what it claims."""


class NotDecidedError(NotProvedError):
    """The time, or the memory, is not sufficient to decide whether a claim is proved."""


class NoCertificateError(NotProvedError):
    """The data are not of the documented form, or beyond its limits."""


def need(condition: Any, reason: str) -> None:
    """Refuse the certificate unless a condition holds."""
    if not condition:
        raise NotProvedError(reason)


def formed(condition: Any, reason: str) -> None:
    """Refuse data that are no certificate unless a condition holds."""
    if not condition:
        raise NoCertificateError(reason)


class Clock:
    """The time (s) that is left to decide; without a limit if none is given."""

    def __init__(self, seconds: float = float("inf")) -> None:
        self.seconds, self.end = seconds, time.monotonic() + seconds

    def check(self) -> None:
        """Stop if the time is over."""
        if time.monotonic() > self.end:
            raise NotDecidedError(f"not decided in {self.seconds:g} s: give --seconds {10 * self.seconds:g}")


def printable(text: Any) -> str:
    """Return a text of a file as it may be printed: without line breaks, controls and marks of direction."""
    marks = (c if c.isprintable() else c.encode("unicode_escape", "surrogatepass").decode() for c in str(text))
    return "".join(marks)


def entry(data: Any, key: str, kind: type) -> Any:
    """Return the value of a key, which is of one kind: dict, list, str or bool."""
    formed(isinstance(data, dict) and type(data.get(key)) is kind, f"its key {key} holds no {NAMES[kind]}")
    return data[key]


NAMES = {dict: "object", list: "list", str: "text", bool: "truth"}


def whole(value: Any, low: int, high: int, what: str) -> int:
    """Return a whole number of a file, from low to high."""
    formed(type(value) is int and low <= value <= high, f"{what} is no whole number from {low} to {high}")
    return int(value)


def real(value: Any, what: str) -> float:
    """Return a number of a file; its size is at most a million."""
    formed(type(value) in (int, float) and -MAX_WHOLE <= value <= MAX_WHOLE, f"{what} is no number up to {MAX_WHOLE}")
    return float(value)


def lists(data: Any, key: str, count: int | None = None) -> list[list[Any]]:
    """Return the value of a key, which is a list of lists; if a count is given, it must have that length."""
    value = entry(data, key, list)
    formed(count in (None, len(value)) and all(isinstance(own, list) for own in value), f"its key {key} holds no lists")
    return list(value)


def rows(data: Any, widths: Iterable[int], read: Callable[[Any], Any], what: str) -> list[list[Any]]:
    """Return a table of a file, whose rows have given numbers of entries."""
    formed(isinstance(data, list), f"{what} are no list")
    wide = list(widths)
    formed(len(data) == len(wide), f"{what} are {len(data)} lists and not {len(wide)}")
    formed(
        all(isinstance(row, list) and len(row) == n for row, n in zip(data, wide, strict=True)), f"{what} are uneven"
    )
    return [[read(value) for value in row] for row in data]


def numbers(data: Any, widths: Iterable[int], what: str) -> list[list[float]]:
    """Return a table of numbers of a file, whose rows have given numbers of entries."""
    return rows(data, widths, lambda value: real(value, what), what)


def fraction(text: Any, what: str) -> Fraction:
    """Return a positive number that is written as a decimal or as a fraction of whole numbers."""
    written = isinstance(text, str) and len(text) <= MAX_DIGITS and NUMBER.fullmatch(text)
    formed(written and text.strip("0./") and not re.search(r"/0+$", text), f"{what} is no text of a number above 0")
    value = Fraction(text)
    formed(value > 0, f"{what} is no text of a number above 0")
    return value


class Hinge(NamedTuple):
    """A hinge: its two panels, its edge from p to q along the first facet, whether on top, and whether it closes."""

    one: int
    two: int
    p: list[int]
    q: list[int]
    top: bool
    closes: bool


def is_convex(corners: list[list[int]]) -> bool:
    """Whether corners differ, none is on the right of any side, and some are on the left."""
    points = np.array(corners)
    if len(np.unique(points, axis=0)) < len(points):
        return False
    sides, chords = np.roll(points, -1, 0) - points, points - points[:, None]
    left = sides[:, None, 0] * chords[..., 1] - sides[:, None, 1] * chords[..., 0]
    return bool(left.min() >= 0 and left.max() > 0)


class ArrayData:
    """The array of a claim: whole coordinates, panels as lists of facets, and hinges."""

    def __init__(self, data: Any) -> None:
        below = MAX_WHOLE - 1
        self.unit = fraction(entry(data, "unit", str), "unit")
        self.root, self.height = (
            whole(data.get("root"), 1, 3, "root"),
            whole(data.get("thickness"), 1, below, "thickness"),
        )
        formed(self.root != 2, "root is neither 1 nor 3")
        facets, panels, hinges = (entry(data, key, list) for key in ("facets", "panels", "hinges"))
        formed(facets and all(isinstance(facet, list) and len(facet) > 2 for facet in facets), "a facet has no corners")
        size = len(facets) * max(map(len, facets)) + len(hinges)
        formed(max(size, len(panels)) < MAX_SIZE, f"its facets and hinges are more than {MAX_SIZE}")

        def coordinate(value: Any) -> int:
            return whole(value, -below, below, "a coordinate")

        self.facets = [rows(facet, [2] * len(facet), coordinate, "corners") for facet in facets]
        formed(all(map(is_convex, self.facets)), "a facet is not convex, with corners counterclockwise")
        last = len(facets) - 1
        formed(all(isinstance(panel, list) and panel for panel in panels), "a panel has no facets")
        self.panels = [[whole(facet, 0, last, "the facet of a panel") for facet in panel] for panel in panels]
        owned = sorted((facet, number) for number, panel in enumerate(self.panels) for facet in panel)
        formed([facet for facet, _ in owned] == list(range(len(facets))), "a facet is not in one panel")
        self.panel_of = [panel for _, panel in owned]
        self.hinges = [self._hinge(hinge) for hinge in hinges]

    def _hinge(self, data: Any) -> Hinge:
        pair = entry(data, "facets", list)
        formed(len(pair) == 2, "a hinge has no two facets")
        one, two = (whole(facet, 0, len(self.facets) - 1, "the facet of a hinge") for facet in pair)
        sides, others = ([*zip(x, x[1:] + x[:1], strict=True)] for x in (self.facets[one], self.facets[two]))
        ends = {(*p, *q) for p, q in others}
        shared = [(p, q) for p, q in sides if (*q, *p) in ends]
        formed(len(shared) == 1, "a hinge is no edge that two facets share")
        face = entry(data, "face", str)
        formed(face in ("top", "bottom"), "a hinge is on no face")
        panels = self.panel_of[one], self.panel_of[two]
        return Hinge(*panels, *shared[0], face == "top", entry(data, "closes", bool))


def checksum(data: dict[str, Any]) -> str:
    """SHA-256 of the data as JSON without spaces, with sorted keys."""
    return hashlib.sha256(json.dumps(data, sort_keys=True, separators=(",", ":")).encode()).hexdigest()


def parsed(content: bytes) -> Any:
    """Return the data of a file: JSON with numbers of at most `MAX_DIGITS` digits, and without repeated keys."""
    formed(len(content) <= MAX_BYTES, f"it is larger than {MAX_BYTES // 2**20} MiB")
    count = content.count(b"[") + content.count(b"{")  # before the data are read
    formed(count <= MAX_LISTS, f"it has more than {MAX_LISTS} lists and objects")

    def short(kind: Callable[[str], Any]) -> Callable[[str], Any]:
        def read(text: str) -> Any:
            if len(text) > MAX_DIGITS:
                raise NoCertificateError(f"a number has more than {MAX_DIGITS} digits")
            return kind(text)

        return read

    def once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        formed(len(dict(pairs)) == len(pairs), "a key stands twice")
        return dict(pairs)

    def none(text: str) -> Any:
        raise NoCertificateError(f"{text} is no number")

    try:
        text = content.decode("utf-8-sig")
        return json.loads(
            text, parse_int=short(int), parse_float=short(float), parse_constant=none, object_pairs_hook=once
        )
    except (ValueError, RecursionError) as error:
        raise NoCertificateError(f"it is no JSON ({printable(error)})") from None


def claims_of(data: Any) -> list[dict[str, Any]]:
    """Return the claims of a certificate, each of a known kind, once its head and its checksum are as documented."""
    formed(isinstance(data, dict), f"it is no {FORMAT} of version {VERSION}")
    kind = data.get("format"), data.get("version")
    formed(kind == (FORMAT, VERSION) and type(kind[1]) is int, f"it is no {FORMAT} of version {VERSION}")
    for key in ("of", *(["panel_mm"] if data.get("panel_mm", "") is not None else [])):
        formed(
            0 < len(entry(data, key, str)) <= MAX_CHARACTERS, f"its key {key} is no text of {MAX_CHARACTERS} letters"
        )
    claims: list[dict[str, Any]] = entry(data, "claims", list)
    formed(0 < len(claims) <= MAX_CLAIMS, f"it has not from 1 to {MAX_CLAIMS} claims")
    for claim in claims:
        formed(entry(claim, "kind", str) in KINDS, "a claim is of no known kind")
    one = data["panel_mm"] is not None or all(claim.get("array") == claims[0].get("array") for claim in claims)
    formed(one, "its claims are of several arrays, and a pattern has one")
    try:
        same = data.get("sha256") == checksum({key: data[key] for key in data if key != "sha256"})
    except (ValueError, TypeError, RecursionError):
        same = False
    formed(same, "the checksum is another: the file was changed")
    return claims


def judged(claim: Any, clock: Clock | None, check: Callable[[Any, Clock], str]) -> str:
    """Return what a check proves of a claim; NotProvedError and its kinds if it does not."""
    try:
        with np.errstate(all="ignore"):  # an overflow proves nothing
            return check(claim, clock or Clock())
    except (ArithmeticError, np.linalg.LinAlgError) as error:
        raise NotProvedError(f"it is not computed ({error})") from error
    except MemoryError as error:
        raise NotDecidedError("not decided in the memory that is there") from error


def main(kind: str, checked: Callable[[Any, Clock], str], description: str | None) -> None:
    """Check the claims of one kind in a file, as a program; print what is proved, or stop with the reason."""
    parser = argparse.ArgumentParser(description=description, epilog="Exit code: 0 proved, 1 not, 2 no certificate.")
    parser.add_argument("file")
    parser.add_argument("--seconds", type=float, default=SECONDS, help="time to decide in, %(default)g by default")
    options = parser.parse_args()
    for stream in (sys.stdout, sys.stderr):  # names may hold letters that a terminal lacks
        stream.reconfigure(errors="backslashreplace")  # type: ignore[union-attr]
    try:
        clock, path = Clock(options.seconds), Path(options.file)
        formed(path.is_file() or not path.exists(), "it is a folder, a pipe or a device")
        with path.open("rb") as file:
            data = parsed(file.read(MAX_BYTES + 1))
        claims = {k: claim for k, claim in enumerate(claims_of(data), 1) if claim["kind"] == kind}
        formed(claims, f"no {kind} is claimed")
        for k, sentence in [(k, checked(claim, clock)) for k, claim in claims.items()]:
            print(f"the array of claim {k} in the file, named {data['of']!r}: proved: {sentence}")
    except (NoCertificateError, OSError) as error:
        stop(f"{printable(options.file)}: no certificate: {printable(error)}", 2)
    except NotProvedError as error:
        stop(f"{printable(options.file)}: not proved: {error}", 1)


def stop(message: str, code: int) -> None:
    """End the program with a line on stderr."""
    print(message, file=sys.stderr)
    sys.exit(code)
