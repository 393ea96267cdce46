"""Flat arrays on latches for other engines, and closed states of true motions beside the flat one."""

import math
from dataclasses import replace

import numpy as np

from hcsearch.motion.kinematics.closing import close_linkage
from hcsearch.scenes import SCENES
from hcsearch.springs.deployment.compiled_scene import OMISSIONS, compile_scene
from hcsearch.springs.flight.deployed_modes import deployed_modes

LATCH = 20.0


def latched_system(linkage, latch=LATCH):
    """The compiled scene `default` with springs as stiff as latches, its whole system without stops."""
    scene = replace(SCENES["default"], spring=f"linear:{latch!r}")
    compiled = compile_scene(linkage, scene, keep=frozenset(OMISSIONS))
    drives = tuple(replace(drive, lower=-math.inf, upper=math.inf) for drive in compiled.system.drives)
    return compiled, replace(compiled.system, drives=drives)


def own_frequencies(compiled, latch=LATCH):
    """Frequencies of the same array by the program."""
    linkage, setup = compiled.linkage, compiled.setup
    return deployed_modes(linkage, np.full(linkage.n_hinges, latch), setup.density, setup.held).frequencies


def closed_states_near_flat(linkage, count, distance, seed=1):
    """Closed states of true motions at about a distance (rad) from the flat state, and their freedoms."""
    rng, states = np.random.default_rng(seed), []
    while len(states) < count:
        start = rng.normal(size=linkage.n_hinges)
        closed = close_linkage(linkage, distance * start / np.linalg.norm(start), tolerance=1e-15, max_steps=200)
        if 0.1 * distance < np.linalg.norm(closed.angles) < 10.0 * distance and closed.closed:
            states.append(closed.angles)
    return states


def coordinates(compiled, angles):
    """Coordinates of the compiled system at fold angles."""
    q = np.zeros(compiled.system.n_joints)
    q[compiled.joint_of] = angles
    return q
