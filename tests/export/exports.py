"""What tests of exports share: values that writers take, and strategies for them."""

from functools import cache

from hypothesis import strategies as st

from hcsearch.basics.errors import InputFileError
from hcsearch.designs.folding import foldings
from hcsearch.export.cutting_sheets import CuttingSheet, cutting_sheet_of
from hcsearch.export.export_files import exported_case
from hcsearch.export.exported import Exported
from hcsearch.export.formats import EXPORT_FORMATS, WrittenFiles
from hcsearch.export.settings import ExportSettings
from hcsearch.shape.pattern import RIGID_CREASE, Crease, Pattern
from hcsearch.subjects.resolve import resolve
from tests.strategies import circuits

DESIGN = "hex:0234435011:1"
MOVING = "hex:0234550132:4"
"""A folding with a path that is planned in no time."""
SLITTED = "square:012233230011:0"
RING = "square:011122233300:0"
"""Squares around a hole of two by two."""


@cache
def exported(name: str, wanted: str = "fold", by: str | None = None, state="flat", **request) -> Exported:
    case = resolve(name, "none.sqlite", path=by == "path", **request)
    return exported_case(case, EXPORT_FORMATS[wanted], by, state)


def written(value: Exported, wanted: str = "fold", settings: ExportSettings = ExportSettings()) -> WrittenFiles:  # noqa: B008 - frozen
    return EXPORT_FORMATS[wanted].write(value, settings)


def sheet_for(value: Exported, settings: ExportSettings) -> CuttingSheet:
    names = EXPORT_FORMATS["svg"].setting_names
    return cutting_sheet_of(value.linkage.pattern, value.labels, **{name: getattr(settings, name) for name in names})


def pattern_of(drawing, thickness=None):
    """The pattern of thick panels (m) that a drawing shows; flat creases are rigid unless they carry a hinge's face."""
    unit = 1.0 if drawing.unit is None else drawing.unit
    creases = {}
    for pair, join in drawing.joins.items():
        if join.assignment == "U":
            raise InputFileError(f"the edge between facets {pair[0]} and {pair[1]} is unassigned: write M, V, F or C")
        if join.assignment == "F":
            creases[pair] = RIGID_CREASE if join.face is None else Crease(join.face, closes=False)
        else:
            creases[pair] = Crease("top" if join.assignment == "V" else "bottom")
    facets = tuple(tuple((unit * x, unit * y) for x, y in facet) for facet in drawing.facets)
    return Pattern.from_polygons(facets, creases, thickness or unit * drawing.thickness, drawing.loops)


@st.composite
def folded(draw: st.DrawFn) -> Exported:
    """A folding of a circuit of any grid, with its flat pairs joined in any way."""
    circuit = draw(circuits(even=True).filter(foldings))
    folding = draw(st.sampled_from(foldings(circuit)))
    way = draw(st.sampled_from(("rigid", "hinged", *(("merged",) if folding.mirror_pairs else ()))))
    return exported_case(resolve(folding.notation, "none.sqlite", flat_pairs=way), EXPORT_FORMATS["fold"])
