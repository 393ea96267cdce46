"""Self-contained HTML pages: of the designs that a query selects, and of one design. The home of Jinja2."""

from __future__ import annotations

from hcsearch.system.lazy import importing

TYPE_CHECKING = False
if TYPE_CHECKING:
    from hcsearch.report.data import FunnelStage, ReportData
    from hcsearch.report.page import render
    from hcsearch.report.writing import write_design, write_report

_HOMES = {
    "data": ("FunnelStage", "ReportData"),
    "page": ("render",),
    "writing": ("write_design", "write_report"),
}

__all__ = ["FunnelStage", "ReportData", "render", "write_design", "write_report"]

__getattr__ = importing(__name__, _HOMES)
