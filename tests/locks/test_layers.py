"""Contacts between layers: their rows are velocities, two-stack foldings need none, and they lock what stops do not."""

import math
from collections import Counter

import numpy as np
import pytest
from scipy.optimize import least_squares, linprog

from hcsearch.library.assemblies import ASSEMBLIES
from hcsearch.library.assemblies.packages import flat_overlap, folded_package
from hcsearch.library.unit_search.elements import elements_of_designs
from hcsearch.library.unit_search.unit_proofs import has_locked_end
from hcsearch.motion.locks.end_locks import (
    WRENCH_MARGIN,
    LayerContact,
    contact_rows,
    layer_contacts,
    lock_at,
    parting_rates,
)
from hcsearch.shape.linkage import Linkage
from hcsearch.shape.pattern import MOUNTAIN_CREASE, RIGID_CREASE, VALLEY_CREASE, Crease, Pattern

DOWN, UP = Crease("bottom", closes=False), Crease("top", closes=False)
"""Hinges that stay flat in the folded state, and turn one way only from there."""

CLAMP = """
vppp
vpv.
vvv.
"""
"""Panel p reaches across the line of its only hinge, and so does v on the other side."""

RING = """
dfe.
ddee
aacc
aabc
"""
"""Six panels in a ring, which fold onto two by two squares."""


def drawn(text, creases, thickness=0.1):
    """Unit squares, joined rigidly where they have one letter; other creases by the places (column, row) they join."""
    rows = text.split()[::-1]
    places = [(x, y) for y, row in enumerate(rows) for x, letter in enumerate(row) if letter != "."]
    corners = ((0, 0), (1, 0), (1, 1), (0, 1))
    facets = tuple(tuple((float(x + dx), float(y + dy)) for dx, dy in corners) for x, y in places)
    beside = [(p, q) for p in places for q in places if p < q and abs(p[0] - q[0]) + abs(p[1] - q[1]) == 1]
    joined = {(p, q): RIGID_CREASE for p, q in beside if rows[p[1]][p[0]] == rows[q[1]][q[0]]} | creases
    number = {place: k for k, place in enumerate(places)}
    numbered = {tuple(sorted((number[p], number[q]))): crease for (p, q), crease in joined.items()}
    pattern = Pattern.from_polygons(facets, numbered, thickness)
    assert flat_overlap(pattern) == 0
    assert folded_package(pattern).overlap_volume < 1e-9
    return Linkage(pattern)


def clamp(third=None):
    """Panels p and v hinged at one edge; with a third crease, the end of v that lies on p is a panel x of its own."""
    text = CLAMP if third is None else CLAMP.replace("v", "x", 1)
    return drawn(text, {((1, 1), (2, 1)): VALLEY_CREASE} | ({((0, 1), (0, 2)): third} if third else {}))


def ring():
    return drawn(
        RING,
        {((1, 0), (2, 0)): MOUNTAIN_CREASE, ((2, 0), (2, 1)): VALLEY_CREASE, ((2, 1), (2, 2)): MOUNTAIN_CREASE}
        | {((0, 1), (0, 2)): MOUNTAIN_CREASE, ((1, 1), (1, 2)): MOUNTAIN_CREASE, ((3, 1), (3, 2)): MOUNTAIN_CREASE}
        | {((1, 2), (1, 3)): VALLEY_CREASE, ((1, 3), (2, 3)): MOUNTAIN_CREASE},
    )


def all_touching(linkage):
    """Every facet that lies on one of another panel, those across a crease too, pair by pair."""
    import shapely

    solids, panel, size = linkage.solids(linkage.folded), linkage.pattern.panel_of, linkage.pattern.size
    touching = []
    for i, one in enumerate(solids):
        for j, two in enumerate(solids):
            if panel[i] == panel[j] or abs(two[..., 2].min() - one[..., 2].max()) > 0.1 * linkage.pattern.thickness:
                continue
            shadows = [shapely.Polygon(solid[0, :, :2] / size) for solid in (one, two)]
            area = shapely.convex_hull(shapely.intersection(*shadows, grid_size=1e-12))
            if area.area > 1e-6:
                touching.append(LayerContact(i, j, np.array(area.exterior.coords)[:-1] * size))
    return touching


def loops(linkage):
    """Screws of the hinges in the sense in which they leave their stops, shape (n_rows, n_hinges)."""
    return linkage.closure(linkage.folded)[1] * np.where(linkage.folded > 0, -1.0, 1.0)


def heights(linkage, x, contact):
    """Where the corners of a contact come to when hinges turn by x, as points of the facet above, over that below."""
    panel = linkage.pattern.panel_of
    before = linkage.poses(linkage.folded)
    after = linkage.poses(linkage.folded + np.where(linkage.folded > 0, -x, x))
    point = np.c_[contact.corners, np.zeros(len(contact.corners))]
    for here, there, k in ((before, after, panel[contact.above]), (after, before, panel[contact.below])):
        point = (point - here[k, :, 3]) @ here[k, :, :3] @ there[k, :, :3].T + there[k, :, 3]
    return point[:, 2]


MOVING = ("element-8r", "unit-i", "unit-ii", "unit-iii", "element-6r", "module-i", "module-ii", "module-iii")


def built(name):
    return Linkage(ASSEMBLIES[name].build(ASSEMBLIES[name].defaults))


@pytest.mark.parametrize("name", ["clamp", "clamp-down", "clamp-up", "ring", *MOVING])
def test_rows_are_velocities(name):
    """Along motions of the first order, whichever way they are summed up."""
    linkage = {"clamp": clamp(), "clamp-down": clamp(DOWN), "clamp-up": clamp(UP), "ring": ring()}.get(name)
    linkage = linkage or built(name)
    rng = np.random.default_rng(5)
    _, values, turns = np.linalg.svd(np.r_[loops(linkage), np.zeros((linkage.n_hinges,) * 2)])
    free = turns[values < 1e-9]
    corners = linkage.pattern.size * rng.normal(size=(3, 2))
    pairs = rng.integers(len(linkage.pattern.facets), size=(20, 2)).tolist()
    touching = [*layer_contacts(linkage), *(LayerContact(i, j, corners) for i, j in pairs)]
    rows = parting_rates(linkage, touching)
    fastest = 0.0
    for x in rng.normal(size=(5, len(free))) @ free:
        ahead, back = (np.concatenate([heights(linkage, s * x, it) for it in touching]) for s in (1e-5, -1e-5))
        velocities = (ahead - back) / 2e-5 / linkage.pattern.size
        assert rows @ x == pytest.approx(velocities, abs=1e-7)
        fastest = max(fastest, np.abs(velocities).max())
    assert fastest > 0.1


@pytest.mark.parametrize(("grid", "n", "expected"), [("hex", 10, {None, 1, 2}), ("square", 12, {None})])
def test_stops_imply_the_contacts_of_two_stacks(grid, n, expected):
    """Statement 26, with every contact, and with each row altered by what loops make zero."""
    rng = np.random.default_rng(6)
    orders = set()
    for element in list(elements_of_designs(grid, n))[::2]:
        linkage = element.linkage
        if not linkage.loops:
            continue
        touching = all_touching(linkage)
        rows = parting_rates(linkage, touching)
        assert len(touching) >= len(linkage.pattern.facets) - 2
        assert rows.min() > -1e-9
        assert (rows.max(axis=1) > 0.1).any()
        assert layer_contacts(linkage) == []
        assert contact_rows(linkage).shape == (0, linkage.n_hinges)
        order = lock_at(linkage, linkage.folded).order
        orders.add(order)
        altered = rows + rng.normal(size=(len(rows), linkage.n_rows)) @ loops(linkage)
        assert altered.min() < -0.1
        assert lock_at(linkage, linkage.folded, altered).order == order
    assert orders == expected


@pytest.mark.parametrize("name", MOVING)
def test_what_moves_is_not_locked_by_contacts(name):
    linkage = built(name)
    rng = np.random.default_rng(7)
    touching = parting_rates(linkage, all_touching(linkage))
    assert len(touching) > 12
    touching += rng.normal(size=(len(touching), linkage.n_rows)) @ loops(linkage)
    assert not lock_at(linkage, linkage.folded, touching).locked
    assert not has_locked_end(linkage)


def test_contacts_lock_what_stops_do_not():
    """By one panel on the other beyond their hinge; by a third one that no hinge joins to it; in a ring."""
    ways = {frozenset((hinge.first, hinge.second)) for hinge in clamp(UP).pattern.hinges}
    (contact,) = layer_contacts(clamp(UP))
    panel = clamp(UP).pattern.panel_of
    assert frozenset((panel[contact.below], panel[contact.above])) not in ways
    for linkage in (clamp(), clamp(UP), ring()):
        rows = contact_rows(linkage)
        stops, lock = lock_at(linkage, linkage.folded), lock_at(linkage, linkage.folded, rows)
        assert (stops.order, lock.order) == (None, 1)
        assert lock.forces.min() >= 0.0
        assert lock.forces.max() > 0.01
        assert "push" in lock.reason
        assert "push" not in stops.reason
        assert (lock.wrench @ loops(linkage) - lock.forces @ rows).min() > WRENCH_MARGIN
        assert has_locked_end(linkage)
    assert np.abs(lock.wrench).max() == 1.0  # in the ring loops and layers hold together
    lock = lock_at(clamp(DOWN), clamp(DOWN).folded, contact_rows(clamp(DOWN)))
    assert not lock.locked
    assert lock.motion == pytest.approx([0.0, 1.0])
    assert not has_locked_end(clamp(DOWN))


def test_what_stops_leave_the_ring_goes_through_its_panels():
    """Pressed open with stops kept its loop closes again, and somewhere a panel is in the one below it."""
    linkage = ring()
    rng = np.random.default_rng(8)
    closed = 0
    for start in 0.3 * rng.dirichlet(np.ones(linkage.n_hinges), size=20):

        def gap(x):
            return np.r_[linkage.closure(linkage.folded - x)[0], x.sum() / 0.3 - 1.0]

        outcome = least_squares(gap, start, bounds=(0.0, math.pi), ftol=1e-15, xtol=1e-15, gtol=1e-15)
        if outcome.cost < 1e-16:
            closed += 1
            assert min(heights(linkage, outcome.x, contact).min() for contact in layer_contacts(linkage)) < -1e-3
    assert closed > 3


def greatest_turn(columns, rows, aim, slack=0.0):
    """The x of sum 1 or less with A x = 0 and C x >= 0, or nearly, that goes farthest one way, by a linear program."""
    height = len(columns)
    above, right = np.r_[-rows, np.ones((1, len(aim)))], np.r_[np.full(len(rows), slack), 1.0]
    return linprog(-aim, A_ub=above, b_ub=right, A_eq=columns, b_eq=np.zeros(height)).x


def test_any_conditions_are_kept_and_what_is_proved_holds():
    """Conditions at random on foldings that stops leave open: proofs by each order, and motions that keep all."""
    rng = np.random.default_rng(9)
    seen = Counter()
    for element in elements_of_designs("hex", 10):
        linkage = element.linkage
        if lock_at(linkage, linkage.folded).locked:
            continue
        columns = loops(linkage)
        for count in (1, 2, 4, 8):
            rows = rng.normal(size=(count, linkage.n_hinges))
            lock = lock_at(linkage, linkage.folded, rows)
            movable, nearly = (
                greatest_turn(columns, rows, np.ones(linkage.n_hinges), slack).sum() > 0.5 for slack in (0.0, 1e-4)
            )
            assert lock.locked or nearly  # what cannot move at first order is proved, unless by a hair
            seen[lock.order] += 1
            if lock.order == 1:
                assert not movable
                assert (lock.wrench @ columns - lock.forces @ rows).min() > WRENCH_MARGIN
                assert lock.forces.min() >= 0.0
                continue
            assert np.abs(columns @ lock.motion).max() < 1e-6
            assert lock.order == 2 or (rows @ lock.motion).min() > -1e-6
            if lock.order == 2:
                assert not lock.forces.any()
                assert (lock.wrench @ columns).min() > -1e-12
                for _ in range(20):
                    x = greatest_turn(columns, rows, rng.normal(size=linkage.n_hinges))
                    senses = np.where(linkage.folded > 0, -1.0, 1.0)
                    bend = lock.wrench @ linkage.bend(linkage.closure(linkage.folded)[1], senses * x)
                    assert bend > 0.0 or x.sum() < 0.5
    assert min(seen[None], seen[1], seen[2]) >= 3, seen


def test_conditions_that_are_met_change_nothing():
    linkage = ring()
    stops = lock_at(linkage, linkage.folded)
    for rows in (np.zeros((0, 6)), np.eye(6), np.zeros((3, 6))):
        lock = lock_at(linkage, linkage.folded, rows)
        assert (lock.order, lock.held_hinges) == (stops.order, stops.held_hinges)
        assert lock.motion == pytest.approx(stops.motion)
