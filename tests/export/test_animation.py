"""The moving picture: what is in front is drawn last, and the file is whole in itself."""

import re
from pathlib import Path
from xml.etree import ElementTree as Xml

import numpy as np
import pytest

from hcsearch import save
from hcsearch.basics.errors import OutputError
from hcsearch.export.animation import (
    FRAME_WIDTH,
    MAX_FRAME_COUNT,
    MIN_FRAME_COUNT,
    animation_of,
    frame_count_of,
    painters_order,
)
from hcsearch.export.formats import export_format_of
from hcsearch.subjects.resolve import resolve
from tests.export.cases import case, replay

GALLERY = Path(__file__).parents[2] / "docs" / "gallery"
SVG = "{http://www.w3.org/2000/svg}"


def entries(prisms, origin, towards):
    """How far along the view a ray from far away enters each prism, inf where it passes: by its planes."""
    found = []
    for bottom, top in prisms:
        up = top[0] - bottom[0]
        edges = np.roll(bottom, -1, axis=0) - bottom
        planes = [(bottom[0], -up), (top[0], up), *zip(bottom, np.cross(edges, up), strict=True)]
        enter, leave = -np.inf, np.inf
        for point, normal in planes:
            speed, gap = -(normal @ towards), normal @ (point - origin)
            if abs(speed) < 1e-12:
                enter = np.inf if gap < 0 else enter
            elif speed < 0:
                enter = max(enter, gap / speed)
            else:
                leave = min(leave, gap / speed)
        found.append(enter if enter < leave - 1e-6 else np.inf)
    return np.array(found)


@pytest.mark.parametrize("name", ["hex:0234550132:4", "thesis-4x4", "unit-ii"])
def test_panels_in_front_are_drawn_after_those_that_they_hide(name):
    motion = resolve(name, "hcsearch.sqlite").replay()[0]
    states = motion.at_time(np.linspace(*motion.at[[0, -1]], 5))
    assert sum(hidden_pairs(motion.linkage.solids(angles)) for angles in states) > 100


def hidden_pairs(prisms):
    """How many prisms are hidden on rays through the middles of others, each of them drawn in order."""
    random = np.random.default_rng(20)
    seen = 0
    for _ in range(3):
        towards = random.normal(size=3)
        towards /= np.linalg.norm(towards)
        place = np.argsort(painters_order(prisms, towards))
        for prism in prisms:
            origin = prism.mean(axis=(0, 1)) + 10.0 * towards
            depth = entries(prisms, origin, towards)
            hit = np.flatnonzero(np.isfinite(depth))
            first = hit[depth[hit].argmin()]
            clear = hit[depth[hit] > depth[first] + 1e-6]
            assert (place[first] > place[clear]).all()
            seen += len(clear)
    return seen


def test_prisms_that_hide_each_other_in_a_ring_are_drawn_all_the_same():
    bar = np.array([[(x, y, z) for x, y in ((0, 0), (3, 0), (3, 1), (0, 1))] for z in (0.0, 0.1)], float)
    tilt = np.array([[1, 0, 0.2], [0, 1, 0], [0, 0, 1]])
    ring = []
    for k in range(3):
        c, s = np.cos(2 * np.pi * k / 3), np.sin(2 * np.pi * k / 3)
        ring.append((bar - (0.6, 0.9, 0.3)) @ tilt @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]]))
    assert sorted(painters_order(ring, np.array([0.0, 0.0, 1.0]))) == [0, 1, 2]


def test_the_picture_has_all_frames_and_asks_for_nothing():
    linkage, _ = case("thesis-4x4")
    text = animation_of(replay("thesis-4x4", np.linspace(linkage.folded, linkage.flat, 5)))
    picture = Xml.fromstring(text)
    (strip,) = picture.findall(f"{SVG}g")
    frames = strip.findall(f"{SVG}g")
    n_frames = frame_count_of(len(linkage.pattern.faces))
    assert [frame.get("transform") for frame in frames] == [f"translate({k * FRAME_WIDTH})" for k in range(n_frames)]
    assert all(frame.findall(f"{SVG}path") for frame in frames)
    used = {path.get("class") for path in picture.iter(f"{SVG}path")}
    assert used == set(re.findall(r"\.(\w+)\{", text)) - {"strip"}
    assert not re.search(r"<script|href|url\(|@import|\bon\w+=", text)
    left, right = 0, int(picture.get("viewBox").split()[2])
    first = [int(x) for x in re.findall(r"M(-?\d+)", Xml.tostring(frames[-1], encoding="unicode"))]
    assert left <= min(first)
    assert max(first) <= right


def test_linkages_of_many_panels_have_fewer_frames():
    counts = [frame_count_of(n) for n in range(1, 200)]
    assert counts == sorted(counts, reverse=True)
    assert (counts[0], counts[-1]) == (MAX_FRAME_COUNT, MIN_FRAME_COUNT)


def test_the_animation_is_chosen_by_its_name_alone(tmp_path):
    assert export_format_of("a.svg").name == "svg"
    assert export_format_of("a.svg", "animation").name == "animation"
    with pytest.raises(OutputError, match="no name for a file"):
        export_format_of("a.gif", "animation")
    (path,) = save("square:01222300:1", tmp_path / "a.svg", format="animation")
    assert "infinite alternate" in path.read_text()


def test_the_picture_of_the_readme_is_small_and_of_a_design_that_deploys():
    path = GALLERY / "moving-hex.svg"
    assert path.stat().st_size < 300_000
    title = Xml.parse(path).getroot().findtext(f"{SVG}title")
    assert title.startswith("hex:012223444500:4, simulated in the scene 'hinged'")
    assert "flat after" in title
