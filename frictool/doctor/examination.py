"""All checks, in the order in which a reader asks."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from frictool.doctor.c_compiler import check_c_compiler
from frictool.doctor.check import Check
from frictool.doctor.machine import check_machine, check_temporary, check_terminal
from frictool.doctor.versions import asked_for, check_extras, check_libraries, check_python


def examine() -> list[Check]:
    """What is found. A part that cannot even be asked is wrong, with the reason."""
    asked = asked_for()
    found = [check_python(), check_libraries(asked)]
    found += [_tried("compiling", _compiling), _tried("kernels", _kept), _tried("left over", _left_over), _tried("solver", _solver)]
    return [*found, check_c_compiler(), *check_extras(asked), check_machine(), check_temporary(), check_terminal()]


def _tried(name: str, check: Callable[[], Check]) -> Check:
    """What is broken may fail on import, in whatever way."""
    try:
        return check()
    except Exception as error:
        told = " ".join(f"{type(error).__name__}: {error}".split())
        return Check(name, "wrong", told, "reinstall: pip install --force-reinstall frictool")


def _compiling() -> Check:
    from frictool.doctor.compiled import check_compiling

    return check_compiling()


def _kept() -> Check:
    from frictool.doctor.compiled import check_kept

    return check_kept()


def _left_over() -> Check:
    from frictool.doctor.compiled import check_left_over, left_over

    return check_left_over(left_over())


def _solver() -> Check:
    from frictool.doctor.solver import check_solver

    return check_solver()


def as_view(checks: list[Check]) -> list[dict[str, Any]]:
    """The machine's view."""
    return [{"check": one.name, "state": one.state, "found": one.found, "try": one.remedy or None, **one.facts} for one in checks]


def lines(checks: list[Check]) -> list[str]:
    """The same for people."""
    shown = []
    for one in checks:
        shown.append(f"{one.state:<6}{one.name:<16}{one.found}")
        if one.remedy:
            shown.append(f"{'':<22}try: {one.remedy}")
    return shown
