"""Evaluations of one array in the database: what has been computed once is taken from there."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from hcsearch.springs.deployment.outcomes import DeploymentCheck
from hcsearch.springs.tuning.evaluation import EvaluationKey
from hcsearch.store import Database, find_evaluations, record_evaluations


class DatabaseMemory:
    """The evaluations of a subject (its notation and sizes, in one text) in a database: a memory of an evaluator."""

    def __init__(self, database: Database, subject: str) -> None:
        self._database, self._subject = database, subject
        rows = find_evaluations(database, subject)
        self._known = {EvaluationKey(row["setting"], row["springs"]): check_of_row(row) for row in rows}

    def recall(self, keys: Sequence[EvaluationKey]) -> Mapping[EvaluationKey, DeploymentCheck]:
        """Those of the keys that are known."""
        return {key: self._known[key] for key in keys if key in self._known}

    def record(self, checks: Mapping[EvaluationKey, DeploymentCheck]) -> None:
        """Store more checks, in one transaction."""
        record_evaluations(self._database, [self.row(self._subject, key, check) for key, check in checks.items()])
        self._known |= checks

    @staticmethod
    def row(subject: str, key: EvaluationKey, check: DeploymentCheck) -> dict[str, Any]:
        """A row of the table."""
        time, panels = (None, (None, None)) if check.collision is None else check.collision
        return {
            "subject": subject,
            "setting": key.setting,
            "springs": key.springs,
            "outcome": check.outcome,
            "clear": None if check.clear is None else int(check.clear),
            "end_time": check.end_time,
            "collision_time": time,
            "first_panel": panels[0],
            "second_panel": panels[1],
            **{name: _finite(getattr(check, name)) for name in _REALS},
            **{name: getattr(check, name) for name in _COUNTS},
        }


_REALS = ("gap", "speed", "remaining", "end_remaining", "widest", "drift", "opening")
_COUNTS = ("steps", "evaluations", "looks")


def check_of_row(row: Mapping[str, Any]) -> DeploymentCheck:
    """The check that a row of the table holds."""
    collision = None
    if row["collision_time"] is not None:
        collision = (row["collision_time"], (row["first_panel"], row["second_panel"]))
    reals: dict[str, Any] = {name: math.nan if row[name] is None and name != "gap" else row[name] for name in _REALS}
    return DeploymentCheck(
        outcome=row["outcome"],
        end_time=row["end_time"],
        clear=None if row["clear"] is None else bool(row["clear"]),
        collision=collision,
        **reals,
        **{name: row[name] for name in _COUNTS},
    )


def _finite(value: float | None) -> float | None:
    """A number, or None for what overflowed: not all databases keep such."""
    return value if value is not None and math.isfinite(value) else None
