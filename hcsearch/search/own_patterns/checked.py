"""The results of the stages for a subject of the user: a verdict on each of its foldings, or on the whole pattern."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

from hcsearch.scenes import Scene
from hcsearch.search.stages.order import FOLDING_STAGES

T = TypeVar("T")


@dataclass(frozen=True)
class Checked:
    """The results of the stages on a subject in a scene.

    Parameters
    ----------
    scene
        The scene.
    facts
        All results as plain data, as `hcsearch check --json` prints them; keys name their units.
    heads
        The subject in lines, above the verdicts.
    verdicts
        The verdict on each folding of a design that was checked, or on a pattern of any panels. Each has its `status`,
        the `heading` that states it, `reasons`, the `play` that it needs, and `deployed_in`: names and scenes with
        which `hcsearch deploy` repeats its deployment.
    funnel
        Number of foldings of a design that pass each stage; empty of other patterns.
    fault
        Why there is no verdict; empty where there is one.
    """

    scene: Scene
    facts: dict[str, Any]
    heads: Sequence[str]
    verdicts: Sequence[Any]
    funnel: dict[str, int]
    fault: str = ""

    @property
    def deploys(self) -> bool:
        """Whether springs bring it from packed to flat, certified free of collisions."""
        return any(verdict.status == "deploys" for verdict in self.verdicts)


def through_stages(
    state: T,
    run: Callable[[str, T], T],
    begin: Callable[[str], None],
    ended: Callable[[T], bool] = lambda _state: False,
) -> T:
    """Take a state through the stages of a folding, until it has ended.

    run : runs the stage of a name on a state. begin : called with the name of each stage before it.
    """
    for name in FOLDING_STAGES:
        begin(name)
        state = run(name, state)
        if ended(state):
            break
    return state
