"""The formats of exports. A format is a module here, a writer in `writers`, and one line in this list.

Loads nothing that is heavy: the command line names formats in its help.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib.util import find_spec
from inspect import signature
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from hcsearch.basics.errors import HcsearchError, OutputError
from hcsearch.export import writers

if TYPE_CHECKING:
    from hcsearch.export.exported import Exported, Settings

Of = Literal["array", "pattern", "motion"]
Content = str | bytes
Files = Content | Mapping[str, Content]
"""What a writer returns: the file, or files by what follows the stem of its name, as `.urdf` and `.closure.json`.

Of several, the first is the file that was asked for.
"""


@dataclass(frozen=True)
class Format:
    """One format.

    name : the word of `--format`. endings : of its files, the usual one first. what : what a file holds, in a phrase.
    writer : a function of an `Exported`, and of the settings that the format heeds by keywords, beside the subject's
        own.
    of : what it is made from: the array alone, which needs no folding; the pattern, in one state; or a motion.
    frames : whether a format of the pattern also holds a motion where one is asked for by `--motion`.
    needs : modules that an extra of that name installs.
    by_name : whether only `--format` chooses it, as another format has its ending.
    """

    name: str
    endings: tuple[str, ...]
    what: str
    writer: Callable[..., Files]
    of: Of = "pattern"
    frames: bool = False
    extra: str = "export"
    needs: tuple[str, ...] = ()
    by_name: bool = False

    @property
    def takes(self) -> frozenset[str]:
        """The names of the settings that the writer asks for."""
        parameters = signature(self.writer).parameters.values()
        return frozenset(parameter.name for parameter in parameters if parameter.kind is parameter.KEYWORD_ONLY)

    def write(self, exported: Exported, settings: Settings) -> Files:
        """Contents of the file, and of any beside it; HcsearchError where what it needs is not installed."""
        self.check_installed()
        return self.writer(exported, **{name: getattr(settings, name) for name in self.takes})

    def check_installed(self) -> None:
        """HcsearchError that names the extra, where what the format needs is not installed."""
        missing = [name for name in self.needs if find_spec(name) is None]
        if missing:
            raise HcsearchError(f"{self.name} needs {missing[0]}: pip install 'hcsearch[{self.extra}]'")


FORMATS: dict[str, Format] = {
    form.name: form
    for form in (
        Format(
            "fold",
            (".fold",),
            "FOLD 1.2: crease pattern and folded states, for origami software",
            writers.write_fold,
            frames=True,
        ),
        Format("svg", (".svg",), "a sheet to cut and crease, as a drawing in millimetres", writers.write_svg),
        Format(
            "animation",
            (".svg",),
            "with --format animation: a moving picture",
            writers.write_animation,
            of="motion",
            by_name=True,
        ),
        Format("dxf", (".dxf",), "the same sheet for CAD systems and cutters", writers.write_dxf, needs=("ezdxf",)),
        Format("csv", (".csv",), "a table of fold angles and gaps along the motion", writers.write_csv, of="motion"),
        Format(
            "parquet",
            (".parquet",),
            "the same table",
            writers.write_parquet,
            of="motion",
            extra="parquet",
            needs=("pyarrow",),
        ),
        Format(
            "networkx",
            (".json",),
            "the graph of panels, creases and slits, as node-link JSON",
            writers.write_networkx,
            of="array",
        ),
        Format("graph6", (".g6",), "the graph of neighbouring panels, as graph6", writers.write_graph6, of="array"),
        Format("glb", (".glb",), "the motion as an animation, in binary glTF 2.0", writers.write_glb, of="motion"),
        Format("stl", (".stl",), "triangles of all panels or of one, in millimetres", writers.write_stl),
        Format("3mf", (".3mf",), "an object for each panel, for printers", writers.write_3mf),
        Format("step", (".step", ".stp"), "an exact solid for each panel, for CAD systems", writers.write_step),
        Format("mjcf", (".xml", ".mjcf"), "a model of the scene for MuJoCo", writers.write_mjcf),
        Format("urdf", (".urdf",), "a tree of links, with a second file of the loops", writers.write_urdf),
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
