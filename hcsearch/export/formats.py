"""The table of export formats, each with its writer.

A writer's keyword parameters are the settings that its format supports (fields of `ExportSettings`). Modules of formats
are imported only by the writers: the command line lists the formats in its help and must start fast, and some formats
need packages of an extra.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib.util import find_spec
from inspect import signature
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from hcsearch.basics.errors import HcsearchError, OutputError

if TYPE_CHECKING:
    from hcsearch.export.cutting_sheets import CuttingSheet
    from hcsearch.export.exported import Exported
    from hcsearch.export.settings import ExportSettings, ExportState, SheetKind, SheetProfile
    from hcsearch.scenes import Scene


def write_fold(exported: Exported) -> str:
    """Write the crease pattern, the folded states, and the motion if there is one."""
    from hcsearch.export.fold import fold_of

    return fold_of(exported.name, exported.linkage, exported.labels, exported.circuit, exported.replay)


def write_svg(
    exported: Exported, *, sheet: SheetKind, kerf_mm: float, hinge_gap_mm: float, profile: SheetProfile
) -> str:
    """Write the sheet as SVG."""
    from hcsearch.export.sheet_formats import svg_of

    return svg_of(_sheet_of(exported, sheet, kerf_mm, hinge_gap_mm, profile), exported.name, profile)


def write_dxf(
    exported: Exported, *, sheet: SheetKind, kerf_mm: float, hinge_gap_mm: float, profile: SheetProfile
) -> str:
    """Write the sheet as DXF."""
    from hcsearch.export.sheet_formats import dxf_of

    return dxf_of(_sheet_of(exported, sheet, kerf_mm, hinge_gap_mm, profile), profile)


def _sheet_of(
    exported: Exported, sheet: SheetKind, kerf_mm: float, hinge_gap_mm: float, profile: SheetProfile
) -> CuttingSheet:
    from hcsearch.export.cutting_sheets import cutting_sheet_of

    pattern, labels = exported.linkage.pattern, exported.labels
    return cutting_sheet_of(pattern, labels, sheet=sheet, kerf_mm=kerf_mm, hinge_gap_mm=hinge_gap_mm, profile=profile)


def write_animation(exported: Exported) -> str:
    """Write the motion as an animated picture."""
    from hcsearch.export.animation import animation_of

    return animation_of(exported.motion)


def write_png(exported: Exported, *, state: ExportState) -> bytes:
    """Write a still of a state."""
    from hcsearch.export.films import still_of

    return still_of(exported, state)


def write_gif(exported: Exported) -> bytes:
    """Write the motion as an animated GIF."""
    from hcsearch.export.films import film_of

    return film_of(exported.motion, "GIF")


def write_webp(exported: Exported) -> bytes:
    """Write the motion as an animated WebP."""
    from hcsearch.export.films import film_of

    return film_of(exported.motion, "WEBP")


def write_csv(exported: Exported) -> str:
    """Write the table of the motion as CSV text, in full precision."""
    return exported.motion.table().to_csv(index=False, lineterminator="\n")


def write_parquet(exported: Exported) -> bytes:
    """Write the table of the motion as Parquet."""
    return exported.motion.table().to_parquet(index=False)


def write_bill(exported: Exported, *, ending: str) -> str:
    """Write the bill of materials as a table of the style of the ending."""
    from hcsearch.export.bill_items import bill_of_case
    from hcsearch.export.bill_texts import BILL_STYLES, bill_text

    return bill_text(bill_of_case(exported.case), BILL_STYLES.get(ending, "csv"))


def write_networkx(exported: Exported) -> str:
    """Write the graph of panels, creases and slits as JSON."""
    from hcsearch.export.graphs import node_link_json

    return node_link_json(exported.name, exported.case.array)


def write_graph6(exported: Exported) -> bytes:
    """Write the graph of neighbouring panels as graph6."""
    from hcsearch.export.graphs import graph6_of

    return graph6_of(exported.case.array)


def write_glb(exported: Exported) -> bytes:
    """Write the motion as an animation in glTF."""
    from hcsearch.export.glb import glb_of

    return glb_of(exported.motion)


def write_stl(exported: Exported, *, state: ExportState, part: str | None) -> bytes:
    """Write triangles of all panels, or of one panel, in a state."""
    from hcsearch.export.panel_solids import wanted_panels
    from hcsearch.export.print_formats import stl_of

    panels = wanted_panels(exported.labels, part)
    return stl_of(exported.linkage, exported.angles(state), exported.name, panels)


def write_3mf(exported: Exported, *, state: ExportState, part: str | None) -> bytes:
    """Write objects of all panels, or of one panel, in a state."""
    from hcsearch.export.panel_solids import wanted_panels
    from hcsearch.export.print_formats import threemf_of

    panels = wanted_panels(exported.labels, part)
    return threemf_of(exported.linkage, exported.labels, exported.angles(state), exported.name, panels)


def write_step(exported: Exported, *, state: ExportState, part: str | None) -> str:
    """Write exact solids of all panels, or of one panel, in a state."""
    from hcsearch.export.panel_solids import wanted_panels
    from hcsearch.export.step import step_of

    panels = wanted_panels(exported.labels, part)
    return step_of(exported.linkage, exported.labels, exported.angles(state), exported.name, panels)


def write_mjcf(exported: Exported, *, contact: bool, timestep_s: float | None) -> str:
    """Write the scene as a model of MuJoCo; HcsearchError where such a model cannot hold it."""
    from hcsearch.export.mjcf import mjcf_of

    scene, linkage = _simulated_scene(exported), exported.case.linkage
    return mjcf_of(linkage, exported.labels, scene, exported.name, contact=contact, timestep=timestep_s)


def write_urdf(exported: Exported, *, stem: str) -> Mapping[str, str | bytes]:
    """Write the scene as a tree of links, its loop closures, and a mesh of each panel; HcsearchError for drives."""
    from hcsearch.export.urdf import urdf_of

    return urdf_of(exported.case.linkage, exported.labels, _simulated_scene(exported), exported.name, stem)


def _simulated_scene(exported: Exported) -> Scene:
    """Return the scene of a model for a simulator, with the springs of its variant; HcsearchError for drives."""
    from hcsearch.scenes.setup import scene_of_setup

    case = exported.case
    if case.drives is not None:
        raise HcsearchError(
            "models for simulators are written with springs, not with drives: leave out the table [drive]"
        )
    return scene_of_setup(case.setup, case.joined_scene, exported.labels)


FormatSubject = Literal["array", "pattern", "motion"]
FileContent = str | bytes
WrittenFiles = FileContent | Mapping[str, FileContent]
"""The result of a writer: the content of one file, or of several by what follows the stem of their names, such as
`.urdf` and `.closure.json`, the main file first."""


@dataclass(frozen=True)
class ExportFormat:
    """An export format.

    name : its name for `--format`. endings : of its files, the usual one first. description : of the content, for help.
    writer : a function of an `Exported`, with the supported settings as keywords.
    subject : the array alone, which needs no folding; the pattern, in one state; or a motion.
    frames : whether a format of the pattern can also hold a motion, chosen by `--motion`.
    extra, needs : name of the extra, and the modules from it that the format needs.
    only_by_name : whether the format must be chosen by `--format`, since another one has its ending.
    joins : whether a file can hold several designs, one after the other.
    simulated : whether a file of the pattern holds the loads and supports of the scene.
    """

    name: str
    endings: tuple[str, ...]
    description: str
    writer: Callable[..., WrittenFiles]
    subject: FormatSubject = "pattern"
    frames: bool = False
    extra: str = "export"
    needs: tuple[str, ...] = ()
    only_by_name: bool = False
    joins: bool = False
    simulated: bool = False

    @property
    def setting_names(self) -> frozenset[str]:
        """The names of the settings that the format supports."""
        parameters = signature(self.writer).parameters.values()
        return frozenset(parameter.name for parameter in parameters if parameter.kind is parameter.KEYWORD_ONLY)

    def write(self, exported: Exported, settings: ExportSettings) -> WrittenFiles:
        """Return the contents of the files; HcsearchError where a needed module is not installed."""
        self.check_installed()
        return self.writer(exported, **{name: getattr(settings, name) for name in self.setting_names})

    def check_installed(self) -> None:
        """Raise HcsearchError, with the name of the extra, where a needed module is not installed."""
        missing = [name for name in self.needs if find_spec(name) is None]
        if missing:
            raise HcsearchError(f"{self.name} needs {missing[0]}: pip install 'hcsearch[{self.extra}]'")


EXPORT_FORMATS: dict[str, ExportFormat] = {
    form.name: form
    for form in (
        ExportFormat(
            "fold",
            (".fold",),
            "FOLD 1.2: crease pattern and folded states, for origami software",
            write_fold,
            frames=True,
        ),
        ExportFormat("svg", (".svg",), "a sheet to cut and crease, as a drawing in millimetres", write_svg),
        ExportFormat(
            "animation",
            (".svg",),
            "with --format animation: a moving picture",
            write_animation,
            subject="motion",
            only_by_name=True,
        ),
        ExportFormat("gif", (".gif",), "a film of the motion, for slides", write_gif, subject="motion"),
        ExportFormat("webp", (".webp",), "the same film, in finer colours", write_webp, subject="motion"),
        ExportFormat("png", (".png",), "a still of the panels in a state", write_png, frames=True),
        ExportFormat("dxf", (".dxf",), "the same sheet for CAD systems and cutters", write_dxf, needs=("ezdxf",)),
        ExportFormat("csv", (".csv",), "a table of fold angles and gaps along the motion", write_csv, subject="motion"),
        ExportFormat(
            "parquet",
            (".parquet",),
            "the same table",
            write_parquet,
            subject="motion",
            extra="parquet",
            needs=("pyarrow",),
        ),
        ExportFormat(
            "bom",
            (".csv", ".md", ".txt", ".json"),
            "with --format bom: panels, hinges, springs and drives to make or buy",
            write_bill,
            only_by_name=True,
        ),
        ExportFormat(
            "networkx",
            (".json",),
            "the graph of panels, creases and slits, as node-link JSON",
            write_networkx,
            subject="array",
        ),
        ExportFormat(
            "graph6", (".g6",), "the graph of neighbouring panels, as graph6", write_graph6, subject="array", joins=True
        ),
        ExportFormat("glb", (".glb",), "the motion as an animation, in binary glTF 2.0", write_glb, subject="motion"),
        ExportFormat("stl", (".stl",), "triangles of all panels or of one, in millimetres", write_stl),
        ExportFormat("3mf", (".3mf",), "an object for each panel, for printers", write_3mf),
        ExportFormat("step", (".step", ".stp"), "an exact solid for each panel, for CAD systems", write_step),
        ExportFormat("mjcf", (".xml", ".mjcf"), "a model of the scene for MuJoCo", write_mjcf, simulated=True),
        ExportFormat(
            "urdf", (".urdf",), "a tree of links, with a second file of the loops", write_urdf, simulated=True
        ),
    )
}


_GONE = {"sparse6": "a file .g6", "edgelist": "a file .json"}
_GONE |= {".s6": _GONE["sparse6"], ".edgelist": _GONE["edgelist"]}
"""Names and endings of formats that are written no more, and what holds the same graph."""


def format_named(name: str) -> ExportFormat:
    """Return the format of a name; OutputError where it is unknown."""
    _refuse_gone(name)
    if name not in EXPORT_FORMATS:
        raise OutputError(f"there is no format {name!r}: choose one of {', '.join(EXPORT_FORMATS)}")
    return EXPORT_FORMATS[name]


def _refuse_gone(name: str) -> None:
    if name in _GONE:
        raise OutputError(f"{name} is written no more: {_GONE[name]} holds the same graph")


def export_format_of(path: str, name: str | None = None) -> ExportFormat:
    """Return the format of a given name, or else of a file's ending; OutputError where it is unknown or ambiguous."""
    if name is not None:
        chosen = format_named(name)
        if Path(path).suffix.lower() not in chosen.endings:
            raise OutputError(f"{path} is no name for a file of the format {name}: write {' or '.join(chosen.endings)}")
        return chosen
    _refuse_gone(Path(path).suffix.lower())
    known = [
        form for form in EXPORT_FORMATS.values() if Path(path).suffix.lower() in form.endings and not form.only_by_name
    ]
    if not known:
        endings = ", ".join(form.endings[0] for form in EXPORT_FORMATS.values() if not form.only_by_name)
        raise OutputError(f"{path or 'an empty name'} has no known ending: write {endings}")
    if len(known) > 1:
        raise OutputError(f"{path} may be {' or '.join(form.name for form in known)}: name one with --format")
    return known[0]
