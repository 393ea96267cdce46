"""The list of assemblies, with their flat patterns."""

from __future__ import annotations

from functools import cache

from markupsafe import Markup

from hcsearch.library.assemblies import ASSEMBLIES, Assembly
from hcsearch.shape.pattern_drawing import draw_pattern
from hcsearch.subjects.linkage_cases import parameters_of
from hcsearch.web.serve.template_pages import render_page


@cache
def render_assembly_list() -> str:
    """Return the HTML page that lists the assemblies with their default sizes."""
    return render_page("assemblies.html", assemblies=[(one, _picture(one)) for one in ASSEMBLIES.values()])


def _picture(assembly: Assembly) -> Markup:
    pattern = assembly.build(parameters_of(assembly, {}))
    # Trusted: integers and fixed words, and a title that `draw_pattern` escapes.
    return Markup(draw_pattern(pattern, assembly.title, standalone=False))
