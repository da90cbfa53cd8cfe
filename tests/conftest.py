"""Settings of all tests, and the processor time of each package at the end of a run.

Property tests draw the same examples every time, and the first example may compile a kernel. A test
has one core: the matrices are small, so that a second thread of the linear algebra waits longer
than it works, on the core of the other file of tests.
"""

from __future__ import annotations

import gc
import json
import os
import sys
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import settings
from hypothesis.internal.conjecture import providers

os.environ.setdefault(
    "OPENBLAS_NUM_THREADS", "1"
)  # read when numpy and scipy are first imported, here and by each child process

_FIXED = settings(derandomize=True, deadline=None, database=None)
settings.register_profile("frictool", _FIXED, max_examples=20)
settings.register_profile("hundred examples", _FIXED, max_examples=100)  # tests/accept
settings.load_profile("frictool")
providers._get_local_constants = lambda: providers._local_constants  # type: ignore[attr-defined]
# without the numbers in the source text of what happens to be imported, a test draws the same
# examples alone and among others


def pytest_configure() -> None:
    """Hold every object that a command prints with --json against the type of its format."""
    import msgspec

    from frictool.cli import console_output
    from frictool.cli.json_formats import json_type
    from frictool.presentation.json_text import json_text

    def checked(form: str, value: dict[str, Any]) -> str:
        text = json_text(form, value)
        msgspec.convert(json.loads(text), json_type(form))
        return text

    console_output.json_text = checked  # type: ignore[attr-defined]  # replaced in tests


@pytest.fixture(scope="module")
def no_rehearsals() -> Iterator[None]:
    """Take each test as it is designed, where its promise is not the subject."""
    from frictool.plan import rehearsed_test
    from frictool.plan.rehearsal import HalfWidthSample

    def within_limits(*arguments: Any, **named: Any) -> dict[str, HalfWidthSample]:
        limits = arguments[2]
        return {name: HalfWidthSample((0.9 * half,), ()) for name, half in limits.items()}

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(rehearsed_test, "rehearse", within_limits)
        yield


def pytest_xdist_auto_num_workers() -> int:
    """Start one process more than there are cores: one often waits for a kernel or for a child."""
    return (os.cpu_count() or 1) + 1


COST = "processor seconds"
LEAST_S = 1.0  # a package that takes less is not listed


@pytest.hookimpl(wrapper=True)
def pytest_collection(session: pytest.Session) -> Iterator[None]:
    """Exempt what the collection leaves from garbage collection: it is kept until the run ends.

    Later objects are searched seldom; with Python's own thresholds, the search takes a tenth of the
    time of some folders.

    pytest rewrites the assertions of each file on its first import and keeps what it wrote. Each
    process begins with other files, so that a clean checkout is rewritten once and not by each.
    """
    gc.disable()
    config, tests = session.config, Path(__file__).parent
    worker = getattr(config, "workerinput", None)
    if worker and config.args == ["tests"]:
        folders = {package.parent for package in tests.glob("*/__init__.py")}
        parts = sorted(map(str, {*folders, *tests.glob("test_*.py")}))
        first = int(worker["workerid"][2:]) * len(parts) // worker["workercount"]
        config.args = parts[first:] + parts[:first]
    writes_no_bytecode, sys.dont_write_bytecode = sys.dont_write_bytecode, False
    try:
        return (yield)
    finally:
        sys.dont_write_bytecode = writes_no_bytecode
        gc.freeze()
        gc.set_threshold(20_000, 20, 20)
        gc.enable()


FIRST = ("tests/docs/test_pages.py", "tests/simulate/test_mechanism.py")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Put two files first that compile most kernels: of identification, and of simulation.

    Two processes that need the same kernels at the same time would wait for each other. The pages
    also take longest, and the last file of a run should be a short one.
    """
    ranks = {name: rank for rank, name in enumerate(FIRST)}
    files = [item.nodeid.partition("::")[0] for item in items]
    order = {name: (ranks.get(name, len(FIRST)), name) for name in files}
    items.sort(key=lambda item: order[item.nodeid.partition("::")[0]])


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item: pytest.Item) -> Iterator[None]:
    start = _processor_s()
    item.user_properties.append((COST, start))
    return (yield)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item, call: pytest.CallInfo[None]) -> Iterator[None]:
    report = yield
    if call.when == "teardown":
        start = dict(item.user_properties)[COST]
        report.user_properties = [(COST, _processor_s() - start)]
    return report


def _processor_s() -> float:
    """Return the processor time of this process and of those that it waited for [s]."""
    used = os.times()
    return used.user + used.system + used.children_user + used.children_system


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    costs: Counter[str] = Counter()
    for reports in terminalreporter.stats.values():
        for report in reports:
            if getattr(report, "when", "") == "teardown":
                costs[report.nodeid.split("/")[1].split("::")[0]] += dict(
                    report.user_properties
                ).get(COST, 0.0)
    listed = ", ".join(
        f"{name} {cost:.0f}" for name, cost in costs.most_common() if cost >= LEAST_S
    )
    if listed:
        terminalreporter.write_line(f"processor time [s]: {sum(costs.values()):.0f}: {listed}")
