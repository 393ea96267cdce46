"""One self-contained HTML page of the designs that a query selects. The only home of Jinja2."""

from hcsearch.report.data import ReportData, Stage
from hcsearch.report.page import render

__all__ = ["ReportData", "Stage", "render", "write_report"]


def __getattr__(name: str) -> object:
    # Looked up on first use: rendering needs no database.
    if name == "write_report":
        from hcsearch.report.writing import write_report  # noqa: PLC0415

        return write_report
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
