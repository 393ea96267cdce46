"""Pages as readers of HTML see them, and the data that they hold for their scripts."""

import json
import re
from html.parser import HTMLParser

from hcsearch.subjects.resolve import resolve
from hcsearch.web.report.design_data import fetch_design_data

VOID = {"meta", "input", "path", "circle"}


class Page(HTMLParser):
    """The elements and texts of a page; fails on tags that do not match."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self.texts: list[tuple[str, str]] = []
        self.open: list[str] = []
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if data.strip():
            self.texts.append((self.open[-1], data.strip()))

    def with_class(self, name: str) -> list[dict[str, str | None]]:
        return [attrs for _, attrs in self.elements if name in (attrs.get("class") or "").split()]

    def count(self, tag: str) -> int:
        return sum(element == tag for element, _ in self.elements)


def data_of(page: str) -> dict:
    """The data for the page's script."""
    return json.loads(re.search(r'<script type="application/json" id="data">(.*?)</script>', page, re.DOTALL)[1])


def unpacked(column, count: int) -> list:
    """A column as `unpack` of table.js reads it."""
    if isinstance(column, list):
        return column
    return [column["words"][at] for at in column["at"]] if "words" in column else [column["all"]] * count


def column(data: dict, table: str, name: str) -> list:
    return unpacked(data[table][name], data["count" if table == "designs" else "folding_count"])


def computed_data(folding):
    """The data of a page on one folding that no database holds."""
    return fetch_design_data(resolve(folding, "none.sqlite").shown())
