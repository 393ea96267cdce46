"""Why a folding has its status: one sentence of what the stages recorded."""

from __future__ import annotations

from collections.abc import Sequence
from typing import cast

from hcsearch.basics.vocabulary import STATUSES, Way, play_sentence
from hcsearch.scenes import joined_name
from hcsearch.scenes.looks import SceneVariant, describe_spring_set
from hcsearch.store import StoredVerdict
from hcsearch.web.report.data import ViewRow

UNTRIED_SENTENCE = "not proved locked; no path was looked for and no springs were tried in this scene"
LOCKED_SENTENCE = "proved locked at an end of the motion, in every way that the scene may join its flat pairs"


def best_deployment(tried: Sequence[ViewRow]) -> ViewRow | None:
    """The deployment that counts: the first that deploys, else the first."""
    return next((row for row in tried if row["status"] == "deploys"), tried[0] if tried else None)


def status_reason(folding: ViewRow, motion: str | None, tried: Sequence[ViewRow]) -> str:
    """The sentence behind the status of a folding; empty where no stage has decided anything.

    motion : the sentence behind the planned motion. tried : its deployments.
    """
    status, best = folding.get("status"), best_deployment(tried)
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
    """How much to leave between faces for the motion that gives a folding its status; None where it has none."""
    needed = row.get("needed_margin")
    return play_sentence(needed if isinstance(needed, float) else None)


def springs_of_row(row: ViewRow) -> str:
    """The springs and the flat pairs of a deployment."""
    text = (
        f"springs: {describe_spring_set(str(row['springs']))}"
        if row["springs"]
        else f"springs of the scene {row['base']}"
    )
    return f"{text}, flat pairs {row['pairs']}"


def deployment_scene_name(row: ViewRow, verdict: StoredVerdict | None) -> str:
    """The name of a deployment's scene by which `hcsearch deploy` repeats it.

    verdict : on the folding in the scene that it serves. Where another look gave it, the scene as it stands names its
    flat pairs: they are joined otherwise unless somebody says so.
    """
    scene, pairs = str(row["scene"]), str(row["pairs"])
    if verdict is None or scene != row["base"]:
        return scene
    deploys, moves = verdict.status == "deploys", verdict.status == "movable" and verdict.path is not None
    deployed = verdict.deployed
    other = deployed is not None and not deployed.as_written if deploys else moves and verdict.path != pairs
    return joined_name(scene, pairs) if other else scene


def way_option_text(way: str | None) -> str:
    """The option by which `hcsearch drive` joins flat pairs in a way; nothing for none."""
    return "" if way is None else f" --flat-pairs {way}"


def verdict_of_row(folding: ViewRow, tried: Sequence[ViewRow]) -> StoredVerdict | None:
    """The verdict of a row of `foldings`, with its deployments; None where no stage has judged it."""
    status, best = folding.get("status"), best_deployment(tried)
    if status not in STATUSES:
        return None
    deployed = None
    if best is not None and best["status"] == "deploys":
        deployed = SceneVariant(
            cast("Way", best["pairs"]), str(best["springs"]), as_written=best["scene"] == best["base"]
        )
    return StoredVerdict(status, cast("Way | None", folding.get("flat_pairs")), deployed)
