"""Why a deployment ended as it did, in sentences, with the remedy where there is one."""

from __future__ import annotations

import numpy as np

from hcsearch.basics.vocabulary import Ending
from hcsearch.motion.collision.clearance import Clearance
from hcsearch.shape.labels import Labels, named_hinges
from hcsearch.springs.deployment.compiling import CompiledScene
from hcsearch.springs.dynamics.simulation import Motion
from hcsearch.system.terminal import short


def reason_of_motion(compiled: CompiledScene, motion: Motion, sooner: str = "give it more seconds") -> str:
    """How a motion ended, and the remedy; sooner : the one against the end of the scene's time."""
    end = f"{short(motion.times[-1])} s"
    held = compiled.at_stops(motion.q[-1])
    shut, opened = (named_hinges(compiled.linkage, hinges) for hinges in (held.closed, held.open))
    where = f"closed hinges {shut}, open hinges {opened}"
    easier, tighter = "raise the tolerance, or take the implicit method", "lower the tolerance"
    closer = "take the compliant formulation"
    if compiled.formulation == "penalty":
        easier, closer = "raise the tolerance, or lower cut_stiffness and stop_stiffness", "raise cut_stiffness"
    balance = closer if compiled.formulation == "constrained" else tighter
    widest = float(np.abs(motion.q[-1][compiled.hinged]).max(initial=0.0))
    return {
        "flat": f"flat after {end}",
        "time": f"after {end} the widest fold angle is {widest:.3g} rad: {sooner}",
        "rest": f"at rest from {end} on: {where}",
        "jammed": f"at {end} stops and loops prevent any motion: {where}",
        "steps": f"stopped at {end} after {motion.steps} steps: {easier}",
        "stuck": f"no step is short enough at {end}: {easier}",
        "open": f"the loops open at {end}: {closer}",
        "diverged": f"numbers overflow at {end}: {tighter}, or take the implicit method",
        "energy": f"the energy balance is off by {motion.drift:.2g} J at {end}: {balance}",
    }[motion.ending]


def reason_with_clearance(reason: str, outcome: Ending, clearance: Clearance | None, labels: Labels) -> str:
    """A reason, after a collision where there is a certain one, or where panels come too near to tell."""
    if outcome == "diverged" or clearance is None or clearance.kind == "clear" or clearance.panels is None:
        return reason
    if clearance.kind == "collides":
        return f"{collision_sentence(clearance.panels, clearance.time, labels)}; {reason}"
    one, two = (labels.panels[panel] for panel in clearance.panels)
    when = "" if clearance.time is None else f" at {short(clearance.time)} s"
    return f"panels {one} and {two} come so near{when} that a collision cannot be excluded; {reason}"


def reason_of_check(
    outcome: Ending, end: float, clear: bool | None, collision: tuple[float, tuple[int, int]] | None, labels: Labels
) -> str:
    """The reason for the verdict on a deployment whose motion was not kept; end : s. clear : None if undecided."""
    if outcome == "diverged":
        return f"diverged at {short(end)} s: the results are not valid"
    if collision is not None:
        return collision_sentence(collision[1], collision[0], labels)
    apart = "clear until then" if clear else "a collision is neither certain nor excluded"
    if outcome == "flat":
        return f"flat after about {short(end, 1)} s, {apart}"  # more digits may hang on the tolerance
    return f"{outcome} at {short(end)} s, {apart}"


def collision_sentence(panels: tuple[int, int], time: float | None, labels: Labels) -> str:
    """Which panels collide, by their names, and when (s)."""
    one, two = (labels.panels[panel] for panel in panels)
    return f"panels {one} and {two} collide" + ("" if time is None else f" at {short(time)} s")
