"""The status codes of a run."""

from __future__ import annotations

from frictool.engine import status_codes


def test_each_status_has_a_number_of_its_own_and_each_failure_a_message() -> None:
    codes = [value for value in vars(status_codes).values() if type(value) is int]
    assert sorted(codes) == list(range(len(codes)))
    assert sorted(status_codes.MESSAGES) == sorted(set(codes) - {status_codes.OK})
