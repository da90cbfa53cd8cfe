"""Statements of a C function for a program, in the program's order.

A value becomes a named C constant if it has a name, is used more than once, or becomes a state.
Other values are expressions in brackets. States are read when they are used, and written after all
values have been computed.
"""

from __future__ import annotations

import textwrap

from frictool.control.program import ProgramNode
from frictool.export.c_fixed_point import FixedNumbers
from frictool.export.c_names import CNames
from frictool.export.c_real_numbers import RealNumbers

WIDTH = 128
INDENT = "    "
UNBROKEN = "\0"
NumberWriter = RealNumbers | FixedNumbers


def c_statements(names: CNames, numbers: NumberWriter) -> list[str]:
    """Return the lines that compute the output and the new states, without writing a state."""
    return _StatementWriter(names, numbers).lines


def operand(names: CNames, numbers: NumberWriter, node: ProgramNode) -> str:
    """Return the C name of a node's value, or the number itself if the node has no name."""
    if node.index in names.results:
        return names.results[node.index]
    if node.index in names.text:
        return names.text[node.index]
    return numbers.number(node)


class _StatementWriter:
    def __init__(self, names: CNames, numbers: NumberWriter) -> None:
        self.names, self.numbers = names, numbers
        self.inline: dict[int, str] = {}
        self.lines: list[str] = []
        comment = ""
        pending = []
        for node in names.program.nodes:
            comment = names.program.comments.get(node.index, comment)
            if node.op in ("constant", "input", "state") or not names.uses[node.index]:
                continue
            if comment:
                pending.append(comment)
                comment = ""
            text = numbers.expression(node, [self._operand(arg, node) for arg in node.args])
            if node.index in names.results:
                self._declare(node, text, pending)
                pending = []
            else:
                self.inline[node.index] = text

    def _operand(self, node: ProgramNode, within: ProgramNode) -> str:
        if node.index in self.inline:
            return self.numbers.closed(node, self.inline[node.index], within)
        return operand(self.names, self.numbers, node)

    def _declare(self, node: ProgramNode, text: str, comments: list[str]) -> None:
        if comments and self.lines:
            self.lines.append("")
        for comment in comments:
            self.lines += wrap_statement(f"/* {comment} */", " * ")
        kind = "int" if node.is_logical else self.numbers.kind
        note = self.numbers.note(node).replace(" ", UNBROKEN)
        self.lines += wrap_statement(
            f"const {kind} {self.names.results[node.index]} = {text};{note}", INDENT
        )


def wrap_statement(text: str, hanging: str = INDENT) -> list[str]:
    """Return a statement in lines of at most WIDTH characters, without a break in its comment."""
    lines = textwrap.wrap(
        text, WIDTH, subsequent_indent=hanging, break_long_words=False, break_on_hyphens=False
    )
    return [INDENT + line.replace(UNBROKEN, " ") for line in lines]
