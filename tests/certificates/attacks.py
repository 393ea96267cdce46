"""A builder of attacks: false certificates of foldings whose path is proved, over all that the format leaves open.

Each attack is a claim that must be refused, with the kind of reason for which. A lock of a folding that moves is false
whatever its boxes are; so is a lock by collision at a margin no less than that of the path. Where an array is changed,
only claims are built that are false, or of no array, whatever moves.
"""

from __future__ import annotations

import itertools
import math
import random
from collections.abc import Callable, Iterator
from fractions import Fraction
from typing import Any, NamedTuple

from hcsearch.motion.certificates.certificate_data import certificate
from hcsearch.motion.certificates.certificate_grammar import Clock
from hcsearch.motion.certificates.certifying import CertificateError, verify_certificate
from tests.certificates.exact_arrays import STILL, Array

BELOW_PI, ABOVE_PI = math.pi, math.nextafter(math.pi, 4.0)
FORM = "documented form|it has not|uneven|is no |are no |holds no|no known kind|a number|is none"
REASONS = {
    "any": "",
    "form": f"{FORM}|twice the margin|in one panel|no loop is closed",
    "name": "its array is not that of|names no folding|names no joining|names no pattern|documented form",
    "cuts": f"{FORM}|cut|bound|a box is empty|the one end alone|no loop is closed",
    "ends": f"{FORM}|the one end alone|its end is|not closed|is open|no loop is closed",
    "face": "a face of its boxes|no loop is closed",
    "closed": "not proved to lie beside|ends at no stop|open a loop|not parallel|panels are not proved"
    "|does not end flat|has no states|a loop is open|wrenches|is no number|not computed|fewer hinges",
    "path": f"{FORM}|ends at no stop|does not end flat|open a loop|not parallel|no states|a loop is open",
    "margin": f"{FORM}|margin|decimal|no loop is closed",
    "vacuous": "it says nothing",
    "limit": "more than",
    "nothing": "it claims nothing|does not end flat|nothing|it has not|no states|a path of no",
    "document": "is no|JSON|version|checksum|no certificate|format",
}
"""What a refusal may say, by kind of reason."""


class Attack(NamedTuple):
    """A claim that must be refused.

    kind : the degree of freedom of the format. reason : of REASONS. named : whether it keeps the array of its folding.
    """

    kind: str
    claim: Any
    reason: str
    named: bool = True


def refusal(claims: Any, of: Any, panel_mm: Any, seconds: float = math.inf) -> str | None:
    """Why `hcsearch verify` refuses a certificate of claims, with a checksum that fits; None where it does not."""
    try:
        verify_certificate(certificate(claims, of, panel_mm), Clock(seconds))
    except CertificateError as refused:
        return str(refused)
    return None


# Locks: any set of boxes with any cuts


class Boxes(NamedTuple):
    """A set of boxes, in numbers of cuts."""

    kind: str
    cuts: list[list[Any]]
    lows: Any
    highs: Any
    end: Any
    reason: str


def one_box(kind: str, cuts: list[list[Any]], end: Any, reason: str, highs: Any = None, lows: Any = None) -> Boxes:
    """One box between the first cuts and the second ones, unless others are named."""
    n = len(cuts)
    return Boxes(kind, cuts, [lows or [0] * n], [highs or [1] * n], end, reason)


def sets_of_boxes(closes: list[bool], rng: random.Random) -> Iterator[Boxes]:
    """Sets of boxes by which a folding that moves would be locked."""
    yield from odd_cuts(closes, rng)
    for end in ("flat", "packed"):
        yield from boxes_about(end, closes, rng)
        yield all_but(closes, end, 10.0 ** rng.uniform(-3, -0.3))
    n, top = len(closes), ABOVE_PI
    for share in (0.5, 0.9, 0.999):
        yield one_box("a box up to a share of pi", [[0.0, share * math.pi, top]] * n, "flat", "face")
    cuts = [[0.0, math.nextafter(math.pi, 0.0), top]] * n
    yield one_box("a box up to the second double below pi", cuts, "flat", "face")
    yield one_box("a box up to the double below pi", [[0.0, BELOW_PI, top]] * n, "flat", "face")
    yield random_boxes(closes, rng)
    yield random_boxes(closes, rng)


def odd_cuts(closes: list[bool], rng: random.Random) -> Iterator[Boxes]:
    """One box between cuts that are none, or in which both ends lie."""
    n, top = len(closes), ABOVE_PI
    plain = [[0.0, top]] * n
    turned = [k for k in range(n) if closes[k]]
    yield one_box("one box that is everything", plain, "flat", "ends")
    yield one_box("one box that is everything", plain, "packed", "ends")
    for high in (top, 3.1999, 3.15):
        k = rng.choice(turned)
        cuts = [[0.0, high, 3.19999] if h == k else [0.0, top] for h in range(n)]
        yield one_box("one hinge with two cuts above pi", cuts, "flat", "cuts")
    cuts = [[0.0, top, 3.1999] if own else [0.0, top] for own in closes]
    yield one_box("all hinges with two cuts above pi", cuts, "flat", "cuts")
    yield one_box("ten cuts above pi", [[0.0, *(top + 0.005 * k for k in range(10))]] * n, "flat", "cuts")
    yield one_box("two neighbouring cuts above pi", [[0.0, top, math.nextafter(top, 4.0)]] * n, "flat", "cuts")
    yield one_box("cuts that end at the double below pi", [[0.0, BELOW_PI]] * n, "flat", "cuts")
    yield one_box("cuts that end beyond 3.2", [[0.0, 3.3]] * n, "flat", "cuts")
    yield one_box("cuts that end far beyond a turn", [[0.0, 1.0, 2 * math.pi]] * n, "flat", "cuts")
    yield one_box("cuts that begin above 0", [[1e-9, 1.0, top]] * n, "flat", "cuts")
    yield one_box("cuts that begin below 0", [[-1.0, 1.0, top]] * n, "flat", "cuts")
    yield one_box("cuts that descend", [[0.0, 2.0, 1.0, top]] * n, "flat", "cuts")
    yield one_box("equal cuts", [[0.0, 1.0, 1.0, top]] * n, "flat", "cuts")
    yield one_box("one cut", [[0.0]] * n, "flat", "cuts", highs=[0] * n)
    for odd in (math.nan, math.inf, -math.inf, "1", None, True, [1.0], {}, 10**400, 1e300):
        yield one_box("cuts that are no numbers", [[0.0, odd, top]] * n, "flat", "cuts")
    yield Boxes("cuts of fewer hinges", plain[1:], [[0] * n], [[1] * n], "flat", "cuts")
    yield Boxes("cuts of more hinges", [*plain, [0.0, top]], [[0] * n], [[1] * n], "flat", "cuts")


def boxes_about(end: str, closes: list[bool], rng: random.Random) -> Iterator[Boxes]:
    """Boxes about one end, which the path leaves, and what is none."""
    n, top = len(closes), ABOVE_PI
    turned = [k for k in range(n) if closes[k]]
    cuts = [[0.0, math.pi - 1.0, top] if own and end == "packed" else [0.0, 1.0, top] for own in closes]
    lows = {"flat": [0] * n, "packed": [int(own) for own in closes]}
    highs = {"flat": [1] * n, "packed": [1 + int(own) for own in closes]}
    other = "packed" if end == "flat" else "flat"
    good = lows[end], highs[end]
    yield one_box("a box about an end", cuts, end, "face", good[1], good[0])
    yield one_box("the other end is named", cuts, other, "ends", good[1], good[0])
    for odd in ("middle", "", None, 0, ["flat"], "Flat", "flat\n", {"flat": 1}):
        yield one_box("an unknown end", cuts, odd, "ends", good[1], good[0])
    both = [lows["flat"], lows["packed"]], [highs["flat"], highs["packed"]]
    joint = [[0.0, 1.0, math.pi - 1.0, top]] * n
    two = [
        [[0] * n, [2 if own else 0 for own in closes]],
        [[1] * n, [3 if own else 1 for own in closes]],
    ]
    yield Boxes("boxes about both ends", joint, *two, end, "ends")
    yield Boxes("boxes twice", cuts, [good[0]] * 3, [good[1]] * 3, end, "face")
    yield Boxes("no boxes", cuts, [], [], end, "ends")
    yield Boxes("boxes without hinges", cuts, [[]], [[]], end, "cuts")
    yield Boxes("more lows than highs", cuts, both[0], [good[1]], end, "cuts")
    yield Boxes("an empty box", cuts, [good[0]], [good[0]], end, "cuts")
    yield Boxes("an empty box beside a good one", cuts, [good[0], good[0]], [good[1], good[0]], end, "cuts")
    yield Boxes("a box that is turned around", cuts, [good[1]], [good[0]], end, "cuts")
    flat_k = [[*good[1][:k], good[0][k], *good[1][k + 1 :]] for k in rng.sample(range(n), min(n, 2))]
    for high in flat_k:
        yield Boxes("a box that is flat in one direction", cuts, [good[0]], [high], end, "cuts")
    for odd in (-1, 3, 10**9, 10**30, 1.0, 0.5, True, "1", None, math.nan, [1]):
        k = rng.randrange(n)
        high = [*good[1][:k], odd, *good[1][k + 1 :]]
        yield Boxes("a bound that is no number of a cut", cuts, [good[0]], [high], end, "cuts")
        low = [*good[0][:k], odd, *good[0][k + 1 :]]
        if odd is not True or good[0][k] != 0:
            yield Boxes("a bound that is no number of a cut", cuts, [low], [good[1]], end, "cuts")
    # slivers: boxes that lie beyond a face and are hardly wider than it
    k = rng.choice(turned)
    at = cuts[k][1]
    thin = [*cuts[k][:2], math.nextafter(at, 4.0), top] if end == "flat" else [0.0, math.nextafter(at, 0.0), at, top]
    own = [thin if h == k else cut for h, cut in enumerate(cuts)]
    if end == "flat":
        low, high = [good[0], [*good[0][:k], 1, *good[0][k + 1 :]]], [good[1], [*good[1][:k], 2, *good[1][k + 1 :]]]
    else:
        first = [*good[0][:k], 2, *good[0][k + 1 :]], [*good[1][:k], 3, *good[1][k + 1 :]]
        low = [first[0], [*good[0][:k], 1, *good[0][k + 1 :]]]
        high = [first[1], [*good[1][:k], 2, *good[1][k + 1 :]]]
    yield Boxes("a sliver that covers a face", own, low, high, end, "face")


def all_but(closes: list[bool], end: str, size: float) -> Boxes:
    """All fold angles but a corner about the other end: a union of as many boxes as there are hinges."""
    n = len(closes)
    away = [own == (end == "flat") and own for own in closes]  # whether the other end is at pi
    cuts = [[0.0, math.pi - size if own else size, ABOVE_PI] for own in away]
    lows, highs = [], []
    for k in range(n):
        lows.append([1 if h == k and not away[k] else 0 for h in range(n)])
        highs.append([1 if h == k and away[k] else 2 for h in range(n)])
    return Boxes("all but a corner about the other end", cuts, lows, highs, end, "face")


def random_boxes(closes: list[bool], rng: random.Random) -> Boxes:
    """Boxes of a grid of random cuts, one of which holds the flat end and none the packed one."""
    n = len(closes)
    cuts = [[0.0, *sorted(rng.uniform(0.05, 3.1) for _ in range(rng.randint(1, 3))), ABOVE_PI] for _ in range(n)]
    k = rng.choice([h for h in range(n) if closes[h]])
    lows, highs = [[0] * n], [[1] * n]
    for _ in range(rng.randint(0, 4)):
        low = [rng.randrange(len(own) - 1) for own in cuts]
        high = [rng.randrange(a + 1, len(own)) for a, own in zip(low, cuts, strict=True)]
        low[k], high[k] = 0, 1  # so that no box holds the packed state
        lows.append(low)
        highs.append(high)
    return Boxes("random boxes", cuts, lows, highs, "flat", "face")


TRIED: tuple[Any, ...] = (0, -1, -(10**9), 1.5, "1", None, math.nan, math.inf, [], 10**30)
"""Numbers of boxes that were tried, of which most are none."""


def locks(claim: dict[str, Any], rng: random.Random) -> Iterator[Attack]:
    """Locks of an array that moves."""
    array = claim["array"]
    closes = [hinge["closes"] for hinge in array["hinges"]]
    base = {"kind": "lock", "array": array, "pairs": claim["pairs"], "tried": 1}
    for boxes in sets_of_boxes(closes, rng):
        data = {"cuts": boxes.cuts, "lows": boxes.lows, "highs": boxes.highs, "end": boxes.end}
        yield Attack(f"lock: {boxes.kind}", {**base, **data}, boxes.reason)
    good = all_but(closes, "flat", 0.5)
    data = {"cuts": good.cuts, "lows": good.lows, "highs": good.highs, "end": "flat"}
    for odd in TRIED:
        yield Attack("lock: tried", {**base, **data, "tried": odd}, "any")
    for key in ("cuts", "lows", "highs", "end", "tried", "array"):
        yield Attack("lock: a key is missing", {k: x for k, x in {**base, **data}.items() if k != key}, "any")
        for odd in (None, [], {}, "x", 1, [None], [[None]]):
            yield Attack("lock: a key of another type", {**base, **data, key: odd}, "any", key != "array")


def collisions(claim: dict[str, Any], rng: random.Random) -> Iterator[Attack]:
    """Locks by collision of an array that moves, at margins no less than that of its path."""
    array = claim["array"]
    panel_of = {facet: panel for panel, own in enumerate(array["panels"]) for facet in own}
    facets = range(len(array["facets"]))
    every = [[a, b] for a, b in itertools.combinations(facets, 2) if panel_of[a] != panel_of[b]]
    beside = [list(hinge["facets"]) for hinge in array["hinges"]]
    closes = [hinge["closes"] for hinge in array["hinges"]]
    base = {**claim, "kind": "collision", "tried": 1}
    base.pop("stretches")
    sets = list(sets_of_boxes(closes, rng))
    good = [boxes for boxes in sets if boxes.reason == "face"]
    others = [boxes for boxes in sets if boxes.reason != "face"]
    for boxes in (*rng.sample(others, 12), *rng.sample(good, 2)):
        data = {"cuts": boxes.cuts, "lows": boxes.lows, "highs": boxes.highs, "end": boxes.end}
        some = rng.choice([every, beside, rng.sample(every, min(len(every), 4))])
        yield Attack(f"collision: {boxes.kind}", {**base, **data, "pairs_of_facets": some}, boxes.reason)
    boxes = all_but(closes, "flat", 0.5)
    data = {
        **base,
        "cuts": boxes.cuts,
        "lows": boxes.lows,
        "highs": boxes.highs,
        "end": "flat",
        "pairs_of_facets": every,
    }
    own = Fraction(claim["margin"])
    thickness = Fraction(array["unit"]) * array["thickness"]
    if 10 * own < thickness:
        margin = repr(float(rng.choice([2, 5]) * own))
        yield Attack("collision: a greater margin", {**data, "margin": margin}, "face")
    for margin in ("0.5", repr(float(thickness / 2)), repr(float(thickness)), "1e300", "1e-999999999", "1e999999999"):
        yield Attack("collision: a margin beyond the panels, or none", {**data, "margin": margin}, "any")
    for margin in ODD_MARGINS:
        yield Attack("collision: a margin that is none", {**data, "margin": margin}, "margin")
    one = rng.choice(every)
    few: list[tuple[str, Any]] = [
        ("no pairs", []),
        ("a facet with itself", [[one[0], one[0]]]),
        ("a facet that is none", [[one[0], len(facets)]]),
        ("a facet that counts from the end", [[one[0], -1]]),
        ("a pair of one", [[one[0]]]),
        ("a pair of three", [[*one, one[0]]]),
        ("a facet that is no whole number", [[one[0], float(one[1])]]),
        ("a facet that is no number", [[str(one[0]), one[1]]]),
        ("pairs that are none", {"0": one}),
        ("pairs that are none", [None]),
        ("pairs that are none", 5),
    ]
    within = [own[:2] for own in array["panels"] if len(own) > 1]
    few += [("two facets of one panel", [pair]) for pair in within[:1]]
    for kind, pairs in few:
        yield Attack(f"collision: {kind}", {**data, "pairs_of_facets": pairs}, "form")
    again = [("pairs twice", every * 3), ("pairs turned around", [pair[::-1] for pair in every])]
    for kind, pairs in rng.sample(again, 1):
        yield Attack(f"collision: {kind}", {**data, "pairs_of_facets": pairs}, "face")


ODD_MARGINS: tuple[Any, ...] = (
    "-1e-5", "nan", "inf", "-inf", "", " 2e-05", "2e-05\n", "2e-05 m", "1_0e-6", "0x1p-15", "\u0661e-5", "1/0", "--1",
    "1e", "0.0000" + "0" * 60 + "1", "9" * 5000, None, True, [], {}, ["2e-05"],
)  # fmt: skip
"""Margins that are not written as the format says, or are below 0."""


# Paths: any stretches


def opens(array: dict[str, Any], angles: list[float]) -> bool:
    """Whether loops are clearly open at a state: by rational rotations near it."""
    own = Array(array)
    for loop in own.loops:
        pose = STILL
        for k, sense in loop:
            angle = angles[k]
            angle = min(angle, 3.14)
            half = math.tan(0.5 * angle) * math.sqrt(own.root / own.hinges[k].square)
            pose = pose.then(own.turn(k, sense, Fraction(half).limit_denominator(10**6)))
        turned = [Fraction(x, pose.divisor) - (i == j) for i, row in enumerate(pose.turn) for j, x in enumerate(row)]
        shifted = [Fraction(x, pose.divisor * own.size) for x in pose.shift]
        if max(map(abs, turned + shifted)) > 0.05:
            return True
    return False


def paths(claim: dict[str, Any], rng: random.Random) -> Iterator[Attack]:
    """Paths of an array that are broken, whatever else moves it."""
    stretches, array = claim["stretches"], claim["array"]
    n = len(array["hinges"])
    closes = [hinge["closes"] for hinge in array["hinges"]]

    def attack(kind: str, own: Any, reason: str) -> Attack:
        return Attack(f"path: {kind}", {**claim, "stretches": own}, reason)

    yield attack("no stretches", [], "nothing")
    yield attack("the last stretch is missing", stretches[:-1], "nothing" if len(stretches) == 1 else "path")
    yield attack("the first stretch twice", [stretches[0], *stretches], "path")
    yield attack("the last stretch twice", [*stretches, stretches[-1]], "path")
    if len(stretches) > 1:
        yield attack("the first stretch is missing", stretches[1:], "path")
    for odd in (None, {}, "x", 5, [None], [[]], [{}], [{"kind": "equal"}], [{"kind": "cubics"}]):
        yield attack("stretches that are none", odd, "any")
    for kind in ("Equal", "line", None, 1, ["equal"]):
        yield attack("a stretch of an unknown kind", [{**stretches[0], "kind": kind}, *stretches[1:]], "form")
    yield attack("equal turns of no hinge", [{"kind": "equal", "hinges": []}], "nothing")
    for odd in (None, 5, "0", [None], [-1], [0.5], ["0"], [[0]], [n], {}):
        yield attack("equal turns of what is no hinge", [{"kind": "equal", "hinges": odd}], "any")
    ends = [math.pi * own for own in closes]
    if opens(array, [0.5 * x for x in ends]):
        turned = [k for k in range(n) if closes[k]]
        yield attack("equal turns of all hinges", [{"kind": "equal", "hinges": turned}], "path")
        line = {"times": [0.0, 0.5, 1.0], "angles": [ends, [x / 2 for x in ends], [0.0] * n]}
        line |= {"kind": "cubics", "rates": [[-x for x in ends]] * 3}
        yield attack("a straight line", [line], "closed")
        many = [1 - k / 64 for k in range(65)]
        fine = {**line, "times": [k / 64 for k in range(65)], "angles": [[s * x for x in ends] for s in many]}
        yield attack("a straight line of many states", [{**fine, "rates": [[-x for x in ends]] * 65}], "closed")
    for place, stretch in enumerate(stretches):
        for kind, own, reason in broken(stretch, closes, rng):
            if kind in ("a jump", "rates against the path") and not Array(array).loops:
                continue  # between two states fold angles run along a cubic, which a hinge in no loop may take
            yield attack(kind, [*stretches[:place], own, *stretches[place + 1 :]], reason)
    for margin in ("0", "0.0", "0.5", "1e300", "1e-999999999", "1e999999999"):
        yield Attack("path: a margin beyond the panels, or none", {**claim, "margin": margin}, "any")
    for margin in ODD_MARGINS:
        yield Attack("path: a margin that is none", {**claim, "margin": margin}, "margin")
    for key in ("stretches", "margin", "array"):
        yield Attack("path: a key is missing", {k: x for k, x in claim.items() if k != key}, "any")
    for kind in ("lock", "collision", "Path", "", None, 0, ["path"], "path "):
        yield Attack("a claim of another kind", {**claim, "kind": kind}, "any")


def broken(stretch: dict[str, Any], closes: list[bool], rng: random.Random) -> Iterator[tuple[str, Any, str]]:
    """A stretch that is broken somewhere."""
    if stretch["kind"] == "equal":
        for k in rng.sample(range(len(closes)), min(3, len(closes))):
            own = sorted({*stretch["hinges"]} ^ {k})
            yield "one hinge more or less turns", {**stretch, "hinges": own}, "path"
        return
    times, angles, rates = stretch["times"], stretch["angles"], stretch["rates"]
    count, moving = len(times), [k for k in range(len(closes)) if angles[0][k] != angles[-1][k]]
    k, inner = rng.choice(moving), rng.randrange(1, count - 1)
    for cut, kind in ((slice(1, None), "the first state"), (slice(None, -1), "the last state")):
        own = {**stretch, "times": times[cut], "angles": angles[cut], "rates": rates[cut]}
        yield f"{kind} is cut", own, "path"
    yield "times fall", {**stretch, "times": times[::-1]}, "path"
    yield "times stand still", {**stretch, "times": [times[0]] * count}, "path"
    swapped = [*times[: inner - 1], times[inner], times[inner - 1], *times[inner + 1 :]]
    yield "two times are swapped", {**stretch, "times": swapped}, "path"
    yield "the path runs backward", {**stretch, "angles": angles[::-1], "rates": rates[::-1]}, "path"
    yield "two states at most", {**stretch, "times": times[:1], "angles": angles[:1], "rates": rates[:1]}, "path"
    yield "no states", {**stretch, "times": [], "angles": [], "rates": []}, "path"

    def moved(place: int, hinge: int, by: float) -> list[list[float]]:
        own = [list(row) for row in angles]
        own[place][hinge] += by
        return own

    for place in (0, -1):
        for by in (1e-9, -1e-9, 4.44e-16 if place == 0 else 5e-324, 0.1):
            yield "an end beside its stop", {**stretch, "angles": moved(place, k, by)}, "path"
    for by in (0.3, -0.3, 1e3):
        yield "a jump", {**stretch, "angles": moved(inner, k, by)}, "closed"
    for odd in (math.nan, math.inf, 1e300):
        yield "an angle that is no number", {**stretch, "angles": moved(inner, k, odd)}, "any"
    fast = [[1e6 * x for x in row] for row in rates]
    yield "rates a million times as great", {**stretch, "rates": fast}, "closed"
    away = [[-x for x in row] for row in rates]
    yield "rates against the path", {**stretch, "rates": away}, "closed"
    for key, rows in (("angles", angles), ("rates", rates)):
        yield "a hinge is missing in a state", {**stretch, key: [*rows[:-1], rows[-1][1:]]}, "any"
        yield "a hinge is missing in all states", {**stretch, key: [row[1:] for row in rows]}, "any"
        yield "a state is missing", {**stretch, key: rows[1:]}, "any"
        for odd in (None, [], "x", 1.0, {}):
            yield "states that are none", {**stretch, key: odd}, "any"


# Arrays: another one than that of the folding, or none


def arrays(claim: dict[str, Any], rng: random.Random) -> Iterator[Attack]:
    """The claim with an array that is none, or at whose packed state loops are open."""
    array = claim["array"]
    facets, hinges, panels = array["facets"], array["hinges"], array["panels"]
    k = rng.randrange(len(facets))
    ring = facets[k]

    def with_facet(own: Any) -> dict[str, Any]:
        return {**array, "facets": [*facets[:k], own, *facets[k + 1 :]]}

    h = rng.randrange(len(hinges))
    loops = {j for loop in Array(array).loops for j, _ in loop}

    def with_hinge(**own: Any) -> dict[str, Any]:
        return {**array, "hinges": [*hinges[:h], {**hinges[h], **own}, *hinges[h + 1 :]]}

    away = next(p for p in range(len(facets)) if p not in hinges[h]["facets"])
    changed: list[tuple[str, Any]] = [
        ("a facet clockwise", with_facet(ring[::-1])),
        ("a facet without corners", with_facet([])),
        ("a facet of two corners", with_facet(ring[:2])),
        ("a facet that is a point", with_facet([ring[0]] * len(ring))),
        ("a facet that crosses itself", with_facet([ring[1], ring[0], *ring[2:]])),
        ("a facet that runs around twice", with_facet(ring * 2)),
        ("a facet away from its hinges", with_facet([[x + 9999, y] for x, y in ring])),
        ("a facet of fractions", with_facet([[x + 0.5, y] for x, y in ring])),
        ("a facet of texts", with_facet([[str(x), y] for x, y in ring])),
        ("a facet of truths", with_facet([[True, y] for _, y in ring])),
        ("a facet too large", with_facet([[x * 10**6, y * 10**6] for x, y in ring])),
        ("a facet in space", with_facet([[x, y, 0] for x, y in ring])),
        ("a panel in two", {**array, "panels": [*panels, panels[0]]}),
        ("a panel without facets", {**array, "panels": [*panels[1:], []]}),
        ("panels of no facets", {**array, "panels": [[p + 1 for p in own] for own in panels]}),
        ("one panel", {**array, "panels": [[p for own in panels for p in own]]}),
        ("panels that are none", {**array, "panels": None}),
        ("a hinge between facets that share nothing", with_hinge(facets=[hinges[h]["facets"][0], away])),
        ("a hinge of one facet", with_hinge(facets=[hinges[h]["facets"][0]] * 2)),
        ("a hinge of no facet", with_hinge(facets=[0, len(facets)])),
        ("a hinge that counts from the end", with_hinge(facets=[p - len(facets) for p in hinges[h]["facets"]])),
        ("a hinge on a side", with_hinge(face="side")),
        ("a hinge on no face", with_hinge(face=None)),
        ("a hinge that is closed by half", with_hinge(closes=0.5)),
        ("a hinge that closes by a text", with_hinge(closes="false")),
        ("a root of 0", {**array, "root": 0}),
        ("a root below 0", {**array, "root": -3}),
        ("a root that is no number", {**array, "root": "3"}),
        ("no thickness", {**array, "thickness": 0}),
        ("a thickness below 0", {**array, "thickness": -6}),
        ("a thickness of a fraction", {**array, "thickness": 6.5}),
        ("a unit of 0", {**array, "unit": "0"}),
        ("a unit over 0", {**array, "unit": "1/0"}),
        ("a unit below 0", {**array, "unit": "-1/1000"}),
        ("a unit of great length", {**array, "unit": "1" * 5000}),
        ("a unit with an exponent", {**array, "unit": "1e-99999999"}),
        ("a unit that is no text", {**array, "unit": 0.001}),
        ("no hinges", {**array, "hinges": []}),
    ]
    for kind, own in changed:
        yield Attack(f"array: {kind}", {**claim, "array": own}, "any", named=False)
    if loops:
        h = rng.choice(sorted(loops))
        for kind, own in (
            ("a hinge that closes, or not", with_hinge(closes=not hinges[h]["closes"])),
            ("all hinges close, or not", {**array, "hinges": [{**own, "closes": not own["closes"]} for own in hinges]}),
        ):
            if not Array(own).is_closed(packed=True):
                yield Attack(f"array: {kind}", {**claim, "array": own}, "any", named=False)
                boxes = all_but([hinge["closes"] for hinge in own["hinges"]], "flat", 0.1)
                lock = {"kind": "lock", "array": own, "pairs": claim["pairs"], "tried": 1000, "end": "flat"}
                lock |= {"cuts": boxes.cuts, "lows": boxes.lows, "highs": boxes.highs}
                yield Attack(f"array: {kind}, lock", lock, "any", named=False)


def renamed(data: dict[str, Any], other: str, rng: random.Random) -> Iterator[tuple[str, Any, Any, Any]]:
    """The claim of a certificate under another name: kinds, claims, names and panels."""
    claim = data["claims"][0]
    for name in (other, "", "hex", "x:0:0", None, 5, ["hex"], data["of"] + ":0", data["of"][:-1], data["of"] + "\n"):
        yield "name: another one", [claim], name, data["panel_mm"]
    for panel in (
        "51x51x6",
        "50x50x7",
        "",
        "x",
        "0x0x0",
        "1e9x1e9x1",
        5,
        [],
        {},
        "nanx1x1",
        "infx1x1",
        "1e-999999999x1x1",
    ):
        yield "name: other panels", [claim], data["of"], panel
    for pairs in ("none", "", None, 5, ["hinged"], "Hinged"):
        yield "name: pairs", [{**claim, "pairs": pairs}], data["of"], data["panel_mm"]
    yield "claims: none", [], data["of"], data["panel_mm"]
    for odd in (None, 5, "path", [], {}):
        yield "claims: one that is none", [claim, odd], data["of"], data["panel_mm"]
    false = next(attack for attack in locks(claim, rng) if attack.kind == "lock: a box about an end")
    yield "claims: a true one and a false one", [claim, false.claim], data["of"], data["panel_mm"]
    yield "claims: a false one and a true one", [false.claim, claim], data["of"], data["panel_mm"]


ATTACKS: tuple[Callable[[dict[str, Any], random.Random], Iterator[Attack]], ...] = (locks, collisions, paths, arrays)


def attacks_on(data: dict[str, Any], seed: int, count: int | None = None) -> list[Attack]:
    """Attacks on a folding, built from the certificate of its path: all, or so many at random."""
    rng = random.Random(seed)
    built = [attack for build in ATTACKS for attack in build(data["claims"][0], rng)]
    return built if count is None else rng.sample(built, min(count, len(built)))
