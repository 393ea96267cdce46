"""What a scene leaves open, from the size and mass of its panels, its springs and its gravity.

Times, lengths and springs of a deployment are those of the scene `default` (panels of 50 mm, 6 mm thick, springs of
0.1 N m/rad), scaled by dimensional analysis: angles follow J phi'' = -k phi, so times grow as the root of J / k, with
J the mass of a panel times its edge squared; springs that lift a panel grow as its weight times its edge.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from hcsearch.collision.margins import EDGE, margin_of, scale_of
from hcsearch.deployment.naming import laws_of, numbered
from hcsearch.dynamics.laws import law_named
from hcsearch.linkage import Linkage
from hcsearch.mesh import facet_area
from hcsearch.scenes import DEFAULT, SCENES, Scene, default_panel

SECONDS = 1.0
"""How long the scene `default` is given, s."""
SOFTEST, STIFFEST = 0.001, 0.2
"""Bounds of the stiffness of a spring there, N m/rad (thesis 4.5.4)."""
_G = 9.81
_PLAIN = SCENES[DEFAULT]
_SPRING = law_named(_PLAIN.spring).mean_stiffness


def settled(scene: Scene, linkage: Linkage) -> Scene:
    """The scene in numbers of a linkage, with nothing left to it.

    Density, margin, spring range and seconds follow from the panels where the scene leaves them open. Seconds are never
    fewer than in the scene `default`; they are given to three digits, as springs are.
    """
    scene = numbered(scene, linkage)
    left_open = (scene.margin, scene.spring_range, scene.seconds)
    if scene.areal_mass is None and None not in left_open:
        return scene
    density = scene.density_of(linkage.pattern.thickness)
    length = scale_of(linkage)
    mass = _mass(linkage, density)
    laws = laws_of(linkage, scene)
    stiffness = float(np.mean([law_named(text).mean_stiffness for text in laws])) if laws else 0.0
    inertia, weight = mass * length**2, mass * length * math.hypot(*scene.gravity) / _G
    springs = max(stiffness / _SPRING, weight)
    seconds = math.sqrt(inertia / springs) if springs else 1.0
    given = scene.damping is not None and stiffness > 0.0
    slowness = scene.damping / stiffness if scene.damping is not None and given else scene.damping_time
    seconds = max(1.0, seconds, slowness / _PLAIN.damping_time)
    scale = _short(springs or inertia)
    return replace(
        scene,
        density=density,
        areal_mass=None,
        margin=float(f"{margin_of(linkage):.10g}") if scene.margin is None else scene.margin,
        spring_range=scene.spring_range or (_short(SOFTEST * scale), _short(STIFFEST * scale)),
        seconds=_short(SECONDS * seconds) if scene.seconds is None else scene.seconds,
    )


def _mass(linkage: Linkage, density: float) -> float:
    """Mean mass of a facet over that of a regular panel of the scene `default` with as many corners."""
    facets = linkage.pattern.facets
    corners = len(facets[0])
    regular = 0.25 * corners * EDGE**2 / math.tan(math.pi / corners)
    mean = sum(map(facet_area, facets)) / len(facets)
    return (density * mean * linkage.pattern.thickness) / (_PLAIN.density * regular * default_panel("square")[2])


def _short(value: float) -> float:
    return float(f"{value:.3g}")
