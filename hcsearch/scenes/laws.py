"""Moment-angle laws of hinges: linear, quadratic, tabulated, preloaded, and tape springs that snap (thesis 2.4, 4.2.1).

A law gives the moment that drives a hinge back to the flat state, as a piecewise cubic function of the fold angle; its
energy is the integral of these pieces, so both are exact. Laws have a notation, moments in N m and angles in rad:

    free                             no moment
    linear:STIFFNESS                 linear:0.1
    quadratic:STIFFNESS,GROWTH       quadratic:0.02,0.03
    table:MOMENT@ANGLE,...           table:0@0,0.1@1.5,0.3@3.1
    table:FILE.csv                   a file of `spring_files`; the text of the law holds the points
    tape:PEAK@ANGLE,LOW@BACK         tape:0.2@0.05,0.03@0.01

Any but `free` may end in a preload, linear:0.1+0.02, and have a factor in front, 2*linear:0.1 (springs in parallel).
Any but `free` and `tape` may act from a time on, in s, or rise in proportion to time:

    linear:0.1 from 0.5 s            no moment up to 0.5 s, then the moment of the law
    linear:0.1 from 0.5 to 2 s       times a factor that rises from 0 to 1, as for a shape-memory spring that is heated
"""

from __future__ import annotations

import math
import os
import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from itertools import pairwise
from pathlib import Path

import numpy as np

from hcsearch.basics.array_values import Reals, WholeNumbers
from hcsearch.basics.errors import HcsearchError, NotationError
from hcsearch.scenes.spring_files import check_angles, read_law_points
from hcsearch.system.terminal import short_number

Cubic = tuple[float, float, float, float]

MAX_LAW_VALUE, MIN_LAW_ANGLE_STEP = 1e300, 1e-9
"""The largest moment or angle of a law, and the least distance of its angles (rad); beyond these, numbers overflow."""
_OVERFLOW = "a law's moments or energies overflow: give smaller moments, or angles further apart"
MAX_LAW_TIME = 1e12
"""The latest time at which a law may act in full, s."""
MAX_LAW_FACTORS = 10
"""Greatest number of factors in front of a law; each call of `scaled_law` adds one."""


def _integral(cubic: Cubic, x: float) -> float:
    a, b, c, d = cubic
    return x * (a + x * (b / 2 + x * (c / 3 + x * d / 4)))


@dataclass(frozen=True)
class LawBranch:
    """Moment (N m) as a piecewise cubic: `cubics[k]` are coefficients of 1, x, x^2, x^3 with x from `breaks[k]` (rad).

    The first piece also extends below its break, and the last one beyond. HcsearchError where moments or energies
    overflow.
    """

    breaks: tuple[float, ...]
    cubics: tuple[Cubic, ...]

    def __post_init__(self) -> None:
        numbers = [coefficient for cubic in self.cubics for coefficient in cubic]
        for angle in (-math.pi, math.pi):
            numbers += [self.moment(angle), self.energy(angle)]
        if not all(map(math.isfinite, numbers)):
            raise HcsearchError(_OVERFLOW)

    def _piece(self, angle: float) -> int:
        return max((k for k, start in enumerate(self.breaks) if start <= angle), default=0)

    def mapped(self, change: Callable[[Cubic], Cubic]) -> LawBranch:
        """Return the branch with other coefficients of each piece."""
        return LawBranch(self.breaks, tuple(map(change, self.cubics)))

    def moment(self, angle: float) -> float:
        """Return the moment at a fold angle, N m."""
        k = self._piece(angle)
        a, b, c, d = self.cubics[k]
        x = angle - self.breaks[k]
        return a + x * (b + x * (c + x * d))

    def energy(self, angle: float) -> float:
        """Return the energy stored at a fold angle, J: the integral of the moment from the flat state."""
        k = self._piece(angle)
        return self.energies()[k] + _integral(self.cubics[k], angle - self.breaks[k])

    def energies(self) -> list[float]:
        """Return the energy stored at each break, J: the integral of the moment from the flat state."""
        energies = [0.0]
        for start, end, cubic in zip(self.breaks, self.breaks[1:], self.cubics, strict=False):
            energies.append(energies[-1] + _integral(cubic, end - start))
        # the energy is 0 at angle 0, wherever the pieces begin
        k = self._piece(0.0)
        flat = energies[k] + _integral(self.cubics[k], -self.breaks[k])
        return [value - flat for value in energies]


@dataclass(frozen=True)
class Law:
    """A moment-angle law; a law with a branch `bent` snaps.

    straight : the branch of the straight hinge, the only branch of most laws. bent : the branch after the snap.
    snap_up, snap_down : fold angles (rad) above which the law leaves the straight branch, and below which the bent one.
    begin, full : times (s) at which the law begins to act and acts in full; in between its moment rises in proportion
        to time. Both 0 for a law that always acts.
    text : the notation that `law_named` reads; empty for a law constructed from its branches.
    """

    straight: LawBranch
    bent: LawBranch | None = None
    snap_up: float = math.inf
    snap_down: float = -math.inf
    begin: float = 0.0
    full: float = 0.0
    text: str = field(default="", compare=False)

    def energy(self, angle: float) -> float:
        """Return the energy stored at a fold angle, J, on the branch that a hinge reaches by folding to that angle."""
        branch = self.bent if self.bent is not None and angle > self.snap_up else self.straight
        return branch.energy(angle)

    @cached_property
    def least_energy(self) -> float:
        """A lower bound of the energy between the stops, J: the least of 101 samples, less a bound between these."""
        angles = [math.pi * k / 100 for k in range(101)]
        branches = [branch for branch in (self.straight, self.bent) if branch is not None]
        steepest = max(abs(branch.moment(angle)) for branch in branches for angle in angles)
        return min(branch.energy(angle) for branch in branches for angle in angles) - steepest * math.pi / 100

    @property
    def mean_stiffness(self) -> float:
        """Rise of the moment from flat to folded over the angle, N m/rad; laws that snap end on the bent branch."""
        branch = self.bent or self.straight
        return max(0.0, (branch.moment(math.pi) - self.straight.moment(0.0)) / math.pi)


FREE_LAW = Law(LawBranch((0.0,), ((0.0, 0.0, 0.0, 0.0),)), text="free")
"""The law without a moment."""


@lru_cache(maxsize=4096)  # one scene's springs return in hundreds of others
def linear_law(stiffness: float, preload: float = 0.0) -> Law:
    """Return the law preload + stiffness angle (thesis eq. 4.20); N m/rad, N m. A preload holds the flat state."""
    _finite(stiffness, preload)
    return _preloaded(Law(_one(0.0, stiffness), text=f"linear:{_short(stiffness)}"), preload)


def quadratic_law(stiffness: float, growth: float, preload: float = 0.0) -> Law:
    """Return the law preload + stiffness angle + growth angle^2; N m/rad, N m/rad^2, N m.

    A growth above 0 describes a spring that stiffens at large angles, as the thesis's may have been (4.6).
    """
    _finite(stiffness, growth, preload)
    text = f"quadratic:{_short(stiffness)},{_short(growth)}"
    return _preloaded(Law(_one(0.0, stiffness, growth), text=text), preload)


def tabulated_law(angles: Iterable[float], moments: Iterable[float], preload: float = 0.0) -> Law:
    """Return a law through two or more points; fold angles in rad, increasing, moments in N m.

    Monotone cubic Hermite interpolation (Fritsch and Butland 1984, SciPy's PchipInterpolator); the first and last
    pieces extrapolate beyond the points, so the points should cover 0 to pi.
    """
    from scipy.interpolate import PchipInterpolator  # noqa: PLC0415 - takes longer to load than a law to make

    x, y = [float(angle) for angle in angles], [float(moment) for moment in moments]
    if len(x) != len(y):
        raise HcsearchError(f"a table of {len(x)} angles and {len(y)} moments: give one moment for each angle")
    if len(x) < 2:
        raise HcsearchError(f"a table of {len(x)} points makes no law: give two points at least")
    _finite(*x, *y, preload)
    for previous, following in pairwise(x):
        if not following - previous >= MIN_LAW_ANGLE_STEP:
            raise HcsearchError(
                f"angle {_short(following)} of the table comes after {_short(previous)}: sort it, each angle once"
            )
    with np.errstate(all="ignore"):
        try:
            pieces = PchipInterpolator(x, y).c[::-1].T
        except ValueError:  # slopes overflow
            raise HcsearchError(_OVERFLOW) from None
    branch = LawBranch(tuple(x[:-1]), tuple((float(a), float(b), float(c), float(d)) for a, b, c, d in pieces))
    text = ",".join(f"{_short(moment)}@{_short(angle)}" for angle, moment in zip(x, y, strict=True))
    return _preloaded(Law(branch, text=f"table:{text}"), preload)


def tape_spring_law(peak: float, peak_angle: float, low: float, back: float | None = None, preload: float = 0.0) -> Law:
    """Return the law of a tape spring bent in its positive sense (Seffen and Pellegrino 1999; thesis 2.4, fig. 2.11b).

    The moment of the straight tape is proportional to the angle from O to A, where it snaps to B. The moment of the
    bent tape is constant, whether the fold grows or shrinks, until it snaps back at a smaller angle. Below 0 the
    straight line continues: there is no snap at C.

    peak, peak_angle : moment (N m) and fold angle (rad) of A. low : moment when bent (N m), at most half the peak.
    back : fold angle at which it snaps back (rad); where the bent branch meets the straight one unless given.
    A snap dissipates the difference of the energies of both branches, each counted from angle 0; HcsearchError where
    that difference would be a gain.
    """
    _finite(peak, peak_angle, low, preload)
    if not (peak > 0.0 and peak_angle > 0.0 and low > 0.0):
        raise HcsearchError("a tape spring has no peak, peak angle or low moment of 0 or less: give positive numbers")
    if not low <= 0.5 * peak:
        raise HcsearchError(
            f"a tape spring that snaps from {_short(peak)} to {_short(low)} N m would gain energy: "
            f"give a low moment of at most half the peak, {_short(0.5 * peak)}"
        )
    stiffness = peak / peak_angle
    angle = low / stiffness if back is None else float(back)
    # this bound reaches the peak angle where low is half the peak
    if not 0.0 < angle <= min(2.0 * low / stiffness * (1.0 + 1e-12), math.nextafter(peak_angle, 0.0)):
        raise HcsearchError(
            f"a tape spring that snaps back at {_short(angle)} rad would gain energy or not be bent: "
            f"give an angle above 0, below {_short(peak_angle)}, and at most {_short(2.0 * low / stiffness)}"
        )
    text = f"tape:{_short(peak)}@{_short(peak_angle)},{_short(low)}@{_short(angle)}"
    return _preloaded(Law(_one(0.0, stiffness), _one(low), float(peak_angle), angle, text=text), preload)


def scaled_law(law: Law, factor: float) -> Law:
    """Multiply the moments of a law by a factor, as for several springs in parallel."""
    if not 0.0 < factor < math.inf:
        raise HcsearchError(f"no law is {factor} times another: give a positive factor, or take the law `free`")

    text = f"{_short(factor)}*{law.text}" if law.text else ""
    return _changed(
        law, lambda cubic: (factor * cubic[0], factor * cubic[1], factor * cubic[2], factor * cubic[3]), text
    )


def _changed(law: Law, change: Callable[[Cubic], Cubic], text: str) -> Law:
    """Return a law with other pieces of both branches, and its notation."""
    return replace(law, straight=law.straight.mapped(change), bent=law.bent and law.bent.mapped(change), text=text)


def timed_law(law: Law, begin: float, full: float) -> Law:
    """Return a law that begins to act at a time and acts in full at another, s; both 0 for one that always acts."""
    if not 0.0 <= begin <= full <= MAX_LAW_TIME:
        raise HcsearchError(
            f"no law acts from {_short(begin)} to {_short(full)} s: give times from 0 to {MAX_LAW_TIME:g}, the earlier "
            "one first"
        )
    if full and (law.bent is not None or law.text == FREE_LAW.text):
        raise HcsearchError(f"the law {law.text} always acts: give a time to one that is linear, quadratic or a table")
    until = f"{_short(begin)} to {_short(full)}" if full > begin else _short(begin)
    plain = law.text.partition(" from ")[0]
    return replace(law, begin=begin, full=full, text=f"{plain} from {until} s" if full else plain)


def preloaded_law(law: Law, preload: float) -> Law:
    """Return a law with a further constant moment (N m); a law `free` becomes `linear:0` with this preload."""
    _finite(preload)
    if not preload:
        return law
    if law.text == FREE_LAW.text:
        return linear_law(0.0, preload)
    if law.full:
        return timed_law(preloaded_law(timed_law(law, 0.0, 0.0), preload), law.begin, law.full)
    match = re.fullmatch(rf"(?P<factors>(?:{_NUMBER}\*\s*)*)(?P<plain>.*?)(?P<preload>(?<![eE]){_PRELOAD})?", law.text)
    if match is None or not law.text:
        raise HcsearchError("a law without a notation takes no preload: read it with law_named")
    factor = math.prod(float(number) for number in match["factors"].split("*")[:-1])
    inner = float(f"{float(match['preload'] or 0.0) + preload / factor:.12g}")
    sign = "+" if inner >= 0.0 else "-"
    return law_named(
        f"{match['factors']}{match['plain']}{sign}{_short(abs(inner))}"
        if inner
        else f"{match['factors']}{match['plain']}"
    )


def law_named(text: str) -> Law:
    """Parse the notation of a law described at the top of this module; `law_named(law.text) == law`.

    A file has the columns that `spring_files.read_law_points` reads, with angles strictly rising or falling.
    Errors: NotationError, and the HcsearchErrors of the laws.
    """
    factors, name = [], text.strip()
    begin = full = 0.0
    if timed := _TIMED.fullmatch(name):
        name, begin = timed["law"], float(timed["begin"])
        full = begin if timed["full"] is None else float(timed["full"])
    while factor := re.match(rf"({_NUMBER})\*\s*", name, re.ASCII):
        factors.append(float(factor[1]))
        name = name[factor.end() :]
    if len(factors) > MAX_LAW_FACTORS:
        raise NotationError(f"{len(factors)} factors in front of a law: multiply them, such as 6*linear:0.1")
    law = _plain(name, text)
    for number in reversed(factors):
        law = scaled_law(law, number)
    return timed_law(law, begin, full) if full else law


def _plain(name: str, text: str) -> Law:
    """Parse a notation without factors; `text` is the whole notation, for messages."""
    if name == FREE_LAW.text:
        return FREE_LAW
    kind, _, arguments = name.partition(":")
    for pattern, make in _NOTATIONS.get(kind, ()):
        if match := re.fullmatch(rf"({pattern})({_PRELOAD})?", arguments, re.ASCII):
            given = [match[1]] if pattern == _FILE else _numbers(match[1])
            return make(*given, preload=float(match[2] or 0.0))
    raise NotationError(f"cannot read the law {text!r}: write {', '.join(_EXAMPLES)}, or +0.02 after one to preload it")


def _from_file(name: str, preload: float) -> Law:
    """Read a tabulated law from a file."""
    angles, moments = read_law_points(_expanded(name))
    if len(angles) > 1 and (np.diff(angles) < 0.0).all():
        angles, moments = angles[::-1], moments[::-1]
    for angle, next_angle in pairwise(angles):
        if not next_angle - angle >= MIN_LAW_ANGLE_STEP:
            raise HcsearchError(
                f"angle {next_angle:.6g} rad of {name} comes after {angle:.6g}: sort it, each angle once, or fit "
                "a law to its rows by hcsearch identify spring"
            )
    return tabulated_law(angles, moments, preload)


def spring_law(text: str, folder: Path) -> str:
    """Replace the file name in a law that a user gives by the points of the file.

    Thus a scene holds all that its verdicts depend on. Laws other than tables are returned unchanged.
    folder : the directory to which names of files are relative.
    Errors: HcsearchError for files that cannot be read, and for tables with angles that no hinge has.
    """
    if timed := _TIMED.fullmatch(text.strip()):
        return f"{spring_law(timed['law'], folder)}{text.strip()[timed.end('law') :]}"
    match = _TABLE.fullmatch(text.strip())
    if match is None:
        return text
    factors, points, preload = match["factors"], match["rest"], match["preload"] or ""
    if re.fullmatch(_POINTS, points, re.ASCII):
        angles = np.array(_numbers(points)[1::2])
        check_angles(angles, "the table of the spring", "; angles of table: are in rad, moments in N m")
        return text
    return f"{factors}{_from_file(str(folder / _expanded(points)), 0.0).text}{preload}"


def _expanded(name: str) -> str:
    """Expand ~ at the start of a file name, which shells leave as it is after a colon."""
    return os.path.expanduser(name) if name.startswith("~/") else name  # noqa: PTH111 - Path's fails without a home


# each number must match in one way only: with two, matching a text that is no table would take 2^n steps
UNSIGNED_NUMBER = r"(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?"
"""Regular expression of a number without a sign."""
_NUMBER = rf"[+-]?{UNSIGNED_NUMBER}"
_PRELOAD = rf"[+-]{UNSIGNED_NUMBER}"
_TIMED = re.compile(
    rf"(?P<law>.*?)\s+from\s+(?P<begin>{UNSIGNED_NUMBER})(?:\s+to\s+(?P<full>{UNSIGNED_NUMBER}))?\s*s",
    re.ASCII | re.DOTALL,
)
_POINT = rf"{_NUMBER}@{_NUMBER}"
_POINTS = rf"{_POINT}(?:,{_POINT})*"
_FILE = r".+\.[cC][sS][vV]"
_TABLE = re.compile(
    rf"(?P<factors>(?:{_NUMBER}\*\s*)*)table:(?P<rest>{_POINTS}|{_FILE})(?P<preload>{_PRELOAD})?", re.ASCII
)


def _numbers(text: str) -> list[float]:
    return [float(number) for number in re.split("[,@]", text)]


_NOTATIONS: dict[str, tuple[tuple[str, Callable[..., Law]], ...]] = {
    "linear": ((_NUMBER, linear_law),),
    "quadratic": ((rf"{_NUMBER},{_NUMBER}", quadratic_law),),
    "table": (
        (_POINTS, lambda *points, preload: tabulated_law(points[1::2], points[::2], preload)),
        (_FILE, _from_file),
    ),
    "tape": ((rf"{_POINT},{_POINT}", tape_spring_law),),
}
_EXAMPLES = (
    "free",
    "linear:0.1",
    "quadratic:0.02,0.03",
    "table:0@0,0.1@1.5,0.3@3.1",
    "table:FILE.csv",
    "tape:0.2@0.05,0.03@0.01",
)


def rounded_law_text(text: str, digits: int = 4) -> str:
    """Return the notation of a law with its numbers rounded to some significant digits, for tables that people read."""
    return re.sub(UNSIGNED_NUMBER, lambda number: short_number(float(number[0]), digits), text, flags=re.ASCII)


def _one(*coefficients: float) -> LawBranch:
    """Return a branch of one piece from angle 0."""
    a, b, c, d = (*map(float, coefficients), 0.0, 0.0, 0.0, 0.0)[:4]
    return LawBranch((0.0,), ((a, b, c, d),))


def _preloaded(law: Law, preload: float) -> Law:
    """Add a constant moment to a law."""
    preload = float(preload)
    if not preload:
        return law

    text = f"{law.text}{'+' if preload > 0.0 else '-'}{_short(abs(preload))}"
    return _changed(law, lambda cubic: (cubic[0] + preload, *cubic[1:]), text)


def _short(number: float) -> str:
    """Return the shortest text that reads as the same number."""
    return repr(float(number)).removesuffix(".0")


def _finite(*numbers: float) -> None:
    """Refuse values that are not numbers or too large to be multiplied."""
    for number in numbers:
        if not abs(number) <= MAX_LAW_VALUE:
            raise HcsearchError(
                f"{number} is no moment or angle: give finite numbers (N m, rad) up to {MAX_LAW_VALUE:g}"
            )


def tables_of_laws(laws: Sequence[Law]) -> tuple[WholeNumbers, Reals, Reals, Reals]:
    """Tabulate laws for the kernels: pieces (n, 2, 2) of both branches, breaks, cubics, energies at the breaks."""
    pieces = np.zeros((len(laws), 2, 2), np.int64)
    breaks: list[float] = []
    cubics: list[Cubic] = []
    energies: list[float] = []
    rows_of: dict[LawBranch, tuple[int, int]] = {}
    for i, law in enumerate(laws):
        for k, branch in enumerate((law.straight, law.bent or law.straight)):
            if branch not in rows_of:
                rows_of[branch] = (len(breaks), len(breaks) + len(branch.breaks))
                breaks += branch.breaks
                cubics += branch.cubics
                energies += branch.energies()
            pieces[i, k] = rows_of[branch]
    return pieces, np.array(breaks), np.array(cubics).reshape(-1, 4), np.array(energies)
