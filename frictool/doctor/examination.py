"""All checks of an installation, in the order of the report."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from frictool.doctor.c_compiler import check_c_compiler
from frictool.doctor.installation_finding import InstallationFinding
from frictool.doctor.library_versions import (
    check_extras,
    check_libraries,
    check_python,
    required_libraries,
)
from frictool.doctor.resources import check_machine, check_temporary, check_terminal


def examine() -> list[InstallationFinding]:
    """Run all checks; return one finding per check, also for a check that raises an exception."""
    required = required_libraries()
    checks = [check_python(), check_libraries(required)]
    checks += [
        _tried("compiling", _compiling),
        _tried("kernels", _kept),
        _tried("left over", _left_over),
        _tried("solver", _solver),
    ]
    return [
        *checks,
        check_c_compiler(),
        *check_extras(required),
        check_machine(),
        check_temporary(),
        check_terminal(),
    ]


def _tried(name: str, check: Callable[[], InstallationFinding]) -> InstallationFinding:
    try:
        return check()
    except Exception as error:
        message = " ".join(f"{type(error).__name__}: {error}".split())
        return InstallationFinding(
            name, "wrong", message, "reinstall: pip install --force-reinstall frictool"
        )


def _compiling() -> InstallationFinding:
    from frictool.doctor.compiled_kernels import check_compiling

    return check_compiling()


def _kept() -> InstallationFinding:
    from frictool.doctor.compiled_kernels import check_kernel_folder

    return check_kernel_folder()


def _left_over() -> InstallationFinding:
    from frictool.doctor.compiled_kernels import check_old_kernels, old_kernel_folders

    return check_old_kernels(old_kernel_folders())


def _solver() -> InstallationFinding:
    from frictool.doctor.solver import check_solver

    return check_solver()


def json_view(checks: list[InstallationFinding]) -> list[dict[str, Any]]:
    """Return the findings as JSON objects."""
    return [
        {
            "check": one.name,
            "state": one.state,
            "found": one.finding,
            "try": one.remedy or None,
            **one.facts,
        }
        for one in checks
    ]


def lines(checks: list[InstallationFinding]) -> list[str]:
    """Return the findings as lines of text."""
    shown = []
    for one in checks:
        shown.append(f"{one.state:<6}{one.name:<16}{one.finding}")
        if one.remedy:
            shown.append(f"{'':<22}try: {one.remedy}")
    return shown
