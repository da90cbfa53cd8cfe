"""Symbols of blocks and parameters; the names of the elements are the indices of the symbols."""

from __future__ import annotations

from dataclasses import dataclass

from frictool.adapters.mechanism.block_references import axis_kind
from frictool.documents.mechanism import Mechanism
from frictool.documents.quantity import Axis, Quantity, si_unit
from frictool.equations.expression import Atom, Term, symbol

RATES: dict[Axis, tuple[str, str, str]] = {
    "rotary": ("rad", "rad/s", "rad/s^2"),
    "linear": ("m", "m/s", "m/s^2"),
}
HALF = symbol("2", "2", value=2.0).inverse()


@dataclass(frozen=True)
class ParameterRow:
    """Row of the table of parameters.

    value, low, high: nominal value and interval in SI; low and high are None without an interval.
    key: key of the value in the document.
    """

    symbol: str
    latex: str
    value: float
    low: float | None
    high: float | None
    unit: str
    key: str


class Notation:
    """Factory of symbols, which also collects the rows of the parameter table."""

    def __init__(self, document: Mechanism) -> None:
        self.document = document
        self.kinds: dict[str, Axis] = {
            name: axis_kind(block) for name, block in document.blocks.items()
        }
        self.parameters: dict[str, ParameterRow] = {}

    def position(self, block: str) -> Term:
        """Return the symbol of a block's position: theta [rad] or x [m]."""
        kind = self.kinds[block]
        return _named(
            "theta" if kind == "rotary" else "x",
            r"\theta" if kind == "rotary" else "x",
            block,
            RATES[kind][0],
        )

    def speed(self, block: str) -> Term:
        """Return the symbol of a block's speed: omega [rad/s] or v [m/s]."""
        kind = self.kinds[block]
        return _named(
            "omega" if kind == "rotary" else "v",
            r"\omega" if kind == "rotary" else "v",
            block,
            RATES[kind][1],
        )

    def acceleration(self, block: str) -> Atom:
        """Return the symbol of a block's acceleration [rad/s^2 or m/s^2]."""
        kind = self.kinds[block]
        speed = self.speed(block).factors[0][0]
        return Atom(
            f"{speed.text}'",
            rf"\dot{{{speed.latex.partition('_')[0]}}}_{speed.latex.partition('_')[2]}",
            RATES[kind][2],
        )

    def inertia(self, block: str) -> Term:
        """Return the symbol J (inertia) or m (mass) of a block."""
        stated = self.document.blocks[block]
        if stated.inertia is not None:
            return self.parameter("J", "J", block, stated.inertia, f"blocks.{block}.inertia")
        assert stated.mass is not None
        return self.parameter("m", "m", block, stated.mass, f"blocks.{block}.mass")

    def parameter(self, letter: str, latex: str, name: str, quantity: Quantity, key: str) -> Term:
        """Return the symbol of a quantity in SI, and add the quantity to the parameter table."""
        term = _named(letter, latex, name, quantity.unit, quantity.value)
        atom = term.factors[0][0]
        self.parameters[atom.text] = ParameterRow(
            atom.text, atom.latex, quantity.value, quantity.low, quantity.high, quantity.unit, key
        )
        return term.of(key)

    def number(self, letter: str, latex: str, name: str, value: float, key: str) -> Term:
        """Return the symbol of a dimensionless number, and add it to the parameter table."""
        return self.parameter(letter, latex, name, Quantity(value, unit=""), key)

    def effort(self, letter: str, name: str, kind: Axis) -> Term:
        """Return the symbol of an unknown effort on a rotary or linear block (`kind`)."""
        latex = {"lambda": r"\lambda"}.get(letter, letter)
        return _named(letter, latex, name, si_unit("effort", kind))

    def stretch(self, letter: str, name: str, kind: Axis) -> tuple[Term, Term]:
        """Return the symbols of a position difference and of the rate of this difference."""
        position, rate, _ = RATES[kind]
        still = _named(letter, letter, name, position)
        return still, symbol(f"{letter}_{name}'", indexed_latex(rf"\dot{{{letter}}}", name), rate)


def _named(letter: str, latex: str, name: str, unit: str, value: float | None = None) -> Term:
    return symbol(f"{letter}_{name}", indexed_latex(latex, name), unit, value)


def indexed_latex(letter: str, name: str) -> str:
    """Return a letter with an index as LaTeX: `F_c` and `brushes` give F_{c,brushes}."""
    base, _, index = letter.partition("_")
    return rf"{base}_{{{index + ',' if index else ''}\mathrm{{{_latex(name)}}}}}"


def _latex(name: str) -> str:
    return name.replace("_", r"\_")


def roman(name: str) -> str:
    """Return a name in upright LaTeX letters, with spaces instead of underscores."""
    return rf"\mathrm{{{name.replace('_', '~')}}}"


def function(
    name: str,
    latex: str,
    argument: str,
    argument_latex: str,
    unit: str = "",
    value: float | None = None,
) -> Term:
    """Return `name(argument)` as one symbol."""
    return symbol(f"{name}({argument})", rf"{latex}\left({argument_latex}\right)", unit, value)
