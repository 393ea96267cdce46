"""Stage `deployment`: verdicts on foldings in a scene as written, and in variants with other joints or spring sets.

All foldings are first tried in the scene as written. Those that do not deploy in it are tried in variants: with their
flat pairs hinged, their mirror pairs merged (where the scene allows either), with spring sets graded over the layers,
the faces or the stacks, so that panels open one after the other, and with sets spread over the whole spring range
(docs/measurements/tables.md gives the number of foldings that each brings flat). A full search is `hcsearch tune`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from functools import partial

import numpy as np

from hcsearch.basics.array_values import Flags
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
    SimulatedCheck,
    agreement_of_checks,
    is_doubtful,
    loops_decide,
    simulations_to_confirm,
)
from hcsearch.springs.deployment.compiled_scene import CompiledScene, compile_scene
from hcsearch.springs.deployment.error_estimates import estimate_errors
from hcsearch.springs.deployment.omission_savings import saved_share
from hcsearch.springs.deployment.outcomes import MAX_DEPLOYMENT_STEPS, DeploymentCheck, methods_of
from hcsearch.springs.deployment.play import Play, needed_margin_of, play_of_deployment
from hcsearch.springs.deployment.quick_check import CheckedMotion, CheckedPanels, check_motion, checked_panels_of
from hcsearch.springs.deployment.simulated_deployment import deployment_of_motion
from hcsearch.springs.deployment.spring_sets import springs_of, with_springs
from hcsearch.springs.dynamics.integration_methods import methods_text

MAX_VARIANT_WORK = 5_000_000
"""Evaluations times panels after which no more variants of a folding are tried, so that large arrays do not take most
of the time. This limit loses none of the foldings of hexagons of 10 and 12 panels, squares of 12 and triangles of 18
that a variant brings flat; a fifth of it loses 4 of 17 of these triangles."""
VERDICT_TOLERANCE = 1e-6
"""Tolerance of all trials; deployments are simulated at tighter ones, too. A looser tolerance for variants would miss
some motions that this one finds, and takes nine tenths of the time."""
MAX_CONFIRMING_STEPS = AGREEMENT_STEPS_FACTOR * MAX_DEPLOYMENT_STEPS["constrained"]
"""Greatest number of steps of a simulation at a tighter tolerance."""


def deploy_foldings(
    circuits: CircuitBatch, foldings: FoldingBatch, locked: Flags, moves: Flags, scene: Scene
) -> DeploymentBatch:
    """Deploy a batch of untwisted foldings in a scene.

    One of the foldings that are congruent by symmetries of circuit and scene is simulated; the others get its trials.
    locked : foldings proved locked with rigid pairs; they are tried with hinged ones, where the scene allows it.
    moves : foldings with a path, proved or not; the others are tried only in the scene as written, as foldings that
    springs bring flat have a path.
    A folding deploys if it becomes flat and is certified clear at several tolerances.
    """
    return _Verdicts(circuits, foldings, locked, moves, scene).run()


class _Verdicts:
    """The computation of the verdicts on a batch; foldings are numbers in the batch."""

    def __init__(
        self, circuits: CircuitBatch, foldings: FoldingBatch, locked: Flags, moves: Flags, scene: Scene
    ) -> None:
        self.scene, self.panel = scene, panel_of(scene, circuits.grid)
        self.variants = scene_variants(scene)
        self.foldings = {i: folding_at(circuits, foldings, i) for i in range(len(foldings))}
        self.congruent = self._congruent_foldings(foldings.row.tolist())
        self.moves = moves
        # the proof is for rigid pairs, and does not apply to a scene in which they are hinged
        self.locked = {i for i in self.foldings if locked[i] and scene.flat_pairs != ("hinged",)}
        self.compiled: dict[tuple[int, Way], CompiledScene] = {}
        self.deploys: dict[int, Trial] = {}
        self.as_written: dict[int, Trial] = {}
        self.disputed: dict[int, Trial] = {}

    def run(self) -> DeploymentBatch:
        for i in self.congruent:
            self._try_folding(i)
            self.compiled.clear()
        clearance, time, margin, gap = np.full((4, len(self.foldings)), np.nan)
        for i, trial in self.deploys.items():
            clearance[i], time[i] = trial.clearance, trial.deploy_time
            margin[i], gap[i] = trial.needed_margin, trial.least_gap
        trials = [trial for i in self.foldings for trial in self._trials(i)]
        return DeploymentBatch(clearance, time, margin, gap, tuple(trials))

    def _try_folding(self, i: int) -> None:
        """Try a folding in one variant after the other until it deploys, or enough work is done."""
        work, screens = 0, dict[Way, CheckedPanels]()
        for variant in self.variants:
            if not variant.as_written and (i in self.deploys or not self.moves[i] or work >= MAX_VARIANT_WORK):
                return
            if not self._can_be_tried(i, variant):
                continue
            scene = self._compiled(i, variant)
            if variant.pairs not in screens:
                screens[variant.pairs] = checked_panels_of(scene)
            panels = screens[variant.pairs]
            found = check_motion(scene, panels, tolerance=VERDICT_TOLERANCE, past_collisions=variant.as_written)
            check, agreement = found.check, None
            if check.deploys or (variant.as_written and check.outcome != "flat" and is_doubtful(check)):
                agreement = self._agreement(scene, panels, found)
            self._record_trial(i, variant, scene, check, agreement)
            work += 0 if variant.as_written else check.evaluations * self.foldings[i].circuit.n

    def _agreement(self, scene: CompiledScene, panels: CheckedPanels, found: CheckedMotion) -> Agreement | None:
        """Compare a doubtful check with checks at other tolerances.

        Where it deploys, these use the margin that it needs: motions that are clear with it are clear with the scene's.
        Other motions are checked again with the scene's margin, and may need more.
        """
        first = _simulated(scene, VERDICT_TOLERANCE, found)
        if loops_decide(found.check):
            return agreement_of_checks([first])
        if found.motion is None:
            return agreement_of_checks(simulations_to_confirm(first, partial(_checked_at, scene, panels)))
        play = play_of_deployment(scene, found.motion)
        needed, tight = play.needed_margin, checked_panels_of(scene, play.needed_margin)

        def simulated(tolerance: float) -> SimulatedCheck:
            nonlocal needed
            other = _checked_at(scene, tight, tolerance)
            if other.deployment is None or other.check.deploys:
                return other
            check = _checked_at(scene, panels, tolerance).check
            if check.deploys:
                needed = needed_margin_of(scene, other.deployment.motion, needed)
            return other._replace(check=check)

        simulations = simulations_to_confirm(first, simulated)
        agreement = agreement_of_checks(simulations)
        assert agreement is not None  # as the first is flat
        deployments = [simulation.deployment for simulation in simulations if simulation.deployment is not None]
        errors = estimate_errors(deployments, VERDICT_TOLERANCE, figures=False)
        return replace(agreement, needed_margin=needed, least_gap=play.least_gap, errors=errors)

    def _record_trial(
        self, i: int, variant: SceneVariant, scene: CompiledScene, check: DeploymentCheck, agreed: Agreement | None
    ) -> None:
        if not (variant.as_written or check.deploys):
            return
        for folding in (i, *self.congruent[i]):
            if folding == i:
                trial = self._trial(i, variant, scene, check, agreed)
            else:
                trial = self._transferred(folding, i, variant, check, agreed)
            if variant.as_written:
                self.as_written[folding] = trial
            if trial.status == "deploys":
                self.deploys[folding] = trial
            elif check.deploys:
                self.disputed.setdefault(folding, trial)

    def _can_be_tried(self, i: int, variant: SceneVariant) -> bool:
        if variant.pairs == "hinged":
            return True
        # motions with merged pairs are motions with rigid pairs, too
        return i not in self.locked and (variant.as_written or self.foldings[i].can_join(variant.pairs))

    def _compiled(self, i: int, variant: SceneVariant) -> CompiledScene:
        key = (i, variant.pairs)
        if key not in self.compiled:
            linkage = self.foldings[i].linkage(self.panel, flat_pairs=variant.pairs)
            self.compiled[key] = compile_scene(linkage, self.scene, keep=frozenset({"stops"}))
        compiled = self.compiled[key]
        compiled = replace(compiled, setup=setup_of_variant(compiled.setup, self.scene, variant))
        if variant.springs:
            compiled = with_springs(compiled, springs_of(self.foldings[i], self.panel, compiled, variant.springs))
        return compiled

    def _congruent_foldings(self, rows: list[int]) -> dict[int, list[int]]:
        """Return the foldings to simulate, each with those that are congruent to it in the scene.

        rows : the row of the circuit of each folding.
        """
        standing = representatives(list(self.foldings.values()), rows, self.panel)
        congruent: dict[int, list[int]] = {}
        for i, first in enumerate(standing):
            if i == first or not self._scene_is_congruent(i, first):
                congruent[i] = []
            else:
                congruent[first].append(i)
        return congruent

    def _scene_is_congruent(self, i: int, first: int) -> bool:
        """Return whether a scene is the same for two congruent foldings: its gravity and held panel may break this."""
        way = self.scene.flat_pairs[0]
        linkage, first_linkage = (self.foldings[k].linkage(self.panel, flat_pairs=way) for k in (i, first))
        one = setup_of_scene(self.scene, linkage).of_congruent(linkage)
        other = setup_of_scene(self.scene, first_linkage)
        return one.held == other.held and bool(np.allclose(one.gravity, other.gravity, rtol=0.0, atol=1e-12))

    def _transferred(
        self, i: int, first: int, variant: SceneVariant, check: DeploymentCheck, agreement: Agreement | None
    ) -> Trial:
        """Transfer the check of the congruent folding `first` to a trial of a folding: only numbers change."""
        compiled = self._compiled(i, variant)
        congruent = compiled.linkage.twin
        assert congruent is not None
        if check.collision is not None:
            time, panels = check.collision
            low, high = sorted(congruent.panels.index(panel) for panel in panels)
            check = replace(check, collision=(time, (low, high)))
        trial = self._trial(i, variant, compiled, check, agreement)
        return replace(trial, as_crease=self.foldings[first].crease)

    def _trial(
        self, i: int, variant: SceneVariant, scene: CompiledScene, check: DeploymentCheck, agreed: Agreement | None
    ) -> Trial:
        labels = labels_of(scene.linkage)
        status, reason = check.verdict, check.reason(labels)
        if agreed is not None:
            status = agreed.verdict
            reason = agreed.reason + (", clear until then" if status == "deploys" else "")
        size, clearance, play = scene.linkage.pattern.size, None, None
        if agreed is not None and status == "deploys" and agreed.needed_margin is not None:
            play = Play(agreed.needed_margin, agreed.least_gap)
            clearance = play.clearance(min(math.inf if check.gap is None else check.gap, size))
        flat_time = agreed.flat_time if agreed is not None and status == "deploys" else None
        errors = agreed.errors if agreed is not None and status == "deploys" else None
        facts = {"design": self.foldings[i].notation}
        written = replace(self.scene, panel=self.panel, flat_pairs=(variant.pairs,))
        tried = scene_of_setup(scene.setup, written, labels)
        return Trial(
            folding=i,
            scene=tried.name,
            values=scene_file_text(facts, scene.formulation, tried),
            formulation=scene.formulation,
            status=status,
            reason=reason,
            clearance=clearance,
            first_contact=check.collision[0] if check.collision is not None and status == "collides" else None,
            deploy_time=flat_time,
            energy_error=check.drift,
            closure_error=check.opening * size,
            method=methods_text(methods_of(scene.formulation), check.stiff_time),
            omitted=tuple(omission.name for omission in scene.omissions),
            time_saved=saved_share(scene, check.evaluations, check.looks),
            needed_margin=None if play is None else play.needed_margin,
            least_gap=None if play is None else play.least_gap,
            error_angle=None if errors is None else errors.angle,
            error_time=None if errors is None else errors.error_of_time(flat_time),
            pairs=variant.pairs,
            springs=variant.springs,
        )

    def _trials(self, i: int) -> Iterator[Trial]:
        """Yield the stored trials of a folding: as written, and the one that deploys, even if at one tolerance only."""
        as_written, deploying = self.as_written.get(i), self.deploys.get(i, self.disputed.get(i))
        if as_written is not None:
            yield as_written
        if deploying is not None and deploying is not as_written:
            yield deploying


def _checked_at(scene: CompiledScene, panels: CheckedPanels, tolerance: float) -> SimulatedCheck:
    """Check a scene at another tolerance."""
    return _simulated(
        scene, tolerance, check_motion(scene, panels, tolerance=tolerance, max_steps=MAX_CONFIRMING_STEPS)
    )


def _simulated(scene: CompiledScene, tolerance: float, found: CheckedMotion) -> SimulatedCheck:
    check, motion = found
    return SimulatedCheck(
        tolerance, check, None if motion is None else deployment_of_motion(scene, motion, certified=False)
    )
