"""Stage `deployment`: verdicts on foldings in a scene as written, and in variants with other joints or spring sets.

All foldings are first tried in the scene as written. Those that do not deploy in it are tried in variants: with their
flat pairs hinged, their mirror pairs merged (where the scene allows either), with spring sets graded over the layers,
the faces or the stacks, so that panels open one after the other, and with sets spread over the whole spring range
(docs/measurements/tables.md gives the number of foldings that each brings flat). A full search is `hcsearch tune`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcsearch.basics.vocabulary import Way
from hcsearch.designs.folding import folding_at, representatives
from hcsearch.designs.records import CircuitBatch, DeploymentBatch, FoldingBatch, Trial
from hcsearch.scenes import Scene, panel_of
from hcsearch.scenes.looks import SceneVariant, scene_variants, setup_of_variant
from hcsearch.scenes.scene_file import scene_file_text
from hcsearch.scenes.setup import scene_of_setup, setup_of_scene
from hcsearch.shape.labels import labels_of
from hcsearch.springs.deployment.agreement import (
    AGREEMENT_STEPS_FACTOR,
    Agreement,
    agreement_of_checks,
    agreement_tolerances,
)
from hcsearch.springs.deployment.compiling import CompiledScene, compile_scene
from hcsearch.springs.deployment.outcomes import MAX_DEPLOYMENT_STEPS, DeploymentCheck
from hcsearch.springs.deployment.play import Play, needed_margin_of, play_of_deployment
from hcsearch.springs.deployment.quick_check import (
    MAX_SCENES_PER_CALL,
    CheckedPanels,
    check_deployments,
    checked_panels_of,
)
from hcsearch.springs.deployment.simulated_deployment import simulate_compiled
from hcsearch.springs.deployment.spring_sets import springs_of, with_springs

MAX_VARIANT_WORK = 5_000_000
"""Evaluations times panels after which no more variants of a folding are tried, so that large arrays do not take most
of the time. Of the foldings of hexagons of 10 and 12 panels, squares of 12 and triangles of 18 that a variant brings
flat none is lost by this limit; a fifth of it loses 4 of 17 of these triangles."""
VERDICT_TOLERANCE = 1e-6
"""Tolerance of all trials; deployments are simulated at tighter ones, too. A looser tolerance for variants would miss
some motions that this one finds, and takes nine tenths of the time."""
FOLDINGS_IN_MEMORY = 256
"""Number of foldings whose scenes are held in memory together."""
TriedVariant = tuple[int, SceneVariant]


def deploy_foldings(
    circuits: CircuitBatch,
    foldings: FoldingBatch,
    locked: NDArray[np.bool_],
    moves: NDArray[np.bool_],
    scene: Scene,
    threads: int = 1,
) -> DeploymentBatch:
    """Deploy a batch of untwisted foldings in a scene.

    Of foldings that symmetries of circuit and scene make congruent one is simulated, and its trials are transferred.
    locked : foldings proved locked with rigid pairs; they are tried with hinged ones, where the scene allows it.
    moves : foldings with a path, proved or not; the others are tried only in the scene as written, as foldings that
    springs bring flat have a path.
    A folding deploys if it becomes flat and is certified clear at several tolerances.
    """
    return _Verdicts(circuits, foldings, locked, moves, scene, threads).run()


class _Verdicts:
    """The computation of the verdicts on a batch; foldings are numbers in the batch."""

    def __init__(
        self,
        circuits: CircuitBatch,
        foldings: FoldingBatch,
        locked: NDArray[np.bool_],
        moves: NDArray[np.bool_],
        scene: Scene,
        threads: int,
    ) -> None:
        self.scene, self.panel = scene, panel_of(scene, circuits.grid)
        self.looks = scene_variants(scene)
        self.foldings = {i: folding_at(circuits, foldings, i) for i in range(len(foldings))}
        self.alike = self._alike(foldings.row.tolist())
        self.moves = moves
        self.count, self.threads = len(foldings), threads
        # the proof is for rigid pairs, and does not apply to a scene in which they are hinged
        self.locked = {i for i in self.foldings if locked[i] and scene.flat_pairs != ("hinged",)}
        self.compiled: dict[tuple[int, Way], CompiledScene] = {}
        self.screens: dict[tuple[int, Way], CheckedPanels] = {}
        self.deploys: dict[int, Trial] = {}
        self.first: dict[int, Trial] = {}
        self.unsure: dict[int, Trial] = {}
        self.spent = np.zeros(self.count, np.int64)

    def run(self) -> DeploymentBatch:
        numbers = list(self.alike)
        for begin in range(0, len(numbers), FOLDINGS_IN_MEMORY):
            self._try(numbers[begin : begin + FOLDINGS_IN_MEMORY])
            self.compiled.clear()
            self.screens.clear()
        clearance, time, margin, gap = np.full((4, self.count), np.nan)
        for i, trial in self.deploys.items():
            clearance[i], time[i] = trial.clearance, trial.deploy_time
            margin[i], gap[i] = trial.needed_margin, trial.least_gap
        trials = [trial for i in self.foldings for trial in self._trials(i)]
        return DeploymentBatch(clearance, time, margin, gap, tuple(trials))

    def _try(self, some: list[int]) -> None:
        """Try foldings until they deploy, variant by variant, or as many variants at once as occupy all threads."""
        first, *others = self.looks
        self._take((first,), some)
        while others and (left := [i for i in some if self._goes_on(i)]):
            # a single thread tries no variant that an earlier one makes needless
            together = 1 if self.threads == 1 else math.ceil(self.threads * MAX_SCENES_PER_CALL / len(left))
            self._take(others[:together], left)
            others = others[together:]

    def _goes_on(self, i: int) -> bool:
        return i not in self.deploys and bool(self.moves[i]) and self.spent[i] < MAX_VARIANT_WORK

    def _take(self, looks: Sequence[SceneVariant], some: list[int]) -> None:
        """Try variants at foldings; the first variant that deploys counts."""
        tried = [(i, look) for look in looks for i in some if self._can(i, look)]
        scenes = {(i, look): (self._compiled(i, look), self.screens[i, look.pairs]) for i, look in tried}
        checks = self._check(scenes, {"tolerance": VERDICT_TOLERANCE, "whole": looks[0].first})
        agreements = self._agreed(scenes, checks)
        for (i, look), one in checks.items():
            if look.first or self._goes_on(i):  # as if the variants had been tried one by one
                self._keep(i, look, scenes[i, look][0], one, agreements.get((i, look)))
                self.spent[i] += 0 if look.first else one.evaluations * self.foldings[i].circuit.n

    def _check(
        self, scenes: dict[TriedVariant, tuple[CompiledScene, CheckedPanels]], options: dict[str, Any]
    ) -> dict[TriedVariant, DeploymentCheck]:
        compiled, screens = [scene for scene, _ in scenes.values()], [own for _, own in scenes.values()]
        return dict(
            zip(scenes, check_deployments(compiled, screens=screens, threads=self.threads, **options), strict=True)
        )

    def _agreed(
        self,
        scenes: dict[TriedVariant, tuple[CompiledScene, CheckedPanels]],
        checks: dict[TriedVariant, DeploymentCheck],
    ) -> dict[TriedVariant, Agreement]:
        """Return the agreement at other tolerances of all trials that deploy."""
        deploying = {tried: scenes[tried] for tried, one in checks.items() if one.deploys}
        plays = {tried: _play(compiled) for tried, (compiled, _) in deploying.items()}
        # motions that are clear with the margin that the first one needs are clear with the scene's
        tight = {
            tried: (compiled, checked_panels_of(compiled, plays[tried].needed_margin))
            for tried, (compiled, _) in deploying.items()
        }
        others = [self._check(tight, _as_near(tolerance)) for tolerance in agreement_tolerances(VERDICT_TOLERANCE)]
        return {
            tried: self._agreement(tried, scene, checks[tried], [other[tried] for other in others], plays[tried])
            for tried, scene in deploying.items()
        }

    def _agreement(
        self,
        tried: TriedVariant,
        scene: tuple[CompiledScene, CheckedPanels],
        first: DeploymentCheck,
        others: list[DeploymentCheck],
        play: Play,
    ) -> Agreement:
        """Compare a check that deploys with those at other tolerances, made with the margin that the first one needs.

        Those that are not clear with it are checked again with the scene's margin, and may need more.
        """
        near, needed = agreement_tolerances(VERDICT_TOLERANCE), play.needed_margin
        for k, tolerance in enumerate(near):
            if others[k].outcome == "flat" and not others[k].deploys:
                others[k] = self._check({tried: scene}, _as_near(tolerance))[tried]
                if others[k].deploys:
                    motion = simulate_compiled(scene[0], certified=False, **_as_near(tolerance)).motion
                    needed = needed_margin_of(scene[0], motion, needed)
        agreement = agreement_of_checks([first, *others], (VERDICT_TOLERANCE, *near))
        return replace(agreement, needed_margin=needed, least_gap=play.least_gap)

    def _keep(
        self, i: int, look: SceneVariant, compiled: CompiledScene, one: DeploymentCheck, agreement: Agreement | None
    ) -> None:
        if not (look.first or one.deploys):
            return
        for own in (i, *self.alike[i]):
            trial = (
                self._trial(i, look, compiled, one, agreement)
                if own == i
                else self._carried(own, i, look, one, agreement)
            )
            if look.first:
                self.first[own] = trial
            if trial.status == "deploys":
                self.deploys[own] = trial
            elif one.deploys:
                self.unsure.setdefault(own, trial)

    def _can(self, i: int, look: SceneVariant) -> bool:
        if look.pairs == "hinged":
            return True
        # motions with merged pairs are motions with rigid pairs, too
        return i not in self.locked and (look.first or self.foldings[i].can_join(look.pairs))

    def _compiled(self, i: int, look: SceneVariant) -> CompiledScene:
        key = (i, look.pairs)
        if key not in self.compiled:
            linkage = self.foldings[i].linkage(self.panel, flat_pairs=look.pairs)
            self.compiled[key] = compile_scene(linkage, self.scene, keep=frozenset({"stops"}))
        compiled = self.compiled[key]
        if key not in self.screens:
            self.screens[key] = checked_panels_of(compiled)
        compiled = replace(compiled, setup=setup_of_variant(compiled.setup, self.scene, look))
        if look.springs:
            compiled = with_springs(compiled, springs_of(self.foldings[i], self.panel, compiled, look.springs))
        return compiled

    def _alike(self, rows: list[int]) -> dict[int, list[int]]:
        """Return the foldings to simulate, each with those that are congruent to it in the scene.

        rows : the row of the circuit of each folding.
        """
        standing = representatives(list(self.foldings.values()), rows, self.panel)
        alike: dict[int, list[int]] = {}
        for i, first in enumerate(standing):
            if i == first or not self._symmetric(i, first):
                alike[i] = []
            else:
                alike[first].append(i)
        return alike

    def _symmetric(self, i: int, first: int) -> bool:
        """Return whether a scene is the same for two congruent foldings: its gravity and held panel may break this."""
        own, other = (self.foldings[k].linkage(self.panel, flat_pairs=self.scene.flat_pairs[0]) for k in (i, first))
        seen, setup = setup_of_scene(self.scene, own).of_twin(own), setup_of_scene(self.scene, other)
        return seen.held == setup.held and bool(np.allclose(seen.gravity, setup.gravity, rtol=0.0, atol=1e-12))

    def _carried(
        self, i: int, first: int, look: SceneVariant, one: DeploymentCheck, agreement: Agreement | None
    ) -> Trial:
        """Transfer the check of the congruent folding `first` to a trial of a folding: only numbers change."""
        compiled = self._compiled(i, look)
        twin = compiled.linkage.twin
        assert twin is not None
        if one.collision is not None:
            time, panels = one.collision
            low, high = sorted(twin.panels.index(panel) for panel in panels)
            one = replace(one, collision=(time, (low, high)))
        trial = self._trial(i, look, compiled, one, agreement)
        return replace(trial, as_crease=self.foldings[first].crease)

    def _trial(
        self, i: int, look: SceneVariant, compiled: CompiledScene, one: DeploymentCheck, agreement: Agreement | None
    ) -> Trial:
        labels = labels_of(compiled.linkage)
        status, reason = one.verdict, one.reason(labels)
        if agreement is not None:
            status = agreement.verdict
            reason = agreement.reason + (", clear until then" if status == "deploys" else "")
        size, clearance, play = compiled.linkage.pattern.size, None, None
        if agreement is not None and status == "deploys" and agreement.needed_margin is not None:
            play = Play(agreement.needed_margin, agreement.least_gap)
            clearance = play.clearance(min(math.inf if one.gap is None else one.gap, size))
        facts = {"design": self.foldings[i].notation}
        scene = replace(self.scene, panel=self.panel, flat_pairs=(look.pairs,))
        tried = scene_of_setup(compiled.setup, scene, labels)
        return Trial(
            folding=i,
            scene=tried.name,
            values=scene_file_text(facts, compiled.formulation, tried),
            formulation=compiled.formulation,
            status=status,
            reason=reason,
            clearance=clearance,
            first_contact=one.collision[0] if one.collision is not None and one.verdict == "collides" else None,
            deploy_time=agreement.flat_time if agreement is not None and status == "deploys" else None,
            energy_error=one.drift,
            closure_error=one.opening * size,
            needed_margin=None if play is None else play.needed_margin,
            least_gap=None if play is None else play.least_gap,
            pairs=look.pairs,
            springs=look.springs,
        )

    def _trials(self, i: int) -> Iterator[Trial]:
        """Yield the stored trials of a folding: as written, and the one that deploys, if only at one tolerance."""
        first, last = self.first.get(i), self.deploys.get(i, self.unsure.get(i))
        if first is not None:
            yield first
        if last is not None and last is not first:
            yield last


def _play(compiled: CompiledScene) -> Play:
    """Return the play of the first motion, simulated again as a check keeps no states."""
    return play_of_deployment(
        compiled, simulate_compiled(compiled, tolerance=VERDICT_TOLERANCE, certified=False).motion
    )


def _as_near(tolerance: float) -> dict[str, Any]:
    """Return the options of a check at another tolerance."""
    return {"tolerance": tolerance, "max_steps": AGREEMENT_STEPS_FACTOR * MAX_DEPLOYMENT_STEPS["constrained"]}
