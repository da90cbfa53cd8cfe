"""The four tests of thesis 3.7 on every friction law, as numbers and verdicts."""

from typing import TYPE_CHECKING

from frictool.exports import lazily

if TYPE_CHECKING:
    from frictool.compare.comparison import Comparison as Comparison
    from frictool.compare.comparison import compare as compare
    from frictool.compare.laws import Laws as Laws
    from frictool.compare.setting import Setting as Setting
    from frictool.compare.setting import table_3_1 as table_3_1
else:
    __getattr__, __dir__ = lazily(
        __name__,
        {
            "Comparison": "frictool.compare.comparison",
            "Laws": "frictool.compare.laws",
            "Setting": "frictool.compare.setting",
            "compare": "frictool.compare.comparison",
            "table_3_1": "frictool.compare.setting",
        },
    )

__all__ = ["Comparison", "Laws", "Setting", "compare", "table_3_1"]
