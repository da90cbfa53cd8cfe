"""Settings of every test of the workers."""

from __future__ import annotations

import pytest

from frictool.workers import dask_cluster
from tests.support.local_cluster import PATIENCE_S


@pytest.fixture(autouse=True)
def patience(monkeypatch: pytest.MonkeyPatch) -> None:
    """A worker may take long to start where other tests run beside it."""
    monkeypatch.setattr(dask_cluster, "FIRST_S", PATIENCE_S)
