"""A pattern of a file as a case: a design that the file draws, or else a linkage of any panels."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hcsearch.basics.errors import HcsearchError, PatternError, SceneError
from hcsearch.shape.linkage import Linkage
from hcsearch.subjects.asked import Asked
from hcsearch.subjects.case import Case, CasePath, MovedCase, PageFacts
from hcsearch.subjects.design_reading import DesignReading
from hcsearch.subjects.pattern_files import (
    DrawnDesign,
    DrawnPattern,
    is_pattern_file,
    only_drawn_folding,
    read_pattern_file,
)
from hcsearch.system.terminal import write_notice
from hcsearch.system.work_steps import Progress

if TYPE_CHECKING:
    from hcsearch.search.own_patterns.checked import Checked
    from hcsearch.search.own_patterns.checked_patterns import PatternVerdict
    from hcsearch.springs.deployment.deployment_facts import Deployed


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class PatternCase(Case):
    """A pattern that is no design, in a scene; drawn : the pattern."""

    kind = "pattern"

    drawn: DrawnPattern

    @classmethod
    def claims(cls, subject: object) -> bool:
        """Whether a text is the name of a file that holds a pattern."""
        return isinstance(subject, str) and is_pattern_file(subject)

    @classmethod
    def read(cls, subject: str, asked: Asked) -> Case:
        """Return the case of the design that a file draws, or of its pattern; PatternError without a packed state."""
        path = subject
        if asked.content:  # as other files that a scene file names
            path = str(Path(asked.name).parent / Path(subject).expanduser())
        panel = asked.panel or asked.content.get("panel_mm")
        if not isinstance(panel, str | None):
            raise SceneError(f"{asked.name} has panel_mm = {panel!r}: write a text, such as panel_mm = '80x8'")
        drawn = read_pattern_file(path, panel)
        if isinstance(drawn, DrawnDesign):
            return cls._design(path, drawn, asked.without_panel())
        return cls._pattern(path, drawn, asked.without_panel())

    @classmethod
    def _design(cls, path: str, drawn: DrawnDesign, asked: Asked) -> Case:
        """Return the case of the folding that a file draws, or of the design with all foldings that it may draw."""
        asked = replace(asked, panel=drawn.panel)
        if asked.extent in ("design", "results") and not asked.content:
            return DesignReading.design_of(drawn.design.circuit, asked, drawn.design.creases)
        notation = only_drawn_folding(drawn)
        case = DesignReading.read(notation, replace(asked, name=notation))
        return replace(case, noted="; ".join(filter(None, (f"{path} is the folding {notation}", case.noted))))

    @classmethod
    def _pattern(cls, path: str, drawn: DrawnPattern, asked: Asked) -> Case:
        """Return the case of a pattern in the scene that is asked for; a line says why it is no design."""
        is_moved = asked.extent in ("folding", "array", "page") or bool(asked.content)
        if asked.extent == "results" and asked.scene is not None and not asked.content:
            raise HcsearchError(
                "the properties of a pattern depend on no scene: ask for a page, or leave the scene out"
            )
        if is_moved and not drawn.packed.packed:
            if asked.packed:
                raise PatternError(
                    f"{path}: {drawn.packed.sentence}; see hcsearch check {path}, or follow motions from the flat "
                    "state by hcsearch motion --from flat"
                )
            write_notice(f"{path}: {drawn.packed.sentence}")
        scene = asked.own_scene(
            f"{path} has panels and joints of its own: leave out --flat-pairs, and name a scene without panels"
        )
        write_notice(f"{path} {drawn.no_design}")
        if is_moved and drawn.packed.assumed:
            write_notice(f"{path}: {drawn.packed.assumed}")
        return cls(name=asked.name, scene=scene, drawn=drawn, **asked.formulation_and_drive)

    @property
    def entries(self) -> dict[str, Any]:
        """Its file, and the size that was asked for."""
        path = str(Path(self.drawn.path).absolute())
        return {"pattern": path} | ({} if self.drawn.panel is None else {"panel_mm": self.drawn.panel})

    @property
    def title(self) -> str:
        """The name of its file."""
        return Path(self.drawn.path).name

    @property
    def source_file(self) -> str:
        """Its file."""
        return self.drawn.path

    @cached_property
    def linkage(self) -> Linkage:
        """Its panels and hinges."""
        return Linkage(self.drawn.packed.pattern)

    def path(self) -> CasePath:
        """Plan its motion from packed to flat."""
        from hcsearch.motion.planning.motion_search import plan_linkage_motion

        self.check_moved()
        return CasePath(self.scene, plan_linkage_motion(self.linkage, self.scene.margin), self.driven_sentence)

    def travel(self) -> MovedCase:
        """Return its travel: by springs, else along a planned path."""
        from hcsearch.springs.flight.travel import travel_along

        self.check_moved()
        by_springs = self.travel_by_springs()
        if isinstance(by_springs, MovedCase):
            return by_springs
        motion = self.path().motion
        if motion.margin is None or motion.states is None:
            raise self.no_travel(by_springs)
        travel = travel_along(self.linkage, self.scene, motion.states)
        return MovedCase(travel, self.scene, f"{by_springs}a proved path")

    def certificate(self, budget: int, progress: Progress | None) -> tuple[dict[str, Any], list[str]]:
        """Prove a path or a lock."""
        from hcsearch.motion.certificates.certifying import prove_pattern

        self.check_moved()
        return prove_pattern(self.linkage, self.title, self.scene.margin, budget, progress)

    def checked(self, progress: Progress | None = None) -> Checked:
        """Take it through every stage, until one shows that it is locked."""
        from hcsearch.search.own_patterns.checked_patterns import check_pattern

        self.check_moved()
        reporting = () if progress is None else (progress,)
        return check_pattern(self.shown_name, self.drawn.packed, self.scene, *reporting)

    @property
    def shown_name(self) -> str:
        """The file as it was named, or the name of the file that a case file names."""
        return self.name if self.claims(self.name) else self.title

    @cached_property
    def mobility(self) -> PatternVerdict:
        """Its degrees of freedom and its locks."""
        from hcsearch.search.own_patterns.checked_patterns import pattern_mobility

        return pattern_mobility(self.title, self.drawn.packed, self.linkage, self.scene)

    @property
    def facts(self) -> dict[str, Any]:
        """Its sizes, its degrees of freedom and its locks as plain data."""
        return self.mobility.facts()

    def lines(self) -> Iterator[str]:
        """Yield the name and the value of each of these."""
        yield from (f"{label:21}{text}" for label, text in self.mobility.rows())

    def page_facts(self, deployed: Deployed, subject: str) -> PageFacts:
        """Return its freedoms, its locks, and the planned path if there is one."""
        from hcsearch.motion.planning.motion_search import plan_linkage_motion, reason_of
        from hcsearch.subjects.replay_sources import replay_of_path

        rows, motions = list(self.mobility.rows()), []
        if not self.mobility.locks and self.moves_along_paths:
            motion = plan_linkage_motion(self.linkage, self.scene.margin)
            rows.append(("planned path", reason_of(motion, joined=False)))
            if motion.states is not None:
                replay = replay_of_path(self.linkage, motion.states, self.title, margin=motion.margin)
                motions.append(("Planned path", replay, f"hcsearch drive {subject}"))
        check = [(f"hcsearch check {subject}", "takes it through all stages")] if self.moves_along_paths else []
        return PageFacts(
            title=self.title,
            facts=self.facts,
            rows=rows,
            commands=[
                *check,
                (f"hcsearch motion {subject}", "follows its motion: branches and singular states"),
                (f"hcsearch export {subject} --output pattern.glb", "writes it for other programs"),
            ],
            motions=motions,
            notes=[],
            published=[],
        )
