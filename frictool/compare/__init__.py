"""Comparison of friction laws by the four tests of thesis 3.7."""

from typing import TYPE_CHECKING

from frictool.runtime.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from frictool.compare.comparison import Comparison as Comparison
    from frictool.compare.comparison import compare as compare
    from frictool.compare.comparison_setting import ComparisonSetting as ComparisonSetting
    from frictool.compare.comparison_setting import table_3_1 as table_3_1
    from frictool.compare.law_simulator import LawSimulator as LawSimulator
else:
    __getattr__, __dir__ = lazy_exports(
        __name__,
        {
            "Comparison": "frictool.compare.comparison",
            "LawSimulator": "frictool.compare.law_simulator",
            "ComparisonSetting": "frictool.compare.comparison_setting",
            "compare": "frictool.compare.comparison",
            "table_3_1": "frictool.compare.comparison_setting",
        },
    )

__all__ = ["Comparison", "ComparisonSetting", "LawSimulator", "compare", "table_3_1"]
