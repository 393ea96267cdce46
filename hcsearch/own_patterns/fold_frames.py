"""Frames of a FOLD file: which of them is the crease pattern, with what it inherits from others."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from hcsearch.errors import InputFileError

_OWN = ("frame_parent", "frame_inherit")
"""What a frame says of itself alone."""


@dataclass(frozen=True)
class Frame:
    """A frame with the values that it inherits; number : 0 is the key frame, others follow as they are listed."""

    number: int
    values: Mapping[str, Any]

    @property
    def name(self) -> str:
        """What messages call it."""
        return "its first frame" if self.number == 0 else f"its frame {self.number}"


def pattern_frame(data: Mapping[str, Any], path: str) -> Frame:
    """The frame that is read; InputFileError where frames are no list, or inherit from what is none.

    That is the first with points that says it is a crease pattern; without one, the first with points that does not
    say that it is folded; without one of those, too, the first with points, or the key frame.
    """
    listed = data.get("file_frames") or []
    if not isinstance(listed, list) or not all(isinstance(frame, dict) for frame in listed):
        raise InputFileError(f"{path} is no sound FOLD file: file_frames is not a list of frames; export it anew")
    frames = [_given(frame) for frame in (data, *listed)]
    patterns = [k for k, frame in enumerate(frames) if "creasePattern" in _classes(frame)]
    unfolded = [k for k, frame in enumerate(frames) if "foldedForm" not in _classes(frame)]
    for k in dict.fromkeys((*patterns, *unfolded, *range(len(frames)))):
        values = _with_inherited(frames, k, path)
        if values.get("vertices_coords"):
            return Frame(k, values)
    return Frame(0, frames[0])


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


def _classes(frame: Mapping[str, Any]) -> list[Any]:
    classes = frame.get("frame_classes")
    return classes if isinstance(classes, list) else []
