"""Everything that a controller document says of its loop, found again."""

from __future__ import annotations

from frictool.documents.controller import Controller
from frictool.verify.certificate import Proved
from frictool.verify.certificate_document import prove_document
from frictool.verify.controller import recheck


def verify(controller: Controller) -> tuple[Proved, ...]:
    """What its certificate states, proved in whole numbers; nothing where it has none. The margins at its vertices are found again.

    Raises NoSolutionError where an inequality does not hold, or a figure is not that of the stored coefficients.
    """
    certificate = controller.certificate
    proved = prove_document(controller, certificate) if certificate is not None and certificate.bounds else ()
    recheck(controller)
    return proved
