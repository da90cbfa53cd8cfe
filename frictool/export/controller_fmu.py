"""Controller as a Functional Mock-up Unit, with `NAME.c` and `NAME.h` of `--lang c` as sources.

The unit executes one sample per period. The drive at the end of a communication step is computed
from the inputs at the start of the step. The drive therefore acts one period after the measurement.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from frictool.control.program import Program
from frictool.documents.controller import Controller, Number
from frictool.documents.quantity import si_unit
from frictool.errors import NoSolutionError
from frictool.export.c_identifier import c_identifier
from frictool.export.encoder_reading import reading_notes
from frictool.export.encoder_wrap import encoder_wrap
from frictool.export.export_origin import ExportOrigin
from frictool.export.fmi_unit import FmiUnit, FmiVariable, functions_text

KINDS: dict[Number, tuple[str, str]] = {"double": ("double", "0.0"), "float": ("float", "0.0f")}
SIGNALS = {"reference": "position", "position": "position", "velocity": "velocity"}


def controller_fmu(
    controller: Controller,
    program: Program,
    number: Number,
    sources: Mapping[str, str],
    origin: ExportOrigin,
) -> dict[str, bytes]:
    """Return the Functional Mock-up Unit of a controller (contents by file name).

    - program: program of the controller
    - number: number format of the code
    - sources: files of `--lang c`; only the header and the source are used
    - origin: origin of the controller's document

    Raises NoSolutionError if the number format is fixed point.
    """
    if number not in KINDS:
        raise NoSolutionError(
            f"{controller.name}: the variables of an FMU are doubles; found --number {number}; "
            "allowed: double, float"
        )
    name = c_identifier(controller.name)
    return FmiUnit(
        controller.name,
        "controller",
        origin,
        controller.sample_period_s,
        tuple(_variables(controller, program)),
        _functions(controller, program, number, origin),
        {file: sources[file] for file in (f"{name}.h", f"{name}.c")},
        is_sampled=True,
    ).files()


def _settings(program: Program) -> list[tuple[str, float]]:
    return [
        (program.names[node.index], node.value)
        for node in program.states.values()
        if node.index not in program.updates
    ]


def _functions(
    controller: Controller, program: Program, number: Number, origin: ExportOrigin
) -> str:
    name = c_identifier(controller.name)
    kind, zero = KINDS[number]
    inputs = list(program.inputs)
    return functions_text(
        "fmi3_controller.c.jinja",
        origin,
        ["GetBoolean"],
        document="the controller",
        id=name,
        ID=name.upper(),
        name=controller.name,
        inputs=inputs,
        position=inputs.index("position"),
        held=[(one, repr(start)) for one, start in _settings(program)],
        kind=kind,
        zero=zero,
        period=repr(controller.sample_period_s),
    )


def _variables(controller: Controller, program: Program) -> Iterator[FmiVariable]:
    time = {"name": "time", "causality": "independent", "unit": "s", "variability": "continuous"}
    yield FmiVariable(0, "Float64", time)
    reference = 0
    wrap, notes = encoder_wrap(controller), reading_notes(controller)
    inputs = [(one, 0.0, si_unit(SIGNALS[one], controller.axis)) for one in program.inputs]
    settings = [(one, start, None) for one, start in _settings(program)]
    for name, start, unit in [*inputs, *settings]:
        reference += 1
        words = {"name": name, "causality": "input", "start": repr(start)}
        words |= {"unit": unit} if unit is not None else {}
        described = list[str]()
        if wrap is not None and name in ("reference", "position"):
            described.append(wrap.requirement)
        if name == "position":
            described += [f"{subject}: {note}" for subject, note in notes.items()]
        if described:
            words["description"] = "; ".join(described)
        yield FmiVariable(reference, "Float64", {**words, "variability": "discrete"})
    drive = {"name": "drive", "causality": "output", "initial": "exact", "start": "0"}
    drive |= {"unit": si_unit(controller.drive, controller.axis), "variability": "discrete"}
    yield FmiVariable(reference + 1, "Float64", drive)
    fault = {"name": "fault", "causality": "output", "initial": "calculated"}
    position = 1 + list(program.inputs).index("position")
    yield FmiVariable(
        reference + 2, "Boolean", {**fault, "variability": "discrete"}, depends_on=(position,)
    )
