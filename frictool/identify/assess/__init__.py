"""Assessment of the parameters that a bench can identify, before any measurement (thesis 4.2)."""

from typing import TYPE_CHECKING

from frictool.runtime.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from frictool.identify.assess.assessment import Assessment as Assessment
    from frictool.identify.assess.assessment import assess as assess
    from frictool.identify.assess.assessment_inputs import AssessmentRequest as AssessmentRequest
else:
    __getattr__, __dir__, __all__ = lazy_exports(
        __name__,
        {"assessment": ["Assessment", "assess"], "assessment_inputs": ["AssessmentRequest"]},
    )
