"""Labels of panels and hinges, as pictures, files and the command line write them.

Panels of a design have the numbers of its circuit, and hinges those of its creases, independently of rigid and merged
creases: panels that form one panel have a joint label, `3+4`, and so have creases that form one hinge. Panels and
hinges of an assembly have the numbers of its pattern.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

from hcsearch.basics.errors import HcsearchError
from hcsearch.shape.linkage import Linkage


@dataclass(frozen=True)
class Labels:
    """A name for each panel and for each hinge of a linkage, in their order.

    design : whether these are numbers of a circuit; crease k joins its panels k and k + 1, cyclically.
    """

    panels: tuple[str, ...]
    hinges: tuple[str, ...]
    design: bool = field(default=False, compare=False)

    @property
    def merged(self) -> tuple[str, ...]:
        """Names of the panels that are merged from several."""
        return tuple(name for name in self.panels if "+" in name)

    def hinge(self, name: str) -> int:
        """Find a hinge by its name, or by one of the creases that form it; HcsearchError where there is none."""
        hinge = _find(self.hinges, name)
        if hinge is not None:
            return hinge
        known = f"the hinges are {label_ranges(self.hinges)}" if self.hinges else "there are no hinges"
        if self.design and name.isdigit() and int(name) < self._n:
            merged = self.panels[self.panel(name)]
            raise HcsearchError(f"crease {int(name)} carries no hinge here, its panels are one, {merged}: {known}")
        raise HcsearchError(f"there is no hinge {name}: {known}")

    def panel(self, name: str) -> int:
        """Find a panel by its name, or by one of the panels that form it; HcsearchError where there is none."""
        panel = _find(self.panels, name)
        if panel is None:
            raise HcsearchError(f"there is no panel {name}: the panels are {label_ranges(self.panels)}")
        return panel

    @property
    def _n(self) -> int:
        return sum(len(name.split("+")) for name in self.panels)


def labels_of(linkage: Linkage) -> Labels:
    """The labels of a linkage's panels and hinges."""
    pattern = linkage.pattern
    if not pattern.of_circuit:
        return Labels(tuple(map(str, range(linkage.n_panels))), tuple(map(str, range(linkage.n_hinges))))
    n = len(pattern.facets)
    creases: list[list[int]] = [[] for _ in range(linkage.n_hinges)]
    for pair, crease in pattern.creases.items():
        if crease.face is not None:
            creases[pattern.hinge_of(pair)].append(n - 1 if pair == (0, n - 1) and n > 2 else pair[0])
    return Labels(
        tuple("+".join(map(str, panel)) for panel in pattern.panels),
        tuple("+".join(map(str, sorted(own))) for own in creases),
        design=True,
    )


def named_hinges(linkage: Linkage, hinges: Iterable[int]) -> str:
    """The names of some hinges of a linkage, separated by commas."""
    names = labels_of(linkage).hinges
    return ", ".join(names[hinge] for hinge in hinges) or "none"


def is_label(text: str) -> bool:
    """Whether a text may be the name of a panel or a hinge: a number, or several as in `3+4`."""
    return all(part.isascii() and part.isdigit() and len(part) < 10 for part in text.split("+"))


def label_data(name: str) -> int | str:
    """A name as data: an integer, or a text for a merged one, `3+4`."""
    return int(name) if name.isdigit() else name


def label_ranges(names: Sequence[str]) -> str:
    """Write names in one line, with consecutive numbers as `0 to 3`."""
    runs: list[list[str]] = []
    for name in names:
        if runs and name.isdigit() and runs[-1][-1].isdigit() and int(name) == int(runs[-1][-1]) + 1:
            runs[-1].append(name)
        else:
            runs.append([name])
    return ", ".join(f"{run[0]} to {run[-1]}" if len(run) > 2 else ", ".join(run) for run in runs)


def _find(names: Iterable[str], name: str) -> int | None:
    """The position of the first name that contains all the numbers of another, in any order; None without one."""
    parts = {part.lstrip("0") or "0" for part in name.split("+")}
    return next((k for k, own in enumerate(names) if parts <= set(own.split("+"))), None)
