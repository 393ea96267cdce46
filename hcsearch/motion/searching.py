"""The shape of all searches: one is made, takes steps until it is done or its budget is spent, and has a result."""

from __future__ import annotations

import math
import time
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Generic, TypeVar

R = TypeVar("R")


@dataclass(frozen=True)
class Budget:
    """The limits of a search.

    efforts : in the unit of the search, such as rounds of trees or boxes of fold angles. seconds : time after which no
    step begins; with such a bound a result depends on the machine. seed : of random numbers.
    """

    efforts: float = math.inf
    seconds: float = math.inf
    seed: int = 0


UNBOUNDED = Budget()
"""The budget of a search that ends by itself."""


class SteppedSearch(ABC, Generic[R]):
    """A search. The same steps have the same results, whatever budget they were made for."""

    @property
    def efforts(self) -> int:
        """Efforts made so far; a search that ends by itself need not count them."""
        return 0

    @property
    @abstractmethod
    def done(self) -> bool:
        """Whether no step remains."""

    @abstractmethod
    def step(self, budget: Budget) -> None:
        """Make the next step, or where it can be divided, as much of it as a budget leaves."""

    @property
    @abstractmethod
    def result(self) -> R:
        """The result after the steps so far."""

    def run(self, budget: Budget = UNBOUNDED) -> R:
        """Make steps until the search is done or its budget is spent; return the result."""
        begun = time.monotonic()
        while not self.done and self.efforts < budget.efforts and time.monotonic() - begun < budget.seconds:
            self.step(budget)
        return self.result
