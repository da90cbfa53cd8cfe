"""Property tests draw the same examples every time, and the first of them may compile a kernel."""

from __future__ import annotations

from hypothesis import settings

settings.register_profile("frictool", derandomize=True, deadline=None, database=None)
settings.load_profile("frictool")
