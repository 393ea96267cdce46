"""Describe the named assemblies of the thesis."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from hcsearch.api.kinds import check_kinds
from hcsearch.library.assemblies import ASSEMBLIES, description
from hcsearch.shape.pattern_drawing import draw_pattern
from hcsearch.subjects.linkage_cases import assembly_named, parameters_of


def describe(name: str, **parameters: Any) -> dict[str, Any]:
    """Describe an assembly of the thesis as plain data, as `hcsearch assembly --json` prints it.

    Parameters
    ----------
    name
        The name of the assembly.
    **parameters
        `alpha` in degrees, `base`, `thickness`, `side` and `width` in millimetres, and `size` as columns x rows, such
        as `3x2`; those that the assembly does not depend on are refused.

    Returns
    -------
    dict
        Plain data, which JSON can hold.
    """
    check_kinds(describe, locals())
    assembly = assembly_named(name)
    return description.describe_assembly(assembly, parameters_of(assembly, parameters))


def draw_assembly(name: str, parameters: Mapping[str, Any]) -> str:
    """Draw the flat pattern of an assembly as SVG; parameters : as in `describe`."""
    assembly = assembly_named(name)
    return draw_pattern(assembly.build(parameters_of(assembly, parameters)), assembly.title)


def list_assemblies() -> list[dict[str, Any]]:
    """List the assemblies as plain data, with their sources and default sizes."""
    return [
        {
            "name": assembly.name,
            "title": assembly.title,
            "source": assembly.source,
            "parameters": description.stated_parameters(assembly, assembly.defaults),
        }
        for assembly in ASSEMBLIES.values()
    ]
