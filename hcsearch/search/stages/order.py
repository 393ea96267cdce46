"""The stages in the order in which they run."""

from __future__ import annotations

from collections.abc import Iterable
from importlib import import_module

from hcsearch.basics.errors import StageError
from hcsearch.basics.vocabulary import STAGE_NAMES
from hcsearch.search.stages.stage import Stage

STAGES: dict[str, Stage] = {name: import_module(f"hcsearch.search.stages.{name}").STAGE for name in STAGE_NAMES}
"""The stages by name; each has a module of its name."""


def stages_until(last: str) -> tuple[Stage, ...]:
    """Return the stages up to and including `last`; StageError for an unknown stage."""
    if last not in STAGES:
        raise StageError(f"stage {last!r} is unknown: use --until {', '.join(STAGES)}")
    names = list(STAGES)
    return tuple(STAGES[name] for name in names[: names.index(last) + 1])


FOLDING_STAGES = tuple(stage.name for stage in stages_until("deployment")[len(stages_until("twist")) :])
"""Names of the stages that judge an untwisted folding, or a pattern, of its own."""


def stage_numbers(stages: Iterable[Stage]) -> dict[str, int]:
    """Return the version numbers under which finished work of stages is stored, by name."""
    return {stage.name: stage.stored_version for stage in stages}


def stage_keeping(keep: str) -> Stage:
    """Return the stage whose passing designs are kept by a value of `--keep`."""
    return next(stage for stage in STAGES.values() if stage.keep == keep)


def check_keep(keep: str, until: str) -> None:
    """Check that the stage needed by `--keep` runs; StageError otherwise."""
    needed = stage_keeping(keep)
    if needed not in stages_until(until):
        raise StageError(f"--keep {keep} needs the stage {needed.name}: use --until {needed.name}")
