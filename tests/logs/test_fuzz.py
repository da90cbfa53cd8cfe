"""A seeded subset of the mutated files that `make accept` reads."""

from __future__ import annotations

import pytest

from tests.accept.check_logs import KINDS, fuzz, sample


@pytest.mark.parametrize("kind", KINDS)
def test_mutated_files_are_read_or_refused_in_one_line(kind: str):
    result = fuzz(sample(kind), seed=1, count=150)
    assert result["passed"]
    assert result["refused"] > 40
