"""HTML pages from the template of a stage inside the common frame, base.html.jinja.

All pages have one style. They contain no script and load nothing from the network.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import jinja2

if TYPE_CHECKING:
    from frictool.documents.provenance import Provenance

FRAME = Path(__file__).parent


def render_page(folder: Path, provenance: Provenance, **texts: Any) -> str:
    """Render the template page.html.jinja in `folder`; the same texts give the same bytes.

    All texts are escaped, except values of type `Markup`. Raises jinja2.UndefinedError if the
    template uses a name that is not passed.
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
