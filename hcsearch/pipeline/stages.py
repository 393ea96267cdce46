"""The stages of the pipeline, in order, with the versions of their results."""

from __future__ import annotations

from hcsearch import deployment, enumeration, folding, mobility, planning, twisting
from hcsearch.errors import StageError

BUILT: dict[str, int] = {
    **{module.STAGE: module.VERSION for module in (enumeration, folding, twisting, mobility)},
    # each of these rests on those before it: a newer version of one makes the others older, too
    planning.STAGE: 100 * planning.VERSION + mobility.VERSION,
    deployment.STAGE: 10_000 * deployment.VERSION + 100 * planning.VERSION + mobility.VERSION,
}

KEEP_NEEDS = {"all": enumeration.STAGE, "two-stack": folding.STAGE, "untwisted": twisting.STAGE}


IN_A_SCENE = (planning.STAGE, deployment.STAGE)
"""Stages whose results depend on a scene."""


def stages_until(last: str) -> dict[str, int]:
    """Name and version of every stage up to `last`; StageError when it is unknown."""
    if last not in BUILT:
        raise StageError(f"stage {last!r} is unknown: use --until {', '.join(BUILT)}")
    names = list(BUILT)
    return {name: BUILT[name] for name in names[: names.index(last) + 1]}


def check_keep(keep: str, until: str) -> None:
    """Refuse to keep designs by a stage that does not run."""
    if KEEP_NEEDS[keep] not in stages_until(until):
        raise StageError(f"--keep {keep} needs the stage {KEEP_NEEDS[keep]}: use --until {KEEP_NEEDS[keep]}")
