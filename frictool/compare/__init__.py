"""Comparison of friction laws by four tests: stick-slip, limit cycle, presliding and drift.

Units of a linear and of a rotary axis are separated by |, as in "m | rad" and "N | N m".
"""

from typing import TYPE_CHECKING

from frictool.runtime.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from frictool.compare.comparison import Comparison as Comparison
    from frictool.compare.comparison import compare as compare
    from frictool.compare.comparison_setting import ComparisonSetting as ComparisonSetting
    from frictool.compare.comparison_setting import table_3_1 as table_3_1
    from frictool.compare.law_simulator import LawSimulator as LawSimulator
else:
    __getattr__, __dir__, __all__ = lazy_exports(
        __name__,
        {
            "comparison": ["Comparison", "compare"],
            "comparison_setting": ["ComparisonSetting", "table_3_1"],
            "law_simulator": ["LawSimulator"],
        },
    )
