"""HTML pages. The template of a command's page is inserted into the common frame, base.html.jinja.

All pages have one style and two scripts, uPlot and explore.js. The scripts turn the figures into
interactive charts. If scripts are disabled, a page shows the static figures. A page loads nothing
from the network; its content security policy permits only these two scripts, by their SHA-256.
"""

from __future__ import annotations

import base64
import hashlib
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import jinja2
from markupsafe import Markup

if TYPE_CHECKING:
    from frictool.documents.provenance import Provenance

FRAME = Path(__file__).parent


def render_page(folder: Path, provenance: Provenance, **texts: Any) -> str:
    """Return the page of the template page.html.jinja in `folder`.

    The same texts give the same bytes. All texts are escaped, except values of type `Markup`. The
    error jinja2.UndefinedError is raised if the template uses a name that is not passed.
    """
    return _page_template(folder).render(provenance=provenance, **_chart_resources(), **texts)


@cache
def _page_template(folder: Path) -> jinja2.Template:
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader([folder, FRAME]),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    return environment.get_template("page.html.jinja")


def _chart_resources() -> dict[str, Any]:
    scripts = page_scripts()
    return {
        "scripts": scripts,
        "script_hashes": [_hash(text) for text in scripts],
        "chart_style": _resource("uplot/uPlot.min.css") + _resource("explore.css"),
        "chart_licence": _resource("uplot/LICENSE"),
    }


def page_scripts() -> list[Markup]:
    """Return the scripts of every page: uPlot, and explore.js, which draws the charts."""
    return [_resource("uplot/uPlot.iife.min.js"), _resource("explore.js")]


@cache
def _resource(name: str) -> Markup:
    return Markup((FRAME / name).read_text(encoding="utf-8"))


def _hash(script: str) -> Markup:
    digest = hashlib.sha256(script.encode()).digest()
    return Markup(f"'sha256-{base64.b64encode(digest).decode()}'")
