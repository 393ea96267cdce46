"""The figures of a folding from its travel, and of a batch of foldings, without those that a scene does not need."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import cast

import numpy as np

from hcsearch.basics.array_values import Flags, Reals
from hcsearch.basics.errors import HcsearchError
from hcsearch.basics.vocabulary import Way, finite_or_none
from hcsearch.designs.folding import Folding, folding_at
from hcsearch.designs.records import (
    CircuitBatch,
    DeploymentBatch,
    FlightNumbers,
    FlightValue,
    FoldingBatch,
    MotionBatch,
    Trial,
)
from hcsearch.kernels.collision.intervals import Course
from hcsearch.scenes import Scene, panel_of
from hcsearch.scenes.scene_file import read_scene_text, scene_in
from hcsearch.shape.labels import labels_of
from hcsearch.springs.dynamics.law_torques import law_torques
from hcsearch.springs.flight.build_errors import BuildTolerances
from hcsearch.springs.flight.clearance_ratio import clearance_ratio
from hcsearch.springs.flight.deployed_modes import DeployedModes, FloatingBase, deployed_modes, flat_stiffness
from hcsearch.springs.flight.latching import latch_bounds
from hcsearch.springs.flight.margin_figures import MarginFigures, margin_figures
from hcsearch.springs.flight.moving_room import craft_clearance
from hcsearch.springs.flight.path_margins import PathMargins, margins_along
from hcsearch.springs.flight.shape_errors import shape_errors
from hcsearch.springs.flight.stowage import stowage_of
from hcsearch.springs.flight.travel import Travel, travel_along, travel_by_springs
from hcsearch.store.columns import FLIGHT_QUANTITIES
from hcsearch.system.work_steps import work_step


@work_step("computing the figures of the motion")
def figures_of(travel: Travel, margins: MarginFigures | None = None) -> FlightNumbers:
    """Return the figures of a folding in a scene; figures of its motion only where there is one.

    margins : from `least_margins`, where they are known.
    """
    standard = travel.standard  # so that congruent foldings have equal figures
    figures = _stowage(travel) | _shape(standard) | _modes(standard)
    if travel.source != "none":
        figures |= _margins(margins or least_margins(travel), travel) | _latches(standard)
        figures |= _clearance(standard) | _craft(travel)
    return dict.fromkeys(quantity.name for quantity in FLIGHT_QUANTITIES) | figures


def tolerances_of(travel: Travel) -> BuildTolerances:
    """Return the tolerances with which an array is built."""
    setup = travel.setup
    return BuildTolerances(setup.stop_tolerance, setup.play, setup.offset_tolerance, setup.thickness_tolerance)


def root_of(travel: Travel) -> int:
    """Return the panel to which places of the flat array refer: its root, or the held panel of a free array."""
    return travel.setup.held if travel.setup.root is None else travel.setup.root


def travel_margins(travel: Travel, resistance: Reals | None = None) -> PathMargins:
    """Return the torque margins at the states of a travel; resistance : (n_hinges,), N m, of the scene if None."""
    return margins_along(
        travel.rates,
        law_torques(travel.setup.laws, travel.states),
        np.array(travel.setup.resistance) if resistance is None else resistance,
    )


def least_margins(travel: Travel, resistance: Reals | None = None) -> MarginFigures:
    """Return the least torque margins of a travel with a motion; resistance : as above.

    Congruent foldings have equal ones, as all take them from the linkage that is simulated in their place.
    """
    standard, hinges = travel.standard, travel.standard_hinges
    friction = (np.array(travel.setup.resistance) if resistance is None else resistance)[hinges]
    found = margin_figures(standard, friction, travel_margins(standard, friction))
    return MarginFigures(*(replace(one, hinge=int(hinges[one.hinge]) if one.hinge >= 0 else -1) for one in found))


def _stowage(travel: Travel) -> dict[str, FlightValue]:
    stowage = stowage_of(travel.linkage, travel.setup.density)
    sides = zip(("stowed_length", "stowed_width", "stowed_height"), stowage.packed.sides, strict=True)
    return {**dict(sides), "area_per_volume": stowage.area_per_volume, "mass": stowage.mass}


def modes_of(travel: Travel) -> DeployedModes:
    """Return the modes of the flat array on its latches."""
    stiffness = flat_stiffness(travel.setup.laws, np.array(travel.setup.latch_stiffness))
    base = _floating_base(travel) if travel.setup.root is None else None
    return deployed_modes(travel.linkage, stiffness, travel.setup.density, root_of(travel), base=base)


def _floating_base(travel: Travel) -> FloatingBase:
    """Return what floats with the held panel of a free array."""
    return FloatingBase(travel.setup.base_mass, travel.setup.base_inertia)


def _modes(travel: Travel) -> dict[str, FlightValue]:
    modes = modes_of(travel)
    return {"deployed_hz": modes.deployed_hz, "soft_modes": modes.soft_modes}


def _latches(travel: Travel) -> dict[str, FlightValue]:
    """Return bounds of the torque of latches, and of the impulse that the root takes at an arrival."""
    setup = travel.setup
    bounds = latch_bounds(
        travel.linkage,
        setup.laws,
        np.array(setup.latch_stiffness),
        setup.density,
        setup.held,
        travel.states[0],
        gravity=setup.gravity,
        restitution=setup.restitution,
        base=_floating_base(travel) if setup.free else None,
    )
    return {"latch_torque": bounds.torque, "latch_impulse": bounds.base_moment}


def _margins(margins: MarginFigures, travel: Travel) -> dict[str, FlightValue]:
    whole, failed = margins
    if whole.value is None or math.isinf(whole.value):  # nothing resists, and springs drive at every state
        return {"torque_margin_failed": finite_or_none(failed.value)}
    return {
        "torque_margin": whole.value,
        "torque_margin_hinge": labels_of(travel.linkage).hinges[whole.hinge] if whole.hinge >= 0 else None,
        "torque_margin_at": whole.at,
        "torque_margin_failed": finite_or_none(failed.value),
    }


def _shape(travel: Travel) -> dict[str, FlightValue]:
    shape = shape_errors(travel.linkage, tolerances_of(travel), root_of(travel))
    return {
        "self_stresses": shape.self_stresses,
        "flatness_mm_per_mrad": shape.flatness_per_rad,
        "tilt": shape.tilt_per_rad,
    }


def _clearance(travel: Travel) -> dict[str, FlightValue]:
    """Return the least gap over the tolerances at all times; none without tolerances."""
    tolerances = tolerances_of(travel)
    found = None if tolerances.are_zero else _course(travel)
    if found is None:
        return {}
    ratio = clearance_ratio(travel.linkage, *found, tolerances, travel.setup.margin)
    return {"clearance_ratio": None if ratio is None else ratio.ratio}


def _craft(travel: Travel) -> dict[str, FlightValue]:
    """Return the least gap to the craft at all times; none without a craft."""
    craft = travel.setup.craft
    found = _course(travel) if craft else None
    return {} if found is None else {"craft_clearance": craft_clearance(travel.linkage, *found, craft, root_of(travel))}


def _course(travel: Travel) -> tuple[Course, float] | None:
    """Return the motion at all times and its slack; None where a path is proved no more."""
    try:
        course, slack = travel.course
    except HcsearchError:
        return None
    return course, float(np.max(slack, initial=0.0))


def flight_of_foldings(
    circuits: CircuitBatch,
    foldings: FoldingBatch,
    chosen: Flags,
    motion: MotionBatch,
    deployment: DeploymentBatch,
    scene: Scene,
) -> tuple[FlightNumbers | None, ...]:
    """Return the figures of the chosen foldings of a batch in a scene, None for the others.

    The motion of a folding is its deployment where springs open it, with the springs and joints that do, else its
    proved path.
    """
    batch = [folding_at(circuits, foldings, i) for i in range(len(foldings))]
    deploying = {trial.folding: trial for trial in reversed(deployment.trials) if trial.status == "deploys"}
    return tuple(
        figures_of(_travel(folding, scene, motion, i, deploying.get(i))) if chosen[i] else None
        for i, folding in enumerate(batch)
    )


def _travel(folding: Folding, scene: Scene, motion: MotionBatch, i: int, trial: Trial | None) -> Travel:
    """Return the travel of a folding of the batch by the motion that decides its status."""
    panel = panel_of(scene, folding.circuit.grid.name)
    if trial is not None:
        tried = scene_in(read_scene_text(trial.values, f"the scene {trial.scene!r}"), grid=folding.circuit.grid.name)
        return travel_by_springs(folding.linkage(panel, flat_pairs=trial.pairs), replace(tried, name=trial.scene))
    way = motion.flat_pairs[i]
    if way is None:
        return travel_along(folding.linkage(panel, flat_pairs=scene.flat_pairs[0]), scene)
    return travel_along(folding.linkage(panel, flat_pairs=cast("Way", way)), scene, motion.paths[i])
