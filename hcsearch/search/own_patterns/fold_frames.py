"""Frames of a FOLD file: which of them is the crease pattern, with what it inherits from others."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from hcsearch.basics.errors import InputFileError

_OWN = ("frame_parent", "frame_inherit")
"""What a frame says of itself alone."""
_NO_PANELS = {"graph", "linkage"}
"""Classes of frames whose edges bound no panels."""


@dataclass(frozen=True)
class Frame:
    """A frame with the values that it inherits; name : what messages call it."""

    name: str
    values: Mapping[str, Any]


def pattern_frame(data: Mapping[str, Any], path: str) -> Frame:
    """The frame that is read; InputFileError where frames are no list, or inherit from what is none.

    That is the first, among those with points and edges or faces, that says it is a crease pattern; without one, the
    first that says neither that it is folded nor that it has no panels; then one without panels, then a folded one.
    Where no frame has points and edges or faces, it is the first with points, or the key frame.
    """
    listed = data.get("file_frames") or []
    if not isinstance(listed, list) or not all(isinstance(frame, dict) for frame in listed):
        raise InputFileError(f"{path} is no sound FOLD file: file_frames is not a list of frames; export it anew")
    frames = [_given(frame) for frame in (data, *listed)]
    pointed = None
    for k in sorted(range(len(frames)), key=lambda k: _rank(frames[k])):
        frame = Frame(_name(k, len(frames), path), _with_inherited(frames, k, path))
        if "vertices_coords" not in frame.values:
            continue
        if "edges_vertices" in frame.values or "faces_vertices" in frame.values:
            return frame
        pointed = pointed or frame
    return pointed or Frame(_name(0, len(frames), path), frames[0])


def _rank(frame: Mapping[str, Any]) -> int:
    """How late a frame is tried."""
    classes = _classes(frame)
    if "creasePattern" in classes:
        return 0
    if "foldedForm" in classes:
        return 3
    return 2 if _NO_PANELS & classes else 1


def _name(number: int, count: int, path: str) -> str:
    """The file and, of several frames, which: 0 is the key frame, others follow as they are listed."""
    if count == 1:
        return path
    return f"frame {number} of {path}" if number else f"the first frame of {path}"


def _with_inherited(frames: list[Mapping[str, Any]], number: int, path: str) -> Mapping[str, Any]:
    """The values of a frame, and of its parent and those before it what it does not have."""
    values: dict[str, Any] = dict(frames[number])
    seen = [number]
    while frames[seen[-1]].get("frame_inherit"):
        parent = frames[seen[-1]].get("frame_parent", 0)
        if type(parent) is not int or not 0 <= parent < len(frames):
            raise InputFileError(
                f"{path} is no sound FOLD file: frame {seen[-1]} inherits from {parent!r}, which is no frame; "
                "export it anew"
            )
        if parent in seen:
            way = " from ".join(f"frame {k}" for k in (*seen[seen.index(parent) :], parent)[:5])
            raise InputFileError(
                f"{path} is no sound FOLD file: {way} inherits in a circle; write frame_inherit false in one of them"
            )
        seen.append(parent)
        values = {**frames[parent], **values}
    return {key: value for key, value in values.items() if key not in _OWN}


def _given(frame: Mapping[str, Any]) -> Mapping[str, Any]:
    """What a frame says: programs that write every key leave null or an empty list where they have nothing."""
    return {key: value for key, value in frame.items() if value is not None and value != []}


def _classes(frame: Mapping[str, Any]) -> set[str]:
    classes = frame.get("frame_classes")
    return {name for name in classes if isinstance(name, str)} if isinstance(classes, list) else set()
