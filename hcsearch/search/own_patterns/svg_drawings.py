"""Crease patterns as SVG, in the colours of Origami Simulator.

Source: A. Ghassaei, E. Demaine, N. Gershenfeld, Fast, interactive origami simulation using GPU computation, 7OSME
(2018), and the design tips of https://origamisimulator.org: borders are black, mountains red, valleys blue, cuts green,
flat edges yellow, and creases that nothing drives magenta; the opacity of a mountain or valley is its fold angle over
180 degrees. Lines, rectangles, polygons, polylines and straight paths are read; styles are read from attributes, the
attribute `style`, and style sheets with simple selectors.
"""

from __future__ import annotations

import colorsys
import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from itertools import pairwise
from xml.etree import ElementTree as Xml

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.basics.errors import InputFileError
from hcsearch.search.own_patterns.fold_reading import PatternDrawing
from hcsearch.search.own_patterns.fold_values import MAX_FOLD_ENTRIES, is_finite_number
from hcsearch.search.own_patterns.line_drawings import CreaseLine, drawing_of_lines, read_xml
from hcsearch.shape.mesh import PlanePoint

_LETTERS = {0: "M", 60: "F", 120: "C", 240: "V", 300: "U"}
"""Assignments by the hue of the colour, degrees; black is B."""
_HUE_TOLERANCE, _LEAST_SATURATION, _LEAST_BRIGHTNESS, _MOST_GREY = 20.0, 0.6, 0.3, 0.2
"""Limits within which colours follow the convention; darker ones are black, and less saturated ones grey."""
_GREY = re.compile("[a-z]*gr[ae]y|white|silver|gainsboro")
_NAMED = {
    "black": "#000000", "red": "#ff0000", "blue": "#0000ff", "green": "#008000", "lime": "#00ff00",
    "yellow": "#ffff00", "magenta": "#ff00ff", "fuchsia": "#ff00ff",
}  # fmt: skip
_UNDRAWN = {"defs", "symbol", "clipPath", "mask", "marker", "pattern", "style", "metadata", "title", "desc", "script"}
"""Elements whose content is not drawn in place."""
_NO_LINES = {"circle", "ellipse", "text", "image", "use", "foreignObject"}
_NUMBER = r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"
_UNIT = "(?:mm|cm|in|Q|pt|pc|px|em|ex|rem|%)"
"""The units of lengths in SVG."""
_LAYER_IDS = {"CUT", "ENGRAVE"}
"""Layers of the sheets for laser cutters that `hcsearch export` writes, whose colours have other meanings."""
_ARGUMENTS = {"M": 2, "L": 2, "H": 1, "V": 1, "Z": 0}
_MAX_VALUE, _MAX_TRANSFORM, _MAX_RULES = 100, 2_000, 1_000
"""Limits of the lengths of values and transforms, and of the number of rules of style."""
_INHERITED = ("stroke", "stroke-opacity")


def read_svg(path: str) -> PatternDrawing:
    """Read an SVG file; InputFileError as in `read_xml`, for curves, and where it holds no flat pattern."""
    root = read_xml(path)
    if _tag(root) != "svg":
        raise InputFileError(f"{path} is no SVG: its outermost element is {_tag(root):.60}; export it as SVG or FOLD")
    if any(element.get("id") in _LAYER_IDS for element in root.iter() if _tag(element) == "g"):
        raise InputFileError(
            f"{path} is a sheet for a laser cutter, whose colours are layers: export it by --profile simulator"
        )
    reader = _Reader(path, _style_rules(root, path))
    reader.read(root)
    if not reader.lines:
        raise InputFileError(
            f"{path} has no line in the colours of Origami Simulator: draw borders black, mountains red and valleys "
            f"blue{reader.left_out()}"
        )
    scale, unit = _unit(root)
    flip = np.array([scale, -scale])
    stated = any(line.angle is not None and abs(line.angle) < 180.0 for line in reader.lines)
    lines = []
    for letter, start, end, angle in reader.lines:
        (x1, y1), (x2, y2) = (flip * start).tolist(), (flip * end).tolist()
        lines.append(CreaseLine(letter, (x1, y1), (x2, y2), angle if stated else None))
    return drawing_of_lines(lines, path, unit, reader.left_out().removeprefix("; "))


@dataclass
class _Reader:
    """The lines of a file that are read so far, as drawn with y down, and what is left out."""

    path: str
    rules: list[tuple[str, dict[str, str]]]
    lines: list[CreaseLine] = field(default_factory=list)
    colours: dict[str, None] = field(default_factory=dict)
    elements: dict[str, None] = field(default_factory=dict)

    def wrong(self, element: Xml.Element, what: str, remedy: str = "draw straight lines") -> InputFileError:
        """Return the error for an element; what, remedy : clauses."""
        name = element.get("id")
        named = f"{_tag(element):.40} {name!r:.40}" if name else f"a {_tag(element):.40}"
        return InputFileError(f"{self.path}: {named} {what}; {remedy}, or export the pattern as FOLD")

    def left_out(self) -> str:
        """Return a clause on what is left out; empty where all is read."""
        parts = [f"lines of the colour {', '.join(self.colours)}"] if self.colours else []
        parts += [", ".join(self.elements)] if self.elements else []
        return f"; left out are {' and '.join(parts)}" if parts else ""

    def read(self, root: Xml.Element) -> None:
        """Read the lines of all elements below one."""
        waiting: list[tuple[Xml.Element, Reals, dict[str, str], float]] = [(root, np.eye(3), {}, 1.0)]
        while waiting:
            element, motion, inherited, opacity = waiting.pop()
            tag = _tag(element)
            if tag in _UNDRAWN:
                continue
            style = self._style(element, inherited)
            if style.get("display") == "none" or style.get("visibility") in ("hidden", "collapse"):
                continue
            if "transform" in style:
                raise self.wrong(element, "is moved by a style: write its transform as an attribute")
            if tag == "svg" and element is not root and {"x", "y", "viewBox"} & set(element.attrib):
                raise self.wrong(element, "is a drawing within the drawing")
            motion = motion @ self._transform(element)
            if tag in _NO_LINES:
                self.elements[tag] = None
            self._add(element, motion, style, opacity)
            passed = {name: style[name] for name in _INHERITED if name in style}
            if len(element):  # the opacity of a group holds for all of it
                opacity *= self._share(element, style, "opacity")
            waiting += [(child, motion, passed, opacity) for child in reversed(element)]

    def _add(self, element: Xml.Element, motion: Reals, style: Mapping[str, str], opacity: float) -> None:
        """Add the lines of an element of a known colour; opacity : of the groups around it."""
        stroke = re.sub(r"\s", "", style.get("stroke", "none")).lower()
        if _tag(element) not in _SHAPES:
            return
        if stroke in ("none", "transparent", ""):
            self.elements[f"{_tag(element)} without a stroke"] = None
            return
        letter = _letter(stroke)
        if letter is None:
            raise InputFileError(
                f"{self.path} has lines of the colour {stroke:.40}, which has no meaning in Origami Simulator: draw "
                "borders black, mountains red, valleys blue, cuts green, flat edges yellow, other creases magenta, and "
                "the rest grey"
            )
        if not letter:
            self.colours[stroke[:40]] = None
            return
        angle = None
        if letter in "MV":
            share = opacity * self._share(element, style, "opacity") * self._share(element, style, "stroke-opacity")
            angle = 180.0 * share * (1.0 if letter == "V" else -1.0)
        for points in _SHAPES[_tag(element)](self, element):
            moved = [motion @ (x, y, 1.0) for x, y in points]
            self.lines += [
                CreaseLine(letter, (float(a[0]), float(a[1])), (float(b[0]), float(b[1])), angle)
                for a, b in pairwise(moved)
            ]

    def _style(self, element: Xml.Element, inherited: Mapping[str, str]) -> dict[str, str]:
        """Return the style of an element: inherited, by attributes, by style sheets, and by its own style."""
        names = ("stroke", "stroke-opacity", "opacity", "display", "visibility")
        style = {**inherited, **{name: element.attrib[name] for name in names if name in element.attrib}}
        classes = element.get("class", "").split()
        for selector, declared in self.rules:
            tag, mark, name = re.fullmatch(r"([\w*-]*)([.#]?)(.*)", selector).groups()  # type: ignore[union-attr]
            if tag in ("", "*", _tag(element)) and (
                not mark or (name in classes if mark == "." else name == element.get("id"))
            ):
                style |= declared
        return {**style, **_declarations(element.get("style", ""))}

    def _share(self, element: Xml.Element, style: Mapping[str, str], name: str) -> float:
        """Return an opacity, from 0 to 1."""
        text = style.get(name, "1").strip()[:_MAX_VALUE]
        match = re.fullmatch(rf"({_NUMBER})(%?)", text)
        share = math.nan if match is None else float(match[1]) * (0.01 if match[2] else 1.0)
        if not 0.0 <= share <= 1.0:
            raise self.wrong(element, f"has the {name} {text!r:.20}, which is not from 0 to 1")
        return share

    def _transform(self, element: Xml.Element) -> Reals:
        """Return the motion by which an element is placed, (3, 3)."""
        text = element.get("transform", "")
        motion: Reals = np.eye(3)
        if len(text) > _MAX_TRANSFORM or re.sub(r"[A-Za-z]+\s*\([^()]*\)|[\s,]", "", text):
            raise self.wrong(element, f"has the transform {text!r:.40}, which is not read")
        for name, arguments in re.findall(r"([A-Za-z]+)\s*\(([^()]*)\)", text):
            matrix = _matrix(name, self._numbers(element, arguments))
            if matrix is None:
                raise self.wrong(element, f"has the transform {name!r:.40}, which is not read")
            motion = motion @ matrix
        return motion

    def _numbers(self, element: Xml.Element, text: str) -> list[float]:
        """Return the numbers in a text."""
        if re.sub(rf"{_NUMBER}|[\s,]", "", text):
            has_unit = re.search(rf"{_NUMBER}\s*{_UNIT}", text)
            remedy = "write numbers without a unit, and the size as width='90mm' and viewBox='0 0 90 60' of the svg"
            raise self.wrong(
                element, f"has {text.strip()!r:.40} where numbers are due", remedy if has_unit else "write numbers"
            )
        numbers = [float(number) for number in re.findall(_NUMBER, text)]
        if not all(map(is_finite_number, numbers)):
            raise self.wrong(element, "has a number that is too large")
        return numbers

    def _length(self, element: Xml.Element, name: str) -> float:
        """Return a length in the units of the drawing, 0 without it."""
        numbers = self._numbers(element, element.get(name, "0").strip().removesuffix("px"))
        if len(numbers) != 1:
            raise self.wrong(element, f"has no number in {name}")
        return numbers[0]

    def line(self, element: Xml.Element) -> Iterator[list[PlanePoint]]:
        """Yield the points of a line."""
        x1, y1, x2, y2 = (self._length(element, name) for name in ("x1", "y1", "x2", "y2"))
        yield [(x1, y1), (x2, y2)]

    def rect(self, element: Xml.Element) -> Iterator[list[PlanePoint]]:
        """Yield the points of a rectangle."""
        x, y, width, height = (self._length(element, name) for name in ("x", "y", "width", "height"))
        yield [(x, y), (x + width, y), (x + width, y + height), (x, y + height), (x, y)]

    def polyline(self, element: Xml.Element) -> Iterator[list[PlanePoint]]:
        """Yield the points of a polyline, or of a polygon, which is closed."""
        numbers = self._numbers(element, element.get("points", ""))
        points = list(zip(numbers[::2], numbers[1::2], strict=False))
        yield [*points, *points[:1]] if _tag(element) == "polygon" else points

    def path_points(self, element: Xml.Element) -> Iterator[list[PlanePoint]]:
        """Yield the points of each part of a path of straight lines."""
        text = element.get("d", "")
        points: list[PlanePoint] = []
        start = here = (0.0, 0.0)
        for command, arguments in re.findall("([A-Za-z])([^A-DF-Za-df-z]*)", text):
            kind, relative = command.upper(), command.islower()
            numbers = self._numbers(element, arguments)
            if kind not in _ARGUMENTS:
                raise self.wrong(element, f"has a curve (command {command} of a path)")
            count = _ARGUMENTS[kind]
            if len(numbers) % (count or 1) or (count == 0) != (not numbers):
                raise self.wrong(element, f"has {len(numbers)} numbers after the command {command} of a path")
            if kind == "Z":
                points.append(start)
                here = start
            for k in range(0, len(numbers), count or 1):
                x, y = here if relative else (0.0, 0.0)
                if kind == "H":
                    here = (x + numbers[k], here[1])
                elif kind == "V":
                    here = (here[0], y + numbers[k])
                else:
                    here = (x + numbers[k], y + numbers[k + 1])
                if kind == "M" and k == 0:  # further pairs are lines
                    yield points
                    points, start = [], here
                if len(points) > MAX_FOLD_ENTRIES:
                    raise self.wrong(element, f"has more than {MAX_FOLD_ENTRIES:,} points")
                points = points or [start]
                points.append(here)
        yield points


_SHAPES = {
    "line": _Reader.line,
    "rect": _Reader.rect,
    "polygon": _Reader.polyline,
    "polyline": _Reader.polyline,
    "path": _Reader.path_points,
}


def _tag(element: Xml.Element) -> str:
    """Return the name of an element without its namespace."""
    return str(element.tag).rpartition("}")[2]


def _letter(colour: str) -> str | None:
    """Return the assignment of a colour; empty for greys, and None for colours without a meaning."""
    if _GREY.fullmatch(colour):
        return ""
    colour = _NAMED.get(colour, colour)
    channels = []
    if match := re.fullmatch("#([0-9a-f]{3}|[0-9a-f]{6})", colour):
        step = len(match[1]) // 3
        channels = [int(match[1][k : k + step] * (3 - step), 16) for k in range(0, 3 * step, step)]
    elif match := re.fullmatch("rgba?[(]([0-9]{1,3}),([0-9]{1,3}),([0-9]{1,3})(?:,1(?:[.]0*)?)?[)]", colour):
        channels = [int(channel) for channel in match.groups()]
    if not channels or max(channels) > 255:
        return None
    hue, saturation, brightness = colorsys.rgb_to_hsv(*(channel / 255.0 for channel in channels))
    if brightness < _LEAST_BRIGHTNESS:
        return "B"
    if saturation < _LEAST_SATURATION:
        return "" if saturation < _MOST_GREY else None
    near = (
        letter
        for hue_of, letter in _LETTERS.items()
        if abs(math.remainder(360.0 * hue - hue_of, 360.0)) < _HUE_TOLERANCE
    )
    return next(near, None)


def _declarations(text: str) -> dict[str, str]:
    """Return the declarations of a style, by their names."""
    pairs = (part.partition(":") for part in text.split(";"))
    return {name.strip().lower(): value.replace("!important", "").strip() for name, colon, value in pairs if colon}


def _style_rules(root: Xml.Element, path: str) -> list[tuple[str, dict[str, str]]]:
    """Return the rules of all style sheets: selectors of an element, a class or an id, the weaker ones first.

    InputFileError for a rule on strokes with another selector.
    """
    rules = []
    for sheet in (element for element in root.iter() if _tag(element) == "style"):
        first, *commented = "".join(sheet.itertext()).split("/*")
        text = first + "".join(comment.partition("*/")[2] for comment in commented)
        for selectors, _, body in (rule.partition("{") for rule in text.split("}")):
            if "{" in body:
                raise InputFileError(
                    f"{path} has a style sheet with the rule {selectors.strip()!r:.40}: write strokes as attributes"
                )
            declared = _declarations(body)
            for selector in map(str.strip, selectors.split(",")):
                if re.fullmatch(r"[\w*-]+|[\w*-]*[.#][\w-]+", selector):
                    rules.append((selector, declared))
                elif {"stroke", "stroke-opacity", "opacity", "display"} & set(declared):
                    raise InputFileError(
                        f"{path} has a style sheet with the selector {selector!r:.40}: write strokes as attributes"
                    )
    if len(rules) > _MAX_RULES:
        raise InputFileError(f"{path} has {len(rules):,} rules of style: write strokes as attributes")
    return sorted(rules, key=lambda rule: ("#" in rule[0], "." in rule[0]))


def _matrix(name: str, numbers: list[float]) -> Reals | None:
    """Return the matrix of a transform, (3, 3); None for an invalid one."""
    first, *others = numbers or [math.nan]
    if name == "matrix" and len(numbers) == 6:
        a, b, c, d, e, f = numbers
        return np.array([[a, c, e], [b, d, f], [0.0, 0.0, 1.0]])
    if name == "translate" and len(numbers) in (1, 2):
        return np.array([[1.0, 0.0, first], [0.0, 1.0, *(others or [0.0])], [0.0, 0.0, 1.0]])
    if name == "scale" and len(numbers) in (1, 2):
        return np.diag([first, *(others or [first]), 1.0])
    if name == "rotate" and len(numbers) in (1, 3):
        cos, sin = math.cos(math.radians(first)), math.sin(math.radians(first))
        x, y = others or (0.0, 0.0)
        return np.array([[cos, -sin, x - cos * x + sin * y], [sin, cos, y - sin * x - cos * y], [0.0, 0.0, 1.0]])
    if name in ("skewX", "skewY") and len(numbers) == 1:
        matrix = np.eye(3)
        matrix[(0, 1) if name == "skewX" else (1, 0)] = math.tan(math.radians(first))
        return matrix
    return None


def _unit(root: Xml.Element) -> tuple[float, str | None]:
    """Return the scale from numbers of a drawing to a unit of length, and this unit; None without a physical one."""
    width, height = (
        re.fullmatch(rf"\s*({_NUMBER})\s*(mm|cm|in)\s*", root.get(name, "")[:_MAX_VALUE])
        for name in ("width", "height")
    )
    box = [float(number) for number in re.findall(_NUMBER, root.get("viewBox", "")[:_MAX_VALUE])]
    if width is None or len(box) != 4 or not (float(width[1]) > 0.0 and min(box[2:]) > 0.0):
        return 1.0, None
    scale = float(width[1]) / box[2]
    if height is not None and height[2] == width[2] and float(height[1]) > 0.0:  # the drawing fits into both
        scale = min(scale, float(height[1]) / box[3])
    return scale, width[2]
