"""A controller as C99: header, source, golden vectors, self-test, all from the program that the simulation runs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import jinja2

from frictool import __version__
from frictool.control.program import Node, Program
from frictool.documents.controller import Controller, Number
from frictool.documents.quantity import si_unit
from frictool.export.identifier import c_identifier, comment_text
from frictool.export.origin import Origin
from frictool.export.program_names import Names, Table
from frictool.export.real_numbers import RealNumbers
from frictool.export.state_meanings import meaning
from frictool.export.statements import INDENT, Numbers, operand, statements, wrapped
from frictool.export.vectors import GoldenVectors
from frictool.export.visits import visits_of

FILES = {
    "{}.h": "controller.h.jinja",
    "{}.c": "controller.c.jinja",
    "{}_vectors.h": "vectors.h.jinja",
    "{}_selftest.c": "selftest.c.jinja",
}
FOLDER = Path(__file__).parent / "templates"


def c_sources(controller: Controller, program: Program, number: Number, vectors: GoldenVectors, origin: Origin) -> dict[str, str]:
    """File name -> text. `program` is the controller's, `vectors` those of the number format.

    Raises NoSolutionError where a coefficient is beyond the range of the format.
    """
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(FOLDER), undefined=jinja2.StrictUndefined, keep_trailing_newline=True, autoescape=False
    )
    environment.globals["comment"] = comment_text
    numbers = RealNumbers(number)
    context = _about(controller, origin) | _code(program, numbers) | _vectors(program, vectors, numbers) | {"number": number}
    return {
        file.format(context["id"]): environment.get_template(template).render(context).rstrip("\n") + "\n"
        for file, template in FILES.items()
    }


def _about(controller: Controller, origin: Origin) -> dict[str, Any]:
    """What the header says of the controller."""
    name = c_identifier(controller.name)
    return {
        "id": name,
        "ID": name.upper(),
        "name": controller.name,
        "sha256": origin.sha256,
        "command": origin.command,
        "version": __version__,
        "controller": controller,
        "position_unit": si_unit("position", controller.axis),
        "speed_unit": si_unit("velocity", controller.axis),
        "drive_unit": si_unit(controller.drive, controller.axis),
    }


def _code(program: Program, numbers: Numbers) -> dict[str, Any]:
    """The program in C: declarations, fields, statements."""
    names = Names(program)
    assert program.output is not None
    body = statements(names, numbers)
    text = "\n".join(body)
    held = [node for node in program.states.values() if node.index not in program.updates]
    return {
        "kind": numbers.kind,
        "suffix": "f" if numbers.kind == "float" else "",
        "constants": [_constant(table, numbers) for table in names.constants],
        "fields": [_field(table, numbers, table.nodes[min(table.nodes)] in held) for table in names.states],
        "starts": _starts(names, numbers),
        "body": body,
        "writes": _writes(names, numbers),
        "returned": operand(names, numbers, program.output),
        "inputs": list(program.inputs),
        "unused": [name for name, node in program.inputs.items() if not names.uses[node.index]],
        "held": [program.names[node.index] for node in held],
        "helpers": [helper for helper in ("absolute", "smaller", "larger") if f"{helper}(" in text],
        "number_of": numbers.literal,
        "has_modes": "mode" in program.states,
    }


def _constant(table: Table, numbers: Numbers) -> str:
    """The declaration of a coefficient or of an array of them, row-major; an element that no value has is 0."""

    def element(node: Node | None) -> str:
        return numbers.constant(node) if node is not None else "0"

    def filled(depth: int, start: tuple[int, ...]) -> str:
        if depth == len(table.shape):
            return element(table.nodes.get(start))
        parts = [filled(depth + 1, (*start, k)) for k in range(table.shape[depth])]
        separator = ",\n    " if depth < len(table.shape) - 1 else ", "
        return "{" + ("\n    " if "\n" in separator else "") + separator.join(parts) + ("\n" if "\n" in separator else "") + "}"

    declared = f"static const {numbers.constant_kind} {table.name}{table.brackets} = {filled(0, ())};"
    return declared + numbers.note(table.nodes[()]) if not table.shape else declared


def _field(table: Table, numbers: Numbers, held: bool) -> tuple[str, str]:
    """A field of the state, and what it is."""
    return f"{numbers.kind} {table.name}{table.brackets};", meaning(table.name, held)


def _starts(names: Names, numbers: Numbers) -> list[str]:
    """What a new state is: at rest at the position."""
    program = names.program
    lines = []
    for table in names.states:
        for node in table.nodes.values():
            value = program.starts.get(node.index) or numbers.literal(node.value)
            lines.append(f"{INDENT}{names.text[node.index]} = {value};")
    return lines


def _writes(names: Names, numbers: Numbers) -> list[str]:
    """The states move, once everything has been computed; what another state held is read before any is written."""
    program = names.program
    read: list[str] = []
    written: list[str] = []
    for state, source in program.updates.items():
        value = operand(names, numbers, source)
        if source.op == "state":
            name = f"held_{len(read)}"
            read.append(f"{INDENT}const {numbers.kind} {name} = {value};")
            value = name
        written += wrapped(f"{names.text[state]} = {value};")
    return read + written


def _vectors(program: Program, vectors: GoldenVectors, numbers: Numbers) -> dict[str, Any]:
    """The golden vectors as the format writes them."""
    visits = visits_of(program)
    return {
        "vectors": vectors,
        "start": numbers.exact(vectors.start, program.inputs["position"]),
        "rows": [[numbers.exact(value, node) for value, node in zip(row, _columns(program), strict=True)] for row in vectors.rows],
        "counted": [f"{count} {visits[name].text}" for name, count in vectors.visits.items()],
        "printed": numbers.printed,
        "cast": numbers.cast,
        "units_of_words": numbers.words,
    }


def _columns(program: Program) -> list[Node]:
    """The values that a row of the vectors holds."""
    assert program.output is not None
    held = [node for node in program.states.values() if node.index not in program.updates]
    return [*program.inputs.values(), *held, program.output]
