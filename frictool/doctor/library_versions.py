"""Checks of the installed libraries against the versions that the package's metadata requires."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from importlib import metadata

from frictool import __version__
from frictool.doctor.installation_finding import InstallationFinding
from frictool.logs.formats import FORMATS

PACKAGE = "frictool"
# extras for users; the package may have only some of them
FOR_USERS = (*(one.library[1] for one in FORMATS if one.library), "protobuf", "cluster", "control")
REQUIREMENT = re.compile(
    r"(?P<name>[A-Za-z0-9._-]+)(\[[^]]*\])?\s*>=\s*(?P<least>[0-9.]+)"
    r"(.*extra == \"(?P<extra>\w+)\")?"
)


@dataclass(frozen=True)
class RequiredLibrary:
    """Library that the package's metadata requires.

    least: minimum version.
    extra: optional feature (pip extra) that requires the library; None if frictool always requires
        it.
    installed: installed version; None if the library is missing.
    """

    name: str
    least: str
    extra: str | None
    installed: str | None

    @property
    def is_met(self) -> bool:
        """Return True if the library is installed in at least the version `least`."""
        return self.installed is not None and _numbers(self.installed) >= _numbers(self.least)


def _numbers(version: str) -> tuple[int, ...]:
    match = re.match(r"\d+(\.\d+)*", version)
    return tuple(int(part) for part in match[0].split(".")) if match else ()


def required_libraries() -> list[RequiredLibrary]:
    """Return the libraries that the metadata of the installed package requires."""
    return list(_requirements(metadata.requires(PACKAGE) or []))


def _requirements(requirements: list[str]) -> Iterator[RequiredLibrary]:
    for text in requirements:
        match = REQUIREMENT.match(text)
        if match is not None:
            yield RequiredLibrary(
                match["name"], match["least"], match["extra"], _installed(match["name"])
            )


def _installed(name: str) -> str | None:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return None


def check_python() -> InstallationFinding:
    """Check that the version of Python satisfies `requires-python`."""
    version = sys.version.split()[0]
    wanted = metadata.metadata(PACKAGE)["Requires-Python"] or ">=3"
    least = wanted.removeprefix(">=")
    facts = {"version": version, "executable": sys.executable, "frictool": __version__}
    if _numbers(version) < _numbers(least):
        return InstallationFinding(
            "python",
            "wrong",
            f"{version}; allowed: {wanted}",
            f"install frictool with Python {least} or later",
            facts,
        )
    return InstallationFinding("python", "ok", f"{version}, {sys.executable}", facts=facts)


def check_libraries(required: list[RequiredLibrary]) -> InstallationFinding:
    """Check the libraries that every installation needs."""
    needed = [one for one in required if one.extra is None]
    facts = {one.name: one.installed for one in needed}
    missing = [one for one in needed if not one.is_met]
    if missing:
        finding = "; ".join(
            f"{one.name} {one.installed or 'is missing'}, needed: >={one.least}" for one in missing
        )
        return InstallationFinding(
            "libraries", "wrong", finding, "pip install --upgrade --force-reinstall frictool", facts
        )
    return InstallationFinding(
        "libraries", "ok", ", ".join(f"{one.name} {one.installed}" for one in needed), facts=facts
    )


def check_extras(required: list[RequiredLibrary]) -> list[InstallationFinding]:
    """Check the libraries of each optional feature (extra)."""
    checks = []
    for extra in FOR_USERS:
        libraries = [one for one in required if one.extra == extra]
        if not libraries:
            continue
        facts = {one.name: one.installed for one in libraries}
        shown = ", ".join(f"{one.name} {one.installed or 'not installed'}" for one in libraries)
        is_there = all(one.is_met for one in libraries)
        remedy = "" if is_there else f"pip install 'frictool[{extra}]'"
        checks.append(
            InstallationFinding(
                f"extra {extra}", "ok" if is_there else "note", shown, remedy, facts
            )
        )
    return checks
