"""The values of a scene that models for simulators hold: as their elements, as notes, or not at all.

A closure file of URDF states all of them. A model of MuJoCo is refused where the scene has a value that neither an
element nor a note of the model holds, one of later versions included.
"""

from __future__ import annotations

from typing import Any

from hcsearch.basics.errors import HcsearchError
from hcsearch.scenes import Scene
from hcsearch.scenes.scene import HINGE_VALUES, SCENE_VALUES

OF_TREES = frozenset(
    {
        *("name", "panel", "flat_pairs", "margin", "density", "areal_mass", "equipment", "gravity", "held", "start"),
        *("spring", "springs", "damping_time", "damping", "friction", "harness", "hinges"),
    }
)
"""Values that name or shape the tree of links, its joints and its start."""
OF_FREE_BASES = frozenset({"base_mass", "base_inertia"})
"""Values that do so where no panel is held."""
NOTED = (
    *("seconds", "spring_range", "stop_tolerance", "play", "thickness_tolerance", "offset_tolerance"),
    *("root", "envelope"),
)
"""Values on which no motion by springs depends: the time that is simulated, limits of springs and of what is built."""


def given_values(scene: Scene) -> dict[str, Any]:
    """Return the values of a scene that differ from those of `default`; of single hinges, the greatest, by its name."""
    given = {name: getattr(scene, name) for name in scene.changed()}
    for _, own in scene.hinges:
        for name, value in own:
            given[name] = max(value, given.get(name, 0.0))
    return {name: value for name, value in given.items() if name not in HINGE_VALUES or value}


def check_model_values(scene: Scene) -> None:
    """Refuse a scene with values that no model of MuJoCo can hold; HcsearchError names them all."""
    held = OF_TREES | {*NOTED} | (OF_FREE_BASES if scene.held == "free" else frozenset())
    lost = [name for name in given_values(scene) if name not in held]
    if lost:
        these = "it" if len(lost) == 1 else "them"
        raise HcsearchError(
            f"models of MuJoCo hold no {', '.join(lost)} of this scene: leave {these} out, or write a .urdf, whose "
            "closure file states all values"
        )


def scene_notes(scene: Scene) -> dict[str, Any]:
    """Return the noted values of a scene by name; of tolerances and play, those of single hinges as HINGE_NAME."""
    notes: dict[str, Any] = {"scene": scene.name}
    notes |= {name: getattr(scene, name) for name in NOTED if name in scene.changed()}
    for hinge, own in scene.hinges:
        notes |= {f"hinge_{hinge}_{name}": value for name, value in own if name in NOTED}
    return notes


def stated_values(scene: Scene) -> dict[str, Any]:
    """Return all values of a scene as JSON holds them, SI units; springs and values of single hinges by hinge."""
    values = {name: getattr(scene, name) for name in SCENE_VALUES}
    return values | {name: row.kind.write(values[name]) for name, row in SCENE_VALUES.items() if row.is_table}
