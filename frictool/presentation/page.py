"""A page of HTML from a stage's template and the frame of all pages, base.html.jinja: one style, no
script, no request to anywhere."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import jinja2

if TYPE_CHECKING:
    from frictool.documents.provenance import Provenance

FRAME = Path(__file__).parent


def render_page(folder: Path, provenance: Provenance, **texts: Any) -> str:
    """The HTML text of the template page.html.jinja in `folder`; the same texts give the same
    bytes.

    Every text is escaped but what is `Markup`. Raises jinja2.UndefinedError where the template
    names what is not given.
    """
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader([folder, FRAME]),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    return environment.get_template("page.html.jinja").render(provenance=provenance, **texts)
