"""Replays as compact plain data, which the player reads from a page.

| key | value | unit |
|---|---|---|
| `version` | of this table: 1 | |
| `title`, `source` | what moves, and where the motion comes from | |
| `unit` | one step of `corners`, `thickness` and `hinges`: 0.01 unless panels are small | mm |
| `thickness` | of all panels | `unit` |
| `corners` | x and y of each corner in the flat state, one after the other | `unit` |
| `facets` | corners of each facet, counterclockwise, by number | |
| `panel` | panel of each facet | |
| `stack` | stack of each facet, 0 or 1, that of facet 0 first; null where the folded state is not two stacks | |
| `creases` | facets i < j that a crease joins, and its hinge, -1 where it is rigid; other shared edges are slits | |
| `hinges` | x, y of start and of end, 1 for the top face or 0, 1 where it closes or 0, both panels | `unit` |
| `order` | panels in the order in which they are placed | |
| `parents`, `via`, `signs` | of each panel: its parent, the hinge between, its sense; -1, -1, 0 for a root | |
| `labels` | names of `panels` and of `hinges` | |
| `axis` | `time`, in s, or `path`, in shares of its length | |
| `at` | place of each key state on the axis, rising | s or 1 |
| `scale` | one step of `angles` | rad |
| `angles` | fold angles, one key state after another: base64 of little-endian int16 | `scale` |
| `certified` | intervals of `at` in which panels are certified clear with `margin` of play | s or 1 |
| `margin` | play on every face | mm |
| `collision` | place of the first collision, and its two panels; null without | s or 1 |
| `error` | greatest error of fold angles by interpolation between key states and rounding | rad |
| `nearest` | panel pair at each key state: deepest overlap, else smallest nonzero gap; -1, -1 without | |
| `gaps` | gaps of these pairs, below 0 where they overlap | `unit` / 10 |
| `touching` | number of pairs of panels that touch at each key state | |

Corners and hinges have whole numbers, or decimals where a hinge spans several creases: these must stay on one line.

Poses follow `Linkage.poses`: the pose of a panel is that of its parent times the rotation about the hinge between, by
sign times fold angle; the axis points from start to end for a hinge on the bottom face, from end to start otherwise.
"""

from __future__ import annotations

import base64
import math
from typing import Any

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.basics.errors import HcsearchError
from hcsearch.motion.collision.distances import nearest_panels
from hcsearch.shape.labels import Labels
from hcsearch.shape.linkage import Linkage
from hcsearch.shape.pattern import RIGID_CREASE, Crease, FacetPair, Pattern
from hcsearch.subjects.replay import Replay, stacks_of

Payload = dict[str, Any]

PAYLOAD_VERSION = 1
LENGTH_STEP_MM = 0.01
"""Step of lengths, mm, for panels of size `MIN_STEP_PANEL_MM` and more."""
MIN_STEP_PANEL_MM = 10.0
"""Size of panels, mm, below which lengths have finer steps."""
ANGLE_STEP = 1e-4
"""Step of fold angles, rad; larger if an angle would exceed the range of int16."""


def payload_of(replay: Replay) -> Payload:
    """Return a replay as plain data for JSON, with the keys in the module's table."""
    linkage, pattern = replay.linkage, replay.linkage.pattern
    unit = _unit(1e3 * pattern.size)
    step = 1e-3 * unit
    n_creases = sum(crease.face is not None for crease in pattern.creases.values())
    digits = None if n_creases == len(pattern.hinges) else 5
    chain = linkage.chain
    scale = max(ANGLE_STEP, float(np.abs(replay.angles).max(initial=0.0)) / 32767)
    nearest = nearest_panels(linkage, replay.angles)
    collision = replay.collision
    return {
        "version": PAYLOAD_VERSION,
        "title": replay.title,
        "source": replay.source,
        "unit": unit,
        "thickness": round(pattern.thickness / step),
        "corners": [round(x / step, digits) for vertex in pattern.vertices for x in vertex],
        "facets": [list(face) for face in pattern.faces],
        "panel": list(pattern.panel_of),
        "stack": stacks_of(linkage),
        "creases": [
            [i, j, pattern.hinge_of((i, j)) if crease.face else -1] for (i, j), crease in pattern.creases.items()
        ],
        "hinges": [
            [
                *(round(x / step, digits) for x in (*h.start, *h.end)),
                int(h.face == "top"),
                int(h.closes),
                h.first,
                h.second,
            ]
            for h in pattern.hinges
        ],
        "order": chain.order.tolist(),
        "parents": chain.parents.tolist(),
        "via": chain.hinges.tolist(),
        "signs": chain.signs.tolist(),
        "labels": {"panels": list(replay.labels.panels), "hinges": list(replay.labels.hinges)},
        "axis": replay.axis,
        "at": _places(replay.at),
        "scale": scale,
        "angles": base64.b64encode(np.rint(replay.angles / scale).astype("<i2").tobytes()).decode("ascii"),
        "certified": [[float(begin), float(end)] for begin, end in replay.certified],
        "margin": round(1e3 * replay.margin, 9),
        "collision": None if collision is None else [float(collision[0]), *map(int, collision[1])],
        "error": replay.error + 0.5 * scale,
        "nearest": nearest.pairs.ravel().tolist(),
        "gaps": np.rint(1e4 * np.nan_to_num(nearest.gaps) / unit).astype(int).tolist(),
        "touching": nearest.touching.tolist(),
    }


def replay_in(payload: Payload) -> Replay:
    """Return the replay from its plain data, with rounded lengths and angles."""
    if payload.get("version") != PAYLOAD_VERSION:
        raise HcsearchError(f"a motion of version {payload.get('version')!r} cannot be read: write it anew")
    step = 1e-3 * payload["unit"]
    corners = (step * np.array(payload["corners"], float)).reshape(-1, 2).tolist()
    hinges = payload["hinges"]
    creases: dict[FacetPair, Crease] = {}
    for i, j, hinge in payload["creases"]:
        creases[i, j] = (
            RIGID_CREASE if hinge < 0 else Crease("top" if hinges[hinge][4] else "bottom", bool(hinges[hinge][5]))
        )
    faces = tuple(map(tuple, payload["facets"]))
    pattern = Pattern(tuple((x, y) for x, y in corners), faces, creases, step * payload["thickness"])
    collision, labels = payload["collision"], payload["labels"]
    return Replay(
        linkage=Linkage(pattern, base=payload["order"][0]),
        labels=Labels(tuple(labels["panels"]), tuple(labels["hinges"])),
        axis=payload["axis"],
        at=np.array(payload["at"], float),
        angles=angles_in(payload),
        certified=tuple((begin, end) for begin, end in payload["certified"]),
        collision=None if collision is None else (collision[0], (collision[1], collision[2])),
        margin=1e-3 * payload["margin"],
        error=payload["error"],
        title=payload["title"],
        source=payload["source"],
    )


def angles_in(payload: Payload) -> Reals:
    """Return the fold angles of the key states, shape (k, n_hinges), rad."""
    steps = np.frombuffer(base64.b64decode(payload["angles"]), "<i2")
    angles: Reals = payload["scale"] * steps.reshape(len(payload["at"]), len(payload["hinges"])).astype(float)
    return angles


def _unit(size: float) -> float:
    """Return the step of lengths for panels of a size, mm: a power of ten."""
    return (
        LENGTH_STEP_MM
        if size >= MIN_STEP_PANEL_MM
        else float(f"1e{math.floor(math.log10(LENGTH_STEP_MM * size / MIN_STEP_PANEL_MM))}")
    )


def _places(at: Reals) -> list[float]:
    """Round places to the fewest digits with an error below a ten-thousandth of the smallest step."""
    smallest_step = float(np.diff(at).min(initial=math.inf))
    digits = (
        max(4, 4 - math.floor(math.log10(smallest_step)))
        if math.isfinite(smallest_step) and smallest_step > 0.0
        else 15
    )
    return [round(float(place), digits) for place in at]
