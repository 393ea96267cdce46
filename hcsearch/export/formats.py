"""The formats of exports. A format is a module in a folder here, with a function `write`, and one line in this list.

Loads nothing that is heavy: the command line names formats in its help.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Literal, Protocol

from hcsearch.errors import HcsearchError, OutputError

if TYPE_CHECKING:
    from hcsearch.export.exported import Exported
    from hcsearch.export.settings import Settings

Of = Literal["array", "pattern", "motion"]
Content = str | bytes
Files = Content | Mapping[str, Content]
"""What a writer returns: the file, or files by what follows the stem of its name, as `.urdf` and `.closure.json`.

Of several, the first is the file that was asked for.
"""


class Writer(Protocol):
    """The function `write` of a format's module."""

    def __call__(self, exported: Exported, settings: Settings) -> Files:
        """Contents of the file, and of any beside it."""


@dataclass(frozen=True)
class Format:
    """One format.

    name : the word of `--format`. room : the folder, beside this module, of its own module. endings : of its files, the
        usual one first. what : what a file holds, in a phrase.
    of : what it is made from: the array alone, which needs no folding; the pattern, in one state; or a motion.
    takes : the settings that it heeds (`Settings`), beside the subject's own. frames : whether a format of the pattern
        also holds a motion where one is asked for by `--motion`.
    needs : modules that an extra of that name installs. module : unless it is the name.
    by_name : whether only `--format` chooses it, as another format has its ending.
    """

    name: str
    room: str
    endings: tuple[str, ...]
    what: str
    of: Of = "pattern"
    takes: frozenset[str] = frozenset()
    frames: bool = False
    extra: str = "export"
    needs: tuple[str, ...] = ()
    module: str = ""
    by_name: bool = False

    @property
    def write(self) -> Writer:
        """Its writer; HcsearchError where what it needs is not installed."""
        self.check_installed()
        writer: Writer = import_module(f"hcsearch.export.{self.room}.{self.module or self.name}").write
        return writer

    def check_installed(self) -> None:
        """HcsearchError that names the extra, where what the format needs is not installed."""
        missing = [name for name in self.needs if find_spec(name) is None]
        if missing:
            raise HcsearchError(f"{self.name} needs {missing[0]}: pip install 'hcsearch[{self.extra}]'")


_SHEET = frozenset({"sheet", "kerf_mm", "hinge_gap_mm", "profile"})
_SOLID = frozenset({"state", "part"})
_SCENE = frozenset({"contact", "timestep_s"})

FORMATS: dict[str, Format] = {
    form.name: form
    for form in (
        Format(
            "fold",
            "origami",
            (".fold",),
            "FOLD 1.2: crease pattern and folded states, for origami software",
            frames=True,
        ),
        Format("svg", "sheets", (".svg",), "a sheet to cut and crease, as a drawing in millimetres", takes=_SHEET),
        Format(
            "animation", "pictures", (".svg",), "with --format animation: a moving picture", of="motion", by_name=True
        ),
        Format(
            "dxf", "sheets", (".dxf",), "the same sheet for CAD systems and cutters", takes=_SHEET, needs=("ezdxf",)
        ),
        Format("csv", "tables", (".csv",), "a table of fold angles and gaps along the motion", of="motion"),
        Format("parquet", "tables", (".parquet",), "the same table", of="motion", extra="parquet", needs=("pyarrow",)),
        Format(
            "networkx", "tables", (".json",), "the graph of panels, creases and slits, as node-link JSON", of="array"
        ),
        Format("graph6", "tables", (".g6",), "the graph of neighbouring panels, as graph6", of="array"),
        Format("glb", "solids", (".glb",), "the motion as an animation, in binary glTF 2.0", of="motion"),
        Format("stl", "solids", (".stl",), "triangles of all panels or of one, in millimetres", takes=_SOLID),
        Format("3mf", "solids", (".3mf",), "an object for each panel, for printers", takes=_SOLID, module="threemf"),
        Format("step", "solids", (".step", ".stp"), "an exact solid for each panel, for CAD systems", takes=_SOLID),
        Format(
            "mjcf",
            "simulators",
            (".xml", ".mjcf"),
            "a model of the scene for MuJoCo",
            takes=_SCENE,
        ),
        Format("urdf", "simulators", (".urdf",), "a tree of links, with a second file of the loops"),
    )
}


def format_of(path: str, name: str | None = None) -> Format:
    """The format of a name, or of a file's ending; OutputError where neither says which, or they differ."""
    if name is not None:
        if name not in FORMATS:
            raise OutputError(f"there is no format {name!r}: choose one of {', '.join(FORMATS)}")
        chosen = FORMATS[name]
        if Path(path).suffix.lower() not in chosen.endings:
            raise OutputError(f"{path} is no name for a file of the format {name}: write {' or '.join(chosen.endings)}")
        return chosen
    known = [form for form in FORMATS.values() if Path(path).suffix.lower() in form.endings and not form.by_name]
    if not known:
        endings = ", ".join(form.endings[0] for form in FORMATS.values() if not form.by_name)
        raise OutputError(f"{path or 'an empty name'} has no known ending: write {endings}")
    if len(known) > 1:
        raise OutputError(f"{path} may be {' or '.join(form.name for form in known)}: name one with --format")
    return known[0]
