"""Self-contained HTML pages: of the designs that a query selects, and of one design. The only home of Jinja2."""

from hcsearch.report.data import FunnelStage, ReportData
from hcsearch.report.page import render
from hcsearch.report.writing import write_design, write_report

__all__ = ["FunnelStage", "ReportData", "render", "write_design", "write_report"]
