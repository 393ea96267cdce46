"""Files of users that are named in place of a design: their drawing as a design, or as a pattern of any panels."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from hcsearch.basics.errors import HcsearchError, InputFileError, PatternError
from hcsearch.system.terminal import write_notice

if TYPE_CHECKING:
    from hcsearch.search.own_patterns.fold_reading import PatternDrawing
    from hcsearch.search.own_patterns.packed_states import PackedPattern
    from hcsearch.search.own_patterns.recognition import RecognisedDesign

MODEL_SUFFIXES = (".urdf", ".xml", ".mjcf")
"""Endings of models of mechanisms."""
DRAWING_SUFFIXES = (".fold", ".cp", ".opx", ".svg")
"""Endings of drawings of crease patterns."""
PATTERN_SUFFIXES = (*DRAWING_SUFFIXES, *MODEL_SUFFIXES)
"""Endings of files that hold a pattern."""


_OTHER_FILES = {
    (".dxf", ".dwg", ".eps", ".ai", ".pdf"): ("a drawing whose lines have no folds", "draw it as a crease pattern"),
    (".stl", ".3mf", ".step", ".stp", ".glb", ".gltf", ".obj", ".ply"): (
        "solids or meshes without hinges", "draw the flat crease pattern"
    ),
    (".orh", ".ori", ".orihimex"): ("a file of Orihime or Oriedita", "export it there"),
    (".png", ".jpg", ".jpeg", ".webp", ".gif"): ("a picture", "draw it as a crease pattern"),
    (".json", ".csv", ".parquet", ".txt"): ("a table or data", "name the design, or draw the crease pattern"),
    (".gz", ".svgz", ".zip", ".bz2", ".xz", ".zst", ".7z"): (
        "a compressed file", "unpack it first, and name what it holds"
    ),
}  # fmt: skip
"""What users may take for patterns: by endings, what it is, and how it becomes a pattern."""


def is_pattern_file(name: str) -> bool:
    """Whether a name is that of a file that holds a pattern."""
    return name.lower().endswith(PATTERN_SUFFIXES)


def refuse_other_file(name: str) -> None:
    """Refuse the name of a file that holds no pattern by its ending: InputFileError with the way to a pattern."""
    for suffixes, (what, remedy) in _OTHER_FILES.items():
        if name.lower().endswith(suffixes):
            raise InputFileError(f"{name} is no crease pattern but {what}: {remedy}, as .fold, .cp or a coloured .svg")


@dataclass(frozen=True)
class DrawnPattern:
    """A pattern of a file that is no design.

    path : of the file. panel : the size that was asked for, as of `pattern_of_drawing`; None for that of the file.
    no_design : why it is taken as no design, as a clause after its name.
    """

    path: str
    panel: str | None
    packed: PackedPattern
    no_design: str


@dataclass(frozen=True)
class DrawnDesign:
    """A design with foldings that a file draws; panel : the size that was asked for, else that of the file, or None."""

    path: str
    panel: str | None
    design: RecognisedDesign


def read_pattern_file(path: str, panel: str | None = None) -> DrawnDesign | DrawnPattern:
    """Read a file as a design, or else as a pattern of any panels.

    panel : as of `--panel`. InputFileError for a file that holds no flat pattern, PatternError as of `pack_drawing`.
    """
    from hcsearch.search.own_patterns.drawn_linkages import states_between_stops  # noqa: PLC0415
    from hcsearch.search.own_patterns.recognition import drawn_panel_size, recognise_design  # noqa: PLC0415

    drawing = _read_drawing(path)
    for remark in drawing.remarks:
        write_notice(f"{path}: {remark}")
    if path.lower().endswith(MODEL_SUFFIXES):
        why = "is no design of a grid, as it is the model of a mechanism"
        return DrawnPattern(path, panel, _packed(path, drawing, panel), why)
    try:
        design = recognise_design(drawing)
    except PatternError as error:
        why, _, _ = str(error).partition(": ")  # without the remedy
        return DrawnPattern(path, panel, _packed(path, drawing, panel), f"is no design of a grid, as {why}")
    notation = design.circuit.notation
    if not design.creases:
        why = f"is taken as a linkage, as {notation} has no two-stack folding"
        return DrawnPattern(path, panel, _packed(path, drawing, panel), why)
    if states_between_stops(drawing):
        packed = _packed(path, drawing, panel)
        if packed.packed:
            why = f"is taken as a linkage, as it states {notation} between the stops of its hinges"
            return DrawnPattern(path, panel, packed, why)
        fault = packed.sentence.removeprefix("no packed state is known: ")
        write_notice(f"{path}: {fault}; the design is checked from its packed states")
    return DrawnDesign(path, drawn_panel_size(design, drawing) if panel is None else panel, design)


def _read_drawing(path: str) -> PatternDrawing:
    """Return the drawing in a file, read by its ending."""
    from hcsearch.search.own_patterns.fold_reading import read_fold  # noqa: PLC0415 - most commands read no such file
    from hcsearch.search.own_patterns.line_drawings import read_cp, read_opx  # noqa: PLC0415
    from hcsearch.search.own_patterns.robot_models import read_model  # noqa: PLC0415
    from hcsearch.search.own_patterns.svg_drawings import read_svg  # noqa: PLC0415

    readers = {".fold": read_fold, ".cp": read_cp, ".opx": read_opx, ".svg": read_svg}
    return readers.get(Path(path).suffix.lower(), read_model)(path)


def _packed(path: str, drawing: PatternDrawing, panel: str | None) -> PackedPattern:
    """Return the pattern of a drawing in its packed state; the errors of `pack_drawing` with the file's name."""
    from hcsearch.search.own_patterns.packed_states import pack_drawing  # noqa: PLC0415 - loads kernels

    try:
        return pack_drawing(drawing, panel)
    except PatternError as error:
        raise PatternError(f"{path}: {error}") from None


def only_drawn_folding(drawn: DrawnDesign) -> str:
    """Return the notation of the folding that a file draws; HcsearchError where it draws several."""
    foldings = [folding.notation for folding in drawn.design.foldings]
    if len(foldings) != 1:
        raise HcsearchError(
            f"{drawn.path} is the design {drawn.design.circuit.notation}, which has the foldings "
            f"{', '.join(foldings)}: name one of these, or assign mountains and valleys"
        )
    return foldings[0]
