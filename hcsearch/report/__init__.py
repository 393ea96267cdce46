"""One self-contained HTML page of the designs that a query selects. The only home of Jinja2."""

from hcsearch.report.data import ReportData, Stage
from hcsearch.report.page import render
from hcsearch.report.writing import write_report

__all__ = ["ReportData", "Stage", "render", "write_report"]
