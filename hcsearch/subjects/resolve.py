"""Resolution of names, files and values to cases: the first kind that claims one reads it."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from hcsearch.basics.errors import HcsearchError, SceneError
from hcsearch.basics.vocabulary import Way
from hcsearch.scenes import Scene
from hcsearch.scenes.scene_file import SUBJECT_KEYS, read_scene_file
from hcsearch.scenes.values import shown_value
from hcsearch.store.columns import column_names
from hcsearch.store.failures import retry_if_changed
from hcsearch.subjects.asked import Asked, Extent
from hcsearch.subjects.case import Case, CaseSubject
from hcsearch.subjects.design_reading import DesignReading
from hcsearch.subjects.linkage_cases import AssemblyCase, LinkageCase
from hcsearch.subjects.names import Place, is_id
from hcsearch.subjects.pattern_case import PatternCase
from hcsearch.subjects.pattern_files import PATTERN_SUFFIXES, refuse_other_file
from hcsearch.subjects.stored_scenes import is_scene_file

KINDS: dict[str, Any] = {
    "linkage": LinkageCase,
    "assembly": AssemblyCase,
    "pattern": PatternCase,
    "design": DesignReading,
}
"""The kinds of subjects by the words of a case file; the first one that claims a name or a value reads it."""


def kind_of(subject: object) -> str:
    """Return the word for the kind of a name or a value: one of `KINDS`, or `case` for a file that names a subject."""
    if isinstance(subject, str) and is_scene_file(subject):
        return "case"
    return next(word for word, kind in KINDS.items() if kind.claims(subject))


@retry_if_changed
def resolve(
    what: CaseSubject | Case,
    db: Place | None = None,
    *,
    scene: Scene | str | None = None,
    panel: str | None = None,
    flat_pairs: Way | None = None,
    values: Mapping[str, Any] | None = None,
    path: bool = False,
    packed: bool = True,
    extent: Extent = "folding",
) -> Case:
    """Resolve a named subject and its scene to a case; a case is returned unchanged.

    Parameters
    ----------
    what
        A text, DESIGN:CREASE, the name of an assembly, a file `NAME.toml` or a pattern as `check` takes it, or a
        Folding, a Circuit or a Linkage. A design without a crease stands for its best folding in the database. If the
        database has verdicts of only one scene and none is named, an id stands for the design in this scene.
    db
        The database in which ids, scenes and verdicts are looked up, in one transaction.
    scene
        A Scene, the name of one, or a file `NAME.toml`.
    panel
        Size of panels in millimetres, such as `50x40x6` or `across 1000x20`.
    flat_pairs
        Joining of flat pairs.
    values
        Values of the scene, by the names of a scene file.
    path
        Whether a design stands for its first folding with a proved path if its best folding has none.
    packed
        Whether a drawn pattern must have a packed state; else a line on standard error says that it has none.
    extent
        What a design stands for: `folding`, one of its foldings; `design`, all of them; `results`, these with their
        results in the database; or `page`, with all that a page shows.

    Returns
    -------
    Case
        The subject in its scene.

    Raises
    ------
    HcsearchError
        For unknown files, scenes, ids and names, and for contradictory arguments.
    """
    if isinstance(what, Case):
        return what
    name, content, subject = str(what), {}, what
    if kind_of(what) == "case":
        content = read_scene_file(name)
        subject = _subject_in(name, content)
    asked = Asked(name, content, scene, panel, flat_pairs, values or {}, path, packed, extent, db)
    case: Case = KINDS[kind_of(subject)].read(subject, asked)
    return case


def _subject_in(path: str, content: Mapping[str, Any]) -> str:
    """Return the subject that a case file names; SceneError without one, and for one named by another kind's key."""
    key = next((key for key in SUBJECT_KEYS if key in content), None)
    if key is None:
        raise SceneError(f"{path} must name a design, an assembly or a pattern: write design = 'hex:0234550132:4'")
    subject = str(content[key])
    fits = kind_of(subject)
    if fits != key and (fits != "design" or is_id(subject) or ":" in subject):
        raise SceneError(f"{path} has {key} = {shown_value(subject)}: write {fits} = {shown_value(subject)}")
    if key == "pattern" and fits != "pattern":
        raise SceneError(f"{path} has pattern = {shown_value(subject)}: name a file {', '.join(PATTERN_SUFFIXES)}")
    return subject


_NAME = re.compile(r"[0-9]+(:[0-9]+)?|[a-z0-9]+:[^\s=<>]*")
_OPERATOR = re.compile(r"[=<>]")
_CONDITION_MARK = re.compile(r"[\s=<>()]")


def is_query(text: str) -> bool:
    """Whether a text is a query for designs; else it is a name. HcsearchError for what is neither.

    A name is an id, a notation, an assembly or a file `.toml` or `.fold`. A query has an operator, a bracket or a
    space, or is the name of a column.
    """
    if not _OPERATOR.search(text):  # a query may name a file of cells
        refuse_other_file(text)
    if kind_of(text) != "design" or _NAME.fullmatch(text):
        return False
    if _CONDITION_MARK.search(text) or text in column_names("designs"):
        return True
    raise HcsearchError(
        f"there is no assembly {text!r}, and it is no query: name DESIGN:CREASE, an assembly that `hcsearch assembly "
        "list` prints or a file .toml or .fold, or write conditions as in 'n=12 untwisted'"
    )
