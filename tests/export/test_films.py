"""Stills and films: each pixel shows the panel in front, and the pictures of a motion belong together."""

from io import BytesIO
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from PIL import Image

from hcsearch import save
from hcsearch.basics.errors import HcsearchError
from hcsearch.cli import hcsearch
from hcsearch.export.animation import MARK_COLOURS, SHADE_COUNT, centred_solids
from hcsearch.export.films import (
    FILM_FRAME_COUNT,
    FIRST_REST_MILLISECONDS,
    FRAME_MILLISECONDS,
    LAST_REST_MILLISECONDS,
    MAX_DRAWING_HEIGHT,
    PICTURE_WIDTH,
    canvas_of,
    caption_at,
    film_of,
)
from hcsearch.subjects.replay import stacks_of
from tests.export.cases import case, replay
from tests.export.exports import MOVING, exported

LIGHT = np.array([0.25, -0.45, 0.86])


def picture(data):
    return Image.open(BytesIO(data))


def first_faces(prisms, origins, towards):
    """The prism that each ray from far away meets first, and the normal of the face by which it enters; -1 for none."""
    found = []
    for origin in origins:
        best = (np.inf, -1, None)
        for number, (bottom, top) in enumerate(prisms):
            up = top[0] - bottom[0]
            edges = np.roll(bottom, -1, axis=0) - bottom
            planes = [(bottom[0], -up), (top[0], up), *zip(bottom, np.cross(edges, up), strict=True)]
            enter, leave, face = -np.inf, np.inf, None
            for point, normal in planes:
                speed, gap = -(normal @ towards), normal @ (point - origin)
                if speed < -1e-15 and gap / speed > enter:
                    enter, face = gap / speed, normal
                elif speed > 1e-15:
                    leave = min(leave, gap / speed)
                elif abs(speed) <= 1e-15 and gap < 0:
                    leave = -np.inf
            if enter < leave and enter < best[0]:
                best = (enter, number, face)
        found.append(best[1:])
    return found


@pytest.mark.parametrize("name", [MOVING, "thesis-4x4", "unit-ii"])
def test_each_pixel_shows_the_panel_in_front(name):
    linkage, _ = case(name)
    motion = replay(name, np.linspace(linkage.folded, linkage.flat, 5))
    canvas = canvas_of(motion, list(motion.angles))
    stacks = stacks_of(linkage)
    seen = 0
    for angles in motion.angles:
        solids = centred_solids(linkage.solids(angles))
        pixels = np.array(canvas.picture(angles, "").convert("RGB")).astype(int)
        random = np.random.default_rng(7)
        right, up, towards = canvas.painter.camera
        size = max(np.linalg.norm(solid.reshape(-1, 3), axis=1).max() for solid in solids)
        at = size * random.uniform(-1.0, 1.0, (250, 2)) @ np.array([right, up])
        for origin, (number, normal) in zip(at, first_faces(solids, at + 10.0 * size * towards, towards), strict=True):
            x, y = canvas.pixel(origin)
            patch = pixels[y - 1 : y + 2, x - 1 : x + 2].reshape(-1, 3)
            if number < 0 or not (patch == patch[0]).all() or tuple(patch[0]) in marks_but_faces():
                continue  # beside the panels, or on a line
            light = float(normal @ LIGHT) / float(np.linalg.norm(normal) * np.linalg.norm(LIGHT))
            letter = "c" if stacks is None else "ab"[stacks[number]]
            expected = f"{letter}{round((SHADE_COUNT - 1) * (0.5 + 0.5 * light))}"
            assert tuple(patch[0]) == MARK_COLOURS[expected], (name, number)
            seen += 1
    assert seen > 100


def marks_but_faces():
    return {colour for look, colour in MARK_COLOURS.items() if len(look) == 1} | {(59, 64, 74)}


@pytest.mark.parametrize("form", ["GIF", "WEBP"])
def test_a_film_has_all_frames_and_repeats(form):
    linkage, _ = case("thesis-4x4")
    film = picture(film_of(replay("thesis-4x4", np.linspace(linkage.folded, linkage.flat, 5)), form))
    assert (film.format, film.n_frames, film.width, film.info["loop"]) == (form, FILM_FRAME_COUNT, PICTURE_WIDTH, 0)
    durations, frames = [], []
    for number in range(film.n_frames):
        film.seek(number)
        frames.append(np.array(film.convert("RGB")))
        durations.append(film.info["duration"])
    rest = [FRAME_MILLISECONDS] * (FILM_FRAME_COUNT - 2)
    assert durations == [FIRST_REST_MILLISECONDS, *rest, LAST_REST_MILLISECONDS]
    assert all((one != other).any() for one, other in pairwise(frames))


def test_frames_of_a_gif_are_the_stills_of_the_same_states():
    value = exported(MOVING, "gif")
    film = picture(film_of(value.motion, "GIF"))
    canvas = canvas_of(value.motion, list(value.motion.at_time(np.linspace(0.0, 1.0, FILM_FRAME_COUNT))))
    for number in (0, 20, FILM_FRAME_COUNT - 1):
        film.seek(number)
        place = number / (FILM_FRAME_COUNT - 1)
        still = canvas.picture(value.motion.at_time(np.array([place]))[0], caption_at(value.motion, place))
        gap = np.abs(np.array(film.convert("RGB")).astype(int) - np.array(still).astype(int)).max(axis=2)
        assert np.percentile(gap, 97) <= 2  # the rest is edges, whose blends are rounded to the palette
        assert gap.max() < 140


def test_captions_have_the_time_and_the_speed_or_the_share_of_the_path():
    path, springs = exported(MOVING, "gif").motion, exported(MOVING, "gif", "springs").motion
    assert [caption_at(path, place) for place in (0.0, 0.4, 1.0)] == [f"{k} % of the path" for k in (0, 40, 100)]
    seconds = float(springs.at[-1])
    slower = 1e-3 * FRAME_MILLISECONDS * (FILM_FRAME_COUNT - 1) / seconds
    assert caption_at(springs, 0.5 * seconds) == f"{0.5 * seconds:.3f} s ({slower:.2g} times slower than real)"


@pytest.fixture
def run(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    def call(*words):
        result = CliRunner().invoke(hcsearch, ["export", *words])
        assert isinstance(result.exception, HcsearchError | None), result.exception
        return result

    return call


def test_stills_are_chosen_by_their_place_and_have_one_scale(run):
    for words, name in (
        (("--at", "0.4"), "a.png"),
        (("--state", "0.4"), "b.png"),
        (("--motion", "path", "--at", "0.4"), "c.png"),
        (("--motion", "path", "--at", "folded"), "d.png"),
        ((), "flat.png"),
        (("--at", "folded"), "folded.png"),
    ):
        assert run(MOVING, "--output", name, *words).exit_code == 0
    read = {path.name: path.read_bytes() for path in Path().glob("*.png")}
    assert read["a.png"] == read["b.png"] == read["c.png"]
    assert len(set(read.values())) == 4
    sizes = {name: picture(data).size for name, data in read.items()}
    assert sizes["c.png"] == sizes["d.png"]
    assert sizes["flat.png"] == sizes["folded.png"]


def test_a_still_of_a_motion_that_fails_says_so_in_red(run):
    result = run("thesis-4x4", "--output", "a.png", "--motion", "springs", "--at", "0.5")
    assert "collide at" in result.stderr
    pixels = np.array(picture(Path("a.png").read_bytes())).reshape(-1, 3)
    assert (pixels == (190, 24, 40)).all(axis=1).sum() > 20
    assert run(MOVING, "--output", "b.png", "--at", "0.5").exit_code == 0
    assert not (np.array(picture(Path("b.png").read_bytes())).reshape(-1, 3) == (190, 24, 40)).all(axis=1).any()


def test_tall_arrays_fit_into_the_picture(tmp_path):
    (path,) = save("square:01" + 19 * "2" + "3" + 18 * "0" + ":1", tmp_path / "a.png")
    drawn = picture(path.read_bytes())
    assert drawn.width == PICTURE_WIDTH
    assert MAX_DRAWING_HEIGHT <= drawn.height <= MAX_DRAWING_HEIGHT + 150
    assert (np.array(drawn)[:, [0, -1]] == 255).all()


def test_what_pictures_cannot_show_is_one_line(run):
    assert "gif takes no --state: leave it out, or choose png" in str(
        run(MOVING, "--output", "a.gif", "--at", "0.5").exception
    )
    assert "'half' is no state: write flat, folded" in str(run(MOVING, "--output", "a.png", "--at", "half").exception)
    assert "no path is planned" in str(run("unit-ii", "--output", "a.webp", "--motion", "path").exception)
    assert list(Path().iterdir()) == []
