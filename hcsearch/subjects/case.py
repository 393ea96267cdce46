"""A case: what a command is about, in a scene, with what can be done with it. Each kind of subject is a class."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Protocol, TypeVar

from hcsearch.basics.errors import HcsearchError, SceneError, SizeError
from hcsearch.basics.vocabulary import Formulation, ReplaySource
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import Folding
from hcsearch.scenes import Scene
from hcsearch.scenes.scene_file import scene_file_text
from hcsearch.scenes.setup import Setup, setup_of_scene
from hcsearch.shape.labels import Labels, labels_of
from hcsearch.shape.linkage import Linkage
from hcsearch.shape.pattern import Pattern

if TYPE_CHECKING:
    from hcsearch.motion.planning.motion_search import PlannedMotion
    from hcsearch.search.own_patterns.checked import Checked
    from hcsearch.springs.deployment.deployment_facts import Deployed
    from hcsearch.springs.deployment.drives import Drives
    from hcsearch.springs.drive.drive_facts import Drive
    from hcsearch.springs.drive.driven_folding import DriveOptions
    from hcsearch.springs.flight.travel import Travel
    from hcsearch.system.work_steps import Progress
from hcsearch.subjects.replay import Replay

CaseSubject = str | Folding | Circuit | Linkage
"""The subject of a deployment or tuning: DESIGN:CREASE, an assembly, a file .toml or .fold, or a value."""


class MovedCase(NamedTuple):
    """The travel of a case, its scene with the joining of flat pairs that moves, and a sentence on what moves it."""

    travel: Travel
    scene: Scene
    source: str


class CasePath(NamedTuple):
    """A planned motion of a case, the scene in which it is planned, and a note on the joining of flat pairs."""

    scene: Scene
    motion: PlannedMotion
    note: str


class PageFacts(NamedTuple):
    """What the page of a linkage tells of it.

    title, facts : its name and its properties. rows : name and value of each property, as texts. commands : that print
    or draw more, each with what it does. motions : to play beside that by springs, each with its title, its replay, and
    its command. notes, published : sentences, and rows of (name, published value, verdict).
    """

    title: str
    facts: Mapping[str, Any]
    rows: list[tuple[str, str]]
    commands: list[tuple[str, str]]
    motions: list[tuple[str, Replay, str]]
    notes: list[str]
    published: list[tuple[str, str, str]]


Page_co = TypeVar("Page_co", covariant=True)


class PageMaker(Protocol[Page_co]):
    """Makes the pages of cases: a design has one of its foldings, each other case one of its linkage."""

    def design_page(self, design: Any) -> Page_co:
        """Make the page of a `CircuitCase`."""

    def linkage_page(self, case: Case) -> Page_co:
        """Make the page of a case that has `page_facts`."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Case(ABC):
    """The subject of a command, in a scene.

    Parameters
    ----------
    name
        The name that the user gave.
    scene
        The requested scene.
    formulation, drive
        The formulation and the drives that a file names.
    noted
        Notes for users.
    """

    kind: ClassVar[str]
    """What it is, as a word."""
    no_path: ClassVar[str]
    """Why no path is planned for it, and the remedy, as the rest of a sentence on `{title}`."""

    name: str
    scene: Scene
    formulation: Formulation | None = None
    drive: Mapping[str, Any] | None = None
    noted: str = ""

    def __repr__(self) -> str:
        return f"<Case {self.title}, scene {self.scene.name}>"

    @property
    @abstractmethod
    def entries(self) -> dict[str, Any]:
        """The subject as the entries of a case file; a file has its whole path, from wherever this one is read."""

    @property
    def title(self) -> str:
        """The name of the subject."""
        return str(next(iter(self.entries.values())))

    @property
    def key(self) -> dict[str, Any]:
        """The key of stored evaluations: the subject with its sizes."""
        return self.entries

    @property
    def joined_scene(self) -> Scene:
        """The scene restricted to the joining of flat pairs of this case."""
        return self.scene

    @cached_property
    @abstractmethod
    def linkage(self) -> Linkage:
        """The panels and hinges that springs move."""

    @cached_property
    def labels(self) -> Labels:
        """The names of its panels and hinges."""
        return labels_of(self.linkage)

    @property
    def array(self) -> Folding | Circuit | Pattern:
        """The panels beside each other, for graphs."""
        return self.linkage.pattern

    @property
    def circuit(self) -> Circuit | None:
        """The circuit; None where there is none."""
        return None

    @cached_property
    def setup(self) -> Setup:
        """The scene in quantities of the linkage, in the variant of this case."""
        return setup_of_scene(self.scene, self.linkage)

    @cached_property
    def drives(self) -> Drives | None:
        """The drives of its hinges from a file; None without."""
        if self.drive is None:
            return None
        from hcsearch.springs.deployment.drives import drives_in

        return drives_in(self.drive, self.labels)

    @property
    def sentence(self) -> str:
        """Notes for users: chosen folding, scene, joining of flat pairs, and their source."""
        return self.noted

    @property
    def driven_sentence(self) -> str:
        """The notes for a motion along a path, which has the springs of the scene."""
        return self.noted

    @property
    def dependencies(self) -> list[str]:
        """All that files of it depend on, as texts."""
        return [scene_file_text(self.entries, self.formulation, self.joined_scene)]

    def stem(self, number: int) -> str:
        """Return the stem of the files of a stored design, whose id is `number`."""
        return str(number)

    @property
    def source_file(self) -> str:
        """The file that draws the subject; empty without one."""
        return ""

    def check_moved(self) -> None:
        """Refuse a case with a drive, a formulation or a variant of a scene, as a motion along a path has none."""
        if self.drive is not None:
            raise SceneError(f"{self.name} has a drive: give it to hcsearch deploy, or leave out its table [drive]")
        if self.formulation not in (None, "constrained"):
            raise SceneError(
                f"{self.name} has formulation = {self.formulation!r}: motions along a path need 'constrained'"
            )

    @property
    def moves_along_paths(self) -> bool:
        """Whether paths are planned for it: it has no drive and no formulation that excludes them."""
        return self.drive is None and self.formulation in (None, "constrained")

    def in_variant(self, name: str) -> Case:
        """Return the case in the variant that the name of a scene ends with; this case without one."""
        return self

    def no_motion(self) -> HcsearchError:
        """Return the error where a path is asked for of a kind that has none."""
        return HcsearchError(f"{self.title} {self.no_path.format(title=self.title)}")

    def deployed(self, formulation: Formulation | None = None, **settings: Any) -> Deployed:
        """Simulate how springs or drives move it, as `deploy_linkage`, by default in the formulation of its file."""
        from hcsearch.springs.deployment.deployment_facts import deploy_linkage

        chosen = formulation or self.formulation or "constrained"
        return deploy_linkage(self.name, self.linkage, self.setup, chosen, drives=self.drives, **settings)

    def path(self) -> CasePath:
        """Plan its motion from packed to flat; HcsearchError where its kind or its file allows none."""
        raise self.no_motion()

    def first_path(self) -> CasePath:
        """Plan its motion as `path`, but with no other joining of flat pairs than that of its status."""
        return self.path()

    def path_linkage(self, path: CasePath) -> Linkage:
        """Return the linkage that moves along a path."""
        return self.linkage

    def unproved(self, path: CasePath) -> str:
        """Return a sentence on why no path is proved."""
        from hcsearch.springs.drive.driven_folding import no_path_reason

        return no_path_reason(path.motion)

    def stored_replay(self) -> Replay | None:
        """Return the replay of its stored path; None without one."""
        return None

    def replay(self, by: ReplaySource | None = None) -> tuple[Replay, str]:
        """Replay a motion; return it with a note on the joining of flat pairs.

        by : `path`, from packed to flat: the stored path of a judged folding, else one planned in the scene; `springs`,
        a simulation. Default: a proved path if there is one, else the simulation, unless springs do not open it and a
        path without proof exists. HcsearchError if a path is required and there is none.
        """
        from hcsearch.springs.deployment.simulated_deployment import simulate_deployment
        from hcsearch.subjects.replay_sources import replay_of_deployment

        replay, note = None, ""
        if by != "springs":
            replay, note = self.stored_replay(), self.driven_sentence
            if replay is None:
                replay, note = self._planned_replay(required=by == "path")
            if replay is not None and (by == "path" or replay.certified):
                return replay, note
        formulation = self.formulation or "constrained"
        deployment = simulate_deployment(self.linkage, self.setup, formulation, drives=self.drives)
        if replay is not None and not deployment.deploys:
            return replay, note
        return replay_of_deployment(deployment, self.title), self.sentence

    def _planned_replay(self, *, required: bool) -> tuple[Replay | None, str]:
        from hcsearch.subjects.replay_sources import replay_of_path

        try:
            path = self.path() if required else self.first_path()
        except SizeError:
            raise
        except HcsearchError:
            if required:
                raise
            return None, ""  # it has no path, or a file with springs or a drive of its own
        motion = path.motion
        if motion.states is None or motion.way is None:
            if required:
                raise HcsearchError(self.unproved(path))
            return None, ""
        replay = replay_of_path(self.path_linkage(path), motion.states, self.title, margin=motion.margin)
        return replay, path.note

    def travel(self) -> MovedCase:
        """Return its travel in the scene: by springs, else along a proved path.

        HcsearchError for a drive, and where neither springs nor a proved path open it.
        """
        raise self.no_motion()

    def travel_by_springs(self) -> MovedCase | str:
        """Return its travel by springs; where they do not open it, the beginning of a sentence that says so."""
        from hcsearch.springs.deployment.simulated_deployment import simulate_deployment
        from hcsearch.springs.flight.travel import travel_of_deployment

        deployment = simulate_deployment(self.linkage, self.setup)
        reason = deployment.check.reason(self.labels) if deployment.outcome == "flat" else deployment.sentence
        if deployment.deploys:
            travel = travel_of_deployment(deployment)
            return MovedCase(travel, self.joined_scene, f"springs, {self.sentence or reason}")
        return f"springs do not open it ({reason}); "

    def no_travel(self, unopened: str) -> HcsearchError:
        """Return the error where nothing moves it; unopened : why springs do not."""
        return HcsearchError(
            f"{self.title} has no motion for a flight sheet: {unopened}no path is proved; see hcsearch drive "
            f"{self.title}"
        )

    def driven(self, path: CasePath, options: DriveOptions | None, progress: Progress | None) -> Drive:
        """Choose motors that open it along a path; NoPathError where none is proved."""
        from hcsearch.springs.drive.driven_folding import NoPathError, drive_linkage

        if path.motion.proved is None:
            raise NoPathError(self.unproved(path))
        return drive_linkage(self.entries, self.linkage, path.scene, path.motion.proved, options, progress)

    def certificate(self, budget: int, progress: Progress | None) -> tuple[dict[str, Any], list[str]]:
        """Prove a path or a lock; return the certificate as plain data, and what `verify` says of it."""
        raise self.no_motion()

    def checked(self, progress: Progress | None = None) -> Checked:
        """Take it through every stage."""
        raise HcsearchError(f"{self.title} is no circuit: name one, such as hex:0234435011, or a file .fold")

    def shown(self) -> Case:
        """Return the case whose `lines` are printed; of a folding, that of its design with this folding alone."""
        return self

    def lines(self) -> Iterator[str]:
        """Yield what `hcsearch show` prints."""
        raise HcsearchError(f"{self.title} is no design: name a circuit such as hex:0234550132, or an assembly")

    def page(self, maker: PageMaker[Page_co]) -> Page_co:
        """Return its page."""
        return maker.linkage_page(self)

    def page_facts(self, deployed: Deployed, subject: str) -> PageFacts:
        """Return what its page tells beside its motion by springs; subject : how commands name it."""
        raise HcsearchError(f"{self.title} is no design: name a circuit such as hex:0234550132, or an assembly")
