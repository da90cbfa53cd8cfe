"""Tags, attributes and text of an HTML page."""

from __future__ import annotations

from html.parser import HTMLParser

from frictool.documents.provenance import Input, Provenance

MADE = Provenance(
    "frictool report run.mcap --spec spec.yaml", "0.1.0", (Input("run.mcap", "ab" * 32),)
)
SVG_NAMESPACES = ("http://www.w3.org/2000/svg", "http://www.w3.org/1999/xlink")


class Page(HTMLParser):
    """Tags, attributes and text of a page."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.attributes: list[tuple[str, str]] = []
        self.text = ""
        self.open: list[str] = []
        self.feed(html)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.attributes += [(name, value or "") for name, value in attrs]

    def handle_data(self, data: str) -> None:
        self.text += data
