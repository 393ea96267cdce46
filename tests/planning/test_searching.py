"""The shape of searches: what ends one, and that the parts of one have the result of the whole."""

import pytest

from hcsearch.motion.planning.path_proofs import CERTIFIED_MARGINS
from hcsearch.motion.planning.simple_moves import SimpleMoves, simple_path
from hcsearch.motion.searching import Budget, SteppedSearch
from tests.planned import joined


class Counting(SteppedSearch[int]):
    """Counts up to ten, by threes where the budget leaves them."""

    efforts = 0

    @property
    def done(self):
        return self.efforts == 10

    def step(self, budget):
        self.efforts = int(min(self.efforts + 3, 10, budget.efforts))

    @property
    def result(self):
        return self.efforts


@pytest.mark.parametrize(
    ("budget", "counted"), [(Budget(), 10), (Budget(7), 7), (Budget(99), 10), (Budget(0), 0), (Budget(seconds=0.0), 0)]
)
def test_a_search_ends_by_itself_or_when_its_budget_is_spent(budget, counted):
    search = Counting()
    assert search.run(budget) == counted
    assert search.run(budget) == counted
    assert search.run() == 10


def test_a_search_in_parts_has_the_result_of_the_whole():
    linkage = joined("square:01222300:0", "rigid")
    whole, search, parts = simple_path(linkage, CERTIFIED_MARGINS[-1]), SimpleMoves(linkage, CERTIFIED_MARGINS[-1]), 0
    while not search.done:
        search.run(Budget(search.efforts + 1))
        parts += 1
    assert parts > 1
    assert (search.result == whole).all()
