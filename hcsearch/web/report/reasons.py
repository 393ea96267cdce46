"""Reasons for the status of a folding in one sentence, from the records of the stages."""

from __future__ import annotations

from collections.abc import Sequence
from typing import cast

from hcsearch.basics.vocabulary import STATUSES, Way, play_sentence
from hcsearch.scenes.looks import SceneVariant, describe_spring_set
from hcsearch.store import StoredVerdict
from hcsearch.web.report.data import ViewRow

UNTRIED_SENTENCE = "not proved locked; no path was searched for and no springs were tried in this scene"
LOCKED_SENTENCE = "proved locked at an end of the motion, in every way that the scene may join its flat pairs"


def best_deployment(deployments: Sequence[ViewRow]) -> ViewRow | None:
    """Return the first deployment that deploys, else the first one."""
    return next((row for row in deployments if row["status"] == "deploys"), deployments[0] if deployments else None)


def status_reason(folding: ViewRow, motion: str | None, deployments: Sequence[ViewRow]) -> str:
    """Return the reason for the status of a folding; empty if no stage has judged it.

    motion : the sentence on the planned motion. deployments : its deployments.
    """
    status, best = folding.get("status"), best_deployment(deployments)
    if folding.get("twist"):
        return f"twist {folding['twist']}: the closed band of panels cannot reach the two stacks"
    if status == "locked":
        return motion or LOCKED_SENTENCE
    if status == "deploys" and best is not None:
        return "; ".join(filter(None, (str(best["reason"]), play_of_row(folding), springs_of_row(best))))
    if motion is None and best is None:
        return UNTRIED_SENTENCE if status == "undecided" or folding.get("kutzbach") is not None else ""
    springs = "springs were not tried" if best is None else f"{best['reason']}; {springs_of_row(best)}"
    return "; ".join(filter(None, (springs, motion, play_of_row(folding))))


def play_of_row(row: ViewRow) -> str | None:
    """Return the sentence on the play that the motion behind the status needs; None without one."""
    needed = row.get("needed_margin")
    return play_sentence(needed if isinstance(needed, float) else None)


def springs_of_row(row: ViewRow) -> str:
    """Return springs and joining of flat pairs of a deployment in words."""
    text = (
        f"springs: {describe_spring_set(str(row['springs']))}"
        if row["springs"]
        else f"springs of the scene {row['base']}"
    )
    return f"{text}, flat pairs {row['pairs']}"


def verdict_of_row(folding: ViewRow, deployments: Sequence[ViewRow]) -> StoredVerdict | None:
    """Return the verdict of a row of `foldings` with its deployments; None if no stage has judged it."""
    status, best = folding.get("status"), best_deployment(deployments)
    if status not in STATUSES:
        return None
    deployed = None
    if best is not None and best["status"] == "deploys":
        deployed = SceneVariant(
            cast("Way", best["pairs"]), str(best["springs"]), as_written=best["scene"] == best["base"]
        )
    return StoredVerdict(status, cast("Way | None", folding.get("flat_pairs")), deployed)
