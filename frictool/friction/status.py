"""What the kernels of this room return beside their values.

======  ===========
================================================================================
status  name         meaning
======  ===========
================================================================================
0       OK           done
1       NOT_FINITE   a state, velocity or parameter is NaN or infinite; nothing was changed
2       MEMORY_FULL  more nested reversals than the memory holds, and it holds fewer than 4; nothing
        was changed
======  ===========
================================================================================
"""

from __future__ import annotations

OK = 0
NOT_FINITE = 1
MEMORY_FULL = 2
