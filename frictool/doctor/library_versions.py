"""What is installed against what the package's own metadata asks for, extras with the command that
installs them."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from importlib import metadata

from frictool import __version__
from frictool.doctor.installation_check import InstallationCheck

PACKAGE = "frictool"
FOR_USERS = (
    "mdf",
    "parquet",
    "mat73",
    "protobuf",
    "cluster",
    "control",
)  # extras that a user has a use for, as far as there are such
ASKED = re.compile(
    r"(?P<name>[A-Za-z0-9._-]+)(\[[^]]*\])?\s*>=\s*(?P<least>[0-9.]+)(.*extra == \"(?P<extra>\w+)\")?"
)


@dataclass(frozen=True)
class RequiredLibrary:
    """A library: the least version, the extra that asks for it (None: every installation), what is
    installed (None: nothing)."""

    name: str
    least: str
    extra: str | None
    installed: str | None

    @property
    def is_met(self) -> bool:
        return self.installed is not None and _numbers(self.installed) >= _numbers(self.least)


def _numbers(version: str) -> tuple[int, ...]:
    """The release of a version: 1.2 of 1.2rc1."""
    found = re.match(r"\d+(\.\d+)*", version)
    return tuple(int(part) for part in found[0].split(".")) if found else ()


def required_libraries() -> list[RequiredLibrary]:
    """What the installed package's metadata asks for."""
    return list(_asked(metadata.requires(PACKAGE) or []))


def _asked(requirements: list[str]) -> Iterator[RequiredLibrary]:
    for text in requirements:
        found = ASKED.match(text)
        if found is not None:
            yield RequiredLibrary(
                found["name"], found["least"], found["extra"], _installed(found["name"])
            )


def _installed(name: str) -> str | None:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return None


def check_python() -> InstallationCheck:
    """The interpreter against `requires-python`."""
    found, wanted = sys.version.split()[0], metadata.metadata(PACKAGE)["Requires-Python"] or ">=3"
    least = wanted.removeprefix(">=")
    facts = {"version": found, "executable": sys.executable, "frictool": __version__}
    if _numbers(found) < _numbers(least):
        return InstallationCheck(
            "python",
            "wrong",
            f"{found}; allowed: {wanted}",
            f"install frictool with Python {least} or later",
            facts,
        )
    return InstallationCheck("python", "ok", f"{found}, {sys.executable}", facts=facts)


def check_libraries(asked: list[RequiredLibrary]) -> InstallationCheck:
    """What every installation needs."""
    needed = [one for one in asked if one.extra is None]
    facts = {one.name: one.installed for one in needed}
    missing = [one for one in needed if not one.is_met]
    if missing:
        found = "; ".join(
            f"{one.name} {one.installed or 'is missing'}, needed: >={one.least}" for one in missing
        )
        return InstallationCheck(
            "libraries", "wrong", found, "pip install --upgrade --force-reinstall frictool", facts
        )
    return InstallationCheck(
        "libraries", "ok", ", ".join(f"{one.name} {one.installed}" for one in needed), facts=facts
    )


def check_extras(asked: list[RequiredLibrary]) -> list[InstallationCheck]:
    """Each extra that a user has a use for."""
    found = []
    for extra in FOR_USERS:
        libraries = [one for one in asked if one.extra == extra]
        if not libraries:
            continue
        facts = {one.name: one.installed for one in libraries}
        shown = ", ".join(f"{one.name} {one.installed or 'not installed'}" for one in libraries)
        is_there = all(one.is_met for one in libraries)
        remedy = "" if is_there else f"pip install 'frictool[{extra}]'"
        found.append(
            InstallationCheck(f"extra {extra}", "ok" if is_there else "note", shown, remedy, facts)
        )
    return found
