"""Stills and films of a motion as PNG, animated GIF and animated WebP, drawn without a browser.

A picture has the title, the state or the time, and the panels, by the painter of `animation`. All pictures of a motion
have one viewpoint and one scale. They are drawn at twice their size and reduced, since Pillow draws lines with steps.
"""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterator
from functools import cache
from io import BytesIO
from itertools import product
from typing import Literal

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from hcsearch.basics.array_values import Reals
from hcsearch.export.animation import (
    FRAME_WIDTH,
    HINGE_WIDTH,
    MARK_COLOURS,
    OUTLINE_COLOUR,
    OUTLINE_WIDTH,
    MotionPainter,
    centred_solids,
)
from hcsearch.export.exported import Exported
from hcsearch.export.settings import ExportState
from hcsearch.shape.linkage import Linkage
from hcsearch.subjects.replay import Replay
from hcsearch.system.figures import text_font_file
from hcsearch.system.terminal import short_number

FilmFormat = Literal["GIF", "WEBP"]
PICTURE_WIDTH, MAX_DRAWING_HEIGHT = 800, 800
"""Width of a picture, and greatest height of the drawing in it, pixels."""
FILM_FRAME_COUNT = 60
FRAME_MILLISECONDS = 80
"""Time of a frame, ms: GIF has whole hundredths of a second."""
FIRST_REST_MILLISECONDS, LAST_REST_MILLISECONDS = 600, 1500
"""Times for which a film rests at its ends, ms."""
_REDUCTION = 2
_TITLE_SIZE, _NOTE_SIZE = 20, 14
_MARGIN = 12
_NOTE_CHARACTERS, _NOTE_LINES = 96, 2
_BACKGROUND, _TEXT_COLOUR, _NOTE_COLOUR, _FAULT_COLOUR = (255, 255, 255), (32, 36, 46), (96, 101, 112), (190, 24, 40)
_BLENDS = (0.0, 1 / 3, 2 / 3)
"""Shares of the outline or the background in the palette of a GIF, for smooth edges."""


def still_of(exported: Exported, state: ExportState) -> bytes:
    """Return a PNG picture of a state."""
    linkage, replay, angles = exported.linkage, exported.replay, exported.angles(state)
    ends, caption = [linkage.folded, linkage.flat], str(state)
    if replay is None:
        canvas = FilmCanvas(linkage, ends, exported.name, "", "")
    else:
        canvas = canvas_of(replay, [*ends, *_frames(replay)[1]])
        if isinstance(state, float):
            first, last = replay.at[[0, -1]].tolist()
            caption = caption_at(replay, first + state * (last - first))
    file = BytesIO()
    canvas.picture(angles, caption).save(file, format="PNG", optimize=True)
    return file.getvalue()


def film_of(replay: Replay, form: FilmFormat) -> bytes:
    """Return a film of a motion, which repeats; steps of its frames are equal in time, or along the path."""
    places, states = _frames(replay)
    canvas = canvas_of(replay, list(states))

    def pictures() -> Iterator[Image.Image]:
        for place, angles in zip(places.tolist(), states, strict=True):
            picture = canvas.picture(angles, caption_at(replay, place))
            # one palette for all frames, so that colours do not flicker
            yield picture.quantize(palette=_palette(), dither=Image.Dither.NONE) if form == "GIF" else picture

    frames = pictures()
    durations = [FRAME_MILLISECONDS] * FILM_FRAME_COUNT
    durations[0], durations[-1] = FIRST_REST_MILLISECONDS, LAST_REST_MILLISECONDS
    file = BytesIO()
    options = {"optimize": False} if form == "GIF" else {"quality": 85, "method": 4}
    first = next(frames)
    first.save(file, format=form, save_all=True, append_images=frames, duration=durations, loop=0, **options)
    return file.getvalue()


def _frames(replay: Replay) -> tuple[Reals, Reals]:
    """Return the places of the frames on the axis of a motion, and their fold angles, (FILM_FRAME_COUNT, n_hinges)."""
    first, last = replay.at[[0, -1]].tolist()
    places = np.linspace(first, last, FILM_FRAME_COUNT)
    return places, replay.at_time(places)


def canvas_of(replay: Replay, states: list[Reals]) -> FilmCanvas:
    """Return the canvas for pictures of a motion that fits some of its states (fold angles, rad)."""
    return FilmCanvas(replay.linkage, states, replay.title, replay.source, replay.faults)


def caption_at(replay: Replay, place: float) -> str:
    """Return the caption of a place on the axis of a motion: a time, with the speed of the film, or a path's share."""
    first, last = replay.at[[0, -1]].tolist()
    if replay.axis == "path":
        return f"{100.0 * place:.0f} % of the path"
    if first == last:
        return f"{place:.4g} s"
    digits = max(0, 2 - math.floor(math.log10(last - first)))
    slowness = 1e-3 * FRAME_MILLISECONDS * (FILM_FRAME_COUNT - 1) / (last - first)
    ratio, word = (slowness, "slower") if slowness >= 1.0 else (1.0 / slowness, "faster")
    return f"{place:.{digits}f} s ({short_number(ratio, 2)} times {word} than real)"


class FilmCanvas:
    """Draws pictures of a linkage with texts above and below."""

    def __init__(self, linkage: Linkage, states: list[Reals], title: str, note: str, faults: str) -> None:
        """Fit states (fold angles, rad) into the pictures; faults : of the motion, in a sentence."""
        self._linkage = linkage
        self._title = textwrap.shorten(title, 60, placeholder="...")
        self._notes = textwrap.wrap(note, _NOTE_CHARACTERS, max_lines=_NOTE_LINES, placeholder=" ...")
        self._faults = textwrap.wrap(faults, _NOTE_CHARACTERS, max_lines=_NOTE_LINES, placeholder=" ...")
        solids = [centred_solids(linkage.solids(angles)) for angles in states]
        self.painter = MotionPainter(linkage, solids, _REDUCTION * PICTURE_WIDTH, _REDUCTION * MAX_DRAWING_HEIGHT)
        line = _REDUCTION * round(1.35 * _NOTE_SIZE)
        self._line = line
        self._above = _REDUCTION * (_MARGIN + round(1.5 * _TITLE_SIZE)) + line * (len(self._notes) + len(self._faults))
        self._below = _REDUCTION * (_MARGIN + round(1.5 * _TITLE_SIZE))

    def picture(self, angles: Reals, caption: str) -> Image.Image:
        """Return the picture of a state with a caption."""
        height = self._above + self.painter.height + self._below
        height += height % _REDUCTION
        image = Image.new("RGB", (_REDUCTION * PICTURE_WIDTH, height), _BACKGROUND)
        draw = ImageDraw.Draw(image)
        self._draw_texts(draw, caption, height)
        scale = _REDUCTION * PICTURE_WIDTH / FRAME_WIDTH
        for mark in self.painter.marks(centred_solids(self._linkage.solids(angles))):
            points = [(x, y + self._above) for x, y in mark.points]
            colour = MARK_COLOURS[mark.look]
            if mark.is_face:
                draw.polygon(points, fill=colour)
                draw.line(
                    [*points, *points[:2]], fill=OUTLINE_COLOUR, width=round(scale * OUTLINE_WIDTH), joint="curve"
                )
            else:
                draw.line(points, fill=colour, width=round(scale * HINGE_WIDTH))
        return image.reduce(_REDUCTION)

    def pixel(self, point: Reals) -> tuple[int, int]:
        """Return the column and row of the pixel that shows a point, (3,), in metres."""
        ((x, y),) = self.painter.projected(point[None])
        return int(x / _REDUCTION), int((y + self._above) / _REDUCTION)

    def _draw_texts(self, draw: ImageDraw.ImageDraw, caption: str, height: int) -> None:
        left, top = _REDUCTION * _MARGIN, _REDUCTION * _MARGIN
        draw.text((left, top), self._title, fill=_TEXT_COLOUR, font=_font(_TITLE_SIZE))
        top += _REDUCTION * round(1.5 * _TITLE_SIZE)
        for colour, lines in ((_NOTE_COLOUR, self._notes), (_FAULT_COLOUR, self._faults)):
            for text in lines:
                draw.text((left, top), text, fill=colour, font=_font(_NOTE_SIZE))
                top += self._line
        draw.text((left, height - self._below), caption, fill=_TEXT_COLOUR, font=_font(_TITLE_SIZE))


@cache
def _font(size: int) -> ImageFont.FreeTypeFont:
    return ImageFont.truetype(text_font_file(), _REDUCTION * size)


@cache
def _palette() -> Image.Image:
    """Return the palette of all films as GIF: the colours of marks and texts, and their blends at smooth edges."""
    texts = (_TEXT_COLOUR, _NOTE_COLOUR, _FAULT_COLOUR)
    pairs = [*product(MARK_COLOURS.values(), [OUTLINE_COLOUR]), *product((*texts, OUTLINE_COLOUR), [_BACKGROUND])]
    colours = {_BACKGROUND, OUTLINE_COLOUR}
    for (one, other), share in product(pairs, _BLENDS):
        red, green, blue = (round((1.0 - share) * a + share * b) for a, b in zip(one, other, strict=True))
        colours.add((red, green, blue))
    image = Image.new("P", (1, 1))
    image.putpalette([value for colour in sorted(colours) for value in colour])
    return image
