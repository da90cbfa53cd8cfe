"""A controller as C99: header, source, golden vectors, self-test. Templates of the blocks lie beside their kernels in `control/`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import jinja2

import frictool.control
from frictool import __version__
from frictool.control import cascade
from frictool.control.packing import pack
from frictool.documents.controller import Controller
from frictool.documents.quantity import si_unit
from frictool.export.identifier import c_identifier, comment_text
from frictool.export.vectors import GoldenVectors

FILES = {
    "{}.h": "controller.h.jinja",
    "{}.c": "controller.c.jinja",
    "{}_vectors.h": "vectors.h.jinja",
    "{}_selftest.c": "selftest.c.jinja",
}
FOLDERS = (Path(__file__).parent / "templates", Path(frictool.control.__file__).parent)


def c_sources(controller: Controller, vectors: GoldenVectors, sha256: str, command: str) -> dict[str, str]:
    """File name -> text. `sha256` is the digest of the controller document, `command` the command line for the provenance."""
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(FOLDERS), undefined=jinja2.StrictUndefined, keep_trailing_newline=True, autoescape=False
    )
    context = _context(controller) | {
        "vectors": vectors,
        "sha256": sha256,
        "command": comment_text(command),
        "version": __version__,
    }
    return {
        file.format(context["id"]): environment.get_template(template).render(context).rstrip("\n") + "\n"
        for file, template in FILES.items()
    }


def _context(controller: Controller) -> dict[str, Any]:
    """What the templates know: the packed parameters by their places (`p`, `number`, `numbers`), which blocks there are, the units."""
    parameters = pack(controller)
    name = c_identifier(controller.name)
    brakes = controller.position_law.action == "brake"
    prefilters = controller.prefilter is not None
    blocks = [
        "prefilter" if prefilters else None,
        "speed_filter" if brakes else None,
        "position_law",
        "band",
        "speed_integral",
        "difference_equation",
        "limiter",
        "cascade",
    ]
    return {
        "id": name,
        "ID": name.upper(),
        "name": comment_text(controller.name),
        "p": cascade,
        "number": lambda place: literal(float(parameters[place])),
        "numbers": lambda place, count: ", ".join(literal(float(value)) for value in parameters[place : place + count]),
        "order": int(parameters[cascade.ORDER]),
        "brakes": brakes,
        "prefilters": prefilters,
        "formula": controller.position_law.formula,
        "blocks": [f"{block}.c.jinja" for block in blocks if block],
        "drive": controller.drive,
        "drive_unit": si_unit(controller.drive, controller.axis),
        "position_unit": si_unit("position", controller.axis),
        "delay_samples": controller.delay_samples,
    }


def literal(value: float) -> str:
    """A double as C writes it, with the fewest digits (17 at most) that give back every bit.

    >>> literal(0.1), literal(1e-05), literal(50.0)
    ('0.1', '1e-05', '50.0')
    """
    return repr(value)
