"""Exports of packages: lazy, complete, and the functions that the commands call."""

from __future__ import annotations

import importlib
import subprocess
import sys

import pytest

PACKAGES = [
    "documents",
    "logs",
    "identify",
    "identify.assess",
    "identify.excite",
    "identify.info",
    "identify.validate",
    "synth",
    "verify",
    "simulate",
    "report",
    "observe",
    "reduce",
    "export",
    "compare",
    "systems",
    "campaign",
    "equations",
]
HEAVY = ("numba", "numpy", "scipy", "clarabel", "matplotlib", "msgspec", "yaml")


@pytest.mark.parametrize("name", PACKAGES)
def test_what_is_offered_is_there(name: str) -> None:
    package = importlib.import_module(f"frictool.{name}")
    for offered in package.__all__:
        found = getattr(package, offered)
        assert not isinstance(found, type(sys)), f"frictool.{name}.{offered} is a module"
        assert offered in dir(package)


def test_a_misspelt_name_is_told_with_those_that_there_are() -> None:
    with pytest.raises(ImportError, match="synthesize"):
        from frictool.synth import synthesize  # noqa: F401  # what is asked for is not there
    import frictool.synth

    with pytest.raises(
        AttributeError, match="it offers SynthesisResult, external_controller, synthesise"
    ):
        frictool.synth.synthesize  # noqa: B018  # reading it is what is tried


def test_importing_the_packages_loads_no_library() -> None:
    code = (
        f"import sys, {', '.join(f'frictool.{name}' for name in PACKAGES)}; "
        f"print(*sorted(set({HEAVY!r}) & set(sys.modules)))"
    )
    assert (
        subprocess.run(
            [sys.executable, "-c", code], capture_output=True, text=True, check=True
        ).stdout.strip()
        == ""
    )


def test_a_module_that_was_imported_first_hides_no_function() -> None:
    """A submodule becomes an attribute of its package: none may have the name of a function that
    the package offers."""
    for name in PACKAGES:
        package = importlib.import_module(f"frictool.{name}")
        for offered in package.__all__:
            with pytest.raises(ModuleNotFoundError):
                importlib.import_module(f"frictool.{name}.{offered}")
