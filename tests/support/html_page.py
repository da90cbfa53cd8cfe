"""Tags, attributes and text of an HTML page."""

from __future__ import annotations

from html.parser import HTMLParser

from frictool.documents.provenance import Input, Provenance
from frictool.presentation.page import page_scripts

MADE = Provenance(
    "frictool report run.mcap --spec spec.yaml", "0.1.0", (Input("run.mcap", "ab" * 32),)
)
SVG_NAMESPACES = ("http://www.w3.org/2000/svg", "http://www.w3.org/1999/xlink")


def without_own_scripts(html: str) -> str:
    """Return the page without the two scripts of its frame; any other script stays."""
    for script in page_scripts():
        html = html.replace(f"<script>{script}</script>", "")
    return html


class Page(HTMLParser):
    """Tags, attributes and text of a page, without the scripts of its frame."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.attributes: list[tuple[str, str]] = []
        self.text = ""
        self.open: list[str] = []
        self.feed(without_own_scripts(html))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.attributes += [(name, value or "") for name, value in attrs]

    def handle_data(self, data: str) -> None:
        self.text += data
