"""STEP (ISO 10303-21, AP214): an exact solid for each panel, in an assembly in one state; millimetres.

Panels are prisms, which planes, lines and points describe exactly. Each is a separate product, named as in `Labels`,
with the axes of the flat state; its placement in the assembly gives the state.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.export.panel_solids import MILLIMETRES_PER_METRE, PanelSolid, panel_solid_of
from hcsearch.shape.labels import Labels
from hcsearch.shape.linkage import Linkage

_HEAD = """ISO-10303-21;
HEADER;
FILE_DESCRIPTION(('panels of a folding array'),'2;1');
FILE_NAME({title},'',(''),(''),'hcsearch','hcsearch','');
FILE_SCHEMA(('AUTOMOTIVE_DESIGN {{ 1 0 10303 214 1 1 1 1 }}'));
ENDSEC;
DATA;
"""
_X, _Z = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])


def step_of(
    linkage: Linkage, labels: Labels, angles: Reals, title: str = "", panels: Sequence[int] | None = None
) -> str:
    """Return an assembly of panels (all unless given) at fold angles (n_hinges,), rad; for a single panel, a part."""
    data = _Data()
    poses = linkage.poses(angles)
    chosen = range(linkage.n_panels) if panels is None else panels
    parts = []
    for panel in chosen:
        name = f"panel {labels.panels[panel]}"
        parts.append((name, panel, data.part(name, panel_solid_of(linkage.pattern, panel))))
    if panels is None or len(panels) > 1:
        axes = data.axes(np.zeros(3), _Z, _X)
        places = [data.placement(poses[panel]) for _, panel, _ in parts]
        shape = data.add(f"SHAPE_REPRESENTATION({_text(title)},{_listed([axes, *places])},{data.context})")
        whole = data.product(title, shape)
        for (name, _, part), place in zip(parts, places, strict=True):
            data.place(name, part, (whole, shape), place)
    return _HEAD.format(title=_text(title)) + "\n".join(data.lines) + "\nENDSEC;\nEND-ISO-10303-21;\n"


StepPart = tuple[str, str, str]
"""Entity names of a part: definition, representation, and axes in the representation."""


class _Data:
    """The data section under construction; entities are named by their numbers, such as `#12`."""

    def __init__(self) -> None:
        self.lines: list[str] = []
        application = self.add("APPLICATION_CONTEXT('core data for automotive mechanical design processes')")
        self.add(f"APPLICATION_PROTOCOL_DEFINITION('international standard','automotive_design',2000,{application})")
        self.products = self.add(f"PRODUCT_CONTEXT('',{application},'mechanical')")
        self.definitions = self.add(f"PRODUCT_DEFINITION_CONTEXT('part definition',{application},'design')")
        length = self.add("(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.))")
        angle = self.add("(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.))")
        solid = self.add("(NAMED_UNIT(*)SI_UNIT($,.STERADIAN.)SOLID_ANGLE_UNIT())")
        accuracy = self.add(
            f"UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE(1.E-07),{length},'distance_accuracy_value','')"
        )
        self.context = self.add(
            f"(GEOMETRIC_REPRESENTATION_CONTEXT(3)GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT(({accuracy}))"
            f"GLOBAL_UNIT_ASSIGNED_CONTEXT(({length},{angle},{solid}))REPRESENTATION_CONTEXT('','3D'))"
        )

    def add(self, entity: str) -> str:
        """Append an entity, and return its name."""
        self.lines.append(f"#{len(self.lines) + 1}={entity};")
        return f"#{len(self.lines)}"

    def product(self, name: str, shape: str) -> str:
        """Add a product with its representation, and return the name of its definition."""
        product = self.add(f"PRODUCT({_text(name)},{_text(name)},'',({self.products}))")
        self.add(f"PRODUCT_RELATED_PRODUCT_CATEGORY('part',$,({product}))")
        formation = self.add(f"PRODUCT_DEFINITION_FORMATION('','',{product})")
        definition = self.add(f"PRODUCT_DEFINITION('design','',{formation},{self.definitions})")
        shape_definition = self.add(f"PRODUCT_DEFINITION_SHAPE('','',{definition})")
        self.add(f"SHAPE_DEFINITION_REPRESENTATION({shape_definition},{shape})")
        return definition

    def part(self, name: str, solid: PanelSolid) -> StepPart:
        """Add a panel as a product."""
        axes = self.axes(np.zeros(3), _Z, _X)
        body = self.add(f"MANIFOLD_SOLID_BREP({_text(name)},{_shell(self, solid)})")
        shape = self.add(f"ADVANCED_BREP_SHAPE_REPRESENTATION({_text(name)},({axes},{body}),{self.context})")
        return self.product(name, shape), shape, axes

    def place(self, name: str, part: StepPart, whole: tuple[str, str], place: str) -> None:
        """Place a part in the assembly.

        whole : definition and shape of the assembly. place : axes of the part there.
        """
        definition, shape, axes = part
        use = self.add(f"NEXT_ASSEMBLY_USAGE_OCCURRENCE({_text(name)},{_text(name)},'',{whole[0]},{definition},$)")
        used = self.add(f"PRODUCT_DEFINITION_SHAPE('','',{use})")
        moved = self.add(f"ITEM_DEFINED_TRANSFORMATION('','',{axes},{place})")
        relation = self.add(
            f"(REPRESENTATION_RELATIONSHIP('','',{shape},{whole[1]})"
            f"REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION({moved})SHAPE_REPRESENTATION_RELATIONSHIP())"
        )
        self.add(f"CONTEXT_DEPENDENT_SHAPE_REPRESENTATION({relation},{used})")

    def placement(self, pose: Reals) -> str:
        """Add the axes of the flat state transformed by a pose (3, 4)."""
        return self.axes(MILLIMETRES_PER_METRE * pose[:, 3], pose[:, 2], pose[:, 0])

    def axes(self, origin: Reals, z: Reals, x: Reals) -> str:
        """Add axes with an origin (mm) and the directions of z and x."""
        return self.add(f"AXIS2_PLACEMENT_3D('',{self.point(origin)},{self.direction(z)},{self.direction(x)})")

    def point(self, position: Reals) -> str:
        """Add a point, mm."""
        return self.add(f"CARTESIAN_POINT('',{_numbers(position)})")

    def direction(self, vector: Reals) -> str:
        """Add a unit vector."""
        return self.add(f"DIRECTION('',{_numbers(vector)})")


def _shell(data: _Data, solid: PanelSolid) -> str:
    """Add the closed shell of a panel: bottom and top within its outlines, and a wall at each of their edges."""
    vertices, n = MILLIMETRES_PER_METRE * solid.vertices, len(solid.points)
    used = sorted(set(solid.wall.ravel().tolist()))
    corners = [*used, *(k + n for k in used)]
    points = {k: data.add(f"VERTEX_POINT('',{data.point(vertices[k])})") for k in corners}
    edges: dict[tuple[int, int], str] = {}

    def edge(a: int, b: int) -> str:
        """Add an oriented edge between two corners; the edge curve is shared by both directions."""
        if (b, a) in edges:
            return data.add(f"ORIENTED_EDGE('',*,*,{edges[b, a]},.F.)")
        if (a, b) not in edges:
            difference = vertices[b] - vertices[a]
            vector = data.add(f"VECTOR('',{data.direction(difference / np.linalg.norm(difference))},1.)")
            line = data.add(f"LINE('',{data.point(vertices[a])},{vector})")
            edges[a, b] = data.add(f"EDGE_CURVE('',{points[a]},{points[b]},{line},.T.)")
        return data.add(f"ORIENTED_EDGE('',*,*,{edges[a, b]},.T.)")

    def face(walks: Sequence[Sequence[int]], normal: Reals, along: Reals) -> str:
        """Add a plane face bounded by closed walks of corners, the outer one first."""
        bounds = []
        for k, walk in enumerate(walks):
            loop = data.add(f"EDGE_LOOP('',{_listed(edge(a, b) for a, b in _around(walk))})")
            bounds.append(data.add(f"{'FACE_BOUND' if k else 'FACE_OUTER_BOUND'}('',{loop},.T.)"))
        plane = data.add(f"PLANE('',{data.axes(vertices[walks[0][0]], normal, along)})")
        return data.add(f"ADVANCED_FACE('',{_listed(bounds)},{plane},.T.)")

    walks = solid.outlines
    faces = [face([walk[::-1] for walk in walks], -_Z, _X), face([[k + n for k in walk] for walk in walks], _Z, _X)]
    for a, b in solid.wall.tolist():
        along = vertices[b] - vertices[a]
        along /= np.linalg.norm(along)
        faces.append(face([(a, b, b + n, a + n)], np.cross(along, _Z), along))
    return data.add(f"CLOSED_SHELL('',{_listed(faces)})")


def _around(walk: Sequence[int]) -> Iterable[tuple[int, int]]:
    return zip(walk, (*walk[1:], walk[0]), strict=True)


def _listed(names: Iterable[str]) -> str:
    return f"({','.join(names)})"


def _numbers(values: Reals) -> str:
    return _listed(map(_real, values.tolist()))


def _real(value: float) -> str:
    """Format a number with the decimal point that STEP requires: 1.E-07."""
    mantissa, exponent, power = repr(value).upper().partition("E")
    return (mantissa if "." in mantissa else mantissa + ".") + exponent + power


def _text(words: str) -> str:
    """Format a string; characters outside ASCII become question marks."""
    plain = words.encode("ascii", "replace").decode()
    return "'" + plain.replace("\\", "\\\\").replace("'", "''") + "'"
