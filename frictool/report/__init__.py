"""Verdict on logs: comparison with a specification, shown as page, text and data."""

from typing import TYPE_CHECKING

from frictool.runtime.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from frictool.report.requirement import ReportRequest as ReportRequest
    from frictool.report.requirement import Requirement as Requirement
    from frictool.report.requirement import Verdict as Verdict
    from frictool.report.verdict import judge as judge
else:
    __getattr__, __dir__, __all__ = lazy_exports(
        __name__,
        {"requirement": ["ReportRequest", "Requirement", "Verdict"], "verdict": ["judge"]},
    )
