"""Controller as C99: header, source, golden vectors and self-test.

The source is generated from the program that the simulation runs. A program is a list of nodes:
inputs, constants, states and operations (control/program.py).
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import jinja2

from frictool import __version__
from frictool.control.fixed_point import FixedProgram, fixed_program
from frictool.control.fixed_point_kernel import shift_rounded
from frictool.control.measurement_guard import FAULT
from frictool.control.program import Program, ProgramNode
from frictool.control.target_band import BRAKE, REST, RUN
from frictool.documents.controller import Controller, ProgramNumber
from frictool.documents.quantity import si_unit
from frictool.export.c_fixed_point import FixedNumbers
from frictool.export.c_identifier import c_identifier, comment_text
from frictool.export.c_names import CNames, NamedArray
from frictool.export.c_real_numbers import RealNumbers
from frictool.export.c_statements import INDENT, NumberWriter, c_statements, operand, wrap_statement
from frictool.export.encoder_reading import reading_notes
from frictool.export.encoder_wrap import wrap_context
from frictool.export.export_origin import ExportOrigin
from frictool.export.fixed_point_header import conversion_macros, field_note, proof_lines
from frictool.export.golden_vectors import GoldenVectors
from frictool.export.mode_coverage import visit_conditions
from frictool.export.rounded_loop import RoundedLoop
from frictool.export.state_meanings import state_meaning

FILES = {
    "{}.h": "controller.h.jinja",
    "{}.c": "controller.c.jinja",
    "{}_vectors.h": "vectors.h.jinja",
    "{}_selftest.c": "selftest.c.jinja",
}
HELPERS = (
    "is_valid",
    "shifted",
    "word",
    "raised",
    "bounded",
    "whole_root",
    "absolute",
    "smaller",
    "larger",
)
FOLDER = Path(__file__).parent / "templates"


def c_sources(
    controller: Controller,
    program: Program,
    number: ProgramNumber,
    vectors: GoldenVectors,
    loop: RoundedLoop,
    origin: ExportOrigin,
) -> dict[str, str]:
    """Return the C files (texts by name) of a controller.

    `program`: program of the controller.
    `vectors`: golden vectors in the number format.
    `loop`: verified properties of the loop with rounded coefficients.

    Raises NoSolutionError if a coefficient is beyond the range of the number format, and
    FixedPointOverflow if the program cannot be scaled to fixed point.
    """
    numbers = FixedNumbers(fixed_program(program)) if number == "q31" else RealNumbers(number)
    names = CNames(program)
    wrap = wrap_context(controller, numbers, program.inputs["position"].index)
    used = "" if wrap is None else f"{wrap['shown']} {wrap['turned']}"
    context = (
        _about(controller, origin)
        | _code(names, numbers, used)
        | _vectors(program, vectors, numbers)
        | {"wrap": wrap, "notes": reading_notes(controller)}
    )
    context |= _format(controller, names, numbers) | {"number": number, "loop": loop}
    environment = _environment()
    return {
        file.format(context["id"]): environment.get_template(template).render(context).rstrip("\n")
        + "\n"
        for file, template in FILES.items()
    }


@cache
def _environment() -> jinja2.Environment:
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(FOLDER),
        undefined=jinja2.StrictUndefined,
        keep_trailing_newline=True,
        autoescape=False,
    )
    environment.globals["comment"] = comment_text
    return environment


def _about(controller: Controller, origin: ExportOrigin) -> dict[str, Any]:
    name = c_identifier(controller.name)
    return {
        "id": name,
        "ID": name.upper(),
        "name": controller.name,
        "sha256": origin.sha256,
        "command": origin.command,
        "version": __version__,
        "controller": controller,
        "hold_samples": controller.measurement_hold_samples,
        "position_unit": si_unit("position", controller.axis),
        "speed_unit": si_unit("velocity", controller.axis),
        "drive_unit": si_unit(controller.drive, controller.axis),
    }


def _code(names: CNames, numbers: NumberWriter, more: str) -> dict[str, Any]:
    """Return the parts of the file NAME.c.

    `more`: other C expressions of the file; the helper functions that they call are included.
    """
    program = names.program
    assert program.output is not None
    guard = program.guard
    assert guard is not None
    entering = [
        line
        for name, node in program.inputs.items()
        if names.uses[node.index]
        for line in numbers.entering(node, name)
    ]
    body = [f"{INDENT}{line}" for line in entering] + c_statements(names, numbers)
    starts, writes = _starts(names, numbers), _writes(names, numbers)
    setters = [
        (program.names[node.index], numbers.stored(node, None, "value"))
        for node in program.constant_states
    ]
    text = "\n".join(
        [
            *(*body, *starts, *writes, *(stored for _, stored in setters)),
            *(numbers.valid("position"), more),
        ]
    )
    helpers = [helper for helper in HELPERS if f"{helper}(" in text]
    return {
        "kind": numbers.kind,
        "suffix": numbers.suffix,
        "constants": [_constant(table, numbers) for table in names.constants],
        "starts": starts,
        "valid_position": numbers.valid("position"),
        "valid_value": numbers.valid("value"),
        "nothing_left": numbers.literal(0.0) if numbers.kind != "int32_t" else "0",
        "largest": numbers.largest if isinstance(numbers, RealNumbers) else "",
        "body": body,
        "writes": writes,
        "fault_word": numbers.started(replace(guard.left, value=FAULT), None),
        "reference": numbers.parameter("reference"),
        "held_reference": names.text[program.states["reference_before"].index].removeprefix(
            "state->"
        ),
        "returned": operand(names, numbers, program.output),
        "inputs": list(program.inputs),
        "parameters": [numbers.parameter(name) for name in program.inputs],
        "unused": ["state"] * ("state->" not in "".join([*body, *writes]))
        + [
            numbers.parameter(name)
            for name, node in program.inputs.items()
            if not names.uses[node.index]
        ],
        "held": setters,
        "helpers": [*helpers, "shifted"] if "word" in helpers else helpers,
    }


def _format(controller: Controller, names: CNames, numbers: NumberWriter) -> dict[str, Any]:
    program = names.program
    scaled = numbers.scaled if isinstance(numbers, FixedNumbers) else None
    drive = program.output
    assert drive is not None
    mode = program.states.get("mode")
    limit = controller.drive_limit
    per_count = controller.bench.encoder.position_per_count
    if scaled is None:
        modes = [numbers.literal(value) for value in (RUN, BRAKE, REST)] if mode is not None else []
        return {
            "fixed": False,
            "fields": [_field(table, numbers, program, "") for table in names.states],
            "period": numbers.literal(controller.sample_period_s),
            "drive_limit": numbers.literal(limit),
            "per_count": _bracketed(numbers.literal(per_count)),
            "modes": modes,
            "conversions": [],
        }
    word = _words(scaled, mode) if mode is not None else []
    return {
        "fixed": True,
        "fields": [
            _field(table, numbers, program, field_note(table, scaled)) for table in names.states
        ],
        "period": repr(controller.sample_period_s),
        "drive_limit": _limit(scaled, drive),
        "per_count": _bracketed(repr(per_count)),
        "modes": word,
        "conversions": conversion_macros(
            c_identifier(controller.name).upper(),
            scaled,
            per_count,
            drive,
        ),
        "proof": proof_lines(names, scaled),
        "longest": scaled.longest,
        "bits": scaled.bits,
    }


def _bracketed(literal: str) -> str:
    """Return a C literal for a macro, in brackets if it is negative."""
    return f"({literal})" if literal.startswith("-") else literal


def _limit(scaled: FixedProgram, drive: ProgramNode) -> int:
    limit = next(index for index, name in scaled.program.names.items() if name == "drive_limit")
    return shift_rounded(
        scaled.constants[limit], scaled.fractions[limit] - scaled.fractions[drive.index]
    )


def _words(scaled: FixedProgram, mode: ProgramNode) -> list[int]:
    return [round(math.ldexp(value, scaled.fractions[mode.index])) for value in (RUN, BRAKE, REST)]


def _constant(table: NamedArray, numbers: NumberWriter) -> str:
    def element(node: ProgramNode | None) -> str:
        return numbers.constant(node) if node is not None else "0"

    def filled(depth: int, start: tuple[int, ...]) -> str:
        if depth == len(table.shape):
            return element(table.nodes.get(start))
        parts = [filled(depth + 1, (*start, k)) for k in range(table.shape[depth])]
        separator = ",\n    " if depth < len(table.shape) - 1 else ", "
        return (
            "{"
            + ("\n    " if "\n" in separator else "")
            + separator.join(parts)
            + ("\n" if "\n" in separator else "")
            + "}"
        )

    fractions = numbers.fractions(table)
    declared = (
        f"static const {numbers.constant_kind} {table.name}{table.brackets} = {filled(0, ())};"
    )
    return declared + numbers.note(table.nodes[()]) if not table.shape else fractions + declared


def _field(
    table: NamedArray, numbers: NumberWriter, program: Program, note: str
) -> tuple[str, str]:
    is_constant = all(node.index not in program.updates for node in table.nodes.values())
    comments = [text for text in (state_meaning(table.name, is_constant), note) if text]
    return f"{numbers.kind} {table.name}{table.brackets};", "; ".join(comments)


def _starts(names: CNames, numbers: NumberWriter) -> list[str]:
    """Return the C statements that initialise the state for an axis at rest.

    If the position is invalid, the controller starts in the fault state.
    """
    program = names.program
    assert program.guard is not None
    lines = []
    for table in names.states:
        for node in table.nodes.values():
            source = (
                program.inputs[program.starts[node.index]] if node.index in program.starts else None
            )
            start = numbers.started(node, source)
            if node is program.guard.left:
                start = f"valid ? {start} : {numbers.started(replace(node, value=FAULT), None)}"
            lines.append(f"{INDENT}{names.text[node.index]} = {start};")
    return lines


def _writes(names: CNames, numbers: NumberWriter) -> list[str]:
    """Return the C statements that write the new states after all values have been computed.

    A state that is copied into another state is read before any state is written.
    """
    program = names.program
    read: list[str] = []
    written: list[str] = []
    for state, source in program.updates.items():
        value = operand(names, numbers, source)
        if source.op == "state":
            name = f"held_{len(read)}"
            read.append(f"{INDENT}const {numbers.kind} {name} = {value};")
            value = name
        written += wrap_statement(
            f"{names.text[state]} = {numbers.stored(program.nodes[state], source, value)};"
        )
    return read + written


def _vectors(program: Program, vectors: GoldenVectors, numbers: NumberWriter) -> dict[str, Any]:
    visits = visit_conditions(program)
    return {
        "vectors": vectors,
        "start": numbers.exact(vectors.start, program.inputs["position"]),
        "invalid": numbers.exact(math.nan, program.inputs["position"]),
        "rows": [
            [numbers.exact(value, node) for value, node in zip(row, _columns(program), strict=True)]
            for row in vectors.rows
        ],
        "counted": [f"{count} {visits[name].text}" for name, count in vectors.visits.items()],
        "printed": numbers.printed,
        "cast": numbers.cast,
        "units_of_words": numbers.words,
    }


def _columns(program: Program) -> list[ProgramNode]:
    assert program.output is not None
    return [*program.inputs.values(), *program.constant_states, program.output]
