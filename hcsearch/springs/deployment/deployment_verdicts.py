"""Stage `deployment`: verdicts on foldings in a scene as written, and in variants with other joints or spring sets.

All foldings are first tried in the scene as written. Those that do not deploy in it are tried in variants: with their
flat pairs hinged, their mirror pairs merged (where the scene allows either), with spring sets graded over the layers,
the faces or the stacks, so that panels open one after the other, and with sets spread over the whole spring range
(docs/measurements/tables.md gives the number of foldings that each brings flat). A full search is `hcsearch tune`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import Any

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
    agreement_of_checks,
    agreement_tolerances,
    is_doubtful,
    tolerances_to_confirm,
)
from hcsearch.springs.deployment.compiled_scene import CompiledScene, compile_scene
from hcsearch.springs.deployment.error_estimates import estimate_errors
from hcsearch.springs.deployment.outcomes import MAX_DEPLOYMENT_STEPS, DeploymentCheck, methods_of
from hcsearch.springs.deployment.play import Play, needed_margin_of, play_of_deployment
from hcsearch.springs.deployment.quick_check import (
    MAX_SCENES_PER_CALL,
    CheckedPanels,
    check_deployments,
    check_with_motion,
    checked_panels_of,
)
from hcsearch.springs.deployment.saved_work import saved_share
from hcsearch.springs.deployment.simulated_deployment import Deployment, deployment_of_motion, simulate_compiled
from hcsearch.springs.deployment.spring_sets import springs_of, with_springs
from hcsearch.springs.dynamics.integration_methods import methods_text
from hcsearch.springs.dynamics.time_integration import Motion

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
TriedScene = tuple[CompiledScene, CheckedPanels]
TriedScenes = dict[TriedVariant, TriedScene]
CheckedMotion = tuple[DeploymentCheck, Motion]
TrialChecks = dict[TriedVariant, DeploymentCheck]


def deploy_foldings(
    circuits: CircuitBatch, foldings: FoldingBatch, locked: Flags, moves: Flags, scene: Scene, threads: int = 1
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
        self, circuits: CircuitBatch, foldings: FoldingBatch, locked: Flags, moves: Flags, scene: Scene, threads: int
    ) -> None:
        self.scene, self.panel = scene, panel_of(scene, circuits.grid)
        self.variants = scene_variants(scene)
        self.foldings = {i: folding_at(circuits, foldings, i) for i in range(len(foldings))}
        self.congruent = self._congruent_foldings(foldings.row.tolist())
        self.moves = moves
        self.n_foldings, self.threads = len(foldings), threads
        # the proof is for rigid pairs, and does not apply to a scene in which they are hinged
        self.locked = {i for i in self.foldings if locked[i] and scene.flat_pairs != ("hinged",)}
        self.compiled: dict[tuple[int, Way], CompiledScene] = {}
        self.screens: dict[tuple[int, Way], CheckedPanels] = {}
        self.deploys: dict[int, Trial] = {}
        self.as_written: dict[int, Trial] = {}
        self.disputed: dict[int, Trial] = {}
        self.evaluations_spent = np.zeros(self.n_foldings, np.int64)

    def run(self) -> DeploymentBatch:
        numbers = list(self.congruent)
        for start in range(0, len(numbers), FOLDINGS_IN_MEMORY):
            self._try_foldings(numbers[start : start + FOLDINGS_IN_MEMORY])
            self.compiled.clear()
            self.screens.clear()
        clearance, time, margin, gap = np.full((4, self.n_foldings), np.nan)
        for i, trial in self.deploys.items():
            clearance[i], time[i] = trial.clearance, trial.deploy_time
            margin[i], gap[i] = trial.needed_margin, trial.least_gap
        trials = [trial for i in self.foldings for trial in self._trials(i)]
        return DeploymentBatch(clearance, time, margin, gap, tuple(trials))

    def _try_foldings(self, foldings: list[int]) -> None:
        """Try foldings until they deploy, variant by variant, or as many variants at once as occupy all threads."""
        as_written, *others = self.variants
        self._try_variants((as_written,), foldings)
        while others and (remaining := [i for i in foldings if self._needs_more_trials(i)]):
            # a single thread tries no variant that an earlier one makes needless
            batch = 1 if self.threads == 1 else math.ceil(self.threads * MAX_SCENES_PER_CALL / len(remaining))
            self._try_variants(others[:batch], remaining)
            others = others[batch:]

    def _needs_more_trials(self, i: int) -> bool:
        return i not in self.deploys and bool(self.moves[i]) and self.evaluations_spent[i] < MAX_VARIANT_WORK

    def _try_variants(self, variants: Sequence[SceneVariant], foldings: list[int]) -> None:
        """Try variants at foldings; the first variant that deploys counts."""
        tried = [(i, variant) for variant in variants for i in foldings if self._can_be_tried(i, variant)]
        scenes = {(i, variant): (self._compiled(i, variant), self.screens[i, variant.pairs]) for i, variant in tried}
        checks = self._check(scenes, {"tolerance": VERDICT_TOLERANCE, "past_collisions": variants[0].as_written})
        agreements = self._agreed(scenes, checks)
        for (i, variant), check in checks.items():
            if variant.as_written or self._needs_more_trials(i):  # as if the variants had been tried one by one
                self._record_trial(i, variant, scenes[i, variant][0], check, agreements.get((i, variant)))
                self.evaluations_spent[i] += 0 if variant.as_written else check.evaluations * self.foldings[i].circuit.n

    def _check(self, scenes: TriedScenes, options: dict[str, Any]) -> TrialChecks:
        compiled, screens = [scene for scene, _ in scenes.values()], [panels for _, panels in scenes.values()]
        checks = check_deployments(compiled, screens=screens, threads=self.threads, **options)
        return dict(zip(scenes, checks, strict=True))

    def _agreed(self, scenes: TriedScenes, checks: TrialChecks) -> dict[TriedVariant, Agreement]:
        """Return the agreement at other tolerances of all trials that deploy, and of doubtful ones as written."""
        deploying = {tried: scenes[tried] for tried, check in checks.items() if check.deploys}
        firsts = {tried: _first_motion(compiled) for tried, (compiled, _) in deploying.items()}
        plays = {k: play_of_deployment(first.compiled, first.motion) for k, first in firsts.items()}
        # motions that are clear with the margin that the first one needs are clear with the scene's
        tight = {k: (scene, checked_panels_of(scene, plays[k].needed_margin)) for k, (scene, _) in deploying.items()}
        others = self._check_with_motions(tight)
        agreements = {
            k: self._agreement(k, scene, checks[k], others[k], firsts[k], plays[k]) for k, scene in deploying.items()
        }
        for (i, variant), check in checks.items():
            if variant.as_written and check.outcome != "flat" and is_doubtful(check):
                tried = {(i, variant): scenes[i, variant]}
                tolerances = tolerances_to_confirm(check, VERDICT_TOLERANCE)
                checked = [check, *(self._check(tried, _as_near(tolerance))[i, variant] for tolerance in tolerances)]
                agreement = agreement_of_checks(checked, (VERDICT_TOLERANCE, *tolerances))
                if agreement is not None:
                    agreements[i, variant] = agreement
        return agreements

    def _check_with_motions(self, scenes: TriedScenes) -> dict[TriedVariant, list[CheckedMotion]]:
        """Check scenes at the other tolerances of an agreement."""
        tolerances = agreement_tolerances(VERDICT_TOLERANCE)
        calls = [(*tried, tolerance) for tried in scenes.values() for tolerance in tolerances]
        with ThreadPoolExecutor(self.threads) as pool:  # the kernel releases the global interpreter lock
            checked = list(pool.map(lambda call: check_with_motion(call[0], call[1], **_as_near(call[2])), calls))
        count = len(tolerances)
        return {tried: checked[k * count : (k + 1) * count] for k, tried in enumerate(scenes)}

    def _agreement(
        self,
        tried: TriedVariant,
        scene: TriedScene,
        check: DeploymentCheck,
        others: Sequence[CheckedMotion],
        first: Deployment,
        play: Play,
    ) -> Agreement:
        """Compare a check that deploys with those at other tolerances, made with the margin that the first one needs.

        Those that are not clear with it are checked again with the scene's margin, and may need more. first : the first
        one with its states.
        """
        tolerances, needed, checks = agreement_tolerances(VERDICT_TOLERANCE), play.needed_margin, [check]
        for tolerance, (other, motion) in zip(tolerances, others, strict=True):
            checks.append(other)
            if other.outcome == "flat" and not other.deploys:
                checks[-1] = self._check({tried: scene}, _as_near(tolerance))[tried]
                if checks[-1].deploys:
                    needed = needed_margin_of(scene[0], motion, needed)
        agreement = agreement_of_checks(checks, (VERDICT_TOLERANCE, *tolerances))
        assert agreement is not None  # as the first is flat
        deployments = [first, *(deployment_of_motion(scene[0], motion, 0.0, certified=False) for _, motion in others)]
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
        if key not in self.screens:
            self.screens[key] = checked_panels_of(compiled)
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
        """Yield the stored trials of a folding: as written, and the one that deploys, if only at one tolerance."""
        as_written, deploying = self.as_written.get(i), self.deploys.get(i, self.disputed.get(i))
        if as_written is not None:
            yield as_written
        if deploying is not None and deploying is not as_written:
            yield deploying


def _first_motion(compiled: CompiledScene) -> Deployment:
    """Return the first motion of an agreement, simulated again as checks of many scenes keep no states."""
    return simulate_compiled(compiled, tolerance=VERDICT_TOLERANCE, certified=False)


def _as_near(tolerance: float) -> dict[str, Any]:
    """Return the options of a check at another tolerance."""
    return {"tolerance": tolerance, "max_steps": AGREEMENT_STEPS_FACTOR * MAX_DEPLOYMENT_STEPS["constrained"]}
