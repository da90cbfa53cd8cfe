"""Metrics against the specification: the verdict, as a page and for machines."""

from typing import TYPE_CHECKING

from frictool.exports import lazily

if TYPE_CHECKING:
    from frictool.report.requirement import Requirement as Requirement
    from frictool.report.requirement import Verdict as Verdict
    from frictool.report.verdict import judge as judge
else:
    __getattr__, __dir__ = lazily(
        __name__,
        {
            "Requirement": "frictool.report.requirement",
            "Verdict": "frictool.report.requirement",
            "judge": "frictool.report.verdict",
        },
    )

__all__ = ["Requirement", "Verdict", "judge"]
