"""The writers of the formats: each passes to its format's module what that asks for.

A writer's keywords are the settings that its format heeds (`Settings`). Modules of formats are imported where they
write: the command line names formats in its help, and some formats need what an extra installs.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from hcsearch.basics.errors import HcsearchError

if TYPE_CHECKING:
    from hcsearch.designs.circuit import Circuit
    from hcsearch.designs.folding import Folding
    from hcsearch.export.cutting_sheets import Sheet
    from hcsearch.export.exported import Exported, Profile, SheetKind, State
    from hcsearch.shape.pattern import Pattern


def write_fold(exported: Exported) -> str:
    """Write the crease pattern, the folded states, and the motion where there is one."""
    from hcsearch.export.fold import fold_of

    return fold_of(exported.name, exported.linkage, exported.labels, exported.circuit, exported.replay)


def write_svg(exported: Exported, *, sheet: SheetKind, kerf_mm: float, hinge_gap_mm: float, profile: Profile) -> str:
    """Write the sheet as SVG."""
    from hcsearch.export.svg import svg_of

    return svg_of(_sheet_of(exported, sheet, kerf_mm, hinge_gap_mm, profile), exported.name, profile)


def write_dxf(exported: Exported, *, sheet: SheetKind, kerf_mm: float, hinge_gap_mm: float, profile: Profile) -> str:
    """Write the sheet as DXF."""
    from hcsearch.export.dxf import dxf_of

    return dxf_of(_sheet_of(exported, sheet, kerf_mm, hinge_gap_mm, profile), profile)


def _sheet_of(exported: Exported, sheet: SheetKind, kerf_mm: float, hinge_gap_mm: float, profile: Profile) -> Sheet:
    from hcsearch.export.cutting_sheets import sheet_of

    pattern, labels = exported.linkage.pattern, exported.labels
    return sheet_of(pattern, labels, sheet=sheet, kerf_mm=kerf_mm, hinge_gap_mm=hinge_gap_mm, profile=profile)


def write_animation(exported: Exported) -> str:
    """Write the motion as a moving picture."""
    from hcsearch.export.animation import animation_of

    return animation_of(exported.motion)


def write_csv(exported: Exported) -> str:
    """Write the table of the motion as CSV."""
    from hcsearch.export.motion_tables import csv_of

    return csv_of(exported.motion)


def write_parquet(exported: Exported) -> bytes:
    """Write the table of the motion as Parquet."""
    from hcsearch.export.motion_tables import parquet_of

    return parquet_of(exported.motion)


def write_networkx(exported: Exported) -> str:
    """Write the graph of panels, creases and slits as JSON."""
    from hcsearch.export.graphs import node_link_json

    return node_link_json(exported.name, _array_of(exported))


def write_graph6(exported: Exported) -> bytes:
    """Write the graph of neighbouring panels as graph6."""
    from hcsearch.export.graphs import graph6_of

    return graph6_of(_array_of(exported))


def _array_of(exported: Exported) -> Folding | Circuit | Pattern:
    """Return the folding, else the circuit, else the pattern of an assembly."""
    if exported.folding is not None:
        return exported.folding
    return exported.case.linkage.pattern if exported.circuit is None else exported.circuit


def write_glb(exported: Exported) -> bytes:
    """Write the motion as an animation in glTF."""
    from hcsearch.export.glb import glb_of

    return glb_of(exported.motion)


def write_stl(exported: Exported, *, state: State, part: str | None) -> bytes:
    """Write triangles of all panels in a state, or of one of them."""
    from hcsearch.export.panel_solids import wanted_panels
    from hcsearch.export.stl import stl_of

    panels = wanted_panels(exported.labels, part)
    return stl_of(exported.linkage, exported.angles(state), exported.name, panels)


def write_3mf(exported: Exported, *, state: State, part: str | None) -> bytes:
    """Write objects of all panels in a state, or of one of them."""
    from hcsearch.export.panel_solids import wanted_panels
    from hcsearch.export.threemf import threemf_of

    panels = wanted_panels(exported.labels, part)
    return threemf_of(exported.linkage, exported.labels, exported.angles(state), exported.name, panels)


def write_step(exported: Exported, *, state: State, part: str | None) -> str:
    """Write exact solids of all panels in a state, or of one of them."""
    from hcsearch.export.panel_solids import wanted_panels
    from hcsearch.export.step import step_of

    panels = wanted_panels(exported.labels, part)
    return step_of(exported.linkage, exported.labels, exported.angles(state), exported.name, panels)


def write_mjcf(exported: Exported, *, contact: bool, timestep_s: float | None) -> str:
    """Write the scene as a model of MuJoCo; HcsearchError where drives move it."""
    from hcsearch.export.mjcf import mjcf_of

    case = exported.case
    if case.drives is not None:
        raise HcsearchError("models of MuJoCo are written with springs, not with drives: leave out the table [drive]")
    return mjcf_of(case.linkage, exported.labels, case.setup, exported.name, contact=contact, timestep=timestep_s)


def write_urdf(exported: Exported, *, stem: str) -> Mapping[str, str | bytes]:
    """Write the scene as a tree of links, its closure, and a mesh of each panel."""
    from hcsearch.export.urdf import urdf_of

    case = exported.case
    return urdf_of(case.linkage, exported.labels, case.setup, exported.name, stem)
