"""Bills of materials: the panels, hinges, springs, latches and drives of a case, alike ones counted together."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from hcsearch.basics.array_values import ByValue, Reals
from hcsearch.scenes.laws import Law
from hcsearch.shape.labels import label_ranges
from hcsearch.shape.least_rectangles import least_rectangle
from hcsearch.shape.mesh import facet_area, without_straight_corners
from hcsearch.shape.pattern import Fold, PanelFace, Pattern
from hcsearch.subjects.case import Case

if TYPE_CHECKING:
    import pandas as pd

ALIKE = 1e-6
"""Greatest relative difference of the sizes or values of parts that are counted together."""


class _Item:
    """Alike parts; names : of the panels or hinges that they are, or are at."""

    names: tuple[str, ...]
    part: ClassVar[str] = "hinges"

    @property
    def cells(self) -> dict[str, Any]:
        """Its values by the names of columns."""
        raise NotImplementedError

    @property
    def row(self) -> dict[str, Any]:
        """The number of parts, the cells and the names of the parts, by the names of columns."""
        return {"count": len(self.names), **self.cells, self.part: label_ranges(self.names)}


@dataclass(frozen=True)
class PanelItem(_Item):
    """Congruent panels; a panel and its mirror image are one part, turned over.

    corners : number of corners of the outline. length, width, thickness : of the smallest box around one of them, m.
    area : m^2. mass : of one, with what is mounted on it, kg. names : of the panels.
    """

    corners: int
    length: float
    width: float
    thickness: float
    area: float
    mass: float
    names: tuple[str, ...]
    part = "panels"

    @property
    def cells(self) -> dict[str, Any]:
        """Its values by the names of columns."""
        return {
            "corners": self.corners,
            "length_mm": 1e3 * self.length,
            "width_mm": 1e3 * self.width,
            "thickness_mm": 1e3 * self.thickness,
            "area_mm2": 1e6 * self.area,
            "mass_g": 1e3 * self.mass,
            "total_mass_g": 1e3 * self.mass * len(self.names),
        }


@dataclass(frozen=True)
class HingeItem(_Item):
    """Hinges of one length on one face of the sheet.

    face : which carries them. fold : valleys are on the top face, mountains on the bottom face, and hinges of flat
    pairs on either. length : of one, m. names : of the hinges.
    """

    face: PanelFace
    fold: Fold
    length: float
    names: tuple[str, ...]

    @property
    def cells(self) -> dict[str, Any]:
        """Its values by the names of columns."""
        return {
            "face": self.face,
            "fold": self.fold,
            "length_mm": 1e3 * self.length,
            "total_length_mm": 1e3 * self.length * len(self.names),
        }


@dataclass(frozen=True)
class SpringItem(_Item):
    """Springs of one law; stiffness : the mean one, N m/rad. law : its notation. names : of their hinges."""

    stiffness: float
    law: str
    names: tuple[str, ...]

    @property
    def cells(self) -> dict[str, Any]:
        """Its values by the names of columns."""
        return {"stiffness_N_m_per_rad": self.stiffness, "law": self.law}


@dataclass(frozen=True)
class DamperItem(_Item):
    """Dampers of equal coefficient; damping : of a hinge with one, N m s/rad. names : of their hinges."""

    damping: float
    names: tuple[str, ...]

    @property
    def cells(self) -> dict[str, Any]:
        """Its values by the names of columns."""
        return {"damping_N_m_s_per_rad": self.damping}


@dataclass(frozen=True)
class LatchItem(_Item):
    """Latches that hold hinges flat; stiffness : N m/rad. names : of their hinges."""

    stiffness: float
    names: tuple[str, ...]

    @property
    def cells(self) -> dict[str, Any]:
        """Its values by the names of columns."""
        return {"stiffness_N_m_per_rad": self.stiffness}


@dataclass(frozen=True)
class DriveItem(_Item):
    """Drives of equal torque and travel; torque : greatest planned, N m. travel : of the fold angle, rad.

    names : of their hinges.
    """

    torque: float
    travel: float
    names: tuple[str, ...]

    @property
    def cells(self) -> dict[str, Any]:
        """Its values by the names of columns."""
        return {"torque_N_m": self.torque, "travel_rad": self.travel}


@dataclass(frozen=True)
class BillSection:
    """The items of one kind; `rows` are their cells, by the names of columns."""

    kind: str
    rows: tuple[dict[str, Any], ...]


@dataclass(frozen=True)
class BillOfMaterials:
    """The parts of a folding or an assembly in a scene; alike parts are one item.

    Parameters
    ----------
    title
        The name of the folding or assembly.
    scene
        The name of the scene, which gives masses, springs, dampers, latches and drives.
    panels, hinges, springs, dampers, latches, drives
        The parts of each kind; dampers are those of hinges whose damping the scene gives, and not in proportion to
        springs.
    """

    title: str
    scene: str
    panels: tuple[PanelItem, ...]
    hinges: tuple[HingeItem, ...]
    springs: tuple[SpringItem, ...] = ()
    latches: tuple[LatchItem, ...] = ()
    drives: tuple[DriveItem, ...] = ()
    dampers: tuple[DamperItem, ...] = ()

    @property
    def mass(self) -> float:
        """The mass of all panels, kg."""
        return sum(item.mass * len(item.names) for item in self.panels)

    @property
    def hinge_length(self) -> float:
        """The length of all hinges, m."""
        return sum(item.length * len(item.names) for item in self.hinges)

    @cached_property
    def sections(self) -> tuple[BillSection, ...]:
        """The kinds of parts that there are, with their items."""
        kinds: dict[str, Sequence[_Item]] = {
            "panels": self.panels,
            "hinges": self.hinges,
            "springs": self.springs,
            "dampers": self.dampers,
            "latches": self.latches,
            "drives": self.drives,
        }
        return tuple(BillSection(kind, tuple(item.row for item in items)) for kind, items in kinds.items() if items)

    def table(self) -> pd.DataFrame:
        """Return all items as one pandas table; columns that do not apply to a kind are missing values.

        The column `kind` is one of `panels`, `hinges`, `springs`, `dampers`, `latches`, `drives`; `names` are those of
        the panels or hinges.
        """
        import pandas as pd  # noqa: PLC0415 - only for tables

        rows = []
        for section in self.sections:
            for row in section.rows:
                *cells, (_, names) = row.items()
                rows.append({"kind": section.kind, **dict(cells), "names": names})
        table = pd.DataFrame(rows).astype({"count": "Int64", "corners": "Int64"})
        return table[[*(name for name in table if name != "names"), "names"]]


def bill_of_case(case: Case) -> BillOfMaterials:
    """Return the bill of materials of a case."""
    return BillOfMaterials(
        case.title,
        case.scene.name,
        _panels(case),
        _hinges(case),
        _springs(case),
        _latches(case),
        _drives(case),
        _dampers(case),
    )


def _panels(case: Case) -> tuple[PanelItem, ...]:
    pattern, density = case.linkage.pattern, case.setup.density
    shapes = [_PanelShape.of(pattern, panel) for panel in range(len(pattern.panels))]
    items = []
    for group in _alike_groups(range(len(shapes)), lambda a, b: shapes[a].is_congruent(shapes[b])):
        shape = shapes[group[0]]
        names = tuple(case.labels.panels[panel] for panel in group)
        mass = density * shape.area * pattern.thickness
        items.append(PanelItem(len(shape.outline), *shape.box, pattern.thickness, shape.area, mass, names))
    return tuple(items)


def _hinges(case: Case) -> tuple[HingeItem, ...]:
    pattern, names = case.linkage.pattern, case.labels.hinges
    lengths = [0.0] * len(pattern.hinges)
    for pair, crease in pattern.creases.items():
        if crease.face is not None:
            lengths[pattern.hinge_of(pair)] += math.dist(*pattern.segment(pair))
    creases = [hinge.crease for hinge in pattern.hinges]
    groups = _alike_groups(
        range(len(lengths)),
        lambda a, b: creases[a] == creases[b] and math.isclose(lengths[a], lengths[b], rel_tol=ALIKE),
    )
    items = [
        HingeItem(
            pattern.hinges[group[0]].face, creases[group[0]].fold, lengths[group[0]], tuple(names[k] for k in group)
        )
        for group in groups
    ]
    return tuple(sorted(items, key=lambda item: (item.fold == "flat", item.face != "top", -item.length)))


def _springs(case: Case) -> tuple[SpringItem, ...]:
    laws = case.setup.laws
    acting = [hinge for hinge, law in enumerate(laws) if _acts(law)]
    items = []
    for group in _alike_groups(acting, lambda a, b: laws[a] == laws[b]):
        law = laws[group[0]]
        items.append(SpringItem(law.mean_stiffness, law.text, tuple(case.labels.hinges[hinge] for hinge in group)))
    return tuple(sorted(items, key=lambda item: item.stiffness))


def _acts(law: Law) -> bool:
    """Return whether a law has a moment anywhere."""
    branches = [branch for branch in (law.straight, law.bent) if branch is not None]
    return any(any(cubic) for branch in branches for cubic in branch.cubics)


def _dampers(case: Case) -> tuple[DamperItem, ...]:
    return tuple(
        DamperItem(damping, tuple(case.labels.hinges[hinge] for hinge in hinges))
        for damping, hinges in sorted(case.setup.dampers().items())
    )


def _latches(case: Case) -> tuple[LatchItem, ...]:
    stiffness = case.setup.latch_stiffness
    held = np.flatnonzero(stiffness).tolist()
    return tuple(
        LatchItem(stiffness[group[0]], tuple(case.labels.hinges[hinge] for hinge in group))
        for group in _alike_groups(held, lambda a, b: stiffness[a] == stiffness[b])
    )


def _drives(case: Case) -> tuple[DriveItem, ...]:
    drives = case.drives
    if drives is None:
        return ()
    drives.check(case.linkage)
    torques, travels = np.abs(drives.torques).max(axis=0), np.ptp(drives.angles, axis=0)
    values = np.column_stack([torques, travels])
    items = []
    for group in _alike_groups(range(len(values)), lambda a, b: np.allclose(values[a], values[b], rtol=ALIKE)):
        torque, travel = values[group[0]].tolist()
        items.append(DriveItem(torque, travel, tuple(case.labels.hinges[drives.hinges[k]] for k in group)))
    return tuple(sorted(items, key=lambda item: -item.torque))


@dataclass(frozen=True, eq=False)
class _PanelShape(ByValue):
    """The shape of a panel in the plane, m.

    outline : corners of the outer walk, straight ones left out, (n, 2). points : those of all walks. box : length and
    width of the smallest rectangle around it.
    """

    outline: Reals
    points: Reals
    area: float
    box: tuple[float, float]

    @staticmethod
    def of(pattern: Pattern, panel: int) -> _PanelShape:
        walks = [without_straight_corners(walk, pattern.vertices, ALIKE) for walk in pattern.outlines[panel]]
        corners = [np.array([pattern.vertices[vertex] for vertex in walk]) for walk in walks]
        area = sum(facet_area(pattern.facets[facet]) for facet in pattern.panels[panel])
        around = least_rectangle(corners[0])
        return _PanelShape(corners[0], np.vstack(corners), area, (around.length, around.width))

    def is_congruent(self, other: _PanelShape) -> bool:
        """Return whether the shapes are congruent, mirror images included.

        The outer walks are compared side by side and turn by turn, holes by the distances between all corners.
        """
        if len(self.outline) != len(other.outline) or len(self.points) != len(other.points):
            return False
        size = math.sqrt(self.area)
        if not np.allclose(self._distances, other._distances, rtol=0.0, atol=ALIKE * size):
            return False
        own, others = self._walk, (other._walk, _mirrored(other._walk))
        return any(
            np.allclose(own, np.roll(walk, shift, axis=0), rtol=0.0, atol=ALIKE * size)
            for walk in others
            for shift in range(len(own))
        )

    @cached_property
    def _distances(self) -> Reals:
        """The distances between all pairs of corners, sorted."""
        from scipy.spatial.distance import pdist  # noqa: PLC0415 - loads slowly

        distances: Reals = np.sort(pdist(self.points))
        return distances

    @cached_property
    def _walk(self) -> Reals:
        """The length of each side, and the distance between the corners before and after its end: (n, 2), m."""
        after, later = np.roll(self.outline, -1, axis=0), np.roll(self.outline, -2, axis=0)
        sides = np.linalg.norm(after - self.outline, axis=1)
        return np.column_stack([sides, np.linalg.norm(later - self.outline, axis=1)])


def _mirrored(walk: Reals) -> Reals:
    """Return a walk in the other direction: the same sides backwards, each with the distance at its other end."""
    return np.column_stack([walk[::-1, 0], np.roll(walk[::-1, 1], -1)])


def _alike_groups(numbers: Iterable[int], alike: Callable[[int, int], bool]) -> list[list[int]]:
    """Group numbers; each is compared with the first of every group."""
    groups: list[list[int]] = []
    for number in numbers:
        group = next((group for group in groups if alike(group[0], number)), None)
        if group is None:
            groups.append([number])
        else:
            group.append(number)
    return groups
