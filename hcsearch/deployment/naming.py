"""Names of panels and hinges in a scene, and the linkage's own numbers that they stand for.

A scene that people write names the panel that is held and hinges with springs of their own as pictures do, by texts
(`labels`); one that is compiled has the numbers of its linkage.
"""

from __future__ import annotations

from dataclasses import replace

from hcsearch.errors import HcsearchError
from hcsearch.labels import Labels, labels_of
from hcsearch.linkage import Linkage
from hcsearch.scenes import Scene


def numbered(scene: Scene, linkage: Linkage) -> Scene:
    """The scene with numbers of the linkage in place of names; HcsearchError where a name or number is none of it."""
    if not scene.springs and scene.held in ("bottom", "free"):
        return scene
    held = scene.held
    if isinstance(held, str) and held not in ("bottom", "free"):
        held = labels_of(linkage).panel(held)
    if isinstance(held, int) and not 0 <= held < linkage.n_panels:
        raise HcsearchError(f"there is no panel {held}: hold one from 0 to {linkage.n_panels - 1}")
    return replace(scene, held=held, springs=_springs(scene, linkage))


def laws_of(linkage: Linkage, scene: Scene) -> list[str]:
    """The law of each hinge of a linkage in a scene; HcsearchError as of `numbered`."""
    laws = [scene.spring] * linkage.n_hinges
    for hinge, law in numbered(scene, linkage).springs:
        laws[int(hinge)] = law
    return laws


def _springs(scene: Scene, linkage: Linkage) -> tuple[tuple[int, str], ...]:
    """The springs by numbers; two names of one hinge must not differ."""
    names = any(isinstance(name, str) for name, _ in scene.springs)
    labels = labels_of(linkage) if names else None
    laws: dict[int, str] = {}
    for name, law in scene.springs:
        hinge = labels.hinge(name) if labels is not None and isinstance(name, str) else int(name)
        if not 0 <= hinge < linkage.n_hinges:
            raise HcsearchError(f"there is no hinge {hinge}: give springs to hinges 0 to {linkage.n_hinges - 1}")
        if laws.setdefault(hinge, law) != law:
            raise HcsearchError(f"hinge {labels_of(linkage).hinges[hinge]} is given two springs: leave one out")
    return tuple(laws.items())


def named(scene: Scene, labels: Labels) -> Scene:
    """The scene with names in place of the linkage's own numbers."""
    held = scene.held
    if isinstance(held, int):
        held = labels.panels[held]
    springs = tuple((labels.hinges[k] if isinstance(k, int) else k, law) for k, law in scene.springs)
    return replace(scene, held=held, springs=springs)
