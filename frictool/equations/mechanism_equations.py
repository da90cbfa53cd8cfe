"""The equations of a mechanism: what `frictool equations` does, on values in memory."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from frictool.documents.key_lines import document_error
from frictool.documents.mechanism import Mechanism
from frictool.equations.derivation import Derivation, derive
from frictool.equations.views import as_data, as_latex, as_text
from frictool.plant.mechanism.assembly import assemble
from frictool.plant.mechanism.element_error import ElementError


@dataclass(frozen=True)
class Equations:
    """derivation: sections of equations, the parameters with their values, what is said beside."""

    derivation: Derivation

    @property
    def text(self) -> str:
        """For people: each equation with its unit and the thesis's number."""
        return as_text(self.derivation)

    @property
    def latex(self) -> str:
        """A fragment for amsmath."""
        return as_latex(self.derivation)

    @property
    def data(self) -> dict[str, Any]:
        """What `--json` prints: every term with its element."""
        return as_data(self.derivation)


def equations(mechanism: Mechanism, *, name: str = "mechanism") -> Equations:
    """The equations that follow from the description, the dimension of every term checked.

    name: what messages call the document, its path where it has one. Raises DocumentError where the
    mechanism is none, with the key of the element.
    """
    try:
        return Equations(derive(mechanism, assemble(mechanism)))
    except ElementError as wrong:
        raise document_error(name, wrong.key, str(wrong)) from None
