"""What a run tells while it goes on."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol


class RunProgress(Protocol):
    """Callback for progress: amount done and in all, a note on results, and the unit."""

    def __call__(self, done: int, total: int, note: str, unit: str = "batch") -> None:
        """Show it."""


AnnounceSentence = Callable[[str], None]
