"""Status codes of the kernels of frictool/friction.

======  ===========  =======================================================================
status  name         meaning
======  ===========  =======================================================================
0       OK           no error
1       NOT_FINITE   a state, velocity or parameter is NaN or infinite; nothing was changed
2       MEMORY_FULL  the memory of nested reversals is full, and too small (fewer than 4) to remove
                     a pair; nothing was changed
======  ===========  =======================================================================
"""

from __future__ import annotations

OK = 0
NOT_FINITE = 1
MEMORY_FULL = 2
