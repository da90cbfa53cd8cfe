"""Function that derives the equations of a mechanism for `frictool equations`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from frictool.adapters.mechanism.assembly import assemble
from frictool.documents.key_lines import document_error
from frictool.documents.mechanism import Mechanism
from frictool.equations.derivation import Derivation, derive
from frictool.equations.derivation_views import as_data, as_latex, as_text
from frictool.plant.mechanism.element_error import ElementError
from frictool.runtime.object_view import ResultView


@dataclass(frozen=True, eq=False, repr=False)
class Equations(ResultView):
    """Equations of a mechanism as text, LaTeX and data.

    - derivation: sections of equations, parameters with their values, and notes
    - explain: True if text and LaTeX contain the numbers of the equations in the thesis
    """

    derivation: Derivation
    explain: bool = False

    @property
    def text(self) -> str:
        """Return the equations as text, with the unit of each equation."""
        return as_text(self.derivation, self.explain)

    @property
    def latex(self) -> str:
        """Return the equations as a LaTeX fragment for amsmath."""
        return as_latex(self.derivation, self.explain)

    @property
    def data(self) -> dict[str, Any]:
        """Return the equations as JSON values; every term names its element."""
        return as_data(self.derivation)


def equations(mechanism: Mechanism, *, name: str = "mechanism", explain: bool = False) -> Equations:
    """Derive the equations of a mechanism and check the dimension of every term.

    Parameters
    ----------
    mechanism : Mechanism
        Document of the mechanism.
    name : str, optional
        Name of the document in messages, such as its path.
    explain : bool, optional
        Add the numbers of the equations in the thesis to text and LaTeX.

    Returns
    -------
    Equations
        Equations as text, LaTeX and data.

    Raises
    ------
    DocumentError
        If the document is invalid; the message contains the key of the element.
    """
    try:
        return Equations(derive(mechanism, assemble(mechanism)), explain)
    except ElementError as wrong:
        raise document_error(name, wrong.key, str(wrong)) from None
