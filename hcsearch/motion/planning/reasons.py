"""What is known of a motion, in sentences."""

from __future__ import annotations

from hcsearch.motion.locks.enclosures import Enclosure
from hcsearch.motion.planning.motions import PlannedMotion
from hcsearch.motion.planning.planner import TreeGrowth
from hcsearch.motion.planning.proofs import PathProof
from hcsearch.shape.labels import Labels

END_NAMES = ("packed", "flat")


def reason_of(motion: PlannedMotion) -> str:
    """What is known of a motion, in a sentence."""
    if motion.locked:
        assert motion.lock is not None
        way, lock = motion.lock
        return (
            f"{_apart(lock)}: proved with {way} flat pairs from the {lock.end} state, by {lock.cubes:,} "
            f"{'cube' if lock.cubes == 1 else 'cubes'} of fold angles"
        )
    if motion.margin is not None:
        play = f"{1e3 * motion.margin:.4g} mm of play on every face"
        return f"a path from packed to flat is proved with {motion.way} flat pairs and {play}"
    if motion.proof is not None:
        known = f"a path with {motion.way} flat pairs was met and is not proved: {_failed(motion.proof, motion.labels)}"
    elif not motion.growths:
        return "no path was searched for: the folding has no mirror pairs of panels to merge"
    else:
        known = "no path was met: " + "; ".join(f"{way} flat pairs, {_grown(growth)}" for way, growth in motion.growths)
    return "; ".join([known, *_beside(motion)])


def _apart(lock: Enclosure) -> str:
    """What keeps the ends apart."""
    ends = "keep the packed and the flat state apart"
    if lock.margin is None:
        return f"closed loops and stops {ends}, even if panels could pass through each other"
    return f"locked by collision at margins up to {1e3 * lock.margin:.4g} mm, as panels, loops and stops {ends}"


def _beside(motion: PlannedMotion) -> list[str]:
    """What is known of an undecided folding beside its searches."""
    parts = [f"proved that there is none with {way} flat pairs{_up_to(lock)}" for way, lock in motion.locks]
    critical = motion.critical
    if critical is not None and critical.proved is not None:
        parts.append(f"a path is proved with {1e3 * critical.proved:.4g} mm of play on every face")
    elif critical is not None and critical.none is not None:
        parts.append(f"none was met with up to {1e3 * critical.none:.4g} mm of play either")
    return parts


def _up_to(lock: Enclosure) -> str:
    """At which margins a lock holds, where it is not all of them."""
    return "" if lock.margin is None else f" at margins up to {1e3 * lock.margin:.4g} mm"


def _failed(proof: PathProof, labels: Labels | None) -> str:
    """Why a path is not proved."""
    if proof.motion is None:
        return "no closed states are proved beside all of it, as it passes states that are singular, or nearly so"
    if any(proof.reach):
        away = " and ".join(
            f"{far:.2g} rad from the {end}" for end, far in zip(END_NAMES, proof.reach, strict=True) if far
        )
        return f"its proof ends {away} state"
    if proof.clear is None:
        return "hinges go beyond their stops by more than the play allows"
    one, two = (k if labels is None else labels.panels[k] for k in proof.clear.panels or (0, 0))
    return f"panels {one} and {two} come too near with {1e3 * proof.clear.margin:.4g} mm of play on every face"


def _grown(growth: TreeGrowth) -> str:
    """What the trees of one search came to."""
    if not all(growth.starts):
        return f"no way out of the {END_NAMES[growth.starts[0] > 0]} state"
    one, two = growth.sizes
    closed = [end for end, off in zip(END_NAMES, growth.closed_off, strict=True) if off]
    state = f"closed off at the {' and the '.join(closed)} state" if closed else "still growing"
    return f"trees of {one:,} and {two:,} states {state} after {growth.rounds} rounds, cells {growth.resolution:g} rad"
