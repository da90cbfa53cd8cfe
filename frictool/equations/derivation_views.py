"""Derivation as text, as LaTeX and as data."""

from __future__ import annotations

import re
import textwrap
from typing import Any

from frictool.equations.derivation import Derivation, Line
from frictool.equations.expression import Equation
from frictool.equations.notation import ParameterRow

WIDTH = 118  # characters of a line


def as_text(derivation: Derivation, explain: bool = False) -> str:
    """Return text: equations with units, driving directions of links, parameters, and notes.

    `explain` adds the numbers of the equations in the thesis.
    """
    out = [derivation.name]
    for title, lines in derivation.sections:
        out += ["", title]
        for line in lines:
            out += _shown(line, numbers="eliminated" in title, explain=explain)
    if derivation.directions:
        out += [
            "",
            "Driving directions of links",
            *(f"  {line}" for line in derivation.directions),
        ]
    out += ["", "Parameters", *_table(derivation.parameters), ""]
    out += [f"note: {note}" for note in derivation.notes]
    out.append(f"{derivation.checked} terms: each has the dimension of its equation")
    return "\n".join(out) + "\n"


def _shown(line: Line, numbers: bool, explain: bool) -> list[str]:
    source = f"  {line.source}" if explain and line.source else ""
    tail = f"[{line.unit or '1'}]{source}"
    when = f", {line.when}" if isinstance(line, Equation) and line.when else ""
    out = _wrapped(f"{line.text}{when}", tail)
    if numbers and isinstance(line, Equation):
        out += _wrapped(line.numbers, f"[{line.unit}]", indent="    ")
    return out


def _wrapped(text: str, tail: str, indent: str = "  ") -> list[str]:
    lines = textwrap.wrap(
        text,
        WIDTH - 20,
        initial_indent=indent,
        subsequent_indent=indent + "    ",
        break_long_words=False,
        break_on_hyphens=False,
    )
    lines[-1] = f"{lines[-1]:<{WIDTH - 20}}  {tail}"
    return lines


def _table(parameters: tuple[ParameterRow, ...]) -> list[str]:
    rows = [
        (
            p.symbol,
            f"{p.value:.6g}",
            "" if p.low is None or p.high is None else f"{p.low:.6g} to {p.high:.6g}",
            p.unit or "1",
            p.key,
        )
        for p in parameters
    ]
    widths = [max(len(row[i]) for row in rows) for i in range(4)] if rows else []
    return [
        "  "
        + "  ".join(
            cell.ljust(width) for cell, width in zip(row, [*widths, 0], strict=True)
        ).rstrip()
        for row in rows
    ]


def as_latex(derivation: Derivation, explain: bool = False) -> str:
    """Return a fragment for amsmath: one paragraph per section, one aligned row per equation.

    `explain` adds the numbers of the equations in the thesis.
    """
    out = [f"% {derivation.name}; amsmath"]
    for title, lines in derivation.sections:
        rows = [_row(line, explain) for line in lines]
        out += [rf"\paragraph{{{title}}}", r"\begin{align*}", " \\\\\n".join(rows), r"\end{align*}"]
    rows = [
        f"${p.latex}$ & {p.value:.6g} & ${_unit(p.unit)}$ & {_escaped(p.key)} \\\\"
        for p in derivation.parameters
    ]
    out += [r"\paragraph{Parameters}", r"\begin{tabular}{llll}", *rows, r"\end{tabular}"]
    return "\n".join(out) + "\n"


def _row(line: Line, explain: bool) -> str:
    body = line.latex.replace(" = ", " &= ", 1) if isinstance(line, Equation) else "&" + line.latex
    said = rf"\quad \text{{{line.source}}}" if explain and line.source else ""
    return f"{body} && [{_unit(line.unit)}]{said}"


def _unit(unit: str) -> str:
    spaced = re.sub(r"\^([\d.]+)", r"^{\1}", unit.replace(" ", r"\,"))
    return rf"\mathrm{{{spaced or '1'}}}"


def _escaped(text: str) -> str:
    return text.replace("_", r"\_")


def as_data(derivation: Derivation) -> dict[str, Any]:
    """Return the derivation as JSON values; every term names its element."""
    return {
        "name": derivation.name,
        "sections": [
            {"title": title, "lines": [_data(line) for line in lines]}
            for title, lines in derivation.sections
        ],
        "parameters": [
            {
                "symbol": p.symbol,
                "latex": p.latex,
                "value": p.value,
                "low": p.low,
                "high": p.high,
                "unit": p.unit,
                "key": p.key,
            }
            for p in derivation.parameters
        ],
        "driven": list(derivation.directions),
        "notes": list(derivation.notes),
        "terms_checked": derivation.checked,
    }


def _data(line: Line) -> dict[str, Any]:
    common = {
        "text": line.text,
        "latex": line.latex,
        "unit": line.unit,
        "key": line.key,
        "source": line.source,
    }
    if not isinstance(line, Equation):
        return {"kind": "statement", **common}
    terms = [
        {"text": ("-" if term.sign < 0 else "") + term.text, "element": term.element}
        for term in line.right
    ]
    return {
        "kind": "equation",
        **common,
        "when": line.when,
        "of": line.of.text,
        "numbers": line.numbers,
        "terms": terms,
    }
