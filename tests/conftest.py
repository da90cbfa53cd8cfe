"""Property tests draw the same examples every time, the first of them may compile a kernel, and a test has one core.

The matrices here are small: a second thread of the linear algebra waits longer than it works, on the core of the other file of tests.
"""

from __future__ import annotations

import os

from hypothesis import settings

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # read when numpy and scipy are first imported, here and by each child process

settings.register_profile("frictool", derandomize=True, deadline=None, database=None)
settings.load_profile("frictool")
