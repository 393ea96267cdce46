"""Parts of the closed states, as far as walks show them, and which one a closed state belongs to.

Parts are far apart, but a part of six freedoms is shown by a hundred thousand states so sparsely that the nearest one
may be of another part. So a state belongs to a part if small steps lead from it to a state of that.
"""

from __future__ import annotations

import numpy as np

from hcsearch.basics.arrays import Reals
from hcsearch.kernels.enclosure.expansion import HingeRings
from hcsearch.kernels.enclosure.refutation import Refutation
from hcsearch.kernels.enclosure.wandering import approach_goal, climb_angles, random_walk
from hcsearch.motion.locks.boxes import Box, states_in

PART_WALK_STEPS, PART_CLIMB_STEPS = 2000, 200
"""Steps of the walk from a state, and of each climb from there."""
MAX_APPROACH_STEPS, APPROACH_ROUNDS = 1000, 3
"""Steps towards the nearest state of a part, and how often the nearest one is chosen anew."""
NEAREST_PART_COUNT = 3
"""Parts towards which steps are tried: those that have the nearest states."""
ARRIVED_DISTANCE = 0.05
"""Steps that come so near to a state (rad, the root of the sum of squares) lead to it."""
APPROACH_START_COUNT = 3
"""States from which steps are tried, the one that was met first, then others of the walk from it."""


class StateParts:
    """Parts of the closed states: the first holds the end that is to be enclosed, the second the other end.

    own, others : (m, n), to which walks from both ends lead. seed : of further walks. work : tables.
    steps : of walks, all together, as boxes of the search are counted.
    """

    def __init__(self, rings: HingeRings, own: Reals, others: Reals, seed: int, work: Refutation) -> None:
        self.rings, self.seed, self.work = rings, seed, work
        self.states = [own, others]
        self.steps = 0

    def climbed(self, states: Reals, box: Box, steps: int) -> Reals:
        """States, and those to which climbs from them lead, within a box."""
        climbed: Reals = climb_angles(self.rings, states, *box, steps, self.seed, self.work)
        self.steps += len(climbed) - len(states)
        return climbed

    def add(self, state: Reals, box: Box) -> int:
        """Add a closed state, (n,), with what a walk from it leads to, and climbs within a box; the number of its part.

        It is a part by itself where steps lead to none that is known, STARTS * NEAREST * AGAIN * TOWARDS at most.
        """
        walked = random_walk(self.rings, state, PART_WALK_STEPS, self.seed, self.work)
        self.steps += PART_WALK_STEPS
        held = states_in(box, walked)
        passed = [walked, self.climbed(held, box, PART_CLIMB_STEPS)[len(held) :]]
        for start in (state, *walked[:: len(walked) // APPROACH_START_COUNT + 1][1:]):
            number = self._leads_to(start, passed)
            if number is not None:
                self.states[number] = np.concatenate([self.states[number], *passed])
                return number
        self.states.append(np.concatenate(passed))
        return len(self.states) - 1

    def _leads_to(self, state: Reals, passed: list[Reals]) -> int | None:
        """The part to which steps lead from a state, if to any; the states that they pass are listed."""
        order = np.argsort([_nearest(part, state)[1] for part in self.states], kind="stable")
        for number in order[:NEAREST_PART_COUNT].tolist():
            here = state
            for again in range(APPROACH_ROUNDS):
                goal = self.states[number][_nearest(self.states[number], here)[0]]
                states, steps = approach_goal(self.rings, here, goal, MAX_APPROACH_STEPS, self.seed + again, self.work)
                self.steps += steps
                passed.append(states)
                here = states[-1]
                if float(((here - goal) ** 2).sum()) < ARRIVED_DISTANCE**2:
                    return int(number)
        return None


def _nearest(states: Reals, state: Reals) -> tuple[int, float]:
    """Which of some states, (m, n), is nearest to one, (n,), and the square of how far away it is."""
    away = ((states - state) ** 2).sum(axis=1)
    number = int(away.argmin())
    return number, float(away[number])
