"""The description of a named assembly: facts as plain data, compared with published ones, and as texts with units."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from hcsearch.basics.errors import PatternError
from hcsearch.basics.vocabulary import finite_or_none
from hcsearch.library.assemblies.eight_r import measured_slit, skew_symmetric_angles, slit_distance
from hcsearch.library.assemblies.named_assembly import Assembly, Parameters
from hcsearch.library.assemblies.packages import Package, flat_overlap, folded_package
from hcsearch.motion.kinematics.dh import dh_closure_jacobian
from hcsearch.motion.kinematics.numerical_rank import Rank, generic_rank, rank_at
from hcsearch.shape.linkage import Linkage
from hcsearch.shape.pattern import Pattern
from hcsearch.system.terminal import short_number

AssemblyFacts = dict[str, Any]

PRINTED_VALUE_TOLERANCE = 5e-5
"""Relative tolerance for agreement with published values, which have four or five printed digits."""

CLEAR_RANK_NOISE_SHARE = 1e-6
"""Limit of a rank's noise over the ratio of thickness to size, with which small singular values scale."""

_SLIT_STATES = (30, 60, 90, 120, 150)


def describe_assembly(assembly: Assembly, parameters: Parameters) -> AssemblyFacts:
    """Compute all facts of an assembly; lengths in millimetres, angles in degrees, None if undecided or undefined.

    `undecided` gives the reason for each undecided fact. `published` compares the thesis's values with ours.
    """
    pattern = assembly.build(parameters)
    linkage = Linkage(pattern)
    undecided: dict[str, str] = {}
    separate = assembly.separate_hinge_count
    facts: AssemblyFacts = {
        "name": assembly.name,
        "title": assembly.title,
        "source": assembly.source,
        "parameters": stated_parameters(assembly, parameters),
        "panels": len(pattern.panels),
        "panels_by_facets": _sizes(pattern),
        "hinges": len(pattern.hinges),
        "merged_joints": None if separate is None else separate - len(pattern.hinges),
        "loops": len(linkage.loops),
        "loop_lengths": sorted(map(len, linkage.loops)),
        "panels_in_no_loop": _in_no_loop(linkage),
        "held_panel": linkage.base,
        "kutzbach": pattern.kutzbach,
    }
    facts |= _mobility(assembly, parameters, linkage, undecided)
    facts |= _folded(pattern, undecided)
    facts |= _elements(assembly, parameters, linkage)
    facts["undecided"] = undecided
    facts |= _feasibility(assembly, parameters, pattern, facts)
    facts["notes"] = list(assembly.notes)
    facts["published"] = compare_facts(_stated(assembly, parameters), facts)
    return facts


def stated_parameters(assembly: Assembly, parameters: Parameters) -> AssemblyFacts:
    """Return the parameters on which an assembly depends, in millimetres and degrees."""
    units = {"alpha": ("alpha_deg", 180 / math.pi), "size": ("size", None)}
    stated: AssemblyFacts = {}
    for name in assembly.parameter_names:
        key, scale = units.get(name, (f"{name}_mm", 1e3))
        value = getattr(parameters, name)
        if scale is None:
            stated[key] = None if value is None else list(value)
        else:
            stated[key] = float(f"{value * scale:.12g}")  # 70 degrees stay 70
    return stated


def _in_no_loop(linkage: Linkage) -> int:
    """Count the panels on open branches."""
    hinges = [linkage.pattern.hinges[hinge] for loop in linkage.loops for hinge, _ in loop]
    return linkage.n_panels - len({panel for hinge in hinges for panel in (hinge.first, hinge.second)})


def _sizes(pattern: Pattern) -> dict[str, int]:
    """Count the panels by their number of facets."""
    sizes = [len(panel) for panel in pattern.panels]
    return {str(size): sizes.count(size) for size in sorted(set(sizes))}


def _mobility(assembly: Assembly, parameters: Parameters, linkage: Linkage, undecided: dict[str, str]) -> AssemblyFacts:
    """Compute ranks at both ends and at a state between them (thesis appendix), where `dof` is the finite mobility."""
    generic = assembly.generic_angles
    between = generic_rank(linkage) if generic is None else rank_at(linkage, generic(parameters))
    ranks = {"dof": between, "nullity_folded": rank_at(linkage, linkage.folded)}
    ranks["nullity_flat"] = rank_at(linkage, linkage.flat)
    doubts = {name: _doubt(rank, linkage.pattern) for name, rank in ranks.items()}
    doubts["rank_between"] = doubts["overconstrained"] = doubts["dof"]
    undecided |= {name: doubt for name, doubt in doubts.items() if doubt is not None}
    facts: AssemblyFacts = {name: rank.nullity for name, rank in ranks.items()}
    facts["rank_between"] = between.rank
    facts["overconstrained"] = (between.nullity or 0) > linkage.pattern.kutzbach
    facts = {name: None if doubts[name] else value for name, value in facts.items()}
    return facts | {"rank_gap": finite_or_none(between.gap)}


def _doubt(rank: Rank, pattern: Pattern) -> str | None:
    """Return why a rank is undecided, or None: no gap, or noise that may hide singular values of thin panels."""
    if rank.rank is None:
        return f"a singular value lies only {rank.gap:.3g} times above the noise, {rank.noise:.3g}"
    if rank.noise > CLEAR_RANK_NOISE_SHARE * min(1.0, pattern.thickness / pattern.size):
        return f"rounding, {rank.noise:.3g}, may hide singular values: give thicker or less slender panels"
    return None


def _folded(pattern: Pattern, undecided: dict[str, str]) -> AssemblyFacts:
    """Compute the facts of the folded package, in millimetres."""
    names = (
        "deployment_ratio",
        "footprint_area_mm2",
        "package_height_mm",
        "layers",
        "stepped",
        "void_volume_mm3",
        "overlap_volume_mm3",
    )
    try:
        folded: Package = folded_package(pattern)
    except PatternError as error:
        undecided |= dict.fromkeys(names, str(error))
        return {"flat_area_mm2": pattern.area * 1e6, **dict.fromkeys(names)}
    return {
        "flat_area_mm2": folded.flat_area * 1e6,
        "deployment_ratio": folded.whole_ratio or f"{folded.ratio:.6g}:1",
        "footprint_area_mm2": folded.footprint_area * 1e6,
        "package_height_mm": folded.height * 1e3,
        "layers": list(folded.heights),
        "stepped": folded.is_stepped,
        "void_volume_mm3": folded.void_volume * 1e9,
        "overlap_volume_mm3": folded.overlap_volume * 1e9,
    }


def _elements(assembly: Assembly, parameters: Parameters, linkage: Linkage) -> AssemblyFacts:
    """Compute singular values of the D-H closure matrix (thesis A10, A16) and slit distances (5.27) of 8R elements."""
    if not assembly.has_element_loops:
        return {"singular_values": None, "slit": None}
    jacobian = dh_closure_jacobian(linkage, linkage.folded)
    jacobian[3::4] *= 1e3  # every fourth row is a position
    slit = []
    for degrees in _SLIT_STATES:
        first = math.radians(degrees)
        angles = skew_symmetric_angles(linkage.pattern, parameters.alpha, first)
        stated = slit_distance(parameters.alpha, parameters.thickness, first)
        measured = measured_slit(linkage.pattern, angles)
        slit.append({"phi_1_deg": degrees, "stated_mm": stated * 1e3, "measured_mm": measured * 1e3})
    values: list[float] = np.linalg.svd(jacobian, compute_uv=False).tolist()
    return {"singular_values": values, "slit": slit}


def _feasibility(assembly: Assembly, parameters: Parameters, pattern: Pattern, facts: AssemblyFacts) -> AssemblyFacts:
    """Collect known reasons why the panels cannot be placed or moved as required."""
    reasons = [assembly.hindrance(parameters)] if assembly.hindrance else []
    if flat_overlap(pattern):
        reasons.append("panels overlap in the flat state")
    if facts["layers"] is None:
        reasons.append(facts["undecided"]["layers"])
    elif facts["overlap_volume_mm3"]:
        reasons.append("panels share a place in the folded state")
    hindrances = [reason for reason in reasons if reason is not None]
    return {"feasible": not hindrances, "hindrances": hindrances}


def _stated(assembly: Assembly, parameters: Parameters) -> dict[str, object]:
    stated = dict(assembly.published)
    if all(_same(getattr(parameters, name), getattr(assembly.defaults, name)) for name in assembly.parameter_names):
        stated |= assembly.published_at_defaults
    return stated


def _same(first: object, second: object) -> bool:
    """Whether two values of a parameter are equal up to the rounding of degrees and millimetres."""
    if isinstance(first, float) and isinstance(second, float):
        return math.isclose(first, second, rel_tol=1e-12)
    return first == second


def compare_facts(stated: Mapping[str, object], facts: AssemblyFacts) -> AssemblyFacts:
    """Compare published facts with computed ones: do they agree (None if undecided); lists may be published in part."""
    return {
        name: {
            "thesis": list(value) if isinstance(value, tuple) else value,
            "here": facts[name],
            "agree": None if facts[name] is None else _agree(value, facts[name]),
        }
        for name, value in stated.items()
    }


def _agree(stated: object, computed: object) -> bool:
    if isinstance(stated, Sequence) and not isinstance(stated, str):
        return isinstance(computed, Sequence) and all(map(_agree, stated, computed)) and len(computed) >= len(stated)
    if isinstance(stated, float) and isinstance(computed, int | float):
        return abs(stated - computed) <= PRINTED_VALUE_TOLERANCE * abs(stated)
    return stated == computed


_UNITS = {"_mm": "mm", "_mm2": "mm2", "_mm3": "mm3", "_deg": "degrees"}
_APART = {"published", "undecided", "notes", "slit", "hindrances"}
"""Facts that have lines of their own."""


def fact_rows(facts: AssemblyFacts) -> Iterator[tuple[str, str]]:
    """Yield the name and the value of each fact, with reasons for undecided ones, but without the thesis's values."""
    for name, value in facts.items():
        if name in _APART or (value is None and name not in facts["undecided"]):
            continue  # without a reason, the fact is not about this assembly
        label, unit = _label(name)
        yield label, f"undecided: {facts['undecided'][name]}" if value is None else f"{fact_text(value)}{unit}"
    for reason in facts["hindrances"]:
        yield "", reason
    for row in facts["slit"] or ():
        yield (
            "slit distance",
            f"{row['measured_mm']:.6g} mm at phi_1 = {row['phi_1_deg']} degrees, {row['stated_mm']:.6g} mm by eq. 5.27",
        )


def published_rows(facts: AssemblyFacts) -> Iterator[tuple[str, str, str]]:
    """Yield the name and the value of each fact that the thesis states, and whether ours agrees."""
    for name, row in facts["published"].items():
        label, unit = _label(name)
        yield (
            label,
            f"{fact_text(row['thesis'])}{unit}",
            {True: "agrees", False: "DIFFERS", None: "undecided"}[row["agree"]],
        )


def fact_lines(facts: AssemblyFacts) -> Iterator[str]:
    """Yield the facts, one a line, then the statements of the thesis and the notes."""
    rows = [*fact_rows(facts)]
    rows += [("the thesis", f"{label} {text}: {verdict}") for label, text, verdict in published_rows(facts)]
    rows += [("note", note) for note in facts["notes"]]
    yield from (f"{label:21}{text}" for label, text in rows)


def fact_text(value: object) -> str:
    """Return a value as text: lists with spaces, named values with units."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return short_number(value, 6)
    if isinstance(value, list | tuple):
        return " ".join(map(fact_text, value))
    if isinstance(value, dict):
        return ", ".join(_named(name, part) for name, part in value.items())
    return str(value)


def _named(name: str, value: object) -> str:
    """Return a named value of several: a size, a number of panels with so many facets, or a length or an angle."""
    if name == "size":
        return f"size {value[0]}x{value[1]}" if isinstance(value, list | tuple) else "size any"
    if name.isdigit():
        return f"{value} of {name}"
    label, unit = _label(name)
    return f"{label} {fact_text(value)}{unit}"


def _label(name: str) -> tuple[str, str]:
    """Return the name of a fact in words, and its unit."""
    for ending, unit in _UNITS.items():
        if name.endswith(ending):
            return name.removesuffix(ending).replace("_", " "), f" {unit}"
    return name.replace("_", " "), ""
