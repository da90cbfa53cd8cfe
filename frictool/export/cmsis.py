"""Linear controller as arrays for CMSIS-DSP's biquads, in one header.

The controller's other blocks are in the exported C only.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import jinja2
import msgspec

from frictool import __version__
from frictool.adapters.controller_composition import controller_program
from frictool.control.coefficient_words import BITS
from frictool.control.fixed_point import fixed_program
from frictool.documents.controller import Controller, LinearController, Number
from frictool.documents.quantity import si_unit
from frictool.errors import NoSolutionError
from frictool.export.biquads import Biquads, fixed_biquads, float_biquads
from frictool.export.c_identifier import c_identifier, comment_text
from frictool.export.c_real_numbers import RealNumbers
from frictool.export.encoder_reading import reading_notes
from frictool.export.encoder_wrap import encoder_wrap
from frictool.export.export_origin import ExportOrigin

FOLDER = Path(__file__).parent / "templates"
KINDS = {"float": "float", "q31": "int32_t", "q15": "int16_t"}


@dataclass(frozen=True)
class CmsisArrays:
    """Biquad stages, and the linear controller with the rounded coefficients of these stages."""

    biquads: Biquads
    linear: LinearController


def cmsis_arrays(controller: Controller, number: Number) -> CmsisArrays:
    """Return the biquads of a controller.

    Raises NoSolutionError if the controller is scheduled, if it has no second-order sections, or if
    the number format cannot represent the sections. Raises FixedPointOverflow if the input of the
    sections has no bound.
    """
    linear = controller.linear
    if controller.schedule is not None:
        raise NoSolutionError(
            f"{controller.name}: scheduled coefficients are not constant arrays; use --lang c"
        )
    if not linear.sos:
        raise NoSolutionError(
            f"{controller.name}: the document contains no second-order sections; use --lang c"
        )
    if number == "float":
        biquads = float_biquads(linear.sos)
    else:
        biquads = fixed_biquads(controller.name, linear.sos, number, _entering(controller, number))
    runs = biquads.sections(number)
    return CmsisArrays(biquads, _as_sections(linear, runs))


def _as_sections(
    linear: LinearController, sections: tuple[tuple[float, ...], ...]
) -> LinearController:
    return msgspec.structs.replace(
        linear,
        form="sos",
        sos=sections,
        sos_anti_windup=(0.0,) * (2 * len(sections)),
        conditional=False,
    )


def _entering(controller: Controller, number: Number) -> float:
    program = controller_program(controller)
    scaled = fixed_program(program, BITS[number])
    indices = {name: index for index, name in program.names.items()}
    entry = indices[_signal(controller)]
    return math.ldexp(max(map(abs, scaled.words[entry])), -scaled.fractions[entry])


def _signal(controller: Controller) -> str:
    if controller.structure == "position":
        return "error"
    return "eta" if controller.linear.input == "eta" else "speed_error"


def cmsis_header(
    controller: Controller, number: Number, arrays: CmsisArrays, margin: float, origin: ExportOrigin
) -> dict[str, str]:
    """Return the text of the header, by its file name."""
    name = c_identifier(controller.name)
    biquads = arrays.biquads
    values = RealNumbers("float").literal if number == "float" else str
    padded = [
        [*stage[:1], 0, *stage[1:]] if number == "q15" else list(stage) for stage in biquads.stages
    ]
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(FOLDER), undefined=jinja2.StrictUndefined, autoescape=False
    )
    environment.globals["comment"] = comment_text
    position = si_unit("position", controller.axis)
    drive = si_unit(controller.drive, controller.axis)
    signals = {
        "error": f"filtered reference - position, {position}",
        "eta": f"integral(speed reference) - position, {position}",
        "speed_error": f"speed reference - speed, {si_unit('velocity', controller.axis)}",
    }
    text = environment.get_template("cmsis.h.jinja").render(
        id=name,
        ID=name.upper(),
        controller=controller,
        number=number,
        kind=KINDS[number],
        rows=[[values(value) for value in stage] for stage in padded],
        found=biquads,
        bits=BITS.get(number, 0),
        step=math.ldexp(biquads.output_scale, -BITS[number]) if number in BITS else 0.0,
        margin=margin,
        signal=signals[_signal(controller)],
        drive_unit=drive,
        wrap=encoder_wrap(controller),
        notes=reading_notes(controller),
        origin=origin,
        version=__version__,
    )
    return {f"{name}_cmsis.h": text.rstrip("\n") + "\n"}
